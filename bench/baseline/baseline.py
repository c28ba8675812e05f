"""Stores what lamprey_bench takes on this kind of machine, or compares it with what is stored. See README.md beside this."""

import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

TOLERATED = 1.25  # ratio of least times


def machine():
    text = pathlib.Path("/proc/cpuinfo").read_text()
    model = re.search(r"^model name\s*:\s*(.*)$", text, re.M)
    return f"{model.group(1) if model else 'unknown processor'}, {os.cpu_count()} cores"


def place(name):
    return pathlib.Path(__file__).parent / (re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-") + ".json")


def measure(program):
    with tempfile.NamedTemporaryFile(suffix=".json") as out:
        subprocess.run([program, f"--benchmark_out={out.name}", "--benchmark_out_format=json"], check=True)
        runs = json.load(open(out.name))["benchmarks"]
    times = {}
    for run in runs:
        kind = {"min": "least", "median": "median"}.get(run.get("aggregate_name"))
        if kind is None:
            continue
        entry = times.setdefault(run["run_name"], {"unit": run["time_unit"]})
        entry[kind] = float(f"{run['cpu_time']:.4g}")
    return times


def main():
    if len(sys.argv) != 3 or sys.argv[1] not in ("store", "compare"):
        sys.exit("usage: baseline.py store|compare PROGRAM")
    program = os.path.abspath(sys.argv[2])
    version = subprocess.run([os.path.join(os.path.dirname(program), "lamprey"), "--version"], capture_output=True, text=True)
    here = {"machine": machine(), "version": version.stdout.strip(), "processor_time": None}
    file = place(here["machine"])
    if sys.argv[1] == "store":
        here["processor_time"] = measure(program)
        file.write_text(json.dumps(here, indent=1) + "\n")
        print(f"wrote {file}")
        return
    if not file.exists():
        sys.exit(f"no baseline for {here['machine']}; make one with store")
    before = json.loads(file.read_text())["processor_time"]
    slower = 0
    print(f"\nratio to the stored baseline ({file.name})")
    for name, now in measure(program).items():
        if name not in before or before[name]["unit"] != now["unit"]:
            continue
        ratio = now["least"] / before[name]["least"]
        slower += ratio > TOLERATED
        print(f"{name:<44} {ratio:6.2f}{'  slower' if ratio > TOLERATED else ''}")
    sys.exit(1 if slower else 0)


main()
