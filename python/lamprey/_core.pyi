"""Compiled part of lamprey; import lamprey instead."""

from collections.abc import Callable, Sequence
import os
from typing import Any, Literal, overload

import numpy
import numpy.typing

from lamprey.errors import InputError as InputError


def ellipsoid_inertia(semi_axes: numpy.typing.ArrayLike, density: float) -> dict[str, Any]:
    """
    Inertia of a homogeneous, neutrally buoyant ellipsoid and of the fluid that it drags along.

    semi_axes: three half lengths, m, or two of an ellipse in the plane, of which one metre is meant. density: of the fluid, kg/m³; 0 is a vacuum.
    Returns a dict with the words of `lamprey inertia --json`, in the frame of the ellipsoid's own axes, about its centre:
    volume (m³), mass (kg), body_inertia (3,) kg m², added_mass (3,) kg, added_inertia (3,) kg m²,
    mass_matrix (3, 3) kg and inertia_matrix (3, 3) kg m², which are body and fluid together.
    InputError where a half length is no positive number or the density a negative one.
    """

class Problem:
    """
    A swimmer and what it shall do, validated: the numbers of a problem file.

    Problem({...}) takes the sections and keys of a problem file as nested dicts: "fluid", "body" and "joint" (lists of dicts),
    "start", "goal", "time", ... NumPy arrays stand for lists. SI units, angles in rad, rotations as rotation vectors.
    Raises InputError naming the key.
    """

    def __init__(self, settings: dict) -> None: ...

    @staticmethod
    def from_toml(text: str, path: str = '<Python>') -> Problem:
        """
        The problem of a file's text; `path` names it in messages. InputError naming the key where it is none.
        """

    def changed(self, **sections) -> Problem:
        """
        The problem with other keys: problem.changed(time={"steps": 100}, search={"starts": 1}).

        Dicts go key by key into what is there, anything else replaces it, None removes it.
        """

    @property
    def text(self) -> str:
        """The problem as TOML."""

    @property
    def settings(self) -> dict[str, object]:
        """The problem as nested dicts, as Problem takes them."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def bodies(self) -> list[str]:
        """Names of the bodies, the root first: the order of all arrays."""

    @property
    def joints(self) -> list[str]:
        """Names of the joints: the order of all arrays."""

    @property
    def steps(self) -> int:
        """Number of steps; arrays have one node more."""

    @property
    def duration(self) -> float:
        """s; where it is free the first guess."""

    @property
    def scheme(self) -> str:
        """paper, trapezoid, midpoint, order4 or order6."""

    def check(self) -> str:
        """
        What `lamprey check` prints: the resolved model as a table for people, and where solve does not take the problem why.

        Raises InputError where the start or the goal breaks a limit.
        """

    def __repr__(self) -> str: ...

    def __eq__(self, other: object, /) -> bool:
        """Whether both have the same settings, wherever they were read."""

    def __hash__(self) -> int: ...

    def __getstate__(self) -> tuple[str, str]: ...

    def __setstate__(self, arg: tuple[str, str], /) -> None: ...

    def connection(self, rotation: numpy.typing.ArrayLike) -> dict[str, Any]:
        """
        The local connection at a shape: how the root moves as the joints turn, where total momentum is zero.

        rotation: (bodies, 3, 3), body to world, of which the shape alone counts; InputError where a body is off its joint by more than 1e-6 rad. Returns "angular" (3, f) and "linear" (3, f, in m): the root's angular velocity and its mass centre's velocity, both along its own axes, by the f rates of the joints, and "inertia" (f, f): M of the kinetic energy ½ rate·M rate, kg m².
        "rates": the joint and the axis of each, of a hinge or universal joint the angle about it, of a ball joint a component of the child's angular velocity against the parent's, in the parent's frame. Equation 9.28.
        """

    def connection_curvature(self, rotation: numpy.typing.ArrayLike) -> dict[str, Any]:
        """
        The curvature of the local connection at a shape: what small loops of shapes move the root by.

        rotation: (bodies, 3, 3), body to world, of which the shape alone counts; InputError as in connection. Returns "angular" (3, f, f) and "linear" (3, f, f, in m), by the f "rates" of connection: the parallelogram of two small motions a, b of the joints (rad) turns the root by angular[k] @ b · a about its axis k and moves it by linear[k] likewise, to second order in its size. Antisymmetric, exact. Equations 9.29, 9.30.
        """

    def height_functions(self, first: str | tuple[str, int] | dict, second: str | tuple[str, int] | dict, first_range: tuple[float, float], second_range: tuple[float, float], points: int = 31, middle: dict | None = None) -> dict[str, Any]:
        """
        Height functions of a swimmer that two shape variables move in a plane: volumes over loops are what it moves.

        first, second: what the variables change, a joint's name, of a ball or universal joint with its axis, ("front", 2); or a mode, a dict of angles and how far each turns for 1 of the variable, {"front": 1.0, "back": -0.5}. middle: angles where both variables are zero, rad, from which they count; those that are not named are zero. Ranges in rad. Returns "first", "second" (points): the variables; "linear" (2, points, points, m) and "angular" (points, points, rad), each for 1 of both variables, rows by the first: along the two axes that follow "normal", the root's axis about which it turns (0, 1 or 2), and about it; told in the frame that shapes disturb least, which stands at "frame_position" (2, points, points, m) and is turned by "frame_angle" (points, points, rad) in the root's.
        Raises InputError where the swimmer leaves the plane. Equation 9.31.
        """

def load(path: str | os.PathLike) -> Problem:
    """
    Reads and validates a problem file.

    Raises InputError (file:line:column: key: what was found, what is allowed, how to mend it), FileNotFoundError.
    """

class Trajectory:
    """
    A motion, in the words, shapes and units of solution.json. Arrays are NumPy float64, read-only, C order.

    nodes = steps + 1; bodies and joints in the order of Problem.bodies and Problem.joints.
    """

    @property
    def name(self) -> str:
        """Of its problem."""

    @property
    def source(self) -> str:
        """Of its problem."""

    @property
    def status(self) -> str:
        """
        optimal, simulated, feasible, infeasible, stalled, time_limit or interrupted.
        """

    @property
    def message(self) -> str:
        """
        One sentence for a person: what happened and, if not optimal, why and what to try; arguments of solve and simulate
        in the place of the command line's options, which solution.json has.
        """

    @property
    def problem(self) -> dict[str, Any]:
        """
        The problem as resolved: bodies, joints (indices), scheme, time_step, duration, steps, cost_rule, goal, ...
        """

    @property
    def duration(self) -> float:
        """s; of a free duration the one found."""

    @property
    def time(self) -> numpy.typing.NDArray[numpy.float64]:
        """(nodes,) s."""

    @property
    def position(self) -> numpy.typing.NDArray[numpy.float64]:
        """(nodes, 3) m, mass centre of the root, world frame."""

    @property
    def rotation(self) -> numpy.typing.NDArray[numpy.float64]:
        """(nodes, bodies, 3, 3) rotation matrices, body → world."""

    @property
    def control(self) -> numpy.typing.NDArray[numpy.float64]:
        """
        (nodes, joints, 3) N m, moment on the parent, parent's frame; its opposite acts on the child.
        """

    @property
    def joint_angle(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        (nodes, joints, 3) rad from the zero angle: (θ, 0, 0) of a hinge, (θ₁, θ₂, 0) of a universal joint, rotation vector of a
        ball joint, parent's frame. Whole turns add up. None: of files of early versions.
        """

    @property
    def control_stages(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """
        (steps, stages, joints, 3) N m, of schemes above order 2; None of others.
        """

    @property
    def stage_time(self) -> numpy.typing.NDArray[numpy.float64] | None:
        """(steps, stages) s, of schemes above order 2; None of others."""

    @property
    def velocity(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
        """
        {linear: (nodes, 3) m/s of the root, root frame; angular: (nodes, bodies, 3) rad/s, body frames}.
        """

    @property
    def momentum(self) -> dict[str, dict[str, numpy.typing.NDArray[numpy.float64]]]:
        """
        {linear, angular}, each {bodies, fluid, total}: (nodes, 3) kg m/s and kg m²/s, world frame, angular about the world origin.
        """

    @property
    def certificate(self) -> dict[str, Any] | None:
        """
        The numbers that prove the answer: goal_error, rest_error, momentum_drift, rotation_drift, kkt, second_order, replay, refinement, ...
        None: not computed, as of motions that were marched; see certify.
        """

    @property
    def tracking(self) -> dict[str, Any] | None:
        """How a march with feedback kept to its maneuver; None of others."""

    @property
    def marched_by(self) -> str | None:
        """What marched in place of the scheme; None: the scheme."""

    @property
    def divided_steps(self) -> dict[str, Any] | None:
        """Where a march divided its steps; None where it did not."""

    @property
    def provenance(self) -> dict[str, Any]:
        """version, build_type, compiler, machine, command, problem_sha256, seed."""

    def shape_loop(self) -> dict[str, Any] | None:
        """
        The loop of shapes of a motion in a plane over its height functions, as the report shows it; else None.

        "variables": the two angles that change, or "s₁", "s₂" of more: coordinates in the plane nearest to all shapes, "modes" how far each angle turns by them, "beside" how far shapes are from it, rad. "first", "second" (nodes): the variables along the motion. "heights": as of Problem.height_functions. Of a loop that closes without total momentum "by_volume" and "moved" (along, across, turn; m, m, rad): the volumes over it, and the twist that takes the frame of the heights once round, on the average over where the loop begins; else None.
        """

    def joint_demands(self) -> list[dict[str, Any]]:
        """
        What the motion asks of each joint, of a universal joint with two moments of each axis: joint (its name, "fin 1" and "fin 2" of axes), largest_moment N m, largest_rate rad/s (at nodes, or mean over a step), largest_power W (at nodes), work J
        (∫ |u·ω| dt, nothing won back), angles (list of (least, largest) rad: of a hinge or an axis one, of a universal joint with fewer moments two, of a
        ball joint how far it is from its zero angle, over the nodes); an empty list: no motion.
        """

    def report(self, path: str | os.PathLike) -> None:
        """
        Writes the report, one HTML file that opens without a server or a network. OSError where it cannot be written.
        """

    def save(self, directory: str | os.PathLike) -> None:
        """
        Writes solution.json, trajectory.h5 and report.html into a directory, as `lamprey solve --out` does; of other minima, too, each in a directory minimum_2, minimum_3 ... within it. OSError where they cannot be written.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

class Solution(Trajectory):
    """
    A motion that was sought, with its certificate. Whether it arrived is its status, never an exception.
    """

    @property
    def cost(self) -> float:
        """By the problem's rule; of effort alone in (N m)² s."""

    @property
    def cost_parts(self) -> dict[str, float] | None:
        """
        effort, work, power, smoothness, angular_velocity, time, transport before weighting, where more than effort and time is asked for.
        """

    @property
    def search(self) -> dict[str, Any] | None:
        """
        starts, solved, minima [{cost, count, by_ipopt where both solvers searched}]; where there are such, strokes and hops (first guesses among them) and set_aside {cost, steps}.
        """

    @property
    def others(self) -> list[Solution]:
        """
        Of other minima, by rising cost, where search.keep of the problem is more than 1; not kept by pickle and load_solution.
        """

    @property
    def solver(self) -> dict[str, Any] | None:
        """
        name, iterations, evaluations, wall_seconds (of the search), processor_seconds (of all workers), total_wall_seconds (of the whole answer), history; limit_weight, (N m)², and work_weight, 1/W, {value, largest}, where there are such multipliers.
        """

    @property
    def feedback(self) -> dict[str, Any] | None:
        """
        Gains about the motion: time (times,), gain (times, controls, states), control_coordinates, state_coordinates.
        """

    @property
    def limit_multipliers(self) -> list[dict[str, Any]] | None:
        """
        What the limits that hold somewhere cost: a dict for each with key (of the problem file), joint, bodies, component and upper (which of its bounds), and multiplier (nodes,): (N m)² by N m, rad, rad/s, m or s, by how much the cost falls for each unit by which the limit gives way, per second.
        """

    @property
    def work_multipliers(self) -> list[list[float]] | None:
        """
        [drives][nodes] signs of the powers, where work has a weight: a row for each joint, of a universal joint with two moments one for each axis.
        """

    @property
    def work_change_multipliers(self) -> list[list[float]] | None:
        """
        [drives][nodes] slopes of the work by the powers' changes over the nodes, where work has a weight.
        """

    def __repr__(self) -> str: ...

    def __getstate__(self) -> bytes: ...

    def __setstate__(self, arg: bytes, /) -> None: ...

def load_solution(directory: str | os.PathLike) -> Trajectory:
    """
    Reads solution.json of a directory: a Solution, or a Trajectory where it was simulated. FileNotFoundError where there is none, another OSError where it is not what Lamprey writes.
    """

def solve(problem: Problem | dict[str, Any] | str | os.PathLike, *, workers: int | None = None, solver: Literal['newton', 'ipopt', 'both'] | None = None, refinement: bool | None = None, time_limit: float | None = None, first: Trajectory | str | os.PathLike | None = None, progress: Callable[[str], object] | None = None, resolve: bool = False) -> Solution:
    """
    Finds the maneuver and proves it: what `lamprey solve` does. Releases the GIL.

    problem: a Problem, its settings as a dict, or the path of a problem file. workers: threads of the search (default: one for each core); without a time limit the answer does not depend on it.
    solver: "newton", "ipopt" or "both" from the same first guesses (default: newton where it takes the problem).
    refinement: solve on half and twice the steps too, for the certificate (default: where that is cheap).
    time_limit: s, wall clock, instead of the problem's. first: a motion of the same bodies and joints, or its directory: the first
    guess, in the place of a random one; its goal, limits, bodies' sizes and steps may have been others. progress: called with
    lines for people, from any thread; what it raises ends the search as Ctrl-C does. resolve: where the problem's steps do not resolve the answer, solve from it on again on more,
    until they do: the answer then has more steps than the problem.

    Not arriving is a status, no exception. Raises InputError for problems that cannot be solved. Ctrl-C raises
    KeyboardInterrupt once the search has stopped; its attribute `solution` then holds the best point so far, with status
    "interrupted": `except KeyboardInterrupt as stop: stop.solution`.
    """

def simulate(problem: Problem | dict[str, Any] | str | os.PathLike, controls: Trajectory | str | os.PathLike | tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike] | Callable[[float], numpy.typing.ArrayLike] | None = None, *, scheme: str | None = None, steps: int | None = None, duration: float | None = None, cycles: int = 1, adaptive: bool = False, reference: bool = False, feedback: Solution | str | os.PathLike | None = None, perturb: float = 0.0, seed: int = 1, angles: Trajectory | str | os.PathLike | tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike] | Callable[[float], numpy.typing.ArrayLike] | None = None, feedback_from: float = 0.0, perturb_inertia: float = 0.0) -> Trajectory:
    """
    Marches from the problem's start, after a stored gait from where that begins: what `lamprey simulate` does. Releases the GIL.

    problem: a Problem, its settings as a dict, or the path of a problem file. controls: None (no moments), a Solution or Trajectory (its moments), a path (solution.json or CSV), a pair (time (rows,) s,
    control (rows, joints, 3) N m; not-a-knot cubic between rows), or a function of time in s that returns (joints, 3) N m:
    moments on the parents, parents' frames with the joints at zero angle; of hinges alone, fixed joints left out, (rows, joints) and (joints,) will do, about the parents' axes.
    scheme, steps, duration: instead of the problem's. cycles: how often the gait of controls or feedback, or the period of a table, is repeated; steps and duration are of all
    cycles together. adaptive: divide steps that do not converge.
    reference: by a Runge-Kutta method on the continuous equations. feedback: a Solution or its directory, followed by its
    moments and gains; feedback_from: s of its time, at which the march begins, from the problem's start, without a duration for the rest of it. perturb: rad, by which each body is turned at the start about a random axis drawn by `seed`. perturb_inertia: share of itself by which each body's mass and inertia, fluid included, differ at most from the problem's, drawn by `seed`. In either case total momentum stays that of the start.
    angles: joint angles to march along, in the place of moments, which are then found: a Solution or Trajectory, a path (solution.json or CSV),
    a pair (time (rows,) s, angles (rows, joints, 3) rad as Trajectory.joint_angle has them), or a function of time in s, asked at the nodes; of hinges alone, fixed joints left out,
    (rows, joints) and (joints,) will do. Joints with actuated = false whose angles are NaN in all rows, or left out of a CSV's header, and all such joints of a stored motion move as they do. Root and total momentum begin as the problem says, steps are as long as the problem's up to the last row; cycles repeats angles that close.

    A march that does not get on ends with status "stalled" and the nodes before. Ctrl-C raises KeyboardInterrupt; its attribute
    `solution` holds the nodes so far.
    """

@overload
def certify(solution: Solution) -> Solution: ...

@overload
def certify(trajectory: Trajectory) -> Trajectory:
    """
    The same motion with its certificate made anew from its own numbers, and the status that this gives it. Releases the GIL; Ctrl-C waits for its end.
    """

class Outcome:
    """How Solver.solve ended."""

    @property
    def status(self) -> str:
        """
        optimal (it converged), feasible (it keeps what is asked, but is not stationary), infeasible (no moment reaches it), stalled (none was found from the last answer on), time_limit or interrupted; unless optimal the last answer stays.
        """

    @property
    def reason(self) -> str:
        """One clause for a person; may be empty where it converged."""

    @property
    def iterations(self) -> int:
        """Newton steps."""

    @property
    def evaluations(self) -> int:
        """Motions that were looked at."""

    @property
    def wall_seconds(self) -> float:
        """s, without the way through Python."""

    def __repr__(self) -> str: ...

class Solver:
    """
    One maneuver solved again and again as its goal, its start or the time left move, each time from the last answer on:
    what a vehicle runs that plans while it swims.

    Owns its workspace; for one thread at a time. Takes limits, waypoints, free durations, periodic goals and all costs, with schemes
    of order 1 or 2; the number of steps stays what it was. Begins at a solution of the problem, or of one like it: then `answered` is False.
    Raises InputError where the problem is not one that it takes or the solution has other nodes or bodies.
    """

    def __init__(self, problem: Problem | dict[str, Any] | str | os.PathLike, solution: Solution) -> None: ...

    def set_goal(self, *, move: Sequence[float | Literal['free']] | None = None, turn: numpy.typing.ArrayLike | None = None, rotation: dict[str, numpy.typing.ArrayLike] = {}, angle: dict[str, numpy.typing.ArrayLike] = {}) -> None:
        """
        Another goal, in the words of [goal] and seen from the problem's own start; what is left out stays.

        move: three entries, m or "free", world frame. turn: rotation vector, rad, world frame. rotation: absolute rotation vectors,
        body → world, by body. angle: rad, by joint, as in [goal] angle. Rows stay what they were, only their values move: InputError otherwise, and where the goal breaks a limit.
        A goal where the swimmer rests is answered by staying.
        """

    def set_start(self, rotation: numpy.typing.ArrayLike, position: numpy.typing.ArrayLike, angular_velocity: numpy.typing.ArrayLike | None = None, linear_velocity: numpy.typing.ArrayLike | None = None) -> None:
        """
        Another start, such as the state that was just measured; the goal stays where it is in the world.

        rotation: (bodies, 3, 3), body → world. position: (3,) m, mass centre of the root, world frame.
        angular_velocity: (bodies, 3) rad/s, body frames; left out: still joints. linear_velocity needs it.
        linear_velocity: (3,) m/s, mass centre of the root, world frame: the whole moves, and carries momentum, as it was seen to; for problems
        whose own start carries some. Left out: only the joints' rates count, and the whole moves as total momentum
        zero demands, which moments cannot change.
        Rotations off their joints by less than 0.1 rad are
        led back onto them, and joints seen beyond a limit of angle, swing or twist by less than that begin at it, still;
        InputError beyond, and where bodies are beyond a clearance or a keep-out by more than a hundredth of the swimmer's size. After advance, which sets a start of its own. Not for periodic goals.
        """

    def set_duration(self, duration: float) -> None:
        """
        Another duration in as many steps, s: the time that is left. Moments stretch with it.

        InputError where it is free or waypoints are tied to times.
        """

    def advance(self, elapsed: float) -> None:
        """
        Time has passed, s, with the swimmer on the last answer: asks for what is left of it, in as many steps.

        The start is where the swimmer is now by that answer; set_start after it tells where it was seen. The time left is less by
        elapsed, bounds of a free duration are, too, and the next solve begins at the rest of the answer. Until one arrives, times
        add up. A least duration that has passed becomes a thousandth of the most; work per distance is that of the rest.
        InputError where nothing is left, for periodic goals and where waypoints are tied to times.
        """

    def solve(self, *, max_iterations: int | None = None, time_limit: float | None = None) -> Outcome:
        """
        Newton steps from the last answer on; releases the GIL.

        The outcome says whether they arrived; unless they did the last answer stays. max_iterations: Newton steps in all, 500 and more while they pay where none are given. time_limit: s; where it ended a search the next one goes on. Ctrl-C raises KeyboardInterrupt; InputError where max_iterations is negative or time_limit not above 0; RuntimeError where another thread is in this Solver.
        """

    @property
    def answered(self) -> bool:
        """
        Whether the last answer belongs to the goal, start and duration that were set last: false from then on until a solve arrives, and after one that does not. Ends that moments do not reach by less than 1e-6 (rad, units of length), as of a
        planar swimmer measured a little out of its plane, count as they are reached.
        """

    @property
    def passed(self) -> float:
        """
        s of the last answer that have passed, by advance; 0 from a solve on that arrives. Where one does not, a vehicle goes on by
        the rest of what it has: simulate(feedback=solver.solution(feedback=True), feedback_from=solver.passed).
        """

    @property
    def path(self) -> dict[str, numpy.typing.NDArray[numpy.float64]]:
        """
        The last answer's arrays by name: "time", "position", "rotation" and "control", as in Solution.
        """

    @property
    def cost(self) -> float:
        """Of the last answer, by the problem's rule."""

    def solution(self, *, feedback: bool = False) -> Solution:
        """
        The last answer with velocities and momenta; at first the solution that was given. Its certificate is None: see certify.

        feedback: with gains about it, for simulate(feedback=) or a vehicle that follows it until the next answer; ValueError where that answer is no motion.
        """
