"""Error against time: Lamprey, the same discrete problem by CasADi, and direct collocation of the continuous equations."""
import dataclasses
import math
import pathlib

import numpy

import continuous
import diagram
import problem
import replay
from direct_collocation import HERMITE_SIMPSON, TRAPEZOIDAL, Collocation
from measured import Times, digits, repeated

GRIDS, QUICK_GRIDS = (40, 100, 200, 400), (40, 100)
ORDER4_GRIDS, QUICK_ORDER4_GRIDS = (30, 50, 100), (50,)
GIVEN = 50  # steps of Lamprey's answer from which peers start
WINDOW = 0.05  # s, of replay
LEVELS = (1e-3, 1e-4)  # errors at which times are compared
OTHER_MINIMUM = 0.2  # relative distance from the limit that is no error of a grid
LAMPREY, ORDER4, CASADI = "Lamprey", "Lamprey, order4", "CasADi, same equations"


@dataclasses.dataclass
class Subject:
    where: str
    example: str
    seed: int  # a first guess whose minimum is the same on all grids
    title: str


SUBJECTS = (Subject("plane", "translation", 2, "translation in the plane"), Subject("space", "rotation", 3, "rotation by half a turn"))


@dataclasses.dataclass
class Point:
    method: str
    steps: int
    times: Times
    cost: float  # NaN: not solved
    drift: float  # of total momentum, relative
    rotation_error: float  # rad, windowed replay
    position_error: float  # m
    cost_error: float = math.nan  # relative to the limit


def lamprey_points(bench, case, subject, grids, method=LAMPREY):
    for steps in grids:
        answer, times = bench.lamprey(case, subject.seed, steps, scheme="order4" if method == ORDER4 else "trapezoid")
        certificate = answer.certificate
        if answer.status != "optimal":
            yield Point(method, steps, times, *(math.nan,) * 4)
            continue
        yield Point(method, steps, times, answer.cost, certificate["momentum_drift"], certificate["replay"]["rotation_error"],
                    certificate["replay"]["position_error"])


def casadi_point(bench, case, steps, start, own):
    grid = bench.grid(case, steps, True)
    solution, times = repeated(lambda: grid.solve(problem.refined(start, steps)), bench.repetitions)
    cost = grid.cost(solution.motion) if solution.converged else math.nan
    same = abs(cost / own.cost - 1.0) < 1e-6  # then it is the same motion, with the same errors
    errors = (own.drift, own.rotation_error, own.position_error) if same else (math.nan,) * 3
    return Point(CASADI, steps, times, cost, *errors)


def collocation_point(bench, task, numbers, method, steps, start):
    grid = Collocation(task, steps, method, bench.folder / "compiled")
    solution, times = repeated(lambda: grid.solve(problem.refined(start, steps)), bench.repetitions)
    if not solution.converged:
        return Point(method, steps, times, *(math.nan,) * 4)
    errors = replay.windowed_errors(task, numbers, solution.motion, WINDOW)
    return Point(method, steps, times, grid.cost(solution), numbers.momentum_drift(solution.motion), *errors)


def limit_of_cost(points):
    """By Richardson from the finest two grids of Hermite–Simpson, order 4, and of Lamprey, order 2; they do not know each other."""
    def extrapolated(method, order):
        coarse, fine = [point for point in points if point.method == method][-2:]
        gain = (fine.steps / coarse.steps)**order
        return (gain * fine.cost - coarse.cost) / (gain - 1.0)
    return extrapolated(HERMITE_SIMPSON, 4), extrapolated(LAMPREY, 2)


def measure(bench, case, subject):
    grids = QUICK_GRIDS if bench.quick else GRIDS
    task = problem.read(bench.example(case))
    numbers = continuous.Numbers(task)
    start = bench.lamprey(case, subject.seed, GIVEN, 1)[0].path
    own_grids = grids if bench.quick else (*grids, 1000)
    points = list(lamprey_points(bench, case, subject, own_grids))
    points += [casadi_point(bench, case, steps, start, own) for steps, own in zip(own_grids, points)]
    points += lamprey_points(bench, case, subject, QUICK_ORDER4_GRIDS if bench.quick else ORDER4_GRIDS, ORDER4)
    for method in (TRAPEZOIDAL, HERMITE_SIMPSON):
        points += [collocation_point(bench, task, numbers, method, steps, start) for steps in grids]
    limit, second = limit_of_cost(points)
    print(f"\n{subject.title}, first guess {subject.seed}: cost in the limit {limit:.2f} by Hermite–Simpson, {second:.2f} by Lamprey's grids")
    print(f"{'':<26}{'N':>5} {'least, s':>9} {'median':>7} {'cost':>12} {'its error':>10} {'momentum':>9} {'replay, rad':>12} {'m':>9}")
    for point in points:
        point.cost_error = abs(point.cost / limit - 1.0)
        print(f"{point.method:<26}{point.steps:>5} {digits(point.times.least):>9} {digits(point.times.median):>7} {point.cost:12.2f} "
              f"{point.cost_error:10.1e} {point.drift:9.0e} {point.rotation_error:12.1e} {point.position_error:9.1e}"
              f"{'' if point.cost_error < OTHER_MINIMUM else '  another minimum'}", flush=True)
    return [point for point in points if point.cost_error < OTHER_MINIMUM]


def curve(points, method, error):
    return [(point.times.least, getattr(point, error), point.steps) for point in points if point.method == method]


def time_to(points, method, error, level):
    """Time at which the error is below the level and stays there, between grids on straight lines of the diagram; None: never."""
    found = [(time, value) for time, value, _ in curve(points, method, error) if value > 0.0]
    if not found or found[-1][1] > level:
        return None
    last = len(found) - 1
    while last > 0 and found[last - 1][1] <= level:
        last -= 1
    if last == 0:
        return found[0][0]
    (t, e), (t_next, e_next) = found[last - 1:last + 1]
    share = (math.log(level) - math.log(e)) / (math.log(e_next) - math.log(e))
    return math.exp(math.log(t) + share * (math.log(t_next) - math.log(t)))


def print_ratios(found):
    print("\nTime for an error / Lamprey's time for it (peers start from Lamprey's answer on "
          f"N = {GIVEN}, which is not counted; Lamprey, order4 too, from its first guess)\n{'':<34}"
          + "".join(f"{subject.where + ', ' + words + f' {level:g}':>28}" for subject in SUBJECTS for words in ("cost", "replay")
                    for level in LEVELS))
    for method in (ORDER4, CASADI, TRAPEZOIDAL, HERMITE_SIMPSON):
        cells = []
        for subject in SUBJECTS:
            for error in ("cost_error", "rotation_error"):
                for level in LEVELS:
                    times = [time_to(found[subject.where], who, error, level) for who in (method, LAMPREY)]
                    cells.append("-" if None in times else digits(times[0] / times[1]))
        print(f"{method:<34}" + "".join(f"{cell:>28}" for cell in cells))


def draw(found, path):
    panels = []
    for subject in SUBJECTS:
        for error, label in (("cost_error", "relative error of the cost"), ("rotation_error", "error of replay over 0.05 s, rad")):
            curves = [diagram.Curve(method, [(t, e) for t, e, _ in curve(found[subject.where], method, error) if e > 0.0],
                                    method not in (LAMPREY, ORDER4, CASADI))
                      for method in (LAMPREY, ORDER4, CASADI, TRAPEZOIDAL, HERMITE_SIMPSON)]
            panels.append(diagram.Panel(subject.title, "processor time, s", label, curves))
    pathlib.Path(path).write_text(diagram.svg("Error of maneuvers against processor time", panels), encoding="utf-8")


def run(bench, cases, drawn):
    found = {}
    for subject in SUBJECTS:
        case = next(case for case in cases if case.example == subject.example)
        found[subject.where] = measure(bench, case, subject)
    print_ratios(found)
    if drawn:
        draw(found, drawn)
