#!/usr/bin/env python3
"""Measures Lamprey's maneuvers against CasADi with Ipopt on the same discrete problem, and against direct collocation.

usage: maneuvers.py LAMPREY EXAMPLES FOLDER [--quick] [--diagram FILE]
LAMPREY: the program; EXAMPLES: the folder of problem files; FOLDER: for runs and compiled functions. tools/bench_peers.sh starts this.

Processor time, one thread. Lamprey's is `solver.processor_seconds`: problem in memory → converged at N = 1,000, coarse grids and all. CasADi's is
that of Ipopt's calls on N = 100 from the same first guess and on N = 1,000 from there; making and compiling functions is not counted.
"""
import os

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"  # read when the libraries are loaded

import argparse
import dataclasses
import pathlib
import sys

import casadi
import numpy

import accuracy
import lamprey_runs
import problem
from casadi_transcription import Transcription
from measured import Times, digits, repeated, spread

COARSE, FULL = 100, 1000  # steps
GIVEN = 25  # steps of the answer of Lamprey's that CasADi is given to reach the same minimum
SAME = 1e-6  # relative difference of cost of one minimum
AGREEMENT = 1e-9  # of the discrete equations, relative to h |u|
CARRIED_ON = {"warm_start_init_point": "yes"}
REPETITIONS = 3


@dataclasses.dataclass
class Case:
    example: str
    where: str
    seeds: range


CASES = (Case("translation", "plane", range(1, 9)), Case("translation_in_space", "space", range(1, 5)),
         Case("rotation", "space", range(1, 5)))


@dataclasses.dataclass
class Row:
    """One first guess; times by who and how."""

    case: Case
    seed: int
    times: dict
    costs: dict

    def ratio(self, peer, own="Lamprey"):
        return self.times[peer].least / self.times[own].least

    def same(self, peer):
        return abs(self.costs[peer] / self.costs["Lamprey"] - 1.0) < SAME


class Bench:
    def __init__(self, arguments):
        self.program, self.examples = arguments.lamprey, pathlib.Path(arguments.examples)
        self.folder, self.quick = pathlib.Path(arguments.folder), arguments.quick
        self.repetitions = 1 if self.quick else REPETITIONS
        self.grids = {}

    def example(self, case):
        return self.examples / f"{case.example}.toml"

    def seeds(self, case):
        return case.seeds[:2] if self.quick else case.seeds

    def lamprey(self, case, seed, steps, repetitions=None, scheme="trapezoid"):
        folder = self.folder / "runs" / f"{case.example}_{seed}_{steps}_{scheme}"
        return repeated(lambda: lamprey_runs.solve(self.program, self.example(case), folder, steps, seed, scheme),
                        repetitions or self.repetitions)

    def grid(self, case, steps, compiled):
        key = case.example, steps, compiled
        if key not in self.grids:
            self.grids[key] = Transcription(problem.read(self.example(case)), steps,
                                            self.folder / "compiled" if compiled else None)
        return self.grids[key]

    def continued(self, case, guess, compiled, repetitions):
        """CasADi and Ipopt from `guess` on the coarse grid, and from its minimum on the full one: cost (NaN: not solved within
        400 iterations and 30 s each) and times."""
        coarse, full = (self.grid(case, steps, compiled) for steps in (COARSE, FULL))
        first, first_times = repeated(lambda: coarse.solve(guess), repetitions)
        if not first.converged:
            return numpy.nan, first_times, Times(0.0 for _ in first_times.seconds)
        start = problem.refined(first.motion, FULL)
        multiplier = full.carried_multiplier(coarse, first.multiplier)
        last, last_times = repeated(lambda: full.solve(start, multiplier, CARRIED_ON), repetitions)
        solved = first.converged and last.converged
        return full.cost(last.motion) if solved else numpy.nan, first_times, last_times

    def disagreement(self, case, answer):
        """What Lamprey's answer leaves of the transcription's rows, relative to the largest impulse of a moment, h |u|."""
        grid = self.grid(case, answer.path.steps, True)
        rows = grid.program.rows(grid.pack(answer.path)).full()
        return abs(rows).max() / (grid.h * abs(answer.path.control).max())


def compare(bench, case, seed):
    own, own_times = bench.lamprey(case, seed, FULL)
    given, given_times = bench.lamprey(case, seed, GIVEN)
    times = {"Lamprey": own_times, "Lamprey, given": Times(a - b for a, b in zip(own_times.seconds, given_times.seconds))}
    costs = {"Lamprey": own.cost if own.status == "optimal" and own.starts == 1 else numpy.nan}
    guess = problem.random_guess(problem.read(bench.example(case)), seed, COARSE)
    for name, start, compiled, repetitions in (("compiled", guess, True, bench.repetitions), ("interpreted", guess, False, 1),
                                               ("given", problem.refined(given.path, COARSE), True, bench.repetitions)):
        costs[name], first, last = bench.continued(case, start, compiled, repetitions)
        times[name], times[f"{name} {COARSE}"], times[f"{name} {FULL}"] = first + last, first, last
    off = bench.disagreement(case, own)
    if not off < AGREEMENT:
        sys.exit(f"maneuvers.py: {case.example}: Lamprey's answer misses the transcription's equations by {off:.1e} h |u|")
    return Row(case, seed, times, costs), off


def print_row(row):
    def cost(name):
        return f"{row.costs[name]:10.1f}" if numpy.isfinite(row.costs[name]) else "    failed"

    def both(name):
        return f"{digits(row.times[name].least):>6} {digits(row.times[name].median):>6}"

    parts = [f"{row.case.example:<21}{row.seed:>2}", f"{cost('Lamprey')} {both('Lamprey')}",
             f"{cost('compiled')}{'=' if row.same('compiled') else ' '} {both('compiled')}"
             f" {digits(row.times[f'compiled {COARSE}'].least):>6} {digits(row.times[f'compiled {FULL}'].least):>6}",
             f"{digits(row.times['interpreted'].least):>6}",
             f"{cost('given')}{'=' if row.same('given') else ' '} {both('given')}"]
    print(" | ".join(parts), flush=True)


def print_ratios(rows):
    """How many times Lamprey's time peers take."""
    print(f"\nCasADi + Ipopt / Lamprey, least times: median (range) over first guesses\n{'':<74}{'plane':<26}space")
    found = {where: [row for row in rows if row.case.where == where] for where in ("plane", "space")}
    solved = {where: [row for row in of if all(numpy.isfinite(c) for c in row.costs.values())] for where, of in found.items()}

    def line(words, ratio, keep=lambda row: True):
        values = [spread([ratio(row) for row in solved[where] if keep(row)]) for where in ("plane", "space")]
        print(f"{words:<74}{values[0]:<26}{values[1]}")

    line("same first guess, stages compiled", lambda row: row.ratio("compiled"))
    line("  where both reach one minimum", lambda row: row.ratio("compiled"), lambda row: row.same("compiled"))
    line("same first guess, stages interpreted", lambda row: row.ratio("interpreted"))
    line("  where both reach one minimum", lambda row: row.ratio("interpreted"), lambda row: row.same("interpreted"))
    line(f"to Lamprey's minimum, CasADi (compiled) given Lamprey's N = {GIVEN}", lambda row: row.ratio("given"),
         lambda row: row.same("given"))
    line("  both from there on", lambda row: row.ratio("given", "Lamprey, given"), lambda row: row.same("given"))


def print_heading(answer, bench):
    provenance = answer.provenance
    print(f"\nManeuvers: Lamprey {provenance['version']} ({provenance['build_type']}, {provenance['compiler']}) on {provenance['machine']}; "
          f"CasADi {casadi.__version__} with its Ipopt and MUMPS"
          f"\nprocessor time of one thread, s, least and median of {bench.repetitions}; N = {FULL:,}; cost in (N m)² s; =: Lamprey's minimum"
          f"\ncompiled, interpreted: from the same first guess, N = {COARSE} cold, then N = {FULL:,}; given: the same from Lamprey's answer on "
          f"N = {GIVEN}, compiled\n"
          f"\n{'problem, first guess':<23} | {'Lamprey':<24} | {'CasADi + Ipopt, compiled':<39} | interp | given"
          f"\n{'':<23} | {'cost':>10} {'least':>6} {'median':>6} | {'cost':>10}  {'least':>6} {'median':>6} {f'N={COARSE}':>6} {f'N={FULL}':>6}"
          f" | {'once':>6} | {'cost':>10}  {'least':>6} {'median':>6}", flush=True)


def main():
    parser = argparse.ArgumentParser()
    for name in ("lamprey", "examples", "folder"):
        parser.add_argument(name)
    parser.add_argument("--quick", action="store_true", help="two first guesses for each problem, coarse grids, no repetitions")
    parser.add_argument("--diagram", help="SVG file to write")
    arguments = parser.parse_args()
    bench = Bench(arguments)
    answer, _ = bench.lamprey(CASES[0], 1, COARSE, 1)
    print_heading(answer, bench)
    rows, worst = [], 0.0
    for case in CASES:
        for seed in bench.seeds(case):
            row, off = compare(bench, case, seed)
            print_row(row)
            rows.append(row)
            worst = max(worst, off)
    print(f"\nLamprey's answers meet CasADi's equations to {worst:.1e} of the largest h |u|")
    print_ratios(rows)
    accuracy.run(bench, CASES, arguments.diagram)


if __name__ == "__main__":
    try:
        main()
    except (lamprey_runs.Failed, problem.Unsuitable) as fault:
        sys.exit(f"maneuvers.py: {fault}")
