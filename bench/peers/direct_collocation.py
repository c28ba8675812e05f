"""Maneuvers by direct collocation of the continuous equations, trapezoidal or Hermite–Simpson, with CasADi and Ipopt.

Variables at each point (nodes, and for Hermite–Simpson their middles): attitude, position, velocities, accelerations, moments. Rows: equations
of motion at each point, collocation of each step, goal. Total momentum is whatever the method makes of it.
"""
import dataclasses

import casadi
import numpy
from scipy.interpolate import CubicSpline

from casadi_transcription import CONTROL_UNIT, Plane, Space, joint_forces, quaternion_product
from continuous import needed_force
from problem import Path, continuous_quaternions, refined
from staged_program import Block, StagedProgram

TRAPEZOIDAL, HERMITE_SIMPSON = "trapezoidal", "Hermite–Simpson"


@dataclasses.dataclass
class Motion:
    """A motion with its velocities at the nodes; moments between nodes: linear, or the parabola through those of the middles."""

    path: Path
    spin: numpy.ndarray  # [N+1][bodies][3], rad/s, body frames
    velocity: numpy.ndarray  # [N+1][3], m/s, of the root's mass centre, world
    middle_control: numpy.ndarray = None  # [N][sum of moments()], N m


class Collocation:
    def __init__(self, problem, steps, method, folder=None):
        self.problem, self.steps, self.method = problem, steps, method
        self.chart = Plane(problem) if problem.planar else Space(problem)
        self.planar = problem.planar
        self.per_step = 2 if method == HERMITE_SIMPSON else 1
        self.h = problem.duration / steps
        chart = self.chart
        turning, moving = len(chart.about) * chart.count, len(chart.along)
        # a point: attitude, position, spin, velocity; their rates beyond; control
        self.sizes = [chart.attitude_size, moving, turning, moving, turning, moving, sum(problem.moments())]
        self.state_size = sum(self.sizes[:4])
        self.stride = sum(self.sizes)
        self.points = steps * self.per_step + 1
        self.program = StagedProgram(self.weights(), numpy.arange(self.state_size), *self.blocks(), folder)

    def weights(self):
        weight = numpy.zeros((self.points, self.stride))
        simpson = self.method == HERMITE_SIMPSON
        pattern = numpy.array([1.0, 4.0, 1.0]) / 6.0 if simpson else numpy.array([0.5, 0.5])
        each = numpy.zeros(self.points)
        for k in range(self.steps):
            each[k * self.per_step:(k + 1) * self.per_step + 1] += self.h * pattern
        weight[:, -self.sizes[-1]:] = each[:, None]
        return weight.ravel()

    def blocks(self):
        motion, step, end = self.motion(), self.step(), self.end()
        dynamics = motion.size1_out(0)
        row_count, blocks = 0, []
        for function, first, stages in ((motion, numpy.arange(self.points), self.points),
                                        (step, numpy.arange(self.steps) * self.per_step, self.steps),
                                        (end, numpy.array([self.points - 1]), 1)):
            size = function.size1_out(0)
            rows = row_count + numpy.arange(size)[:, None] + size * numpy.arange(stages)
            variables = numpy.arange(function.size1_in(0))[:, None] + self.stride * first
            blocks.append(Block(function, variables, rows, numpy.full((1, stages), self.h)))
            row_count += size * stages
        return row_count, blocks

    def symbols(self):
        return [casadi.SX.sym(name, size) for name, size in
                zip(("attitude", "position", "spin", "velocity", "spin_rate", "acceleration", "control"), self.sizes)]

    def spins(self, values):
        """Three components for each body."""
        if self.planar:
            return [casadi.vertcat(0.0, 0.0, values[i]) for i in range(self.chart.count)]
        return [values[3 * i:3 * i + 3] for i in range(self.chart.count)]

    def vector(self, values):
        return casadi.vertcat(values, 0.0) if self.planar else values

    def motion(self):
        """Equations of motion at a point (2.9), in the unit of moments."""
        point = self.symbols()
        attitude, _, spin, velocity, spin_rate, acceleration, control = point
        bodies, chart = self.problem.bodies, self.chart
        R = chart.rotations(attitude)
        force, torque = needed_force(bodies, R, self.spins(spin), self.vector(velocity), self.spins(spin_rate),
                                     self.vector(acceleration))
        U = joint_forces(bodies, R, CONTROL_UNIT * control)
        rows = [force[chart.along]] + [(t - u)[chart.about] for t, u in zip(torque, U)]
        z, h = casadi.vertcat(*point), casadi.SX.sym("h")
        return casadi.Function("motion", [z, h], [casadi.vertcat(*rows) / CONTROL_UNIT])

    def state_and_rate(self, point):
        attitude, position, spin, velocity, spin_rate, acceleration, _ = point
        if self.planar:
            turning = [spin]
        else:
            quaternions = self.chart.each(attitude, 4)
            turning = [0.5 * quaternion_product(q, casadi.vertcat(0.0, w)) for q, w in zip(quaternions, self.spins(spin))]
        return (casadi.vertcat(attitude, position, spin, velocity),
                casadi.vertcat(*turning, velocity, spin_rate, acceleration))

    def step(self):
        points = [self.symbols() for _ in range(self.per_step + 1)]
        h = casadi.SX.sym("h")
        (y, f), (y_next, f_next) = self.state_and_rate(points[0]), self.state_and_rate(points[-1])
        if self.method == TRAPEZOIDAL:
            rows = [y_next - y - 0.5 * h * (f + f_next)]
        else:
            middle, f_middle = self.state_and_rate(points[1])
            rows = [middle - 0.5 * (y + y_next) - h / 8.0 * (f - f_next), y_next - y - h / 6.0 * (f + 4.0 * f_middle + f_next)]
        z = casadi.vertcat(*(part for point in points for part in point))
        return casadi.Function("step", [z, h], [casadi.vertcat(*rows)])

    def end(self):
        """Goal, and rest of the joints: with total momentum zero the whole rests (docs/theory, chapter 5)."""
        point = self.symbols()
        attitude, position, spin = point[:3]
        chart, problem = self.chart, self.problem
        R, Omega = chart.rotations(attitude), self.spins(spin)
        goal = chart.attitudes(continuous_quaternions(problem.end[None]))[0]
        rows = [chart.goal(attitude, goal)]
        rows += [position[c] - problem.move[c] for c in chart.along if problem.move[c] is not None]
        for i, body in enumerate(problem.bodies[1:], start=1):
            rows.append((Omega[i] - R[i].T @ (R[body.parent] @ Omega[body.parent]))[chart.about])
        z, h = casadi.vertcat(*point), casadi.SX.sym("h")
        return casadi.Function("end", [z, h], [casadi.vertcat(*rows)])

    def pack(self, path):
        """Velocities and accelerations by splines."""
        chart = self.chart
        path = refined(path, self.points - 1)
        times = numpy.linspace(0.0, self.problem.duration, self.points)
        attitude = chart.attitudes(path.quaternion)
        rate = CubicSpline(times, attitude)(times, 1)
        if self.planar:
            spin = rate
        else:
            q, q_rate = path.quaternion, rate.reshape(path.quaternion.shape)
            vector = q[..., :1] * q_rate[..., 1:] - q_rate[..., :1] * q[..., 1:] - numpy.cross(q[..., 1:], q_rate[..., 1:])
            spin = 2.0 * vector.reshape(self.points, -1)
        along = CubicSpline(times, path.position[:, chart.along])
        spin[0] = 0.0
        velocity = along(times, 1)
        velocity[0] = 0.0
        parts = [attitude, path.position[:, chart.along], spin, velocity, CubicSpline(times, spin)(times, 1), along(times, 2),
                 path.control / CONTROL_UNIT]
        return numpy.hstack(parts).ravel()

    def unpack(self, point):
        values = point.reshape(self.points, self.stride)
        attitude, along, spin, velocity, _, _, control = numpy.split(values, numpy.cumsum(self.sizes)[:-1], axis=1)
        nodes = slice(None, None, self.per_step)
        chart, count = self.chart, self.steps + 1

        def components(found, which, shape):
            full = numpy.zeros((count, *shape, 3))
            full[..., which] = found[nodes].reshape(count, *shape, -1)
            return full

        path = Path(chart.quaternions(attitude[nodes]), components(along, chart.along, ()), CONTROL_UNIT * control[nodes])
        middle = CONTROL_UNIT * control[1::2] if self.method == HERMITE_SIMPSON else None
        return Motion(path, components(spin, chart.about, (chart.count,)), components(velocity, chart.along, ()), middle)

    def cost(self, outcome):
        return 0.5 * CONTROL_UNIT**2 * float(self.weights() @ outcome.point**2)

    def solve(self, path, options=None):
        outcome = self.program.solve(self.pack(path), options=options)
        outcome.motion = self.unpack(outcome.point)
        return outcome
