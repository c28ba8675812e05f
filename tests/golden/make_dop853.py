#!/usr/bin/env python3
"""Golden trajectories of the three-body chain: the continuous equations (docs/theory, section 2) in Lie-Poisson form,
written from the kinetic energy alone, marched by scipy's DOP853 at rtol = atol = 1e-13.

State: rotations (body -> world), x (root's mass centre), mu = (pi_0, p, pi_1, pi_2), the derivative of T with respect
to (Omega_0, xdot, Omega_1, Omega_2).
  d pi_i/dt = pi_i x Omega_i + (derivative of T along dR_i = R_i hat(eta)) + U_i,   dp/dt = 0
u_j acts on the root in the root's frame, its opposite on the child. Each case is marched a second time with small
steps; `estimated_error` is the largest difference of any stored number. The right-hand side is compared with the
80-digit accelerations of reference.json first.

usage:  make_dop853.py [dop853.json]        (needs numpy and scipy; fifteen seconds)
"""
import json
import os
import sys

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

HERE = os.path.dirname(os.path.abspath(__file__))
TIMES = [0.1, 1.0]
BODIES = range(3)
SLOT = (0, 2, 3)  # slot of body i among the four 3-vectors of mu and xi; slot 1 belongs to x


class Chain:
    def __init__(self, M, J, parent_offset, child_offset):
        self.M = [np.array(m, float) for m in M]
        self.J = [np.array(j, float) for j in J]
        self.parent_offset = [np.zeros(3)] + [np.array(d, float) for d in parent_offset]
        self.child_offset = [np.zeros(3)] + [np.array(d, float) for d in child_offset]

    def velocity_maps(self, R):
        """V_i = maps[i] xi, body frame."""
        maps = []
        for i in BODIES:
            A = np.zeros((3, 12), dtype=R[0].dtype)
            A[:, 3:6] = R[i].T
            if i > 0:
                A[:, 0:3] = -R[i].T @ R[0] @ hat(self.parent_offset[i])
                A[:, 3 * SLOT[i]:3 * SLOT[i] + 3] = hat(self.child_offset[i])
            maps.append(A)
        return maps

    def inertia(self, R):
        total = sum(A.T @ M @ A for A, M in zip(self.velocity_maps(R), self.M))
        for i in BODIES:
            s = 3 * SLOT[i]
            total[s:s + 3, s:s + 3] += self.J[i]
        return total

    def energy(self, R, xi):
        return 0.5 * xi @ self.inertia(R) @ xi

    def shape_force(self, R, xi):
        """Derivative of T at fixed xi along the turns eta_i, in the four slots."""
        force = np.zeros((4, 3))
        for i, A in enumerate(self.velocity_maps(R)):
            V = A @ xi
            P = self.M[i] @ V  # body frame
            force[SLOT[i]] += np.cross(P, V)
            if i > 0:
                swing = np.cross(xi[0:3], self.parent_offset[i])
                own = np.cross(xi[3 * SLOT[i]:3 * SLOT[i] + 3], self.child_offset[i])
                force[0] += np.cross(swing, R[0].T @ R[i] @ P)
                force[SLOT[i]] -= np.cross(own, P)
        return force

    def momentum_rate(self, R, xi, mu, u):
        rate = self.shape_force(R, xi)
        for i in BODIES:
            s = slice(3 * SLOT[i], 3 * SLOT[i] + 3)
            rate[SLOT[i]] += np.cross(mu[s], xi[s])
        rate[0] += u[0] + u[1]
        rate[2] -= R[1].T @ R[0] @ u[0]
        rate[3] -= R[2].T @ R[0] @ u[1]
        return rate.ravel()

    def total_momentum(self, R, x, mu):
        angular = np.cross(x, mu[3:6]) + sum(R[i] @ mu[3 * SLOT[i]:3 * SLOT[i] + 3] for i in BODIES)
        return mu[3:6], angular


def hat(v):
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def moments(control, t):
    """u_j(t)[k] = sum over m of amplitude[j][k][m - 1] sin(2 pi m t + phase[j][k][m - 1])."""
    amplitude, phase = control
    m = np.arange(1, amplitude.shape[2] + 1)
    return (amplitude * np.sin(2.0 * np.pi * m * t + phase)).sum(axis=2)


def march(chain, R, x, xi, control, **settings):
    def unpack(y):
        return y[:27].reshape(3, 3, 3), y[27:30], y[30:]

    def rate(t, y):
        Q, _, mu = unpack(y)
        v = np.linalg.solve(chain.inertia(Q), mu)
        turning = [Q[i] @ hat(v[3 * SLOT[i]:3 * SLOT[i] + 3]) for i in BODIES]
        return np.concatenate([np.ravel(turning), v[3:6], chain.momentum_rate(Q, v, mu, moments(control, t))])

    start = np.concatenate([np.ravel(R), x, chain.inertia(R) @ xi])
    run = solve_ivp(rate, (0.0, TIMES[-1]), start, "DOP853", t_eval=TIMES, rtol=1e-13, atol=1e-13, **settings)
    assert run.success
    return [state(chain, t, *unpack(y)) for t, y in zip(TIMES, run.y.T)]


def state(chain, t, R, x, mu):
    nearest = [u @ w for u, _, w in map(np.linalg.svd, R)]
    xi = np.linalg.solve(chain.inertia(nearest), mu)
    linear, angular = chain.total_momentum(nearest, x, mu)
    return {"time": t, "rotation": np.array(nearest), "position": x,
            "angular_velocity": np.array([xi[3 * s:3 * s + 3] for s in SLOT]), "linear_velocity": xi[3:6],
            "momentum": mu, "energy": chain.energy(nearest, xi), "total_linear_momentum": linear,
            "total_angular_momentum": angular}


def difference(first, second):
    pairs = [(np.asarray(a[key]), np.asarray(b[key])) for a, b in zip(first, second) for key in a]
    return max(float(np.max(np.abs(a - b))) for a, b in pairs)


def plain(value):
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    return float(value) if isinstance(value, np.floating) else value


def check_against_reference():
    with open(os.path.join(HERE, "reference.json")) as file:
        cases = json.load(file)["cases"]
    for case in cases:
        given, model = case["inputs"], case["inputs"]["model"]
        chain = Chain(model["M"], model["J"], [model["d01"], model["d02"]], [model["d10"], model["d20"]])
        R, xi, u = np.array(given["R"]), np.array(given["xi"]), np.array(given["u"]).reshape(2, 3)
        tiny = 1e-30  # the imaginary part of a complex step is a derivative without cancellation
        turned = [R[i] + 1j * tiny * R[i] @ hat(xi[3 * SLOT[i]:3 * SLOT[i] + 3]) for i in BODIES]
        inertia_rate = chain.inertia(turned).imag / tiny
        rate = chain.momentum_rate(R, xi, chain.inertia(R) @ xi, u)
        acceleration = np.linalg.solve(chain.inertia(R), rate - inertia_rate @ xi)
        expected = np.array(case["outputs"]["xi_dot"])
        error = np.linalg.norm(acceleration - expected) / np.linalg.norm(expected)
        assert error < 1e-12, (case["name"], error)
        print(f"{case['name']}: accelerations differ by {error:.1e}")


def physical_chain():
    outer_mass, outer_inertia = np.diag([0.2664, 0.6551, 0.3677]), np.diag([0.1961, 1.7889, 2.9210])
    M = [np.diag([1.0659, 2.1696, 1.6641]), outer_mass, outer_mass]
    J = [np.diag([1.3480, 20.1500, 25.3276]), outer_inertia, outer_inertia]
    return Chain(M, J, [[8.8, 0.0, 0.0], [-8.8, 0.0, 0.0]], [[-5.5, 0.0, 0.0], [5.5, 0.0, 0.0]])


def paper_start():
    """The paper's start shape: straight but for the rear body, yawed by 45 degrees."""
    return [np.eye(3), np.eye(3), Rotation.from_rotvec([0.0, 0.0, np.pi / 4.0]).as_matrix()]


def spatial_control():
    amplitude = [[[0.4, -0.2, 0.1], [30.0, -20.0, 10.0], [-25.0, 40.0, 15.0]],
                 [[-0.3, 0.2, 0.1], [20.0, 25.0, -15.0], [35.0, -20.0, 20.0]]]
    phase = [[[0.3, 1.1, -0.4], [0.7, -0.2, 0.5], [0.1, 0.9, -1.3]],
             [[-0.6, 0.4, 1.5], [-0.9, 0.3, 1.2], [0.2, -1.0, 0.8]]]
    return np.array(amplitude), np.array(phase)


def planar_control():
    amplitude, phase = np.zeros((2, 3, 2)), np.zeros((2, 3, 2))
    amplitude[:, 2] = [[300.0, -150.0], [-200.0, 250.0]]
    phase[:, 2] = [[0.4, -0.7], [0.2, 1.1]]
    return amplitude, phase


def solve_case(name, xi, control):
    chain, R, x = physical_chain(), paper_start(), np.zeros(3)
    mu = chain.inertia(R) @ xi
    coarse = march(chain, R, x, xi, control)
    fine = march(chain, R, x, xi, control, max_step=1e-3)
    error = difference(coarse, fine)
    print(f"{name}: energy {chain.energy(R, xi):.14g} -> {coarse[-1]['energy']:.14g}, estimated error {error:.1e}")
    amplitude, phase = control
    return plain({"name": name, "control": {"amplitude": amplitude, "phase": phase},
                  "start": state(chain, 0.0, np.array(R), x, mu), "states": fine, "estimated_error": error})


def main():
    path = sys.argv[1] if len(sys.argv) > 1 else os.path.join(HERE, "dop853.json")
    check_against_reference()
    chain = physical_chain()
    tumbling = np.array([0.6, -0.9, 1.2, 0.5, 0.2, -0.1, 2.5, 1.0, -1.5, -2.0, 1.5, 1.0])
    energy = chain.energy(paper_start(), tumbling)
    assert abs(energy - 101.94622872518) < 1e-11, energy
    none = (np.zeros((2, 3, 1)), np.zeros((2, 3, 1)))
    cases = [solve_case("tumble", tumbling, none), solve_case("tumble_controlled", tumbling, spatial_control()),
             solve_case("planar_from_rest", np.zeros(12), planar_control())]
    model = {"mass_matrix": chain.M, "inertia_matrix": chain.J, "parent_offset": chain.parent_offset[1:],
             "child_offset": chain.child_offset[1:]}
    with open(path, "w") as file:
        json.dump({"description": "three-body chain, continuous equations, DOP853; see make_dop853.py",
                   "control": moments.__doc__, "model": plain(model), "cases": cases}, file, indent=1)
        file.write("\n")


if __name__ == "__main__":
    main()
