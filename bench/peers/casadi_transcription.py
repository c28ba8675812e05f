"""Maneuvers by CasADi and Ipopt: the discrete problem of `lamprey solve` as a full transcription at zero total momentum.

Variables: rotations, position and moments at the nodes, Cayley vectors of the steps' turns. Rows: kinematics, zero total momentum of each
step in place of the root's balance, balance of all other bodies, goal. In a plane angles take the place of quaternions and Cayley vectors.
Letters and equation numbers are those of docs/theory.
"""
import casadi
import numpy
from scipy.interpolate import CubicSpline

from problem import Path, continuous_quaternions
from staged_program import Block, StagedProgram

CONTROL_UNIT = 100.0  # N m


def vee_twice(A):
    return casadi.vertcat(A[2, 1] - A[1, 2], A[0, 2] - A[2, 0], A[1, 0] - A[0, 1])


def quaternion_product(a, b):
    vector = a[0] * b[1:] + b[0] * a[1:] + casadi.cross(a[1:], b[1:])
    return casadi.vertcat(a[0] * b[0] - casadi.dot(a[1:], b[1:]), vector)


def momenta_of_step(bodies, h, R, E, shift_of_root):
    """(p⁻_i, p⁺_i, p_x) of the trapezoid scheme, (4.2) and (4.3); R and E = F − I: 3×3 of each body."""
    count = len(bodies)
    R_next = [R[i] + R[i] @ E[i] for i in range(count)]
    D = [shift_of_root]
    for i, body in enumerate(bodies[1:], start=1):
        a = body.parent
        D.append(D[a] + R[a] @ (E[a] @ body.parent_offset) - R[i] @ (E[i] @ body.child_offset))
    P, minus, plus = [], [], []
    for i, body in enumerate(bodies):
        M, J = body.mass_matrix, body.inertia_matrix
        Jd = 0.5 * numpy.trace(J) * numpy.eye(3) - J
        w, w_next = R[i].T @ D[i], R_next[i].T @ D[i]
        P.append((R[i] @ (M @ w) + R_next[i] @ (M @ w_next)) / (2.0 * h))
        minus.append((vee_twice(E[i] @ Jd) + 0.5 * casadi.cross(w, M @ w)) / h)
        plus.append((vee_twice(Jd @ E[i]) - 0.5 * casadi.cross(w_next, M @ w_next)) / h)
    for i in reversed(range(1, count)):  # from the leaves to the root
        body, a = bodies[i], bodies[i].parent
        for p, frame in ((minus, R), (plus, R_next)):
            p[i] = p[i] - casadi.cross(body.child_offset, frame[i].T @ P[i])
            p[a] = p[a] + casadi.cross(body.parent_offset, frame[a].T @ P[i])
        P[a] = P[a] + P[i]
    return minus, plus, P[0]


def joint_forces(bodies, R, control):
    """U_i of (1.5), each body's own frame; control: numbers of all joints, N m."""
    U, used = [casadi.SX.zeros(3) for _ in bodies], 0
    for i, body in enumerate(bodies[1:], start=1):
        u = casadi.DM(body.control_axes) @ control[used:used + body.control_axes.shape[1]]
        used += body.control_axes.shape[1]
        U[body.parent] += u
        U[i] -= R[i].T @ (R[body.parent] @ u)
    return U


class Space:
    """Attitudes are quaternions of any length, R = R(q/|q|); turns are scaled Cayley vectors, F = cayley(h ω/2)."""

    along, about = [0, 1, 2], [0, 1, 2]  # components of vectors and of rotations that the motion has

    def __init__(self, problem):
        self.count = len(problem.bodies)
        self.attitude_size, self.turn_size, self.kinematics_size = 4 * self.count, 3 * self.count, 4 * self.count

    def each(self, v, size):
        return [v[size * i:size * (i + 1)] for i in range(self.count)]

    def rotations(self, attitude):
        def rotation(q):
            V = casadi.skew(q[1:])
            return casadi.SX.eye(3) + 2.0 / casadi.dot(q, q) * (q[0] * V + V @ V)
        return [rotation(q) for q in self.each(attitude, 4)]

    def turns(self, h, attitude, turn, attitude_next):
        """F − I of each body, without subtraction (4.8)."""
        def minus_identity(zeta):
            V = casadi.skew(zeta)
            return 2.0 / (1.0 + casadi.dot(zeta, zeta)) * (V + V @ V)
        return [minus_identity(0.5 * h * omega) for omega in self.each(turn, 3)]

    def kinematics(self, h, attitude, turn, attitude_next):
        rows = []
        for q, omega, q_next in zip(self.each(attitude, 4), self.each(turn, 3), self.each(attitude_next, 4)):
            zeta = 0.5 * h * omega
            F = casadi.vertcat(1.0, zeta) / casadi.sqrt(1.0 + casadi.dot(zeta, zeta))
            rows.append(q_next - quaternion_product(q, F))
        return casadi.vertcat(*rows)

    def goal(self, attitude, end):
        """2 vec(q_goal* ∘ q) of each body; end: the goal in this chart."""
        conjugate = [casadi.DM(q * numpy.array([1.0, -1.0, -1.0, -1.0])) for q in self.each(end, 4)]
        return casadi.vertcat(*(2.0 * quaternion_product(g, q)[1:] for g, q in zip(conjugate, self.each(attitude, 4))))

    def attitudes(self, quaternion):
        return quaternion.reshape(len(quaternion), -1)

    def quaternions(self, attitude):
        q = attitude.reshape(len(attitude), -1, 4)
        return q / numpy.linalg.norm(q, axis=2, keepdims=True)

    def packed_turns(self, h, quaternion):
        q, q_next = quaternion[:-1], quaternion[1:]
        scalar = (q * q_next).sum(axis=2, keepdims=True)
        vector = q[..., :1] * q_next[..., 1:] - q_next[..., :1] * q[..., 1:] - numpy.cross(q[..., 1:], q_next[..., 1:])
        return (2.0 / h * vector / scalar).reshape(len(q), -1)


class Plane:
    """Attitudes are angles about e_3; turns are their differences."""

    along, about = [0, 1], [2]
    turn_size, kinematics_size = 0, 0

    def __init__(self, problem):
        self.count = self.attitude_size = len(problem.bodies)

    def rotations(self, attitude):
        def rotation(angle):
            c, s, R = casadi.cos(angle), casadi.sin(angle), casadi.SX(3, 3)
            R[0, 0], R[0, 1], R[1, 0], R[1, 1], R[2, 2] = c, -s, s, c, 1.0
            return R
        return [rotation(attitude[i]) for i in range(self.count)]

    def turns(self, h, attitude, turn, attitude_next):
        def minus_identity(angle):
            c, s, E = -2.0 * casadi.sin(0.5 * angle)**2, casadi.sin(angle), casadi.SX(3, 3)
            E[0, 0], E[0, 1], E[1, 0], E[1, 1] = c, -s, s, c
            return E
        return [minus_identity(attitude_next[i] - attitude[i]) for i in range(self.count)]

    def kinematics(self, h, attitude, turn, attitude_next):
        return casadi.SX(0, 1)

    def goal(self, attitude, end):
        return attitude - casadi.DM(end)

    def attitudes(self, quaternion):
        return 2.0 * numpy.unwrap(numpy.arctan2(quaternion[..., 3], quaternion[..., 0]), axis=0)

    def quaternions(self, attitude):
        zero = numpy.zeros_like(attitude)
        return numpy.stack([numpy.cos(0.5 * attitude), zero, zero, numpy.sin(0.5 * attitude)], axis=2)

    def packed_turns(self, h, quaternion):
        return numpy.zeros((len(quaternion) - 1, 0))


class Transcription:
    """A problem on a grid. A point holds attitude, position, control of each node, and between them each step's turn."""

    def __init__(self, problem, steps, folder=None):
        self.problem, self.steps, self.h = problem, steps, problem.duration / steps
        self.chart = Plane(problem) if problem.planar else Space(problem)
        chart, N = self.chart, steps
        self.controls = sum(problem.moments())
        self.sizes = [chart.attitude_size, len(chart.along), self.controls, chart.turn_size]
        self.stride = sum(self.sizes)
        self.size = (N + 1) * self.stride - chart.turn_size
        self.balances = len(chart.about) * (chart.count - 1)
        self.momenta = len(chart.along) + len(chart.about)
        # rows: kinematics, momentum, balance of each step; balance of the last node; goal
        self.row_stride = chart.kinematics_size + self.momenta + self.balances
        self.program = StagedProgram(self.weights(), self.fixed(), *self.blocks(), folder)

    def weights(self):
        weight = numpy.zeros((self.steps + 1, self.stride))
        first = self.sizes[0] + self.sizes[1]
        weight[:, first:first + self.controls] = self.h
        weight[[0, -1]] *= 0.5
        return weight.ravel()[:self.size]

    def fixed(self):
        return numpy.arange(self.sizes[0] + self.sizes[1])

    def blocks(self):
        N = self.steps
        stage, end = self.stage(), self.end()
        nodes, steps = numpy.arange(N + 1), numpy.arange(N)
        step = numpy.full((2, N), self.h)  # h, and the weight of U
        step[1, 0] *= 0.5
        first = self.row_stride - self.balances
        rows = numpy.concatenate([numpy.arange(self.row_stride), numpy.arange(first, first + self.balances) + self.row_stride])
        rows = rows[:, None] + self.row_stride * steps
        rows[self.row_stride:, -1] -= first  # the last node has a balance only
        last = numpy.arange(end.size1_out(0)) + N * self.row_stride
        variables = numpy.arange(stage.size1_in(0))[:, None] + self.stride * steps
        at_end = numpy.arange(end.size1_in(0)) + N * self.stride
        blocks = [Block(stage, variables, rows, step), Block(end, at_end[:, None], last[:, None], step[:1, -1:])]
        return N * self.row_stride + len(last), blocks

    def stage(self):
        """Step k: (node, turn, attitude and position of the next node; h, weight of U) → kinematics, momentum, balance at k, and at k + 1."""
        chart, bodies = self.chart, self.problem.bodies
        attitude, position, control, turn, attitude_next, position_next = (
            casadi.SX.sym(name, size) for name, size in
            zip(("attitude", "position", "control", "turn", "attitude_next", "position_next"), self.sizes + self.sizes[:2]))
        h, weight = casadi.SX.sym("h"), casadi.SX.sym("weight")
        R = chart.rotations(attitude)
        E = chart.turns(h, attitude, turn, attitude_next)
        shift = position_next - position
        shift = casadi.vertcat(shift, 0.0) if len(chart.along) == 2 else shift
        minus, plus, linear = momenta_of_step(bodies, h, R, E, shift)
        angular = sum(R[i] @ minus[i] for i in range(chart.count))
        U = joint_forces(bodies, R, CONTROL_UNIT * control)
        rows = [chart.kinematics(h, attitude, turn, attitude_next), linear[chart.along], angular[chart.about]]
        rows += [(minus[i] - weight * U[i])[chart.about] for i in range(1, chart.count)]
        rows += [-plus[i][chart.about] for i in range(1, chart.count)]
        z = casadi.vertcat(attitude, position, control, turn, attitude_next, position_next)
        return casadi.Function("stage", [z, casadi.vertcat(h, weight)], [casadi.vertcat(*rows)])

    def end(self):
        """Last node → rest of all bodies but the root, goal (5.5)."""
        chart, problem, h = self.chart, self.problem, casadi.SX.sym("h")
        attitude, position, control = (casadi.SX.sym(name, size) for name, size in
                                       zip(("attitude", "position", "control"), self.sizes))
        U = joint_forces(problem.bodies, chart.rotations(attitude), CONTROL_UNIT * control)
        goal = chart.attitudes(continuous_quaternions(problem.end[None]))[0]
        rows = [-0.5 * h * U[i][chart.about] for i in range(1, chart.count)] + [chart.goal(attitude, goal)]
        rows += [position[c] - problem.move[c] for c in chart.along if problem.move[c] is not None]
        return casadi.Function("end", [casadi.vertcat(attitude, position, control), h], [casadi.vertcat(*rows)])

    def pack(self, path):
        turns = self.chart.packed_turns(self.h, path.quaternion)
        turns = numpy.vstack([turns, numpy.zeros((1, self.chart.turn_size))])
        nodes = [self.chart.attitudes(path.quaternion), path.position[:, self.chart.along], path.control / CONTROL_UNIT, turns]
        return numpy.hstack(nodes).ravel()[:self.size]

    def unpack(self, point):
        padded = numpy.concatenate([point, numpy.zeros(self.chart.turn_size)]).reshape(self.steps + 1, self.stride)
        attitude, along, control, _ = numpy.split(padded, numpy.cumsum(self.sizes)[:-1], axis=1)
        position = numpy.zeros((self.steps + 1, 3))
        position[:, self.chart.along] = along
        return Path(self.chart.quaternions(attitude), position, CONTROL_UNIT * control)

    def cost(self, path):
        weight = numpy.full(self.steps + 1, self.h)
        weight[[0, -1]] *= 0.5
        return 0.5 * float(weight @ (path.control ** 2).sum(axis=1))

    def solve(self, path, multiplier=None, options=None):
        """An outcome whose motion is a path."""
        outcome = self.program.solve(self.pack(path), multiplier, options)
        outcome.motion = self.unpack(outcome.point)
        return outcome

    def carried_multiplier(self, coarse, multiplier):
        """Multipliers of a coarser grid's answer on this one. Momentum rows are algebraic: their multipliers go with h."""
        rows, first = coarse.steps * coarse.row_stride, coarse.row_stride - coarse.balances
        inner = multiplier[:rows].reshape(coarse.steps, -1)
        balance = numpy.vstack([inner[:, first:], multiplier[rows:rows + self.balances]])
        of_step = numpy.array(inner[:, :first])
        of_step[:, first - self.momenta:] *= self.h / coarse.h

        def on(values, times, wanted):
            return CubicSpline(times, values)(wanted)

        middles = (numpy.arange(coarse.steps) + 0.5) / coarse.steps
        wanted = (numpy.arange(self.steps) + 0.5) / self.steps
        of_step = on(of_step, middles, wanted)
        balance = on(balance, numpy.linspace(0.0, 1.0, coarse.steps + 1), numpy.linspace(0.0, 1.0, self.steps + 1))
        inner = numpy.hstack([of_step, balance[:-1]])
        return numpy.concatenate([inner.ravel(), balance[-1], multiplier[rows + self.balances:]])
