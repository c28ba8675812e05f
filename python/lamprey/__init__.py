"""Lamprey: maneuvers of articulated bodies in a perfect fluid.

    import lamprey as lp
    problem = lp.load("examples/translation.toml")
    solution = lp.solve(problem)
    solution.cost, solution.certificate["kkt"], solution.rotation[-1]

The words are those of problem files and of solution.json. SI units, angles in rad. Rotations that people give are rotation vectors
(axis times angle); rotations in arrays are 3x3 matrices, body coordinates to world coordinates. Arrays are NumPy float64, with

    time      (nodes,)                s
    position  (nodes, 3)              m, mass centre of the root (the first body), world frame
    rotation  (nodes, bodies, 3, 3)   body to world
    control   (nodes, joints, 3)      N m, on the parent, in the parent's frame; its opposite acts on the child
    velocity  {linear (nodes, 3) m/s of the root, root frame; angular (nodes, bodies, 3) rad/s, body frames}
    momentum  {linear, angular}, each {bodies, fluid, total} (nodes, 3), world frame, angular about the world origin

and nodes = steps + 1. What is wrong with a problem or an argument is an InputError, which is a ValueError and names the key; a
search that does not arrive is a status. solve, simulate and Solver.solve release the GIL; Ctrl-C ends them with KeyboardInterrupt.
"""
from ._core import (
    Outcome,
    Problem,
    Solution,
    Solver,
    Trajectory,
    _verify,
    certify,
    ellipsoid_inertia,
    load,
    load_solution,
    simulate,
    solve,
)
from .errors import InputError
from importlib.metadata import version as _version

__version__ = _version("lamprey")

__all__ = [
    "InputError",
    "Outcome",
    "Problem",
    "Solution",
    "Solver",
    "Trajectory",
    "certify",
    "ellipsoid_inertia",
    "load",
    "load_solution",
    "simulate",
    "solve",
    "verify",
]


def verify(directory, *, problem=None):
    """Recomputes the certificate of a stored solution from its files alone: what `lamprey verify` does.

    problem: a Problem, its settings as a dict, or the path of a problem file, whose question the solution has to be one to.
    Returns {holds, status, message, certificate, claims, trajectory, problem}. holds: whether the files promise nothing that is not
    so. status, message, certificate: what the numbers say now. claims: fields of the stored certificate, and others that follow
    from the rest, that are not so, {field, stored, found, contradiction} each: found is None where nothing is found; contradiction
    tells in words what the stored number is beside another one that is stored, which found is then, else it is None. trajectory: where trajectory.h5 differs from solution.json, in
    words; "" where it does not. problem: where the stored problem is another than the given one, a sentence for each field.
    FileNotFoundError where there is no solution.json, another OSError where it is not what Lamprey writes, InputError for the
    problem.
    """
    if isinstance(directory, Trajectory):
        raise TypeError("verify(): directory: found a motion; allowed: where one is saved; certify takes the motion itself")
    found, holds, claims, trajectory, differences = _verify(directory, problem)
    return {
        "holds": holds,
        "status": found.status,
        "message": found.message,
        "certificate": found.certificate,
        "claims": claims,
        "trajectory": trajectory,
        "problem": differences,
    }
