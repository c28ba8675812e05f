"""A maneuver as peers need it, read from a problem file; first guesses; motions on finer grids."""
import dataclasses
import math
import tomllib

import numpy
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation

HARMONICS = 4
AMPLITUDE = 0.8  # rad, of a guess's first harmonic


class Unsuitable(Exception):
    """What these scripts do not model."""


@dataclasses.dataclass
class Body:
    name: str
    mass_matrix: numpy.ndarray  # 3×3, kg, body + fluid
    inertia_matrix: numpy.ndarray  # 3×3, kg m², body + fluid
    parent: int = -1  # -1: the root
    parent_offset: numpy.ndarray = None  # m, parent's mass centre → joint, parent's frame
    child_offset: numpy.ndarray = None  # m, own mass centre → joint, own frame
    control_axes: numpy.ndarray = None  # 3×m: the joint's moment on the parent, parent's frame, is this times m numbers


@dataclasses.dataclass
class Problem:
    """From rest to rest by ball joints; parents stand before their children."""

    name: str
    bodies: list
    start: numpy.ndarray  # [bodies] 3×3, body → world
    turn: numpy.ndarray  # rotation vector, world: every body ends turned by it
    move: list  # 3 displacements of the root's mass centre, m, None where free
    duration: float  # s
    steps: int

    @property
    def planar(self):
        """All moments about e_3 alone, as are start and goal."""
        axes = numpy.hstack([body.control_axes for body in self.bodies[1:]])
        flat = all(abs(R[2, 2] - 1.0) < 1e-15 for R in self.start) and not self.turn[:2].any()
        return flat and not axes[:2].any()

    @property
    def end(self):
        return Rotation.from_rotvec(self.turn).as_matrix() @ self.start

    def moments(self):
        """How many numbers a joint's moment has, for each body but the root."""
        return [body.control_axes.shape[1] for body in self.bodies[1:]]


def matrix(written):
    array = numpy.array(written, dtype=float)
    return numpy.diag(array) if array.ndim == 1 else array


def required(table, key, where):
    if key not in table:
        raise Unsuitable(f"{where}: {key} is missing")
    return table[key]


def read(path):
    with open(path, "rb") as stream:
        written = tomllib.load(stream)
    names = [body["name"] for body in written["body"]]
    bodies = [Body(body["name"], matrix(required(body, "mass_matrix", path)), matrix(required(body, "inertia_matrix", path)))
              for body in written["body"]]
    for joint in written["joint"]:
        if joint["kind"] != "ball" or {"stiffness", "damping"} & joint.keys():
            raise Unsuitable(f"{path}: joints other than ball joints without springs and dampers")
        body = bodies[names.index(joint["child"])]
        body.parent = names.index(joint["parent"])
        body.parent_offset, body.child_offset = numpy.array(joint["parent_offset"]), numpy.array(joint["child_offset"])
        body.control_axes = numpy.array(joint.get("control_axes", numpy.eye(3))).T
    if any(body.parent >= i for i, body in enumerate(bodies)):
        raise Unsuitable(f"{path}: a body stands before its parent")
    start, goal = written["start"], written["goal"]
    if any("velocity" in key for key in start) or not goal.get("rest") or "rotation" in goal:
        raise Unsuitable(f"{path}: other than from rest to rest, all bodies turned alike")
    turned = [Rotation.from_rotvec(start.get("rotation", {}).get(name, [0.0, 0.0, 0.0])).as_matrix() for name in names]
    move = [None if component == "free" else component for component in goal.get("move", ["free"] * 3)]
    return Problem(written["name"], bodies, numpy.array(turned), numpy.array(goal["turn"]), move,
                   written["time"]["duration"], written["time"]["steps"])


@dataclasses.dataclass
class Path:
    """A motion at the nodes of a grid. Quaternions are (scalar, vector), without jumps of sign along the motion."""

    quaternion: numpy.ndarray  # [N+1][bodies][4]
    position: numpy.ndarray  # [N+1][3], m
    control: numpy.ndarray  # [N+1][sum of moments()], N m

    @property
    def steps(self):
        return len(self.position) - 1

    @property
    def rotation(self):
        shape = self.quaternion.shape[:2]
        flat = self.quaternion.reshape(-1, 4)
        return Rotation.from_quat(flat, scalar_first=True).as_matrix().reshape(*shape, 3, 3)


def continuous_quaternions(rotation):
    """Of rotation matrices [N+1][bodies][3][3], without jumps of sign."""
    flat = Rotation.from_matrix(rotation.reshape(-1, 3, 3)).as_quat(scalar_first=True)
    quaternion = flat.reshape(*rotation.shape[:2], 4)
    quaternion[0] *= numpy.where(quaternion[0, :, :1] < 0.0, -1.0, 1.0)
    jumps = numpy.sign((quaternion[1:] * quaternion[:-1]).sum(axis=2))
    quaternion[1:] *= numpy.cumprod(numpy.where(jumps == 0.0, 1.0, jumps), axis=0)[..., None]
    return quaternion


def refined(path, steps):
    """On a grid of `steps`: cubic splines through quaternions, positions and moments."""
    def through(values):
        return CubicSpline(numpy.linspace(0.0, 1.0, len(values)), values)(numpy.linspace(0.0, 1.0, steps + 1))

    quaternion = through(path.quaternion)
    return Path(quaternion / numpy.linalg.norm(quaternion, axis=2, keepdims=True), through(path.position),
                through(path.control))


class Random:
    """SplitMix64, and normal numbers by Box and Muller: Lamprey's own, so that one seed means one first guess on both sides."""

    def __init__(self, seed):
        self.state = seed % 2**64

    def uniform(self):
        self.state = (self.state + 0x9E3779B97F4A7C15) % 2**64
        z = self.state
        z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) % 2**64
        z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) % 2**64
        z ^= z >> 31
        return ((z >> 11) + 0.5) * 2.0**-53

    def normal(self):
        radius = math.sqrt(-2.0 * math.log(self.uniform()))
        return radius * math.cos(2.0 * math.pi * self.uniform())


def random_guess(problem, seed, steps):
    """The first guess of `lamprey solve` for `[search] seed`: joints swing at random, the root goes straight to its goal (5.10)."""
    random = Random(seed * 0x100000001B3)
    s = numpy.linspace(0.0, 1.0, steps + 1)
    blend = s**3 * (10.0 + s * (6.0 * s - 15.0))
    waves = numpy.array([numpy.sin((m + 1) * math.pi * s) * numpy.sin(math.pi * s) for m in range(HARMONICS)])
    rotation = numpy.zeros((steps + 1, len(problem.bodies), 3, 3))
    turn = problem.start[0].T @ problem.turn
    rotation[:, 0] = problem.start[0] @ Rotation.from_rotvec(blend[:, None] * turn).as_matrix()
    for i, body in enumerate(problem.bodies[1:], start=1):
        amplitudes = numpy.array([[AMPLITUDE * random.normal() / (m + 1) for _ in range(body.control_axes.shape[1])]
                                  for m in range(HARMONICS)])
        swing = Rotation.from_rotvec(waves.T @ amplitudes @ body.control_axes.T).as_matrix()
        start = problem.start[body.parent].T @ problem.start[i]
        end = problem.end[body.parent].T @ problem.end[i]
        change = Rotation.from_matrix(start.T @ end).as_rotvec()
        joint = swing @ start @ Rotation.from_rotvec(blend[:, None] * change).as_matrix()
        rotation[:, i] = rotation[:, body.parent] @ joint
    shift = numpy.array([component or 0.0 for component in problem.move])
    return Path(continuous_quaternions(rotation), blend[:, None] * shift,
                numpy.zeros((steps + 1, sum(problem.moments()))))
