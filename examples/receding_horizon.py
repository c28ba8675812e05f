"""Plans while it swims: the roll of rotation.toml by a swimmer that is not quite the one that was planned for.

In each tenth of the time the swimmer moves by its latest plan, is measured, and plans anew from where it is. Its masses are not those
that its plans assume. Printed is how far it misses with one plan from beginning to end, with one plan and its gains, and with plans
made anew. Run: python3 examples/receding_horizon.py [rotation.toml | drifting.toml]
"""
import copy
import pathlib
import sys

import numpy as np

import lamprey as lp

PARTS = 10     # plans
STEPS = 100    # of a plan
HEAVIER = 1.03  # the second body's mass and inertia, or where none are given its mass, against those that plans assume


def swimmer_of(problem):
    """The swimmer that moves: the problem's with a heavier second body."""
    settings = copy.deepcopy(problem.settings)
    body = settings["body"][1]
    given = [key for key in ("mass", "body_inertia", "mass_matrix", "inertia_matrix", "coupling_matrix") if key in body]
    for key in given:
        body[key] = (HEAVIER * np.array(body[key])).tolist()
    if not given:
        body["mass"] = HEAVIER * settings["fluid"]["density"] * 4.0 / 3.0 * np.pi * np.prod(body["semi_axes"])
    return settings


def rotation_vector(rotation):
    """rad, of a rotation matrix by less than half a turn."""
    sine = 0.5 * np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                           rotation[1, 0] - rotation[0, 1]])
    angle = np.arctan2(np.linalg.norm(sine), 0.5 * (np.trace(rotation) - 1.0))
    return sine * (angle / np.sin(angle) if angle > 1e-12 else 1.0)


def swim(settings, motion, node, **way):
    """Marches from a node of a motion."""
    rotation = motion.rotation[node]
    start = {
        "rotation": {body["name"]: rotation_vector(R).tolist() for body, R in zip(settings["body"], rotation)},
        "angular_velocity": {body["name"]: w.tolist()
                             for body, w in zip(settings["body"], motion.velocity["angular"][node])},
        "linear_velocity": (rotation[0] @ motion.velocity["linear"][node]).tolist(),
        "position": motion.position[node].tolist(),
    }
    return lp.simulate(lp.Problem({**settings, "start": start}), **way)


def missed(end, goal):
    """rad, by which the body that misses most is off its goal."""
    return max(np.linalg.norm(rotation_vector(a.T @ b)) for a, b in zip(goal, end))


def main(path):
    problem = lp.load(path).changed(time={"steps": STEPS})
    solution = lp.solve(problem)
    settings, goal = swimmer_of(problem), solution.rotation[-1]
    duration = solution.time[-1]
    carried = [solution.momentum[kind]["total"][0] for kind in ("linear", "angular")]
    drifts = np.abs(carried).max() > 1e-9 * np.abs(solution.momentum["linear"]["bodies"]).max()  # else what is seen of it is an error
    print(f"planned: cost {solution.cost:.6g}, {solution.message}")
    if not solution.certificate["resolved"]:
        print(f"  {STEPS} steps do not resolve this plan, and what follows misses for that alone: more of them (STEPS) may help")

    for name, way in (("one plan", {"controls": solution}), ("one plan and its gains", {"feedback": solution})):
        print(f"{name}: misses by {missed(swim(settings, solution, 0, **way).rotation[-1], goal):.2g} rad")

    solver = lp.Solver(problem, solution)
    plan, seen, node = solver.solution(feedback=True), solution, 0
    for part in range(PARTS):
        seen = swim(settings, seen, node, feedback=plan, feedback_from=solver.passed, duration=duration / PARTS,
                    steps=2 * STEPS // PARTS)
        node = -1
        if seen.status != "simulated" or "lost" in seen.message:
            print(f"  {(part + 1) * duration / PARTS:.1f} s: {seen.message}")
        if part + 1 == PARTS:
            break
        solver.advance(duration / PARTS)
        drift = {"linear_velocity": seen.rotation[-1, 0] @ seen.velocity["linear"][-1]} if drifts else {}
        solver.set_start(seen.rotation[-1], seen.position[-1], seen.velocity["angular"][-1], **drift)
        outcome = solver.solve()
        if not solver.answered:  # it goes on by the rest of the plan that it has
            print(f"  {(part + 1) * duration / PARTS:.1f} s: {outcome.status}, {outcome.reason}")
            continue
        print(f"  {(part + 1) * duration / PARTS:.1f} s: {outcome.status} in {1e3 * outcome.wall_seconds:.1f} ms, "
              f"{outcome.iterations} steps of Newton's method, cost {solver.cost:.6g}")
        plan = solver.solution(feedback=True)
    print(f"plans made anew: misses by {missed(seen.rotation[-1], goal):.2g} rad")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).with_name("rotation.toml")))
