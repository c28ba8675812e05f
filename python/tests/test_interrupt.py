"""Ctrl-C ends long calls soon (under two seconds where nothing else runs), with KeyboardInterrupt and what there is."""
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
LONG = {
    "newton": 'lp.solve(problem.changed(search={"starts": 100000}), solver="newton", workers=2, progress=told)',
    "ipopt": 'lp.solve(problem.changed(search={"starts": 100000}), solver="ipopt", workers=2, progress=told)',
    "angles": 'lp.simulate(problem, angles=lambda t: told(t) or time.sleep(1e-3) or [[0, 0, 0.1 * t], [0, 0, 0]], steps=20_000)',
    "simulate": 'lp.simulate(problem, lambda t: told(t) or [[0, 0, 1], [0, 0, 1]], steps=10_000_000)',
}
# What a shell starts in the background ignores SIGINT, and so does what that starts.
PROGRAM = """
import signal
import sys
import time
signal.signal(signal.SIGINT, signal.default_int_handler)
import lamprey as lp
problem = lp.load(sys.argv[1]).changed(time={{"steps": 200}})
def told(line):
    global told
    print("under way", flush=True)
    told = lambda line: None
def once(line): told(line)
try:
    {call}
except KeyboardInterrupt as stop:
    print("stopped", stop.solution.status, len(stop.solution.time), flush=True)
else:
    print("ended by itself", flush=True)
"""


@pytest.mark.parametrize("name", LONG)
def test_ctrl_c_ends_a_long_call(name):
    program = PROGRAM.format(call=LONG[name].replace("told", "once"))
    run = subprocess.Popen([sys.executable, "-c", program, str(ROOT / "examples" / "translation.toml")],
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env={**os.environ, "PYTHONUNBUFFERED": "1"})
    try:
        assert run.stdout.readline().strip() == "under way", run.stderr.read()
        time.sleep(0.5)
        run.send_signal(signal.SIGINT)
        begin = time.perf_counter()
        said, errors = run.communicate(timeout=20)
        seconds = time.perf_counter() - begin
    finally:
        run.kill()
    assert said.startswith("stopped interrupted"), said + errors
    assert run.returncode == 0
    assert seconds < 6.0
