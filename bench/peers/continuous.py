"""The continuous equations of docs/theory, chapter 2, as CasADi expressions, and their numbers."""
import casadi
import numpy

from casadi_transcription import joint_forces


def gathered(bodies, R, linear, angular):
    """Generalised force or momentum (2.8), (2.5) of forces (world) at mass centres and torques (body) about them."""
    linear, angular = list(linear), list(angular)
    for i in reversed(range(1, len(bodies))):  # from the leaves to the root
        body, a = bodies[i], bodies[i].parent
        angular[i] = angular[i] - casadi.cross(body.child_offset, R[i].T @ linear[i])
        angular[a] = angular[a] + casadi.cross(body.parent_offset, R[a].T @ linear[i])
        linear[a] = linear[a] + linear[i]
    return linear[0], angular


def spread(bodies, R, root, at_offset):
    """Of each mass centre: the root's, and along the tree what at_offset(body, offset) says of joints, body frames."""
    found = [root]
    for i, body in enumerate(bodies[1:], start=1):
        a = body.parent
        found.append(found[a] + R[a] @ at_offset(a, body.parent_offset) - R[i] @ at_offset(i, body.child_offset))
    return found


def momentum(bodies, R, Omega, velocity):
    """(p_x, μ_i) of (2.5)."""
    rates = spread(bodies, R, velocity, lambda i, d: casadi.cross(Omega[i], d))
    linear = [R[i] @ (body.mass_matrix @ (R[i].T @ rates[i])) for i, body in enumerate(bodies)]
    return gathered(bodies, R, linear, [body.inertia_matrix @ Omega[i] for i, body in enumerate(bodies)])


def needed_force(bodies, R, Omega, velocity, Omega_rate, acceleration):
    """(U_x, U_i) that the motion needs, (2.7) and (2.8)."""
    def turning(i, d):
        return casadi.cross(Omega_rate[i], d) + casadi.cross(Omega[i], casadi.cross(Omega[i], d))
    rates = spread(bodies, R, velocity, lambda i, d: casadi.cross(Omega[i], d))
    accelerations = spread(bodies, R, acceleration, turning)
    force, torque = [], []
    for i, body in enumerate(bodies):
        M, J = body.mass_matrix, body.inertia_matrix
        V = R[i].T @ rates[i]
        V_rate = R[i].T @ accelerations[i] - casadi.cross(Omega[i], V)
        force.append(R[i] @ (M @ V_rate + casadi.cross(Omega[i], M @ V)))
        torque.append(J @ Omega_rate[i] + casadi.cross(Omega[i], J @ Omega[i]) + casadi.cross(V, M @ V))
    return gathered(bodies, R, force, torque)


class Numbers:
    """Rates and total momentum of the whole swimmer as functions of plain arrays; rotations are 3×3 for each body."""

    def __init__(self, problem):
        bodies, count = problem.bodies, len(problem.bodies)
        Rs = [casadi.SX.sym(f"R{i}", 3, 3) for i in range(count)]
        Omega, rate = ([casadi.SX.sym("w", 3) for _ in range(count)] for _ in range(2))
        x, v, a = (casadi.SX.sym(name, 3) for name in "xva")
        u = casadi.SX.sym("u", sum(problem.moments()))
        force, torque = needed_force(bodies, Rs, Omega, v, rate, a)
        U = joint_forces(bodies, Rs, u)
        missing = casadi.vertcat(*(t - U[i] for i, t in enumerate(torque)), force)
        unknown = casadi.vertcat(*rate, a)
        zero = casadi.DM.zeros(unknown.shape)
        inertia = casadi.jacobian(missing, unknown)
        bias = casadi.substitute(missing, unknown, zero)
        given = [casadi.horzcat(*Rs), casadi.horzcat(*Omega), v, u]
        self.equations = casadi.Function("equations", given, [casadi.cse(casadi.densify(inertia)), casadi.cse(bias)])
        p_x, mu = momentum(bodies, Rs, Omega, v)
        p_Omega = casadi.cross(x, p_x) + sum(R @ m for R, m in zip(Rs, mu))
        self.momenta = casadi.Function("momenta", [casadi.horzcat(*Rs), casadi.horzcat(*Omega), v, x],
                                       [casadi.vertcat(p_x, p_Omega), casadi.vertcat(*mu, p_x)])
        self.count = count

    def accelerations(self, R, Omega, velocity, control):
        """ξ̇ = (Ω̇_0, …, ẍ); R: [bodies][3][3], Omega: [bodies][3]."""
        inertia, bias = self.equations(numpy.hstack(R), Omega.T, velocity, control)
        return numpy.linalg.solve(inertia.full(), -bias.full().ravel())

    def momentum_drift(self, motion):
        """Largest total momentum, of a motion from rest, as a share of the largest entry of μ."""
        R = motion.path.rotation
        found = [self.momenta(numpy.hstack(R[k]), motion.spin[k].T, motion.velocity[k], motion.path.position[k])
                 for k in range(len(R))]
        scale = max(abs(mu.full()).max() for _, mu in found)
        return max(abs(total.full()).max() for total, _ in found) / scale
