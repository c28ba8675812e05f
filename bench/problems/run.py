"""Which of these problems end in a proved local minimum, at what cost and in what time.

usage: python3 bench/problems/run.py build/release/lamprey [NAME ...]

Swimmers, costs and limits of people who tried Lamprey, hard ones among them: not all are solved. Each has 60 s.
"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

LIMIT = 60  # s


def solve(program, problem, folder):
    """The answer, or the reason why there is none."""
    try:
        run = subprocess.run(
            [program, "solve", problem, "--out", folder], capture_output=True, text=True, timeout=LIMIT, check=False
        )
    except subprocess.TimeoutExpired:
        return f"no answer within {LIMIT} s"
    answer = pathlib.Path(folder) / "solution.json"
    if answer.exists():
        return json.loads(answer.read_text())
    return "refused: " + (run.stderr.strip().splitlines() or ["without a word"])[-1]


def verdict_of(answer):
    if isinstance(answer, str):
        return None
    return (answer["certificate"] or {}).get("verdict") or answer["status"]


def row(problem, answer):
    verdict = verdict_of(answer)
    if verdict is None:
        return f"{problem.stem:34} {answer}"
    words = "" if answer["status"] == "optimal" else answer["message"][:110]
    cost = "-" if answer["cost"] is None else f"{answer['cost']:.6g}"
    return f"{problem.stem:34} {verdict:22} {cost:>12} {answer['solver']['wall_seconds']:7.1f} s  {words}"


def main():
    if len(sys.argv) < 2 or sys.argv[1] in ("-h", "--help"):
        sys.exit(__doc__)
    if shutil.which(sys.argv[1]) is None:
        sys.exit(f"{sys.argv[1]}: no program; build it with ./dev build")
    here = pathlib.Path(__file__).parent
    problems = [here / f"{name}.toml" for name in sys.argv[2:]] or sorted(here.glob("*.toml"))
    for problem in problems:
        if not problem.exists():
            sys.exit(f"{problem.stem}: no such problem here; there are {', '.join(sorted(p.stem for p in here.glob('*.toml')))}")
    proved = 0
    for problem in problems:
        with tempfile.TemporaryDirectory() as folder:
            answer = solve(sys.argv[1], problem, folder)
        proved += verdict_of(answer) == "proved local minimum"
        print(row(problem, answer), flush=True)
    print(f"{proved} of {len(problems)} proved")


if __name__ == "__main__":
    main()
