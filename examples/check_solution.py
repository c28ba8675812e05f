#!/usr/bin/env python3
"""Checks a solution of Lamprey without Lamprey: python3 check_solution.py DIR

Needs NumPy and nothing else. Reads DIR/solution.json and recomputes, from docs/theory, what its certificate claims.
Numbers of equations are those of docs/theory. SI units, angles in radians. Exit code 0: every number keeps its mark and
agrees with the stored one; 1: one does not; 2: wrong usage, unreadable file, no NumPy, or a scheme that is not covered.

Arrays: R [..., bodies, 3, 3] rotations, body to world; x [..., 3] mass centre of the root; v [..., freedoms]
components along the freedoms of chapter 8 (turns of free bodies, angles of led ones, the root's position last);
a [..., moments] moments of all joints: three numbers in the parent's frame on ball joints, one for each axis else.
"""
import json
import math
import pathlib
import sys
from types import SimpleNamespace

try:
    import numpy as np
except ImportError:
    print("check_solution.py: needs NumPy (apt install python3-numpy, or pip install numpy)", file=sys.stderr)
    sys.exit(2)

IMAGINARY = 1e-30  # step of derivatives by complex numbers: f'(x) = Im f(x + i step) / step, with no round-off
SEGMENTS = 20      # of the sweep for the multipliers, as in (6.5)


# Vectors and rotations: all but rotation() and distance() also take complex numbers.

def T(A):
    return np.swapaxes(A, -1, -2)


def times(A, v):
    return (A @ v[..., None])[..., 0]


def cross(a, b):
    return np.stack([a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1], a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
                     a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]], -1)


def hat(v):
    return np.stack([cross(v, e) for e in np.eye(3)], -1)


def share(part, whole):
    """part / whole; of nothing 0."""
    return part / whole if part else 0.0


def vee(A):
    """sin(angle) times the axis, of a rotation."""
    return 0.5 * np.stack([A[..., 2, 1] - A[..., 1, 2], A[..., 0, 2] - A[..., 2, 0], A[..., 1, 0] - A[..., 0, 1]], -1)


def trace(A):
    return np.trace(A, axis1=-2, axis2=-1)


def arctan2(s, c):
    value = np.arctan2(np.real(s), np.real(c))
    if np.iscomplexobj(s) or np.iscomplexobj(c):
        return value + 1j * (np.real(c) * np.imag(s) - np.real(s) * np.imag(c)) / (np.real(s)**2 + np.real(c)**2)
    return value


def rotation(v):
    """exp of a rotation vector."""
    angle, H = np.linalg.norm(v), hat(np.asarray(v, float))
    return np.eye(3) + np.sinc(angle / np.pi) * H + 0.5 * np.sinc(angle / 2 / np.pi)**2 * H @ H


def log(Q):
    """The rotation vector of Q, away from the half turn."""
    v = vee(Q)
    square = (v * v).sum(-1)
    small = np.abs(square) < 1e-10
    sine = np.sqrt(np.where(small, 1, square))
    return np.where(small, 1 + square / 6, arctan2(sine, (trace(Q) - 1) / 2) / sine)[..., None] * v


def distance(Q, P):
    """The largest angle between rotations, rad."""
    D = T(Q) @ P
    return np.arctan2(np.linalg.norm(vee(D), axis=-1), (trace(D) - 1) / 2).max()


def largest(v):
    return np.linalg.norm(v, axis=-1).max()


# The swimmer

def carlson_rd(x, y, z):
    """R_D of (1.6) by duplication: the arguments come together by a factor of 4 each time."""
    total, factor = 0.0, 1.0
    while max(x, y, z) - min(x, y, z) > 1e-9 * max(x, y, z):
        shift = math.sqrt(x * y) + math.sqrt(y * z) + math.sqrt(z * x)
        total += 3 * factor / (math.sqrt(z) * (z + shift))
        x, y, z, factor = (x + shift) / 4, (y + shift) / 4, (z + shift) / 4, factor / 4
    return total + factor * ((x + y + 3 * z) / 5)**-1.5


def ellipsoid(axes):
    """Added mass and inertia (1.8) for density 1, body's inertia (1.11) for mass 1: three diagonals."""
    square, volume = np.square(axes), 4 / 3 * np.pi * np.prod(axes)
    alpha = [2 / 3 * np.prod(axes) * carlson_rd(square[i - 2], square[i - 1], square[i]) for i in range(3)]
    added, inertia, own = np.zeros(3), np.zeros(3), np.zeros(3)
    for i in range(3):
        b, c, beta, gamma = square[i - 2], square[i - 1], alpha[i - 2], alpha[i - 1]
        added[i] = volume * alpha[i] / (2 - alpha[i])
        if abs(b - c) > 1e-12 * (b + c):
            inertia[i] = volume / 5 * (b - c)**2 * (gamma - beta) / (2 * (b - c) + (b + c) * (beta - gamma))
        own[i] = (b + c) / 5
    return added, inertia, own


def ellipse(axes):
    """The same of one metre of an elliptic cylinder, (1.23), in whose plane the fluid moves; out of it the body alone."""
    a, b = np.square(axes[:2])
    added = np.pi * np.array([b, a, 0.0])
    inertia = np.pi / 8 * (a - b)**2 * np.array([0.0, 0.0, 1.0])
    return added, inertia, np.array([b / 4 + 1 / 12, a / 4 + 1 / 12, (a + b) / 4])


def read_swimmer(problem):
    """Tree, freedoms, matrices of problem.bodies and problem.joints."""
    bodies, joints = problem["bodies"], problem["joints"]
    s, n = SimpleNamespace(scheme=problem["scheme"]), len(bodies)
    s.n, s.names = n, [body["name"] for body in bodies]
    s.semi_axes = np.array([body["semi_axes"] for body in bodies], float)
    s.ellipse = [body.get("ellipse", False) for body in bodies]
    s.mass = np.array([body["mass"] for body in bodies], float)
    s.own_inertia, s.J, s.M, s.C = (np.array([body[key] for body in bodies], float) for key in (
        "body_inertia", "inertia_matrix", "mass_matrix", "coupling_matrix"))
    s.parent, s.joint, s.kind, s.joint_names = [-1] * n, [-1] * n, ["free"] * n, [None] * n
    s.d_pi, s.d_ip, s.Q0, s.a, s.b = np.zeros((n, 3)), np.zeros((n, 3)), np.tile(np.eye(3), (n, 1, 1)), [0] * n, [0] * n
    s.stiffness, s.damping, bases = np.zeros(n), np.zeros(n), [np.zeros((0, 0))] * n
    s.control_axes = [np.zeros((0, 0))] * n
    for j, joint in enumerate(joints):
        i, axes = joint["child"], np.reshape(np.array(joint["control_axes"], float), (-1, 3))
        s.parent[i], s.joint[i], s.kind[i], s.joint_names[i] = joint["parent"], j, joint["kind"], joint["name"]
        s.d_pi[i], s.d_ip[i] = joint["parent_offset"], joint["child_offset"]
        s.stiffness[i], s.damping[i] = joint["stiffness"], joint["damping"]
        s.Q0[i], frame = rotation(joint["reference_rotation"]), np.eye(3)
        if s.kind[i] == "universal":
            s.a[i], s.b[i] = (np.array(axis, float) / np.linalg.norm(axis) for axis in joint["axes"])
            frame = np.array([s.a[i], s.Q0[i] @ s.b[i]])
        elif s.kind[i] == "hinge":
            s.b[i] = np.array(joint["axis"], float) / np.linalg.norm(joint["axis"])
            frame = (s.Q0[i] @ s.b[i])[None]
        elif s.kind[i] == "fixed":
            frame = np.zeros((0, 3))
        bases[i] = np.zeros((len(frame), 0))
        if axes.size and frame.size:
            u, size, _ = np.linalg.svd(frame @ axes.T, full_matrices=False)
            bases[i] = u[:, size > 1e-6]  # orthonormal: the moments that the joint can exert
            s.control_axes[i] = axes @ frame.T  # one row for each, along the joint's own axes
    s.led = [kind in ("universal", "hinge", "fixed") for kind in s.kind]
    counts = [{"universal": 2, "hinge": 1, "fixed": 0}.get(kind, 3) for kind in s.kind]
    ends = np.cumsum([0] + counts)
    s.part, s.position, s.freedoms = [slice(*ends[i:i + 2]) for i in range(n)], slice(ends[n], ends[n] + 3), ends[n] + 3
    ends = np.cumsum([0] + [count if s.joint[i] >= 0 else 0 for i, count in enumerate(counts)])
    s.moment, s.moments = [slice(*ends[i:i + 2]) for i in range(n)], ends[n]
    s.basis, column = np.zeros((ends[n], sum(basis.shape[1] for basis in bases))), 0
    # whether the axes of the moments are told, not only what they span
    s.told_axes = all(basis.shape[1] < 2 or np.array_equal(np.abs(basis), np.eye(len(basis))) for basis in bases)
    for i in range(n):
        s.basis[s.moment[i], column:column + bases[i].shape[1]] = bases[i]
        column += bases[i].shape[1]
    s.order = [0]
    for i in s.order:
        s.order += [c for c in range(n) if s.parent[c] == i]
    s.length = 2.0**round(math.log2(s.semi_axes.max() / 8))  # of (6.1)
    return s


def relative(s, R, i):
    return T(R[..., s.parent[i], :, :]) @ R[..., i, :, :]


def joint_axes(s, Q, i):
    """S of (8.3), its columns."""
    b = np.broadcast_to(s.b[i], Q.shape[:-1]) if s.kind[i] != "fixed" else None
    columns = {"universal": lambda: [T(Q) @ s.a[i], b], "hinge": lambda: [b], "fixed": list}[s.kind[i]]()
    return np.stack(columns, -1) if columns else np.zeros(Q.shape[:-1] + (0,))


def angles(s, Q, i):
    """Angles of a led body's joint, from (8.1)."""
    b = s.b[i]
    if s.kind[i] == "hinge":
        W = s.Q0[i].T @ Q
        return arctan2(vee(W) @ b, (trace(W) - 1) / 2)[..., None]
    if s.kind[i] == "fixed":
        return np.zeros(Q.shape[:-2] + (0,))
    a, b0, a0 = s.a[i], s.Q0[i] @ b, s.Q0[i].T @ s.a[i]
    return np.stack([arctan2(Q @ b @ cross(a, b0), Q @ b @ b0), arctan2(-(T(Q) @ a) @ cross(b, a0), T(Q) @ a @ a0)], -1)


def body_turns(s, R, v):
    """Turns of the bodies along components of the freedoms, (8.3); velocities as well."""
    turns = [None] * s.n
    for i in s.order:
        turns[i] = v[..., s.part[i]]
        if s.led[i]:
            Q = relative(s, R, i)
            turns[i] = times(T(Q), turns[s.parent[i]]) + times(joint_axes(s, Q, i), turns[i])
    return np.stack(turns, -2)


def centres(s, R, x):
    """Mass centres by (1.1); of a difference of rotations, displacements by (3.1)."""
    X = [x] * s.n
    for i in s.order[1:]:
        X[i] = X[s.parent[i]] + R[..., s.parent[i], :, :] @ s.d_pi[i] - R[..., i, :, :] @ s.d_ip[i]
    return np.stack(X, -2)


def gather(s, R, m, f):
    """Components along the freedoms of moments m (body frames) and forces f (world) on all bodies, (8.5)."""
    m, f, e = [m[..., i, :] for i in range(s.n)], [f[..., i, :] for i in range(s.n)], [None] * s.n
    for i in reversed(s.order[1:]):
        p, seen = s.parent[i], times(T(R[..., i, :, :]), f[i])
        n = m[i] - cross(np.broadcast_to(s.d_ip[i], seen.shape), seen)
        f[p] = f[p] + f[i]
        seen = times(T(R[..., p, :, :]), f[i])
        m[p] = m[p] + cross(np.broadcast_to(s.d_pi[i], seen.shape), seen)
        e[i] = n
        if s.led[i]:
            Q = relative(s, R, i)
            e[i], m[p] = times(T(joint_axes(s, Q, i)), n), m[p] + times(Q, n)
    e[0] = m[0]
    return np.concatenate(e + [f[0]], -1)


# Discrete mechanics

def momenta(s, R, R1, dx, h):
    """E⁻, E⁺ of (8.27) but for U, by (8.10), (8.13) and (8.17): p⁻, p⁺ of (4.3) where no joint is damped."""
    F, identity = T(R) @ R1, np.eye(3)
    w = times(T(R), centres(s, R1 - R, dx))
    phi, J, gamma, beta, mean = vee(F), s.J, 0, 0, 0
    if s.scheme == "trapezoid":
        nodes = [(0.5, identity, 0 * identity), (0.5, F, identity)]
    elif s.scheme == "midpoint":  # (8.9)
        zeta = 2 * phi / (1 + trace(F))[..., None]
        z = hat(zeta / (1 + np.sqrt(1 + (zeta * zeta).sum(-1)))[..., None])
        nodes = [(1.0, (identity + z) @ np.linalg.inv(identity - z), 0.5 * (identity + z))]
    else:
        nodes, c = [(1.0, identity, 0 * identity)], hat(-s.d_ip)
        J = s.J - c @ s.M @ c  # (3.5)
    for weight, G, N in nodes:
        y = times(T(G), w)
        p = weight * (times(s.M, y) + times(s.C, phi))
        gamma, beta, mean = gamma + times(T(N), cross(p, y)), beta + times(G, p), mean + weight * y
    spread = lambda A: trace(A)[..., None, None] * identity - A
    gamma = gamma + 2 * vee((spread(J) - 0.5 * trace(J)[:, None, None] * identity) @ F)
    gamma = gamma + 0.5 * times(spread(F), times(T(s.C), mean))
    if s.scheme == "paper":
        c = np.broadcast_to(-s.d_ip, phi.shape)
        gamma = gamma - cross(c, times(T(F), times(s.M, times(F - identity, c))))
    gamma, beta = gamma / h, beta / h
    left, right, force = times(F, gamma) + cross(w, beta), gamma, times(R, beta)
    left, right, led = left.copy(), right.copy(), []
    for i in s.order[1:]:
        if s.damping[i]:  # (8.17)
            p, Q, Q1 = s.parent[i], relative(s, R, i), relative(s, R1, i)
            if s.led[i]:
                turn = angles(s, Q1, i) - angles(s, Q, i)
                led.append((i, s.damping[i] / 2 * (turn - 2 * np.pi * np.round(turn.real / 2 / np.pi))))
            else:
                turn = s.damping[i] / 2 * log(T(Q) @ Q1)
                left[..., i, :] += turn
                left[..., p, :] -= times(Q, turn)
                right[..., i, :] -= turn
                right[..., p, :] += times(Q1, turn)
    left, right = gather(s, R, left, force), gather(s, R1, right, force)
    for i, turn in led:
        left[..., s.part[i]] += turn
        right[..., s.part[i]] -= turn
    return left, right


def joint_forces(s, R, a):
    """U along the freedoms: moments by (8.14), springs by (8.16)."""
    zero = np.zeros(a.shape[:-1] + (s.n, 3), np.result_type(R, a))
    m, led = zero.copy(), []
    for i in s.order[1:]:
        u, p, Q = a[..., s.moment[i]], s.parent[i], relative(s, R, i)
        if s.led[i]:
            led.append((i, -u - (s.stiffness[i] * angles(s, Q, i) if s.stiffness[i] else 0)))
            continue
        if s.stiffness[i]:
            u = u + s.stiffness[i] * times(Q, log(s.Q0[i].T @ Q))
        m[..., p, :] += u
        m[..., i, :] -= times(T(Q), u)
    U = gather(s, R, m, zero)
    for i, u in led:
        U[..., s.part[i]] += u
    return U


def total_momentum(s, R, x, mu):
    """Linear and angular momentum of the whole, (4.7), for any joints."""
    return mu[..., s.position], cross(x, mu[..., s.position]) + sum(
        times(R[..., i, :, :], mu[..., s.part[i]]) for i in range(s.n) if not s.led[i])


# Continuous mechanics

def velocities(s, R, v):
    """Angular velocities and those of the mass centres, seen from the bodies, (1.3)."""
    turns = body_turns(s, R, v)
    return turns, times(T(R), centres(s, R @ hat(turns), v[..., s.position]))


def continuous_momentum(s, R, v):
    """𝕀ξ of (2.5), with coupling (2.12)."""
    turns, V = velocities(s, R, v)
    return gather(s, R, times(s.J, turns) + times(T(s.C), V), times(R, times(s.M, V) + times(s.C, turns)))


def inertia(s, R):
    """𝕀 of (2.4), column by column."""
    directions = np.broadcast_to(np.eye(s.freedoms), R.shape[:-3] + (s.freedoms, s.freedoms))
    return T(continuous_momentum(s, R[..., None, :, :, :], directions))


def carried_as_one(s, m, R, x):
    """Momenta of a whole that moves as one with the total momentum of the start, (9.37)."""
    linear, angular = total_momentum(s, m.R[0], m.x[0], continuous_momentum(s, m.R[0], m.start_v))
    motions = np.zeros((6, s.freedoms), R.dtype)  # turns about the root's mass centre, then shifts
    for i in range(s.n):
        if not s.led[i]:
            motions[:3, s.part[i]] = R[i]
    motions[3:, s.position] = np.eye(3)
    carried = continuous_momentum(s, R[None], motions)
    return np.linalg.solve(carried @ motions.T, np.concatenate([angular - cross(x, linear), linear])) @ carried


def accelerations(s, R, v, a):
    """Rates of the velocities by (2.9) and (2.13), dampers by (2.14)."""
    O, V = velocities(s, R, v)
    rates = [np.zeros(O.shape[:-2] + (3,))] * s.n  # Ω̇ and ẍ at ξ̇ = 0
    for i in s.order[1:]:
        if s.led[i]:  # (8.4)
            Q = relative(s, R, i)
            S, own, passed = joint_axes(s, Q, i), v[..., s.part[i]], times(T(Q), O[..., s.parent[i], :])
            rates[i] = cross(passed, times(S, own)) + times(T(Q), rates[s.parent[i]])
            if s.kind[i] == "universal":
                rates[i] = rates[i] + own[..., :1] * own[..., 1:] * cross(S[..., 0], S[..., 1])
    rates = np.stack(rates, -2)
    dV = times(T(R), centres(s, R @ (hat(O) @ hat(O) + hat(rates)), np.zeros(O.shape[:-2] + (3,)))) - cross(O, V)
    P, L = times(s.M, V) + times(s.C, O), times(s.J, O) + times(T(s.C), V)
    force = times(R, times(s.M, dV) + times(s.C, rates) + cross(O, P))
    torque = times(s.J, rates) + times(T(s.C), dV) + cross(O, L) + cross(V, P)
    damped = np.zeros_like(v)
    for i in s.order[1:]:
        if s.damping[i] and s.led[i]:
            damped[..., s.part[i]] -= s.damping[i] * v[..., s.part[i]]
        elif s.damping[i]:
            Q = relative(s, R, i)
            turn = s.damping[i] * (O[..., i, :] - times(T(Q), O[..., s.parent[i], :]))
            torque[..., i, :] += turn
            torque[..., s.parent[i], :] -= times(Q, turn)
    right = joint_forces(s, R, a) + damped - gather(s, R, torque, force)
    return np.linalg.solve(inertia(s, R), right[..., None])[..., 0]


def march(s, m, first, steps, parts):
    """From the stored states at the nodes `first`, all at once, `steps` steps in `parts` parts of Runge and Kutta's
    classical method each; moments run linearly between nodes. The largest error at the end, rad."""
    R, x, v, dt = m.R[first], m.x[first], m.v[first], m.h / parts
    for k in range(steps):
        a, slope = m.a[first + k], m.a[first + k + 1] - m.a[first + k]
        for j in range(parts):
            at, sums, state = 0.0, 0, (R, x, v)
            for back, weight in ((0, 1), (0.5, 2), (0.5, 2), (1, 1)):
                if back:
                    state = tuple(q + back * dt * r for q, r in zip((R, x, v), rate))
                at = (j + back) / parts
                rate = (state[0] @ hat(body_turns(s, state[0], state[2])), state[2][..., s.position],
                        accelerations(s, state[0], state[2], a + at * slope))
                sums = [weight / 6 * r + (sums[q] if back else 0) for q, r in enumerate(rate)]
            R, x, v = (q + dt * r for q, r in zip((R, x, v), sums))
    return distance(m.R[first + steps], R)


def replay(s, m, window):
    """The rotation error of (6.7) in windows; the step is halved until it settles to 1e-7 rad or a thousandth."""
    steps = min(max(1, round(window / m.h)), m.N)
    firsts, rest = np.arange(m.N // steps) * steps, m.N % steps
    parts, found = max(1, math.ceil(m.h * np.abs(m.v[:, :s.position.start]).max() / 0.05)), [math.inf]
    while len(found) < 6 and not (len(found) > 1 and abs(found[-1] - found[-2]) < max(1e-7, 1e-3 * found[-1])):
        with np.errstate(all="ignore"):
            worst = march(s, m, firsts, steps, parts)
            found.append(max(worst, march(s, m, np.array([m.N - rest]), rest, parts)) if rest else worst)
        parts *= 2
    return found[-1]


# First-order optimality

def moved(s, R, x, v):
    return R @ (np.eye(3) + hat(body_turns(s, R, v))), x + v[..., s.position]


def derivative(s, f, R, x):
    """Of f(R, x) along the freedoms, by complex numbers; the last axis is the direction."""
    columns = []
    for direction in np.eye(s.freedoms):
        v = np.broadcast_to(1j * IMAGINARY * direction, x.shape[:-1] + (s.freedoms,))
        columns.append(np.imag(f(*moved(s, R, x, v))) / IMAGINARY)
    return np.stack(columns, -1)


def margin(s, problem, entry):
    """g of (6.23) as a function of (R, x) of one node; None where it is not covered."""
    i = s.joint.index(entry["joint"]) if entry["joint"] >= 0 else -1
    word, limits = entry["key"].split("."), problem.get("limits", {})
    if word[0] == "waypoint" and i < 0 and max(entry["bodies"]) < 0:
        return lambda R, x: x[entry["component"]]
    if word[:1] != ["limits"] or word[1] not in ("swing", "twist", "angle"):
        return None
    b = -s.d_ip[i] / np.linalg.norm(s.d_ip[i])
    if word[1] == "swing":  # (10.1)
        arm = s.d_pi[i] / np.linalg.norm(s.d_pi[i])
        sine = lambda u: np.sqrt((cross(arm, u)**2).sum())
        return lambda R, x: -arctan2(sine(relative(s, R, i) @ b), relative(s, R, i) @ b @ arm)
    if word[1] == "twist":  # (10.2)
        turn = lambda W: 2 * np.arctan(2 * (vee(W) @ s.Q0[i] @ b) / (1 + trace(W)))
        sign = lambda t: 1 if t.real > 0 else -1
        return lambda R, x: -sign(turn(relative(s, R, i) @ s.Q0[i].T)) * turn(relative(s, R, i) @ s.Q0[i].T)
    return lambda R, x: (-1 if entry["upper"] else 1) * angles(s, relative(s, R, i), i)[max(entry["component"], 0)]


def weighs_smoothness_at_most(problem):
    """Whether nothing costs or wins anything beside effort, time and smoothness."""
    others = [weight for key, weight in problem.get("cost_weights", {}).items() if key != "smoothness"]
    return not any(others) and "displacement_weight" not in problem


def smoothness(problem):
    return problem.get("cost_weights", {}).get("smoothness", 0.0)


def cost_by_moments(s, m, problem):
    """∂(cost)/∂(moments), of effort and smoothness: (5.1) and its differences from node to node."""
    gradient, change = problem["effort"] * m.weight[:, None] * m.a, np.diff(m.a, axis=0)
    gradient[:-1] -= smoothness(problem) / m.h * change
    gradient[1:] += smoothness(problem) / m.h * change
    return gradient


def gradient_of_cost(s, m, S):
    """∂/∂(moments) and −∂/∂(states) of cost − limits and waypoints, (5.1) and (6.23); third, a key not covered."""
    gradient, pulls = cost_by_moments(s, m, S["problem"]), np.zeros((m.N + 1, s.freedoms))
    for entry in S.get("limit_multipliers", []):
        value, word = np.array(entry["multiplier"], float), entry["key"].split(".")
        if not value.any():
            continue
        if word[0] == "limits" and word[1].startswith("torque"):  # of one component or of the whole moment
            i = s.joint.index(entry["joint"])
            moment = m.a[:, s.moment[i]]
            if word[1] == "torque_component":
                axis = s.control_axes[i][entry["component"]]
                moment = np.outer(moment @ axis, axis)
            length = np.linalg.norm(moment, axis=1)
            gradient[:, s.moment[i]] += (m.tau * value / np.where(length > 0, length, 1))[:, None] * moment
            continue
        g = margin(s, S["problem"], entry)
        if g is None:
            return None, None, entry["key"]
        for k in np.flatnonzero(value):
            pulls[k] += value[k] * (1 if word[0] == "waypoint" else m.h) * derivative(s, g, m.R[k], m.x[k])
    return gradient, pulls, None


def optimality(s, m, S):
    """kkt of (6.5): (number, None), or (None, what is not covered).

    The Lagrangian is cost + Σ λ_k·r_k + ν·goal − limits, with r_k = E⁻_k − E⁺_{k−1} − τ_k U_k the balance at node k. It
    is stationary in g_k where with α_k = B_{k−1}ᵀλ_{k−1} − D_{k−1}ᵀλ_k

        α_k = (τ_k ∂U_k/∂g_k − A_k)ᵀ λ_k + C_kᵀ λ_{k+1} + ∂(limits)/∂g_k,

    A, B the derivatives of E⁻ by the left and the right node, C, D those of E⁺. So (λ, α) goes from node to node
    backwards. It does so on short segments with unknowns of their own at their ends, since over the whole motion its
    growth would drown all but one direction in round-off; the null space of the ties between them is found by QR.
    """
    problem, N, n, h = S["problem"], m.N, s.freedoms, m.h
    goal = problem["goal"]
    if goal["periodic"] or "free_duration" in problem or not weighs_smoothness_at_most(problem):
        return None, "gaits, free durations and weights beside effort and smoothness"
    gradient, pulls, missing = gradient_of_cost(s, m, S)
    if missing:
        return None, f"multipliers of {missing}"
    tau = m.tau
    gradient = gradient @ s.basis
    A, C = np.split(derivative(s, lambda R, x: np.concatenate(momenta(s, R, m.R[1:], m.x[1:] - x, h), -1),
                               m.R[:-1], m.x[:-1]), 2, axis=1)
    B, D = np.split(derivative(s, lambda R, x: np.concatenate(momenta(s, m.R[:-1], R, x - m.x[:-1], h), -1),
                               m.R[1:], m.x[1:]), 2, axis=1)
    by_state = tau[:, None, None] * derivative(s, lambda R, x: joint_forces(s, R, m.a), m.R, m.x)
    none = joint_forces(s, m.R, 0 * m.a)
    by_moments = np.stack([joint_forces(s, m.R, np.broadcast_to(b, m.a.shape)) - none for b in s.basis.T], -1)
    rows = derivative(s, lambda R, x: goal_rows(s, goal, m, R, x), m.R[-1], m.x[-1])

    # One step backwards: (λ, α, 1) at node k+1 to that at node k, in units that make both numbers of one size.
    unit = np.sqrt(np.diagonal(inertia(s, m.R), axis1=1, axis2=2).max(0))
    unit = np.concatenate([1 / unit, unit / m.duration])
    step = np.zeros((N, 2 * n + 1, 2 * n + 1))
    step[:, :n, :2 * n] = np.linalg.solve(T(B), np.concatenate([T(D), np.broadcast_to(np.eye(n), D.shape)], 2))
    step[:, n:2 * n, :2 * n] = T(by_state[:-1] - A) @ step[:, :n, :2 * n]
    step[:, n:2 * n, :n] += T(C)
    step[:, n:2 * n, 2 * n], step[:, 2 * n, 2 * n] = pulls[:-1], 1
    full = np.append(unit, 1)
    step *= full / full[:, None]
    # Unknowns: (λ, α) at each segment's end, then ν. Ties hold them together.
    ends = np.unique(np.linspace(0, N, min(SEGMENTS, N) + 1).round().astype(int))
    count, size = len(ends) - 1, 2 * n
    unknowns = count * size + len(rows)
    ties, given = [], []
    jacobian, shift = np.zeros((N + 1, s.basis.shape[1], unknowns)), gradient.copy()

    def meet(k, map_, at):  # the gradient by the moments at node k: (weight) u_k − τ_k (∂U_k/∂u)ᵀ λ_k
        to = -tau[k] * T(by_moments[k]) @ (unit[:n, None] * map_[:n])
        jacobian[k, :, at:at + size], shift[k] = to[:, :size], gradient[k] + to[:, size]

    for j in range(count):
        map_, at = np.eye(size + 1), j * size
        if j == count - 1:
            meet(N, map_, at)
        for k in range(ends[j + 1] - 1, ends[j] - 1, -1):
            map_ = step[k] @ map_
            meet(k, map_, at)
        if j > 0:
            tie = np.zeros((size, unknowns))
            tie[:, at - size:at], tie[:, at:at + size] = np.eye(size), -map_[:size, :size]
            ties.append(tie)
            given.append(map_[:size, size])
    # At the last node: α_N = (τ_N ∂U_N/∂g − ∂p_N/∂g)ᵀ λ_N − (goal's rows)ᵀ ν + ∂(limits)/∂g, where p_N, which the end is to have,
    # is 0 at rest and (9.37) of joints alone
    tie, at = np.zeros((n, unknowns)), (count - 1) * size
    last = by_state[N]
    if goal["rest"] == "joints":
        last = last - derivative(s, lambda R, x: carried_as_one(s, m, R, x), m.R[-1], m.x[-1])
    tie[:, at:at + n] = -T(last) * unit[:n] / unit[n:, None]
    tie[:, at + n:at + size], tie[:, count * size:] = np.eye(n), T(rows) * (unit[n:].max() / unit[n:, None])
    ties.append(tie)
    given.append(pulls[N] / unit[n:])
    if not goal["rest"]:
        tie = np.zeros((n, unknowns))
        tie[:, at:at + n] = np.eye(n)
        ties.append(tie)
        given.append(np.zeros(n))
    ties, given = np.concatenate(ties), np.concatenate(given)
    space = np.linalg.qr(ties.T, mode="complete")[0][:, len(ties):]
    start = np.linalg.lstsq(ties, given, rcond=None)[0]
    jacobian, shift = jacobian.reshape(-1, unknowns), shift.ravel()
    shift, columns = shift + jacobian @ start, jacobian @ space
    u, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    u = u[:, sizes > 1e-10 * sizes[0]]
    left = shift - u @ (u.T @ shift)
    left -= u @ (u.T @ left)
    return share(np.abs(left).max(), np.abs(gradient).max()), None


# The checks

def led_by_angle(s, goal, i):
    """Whether a body hangs below a joint of goal.angle, with no rotation stated of it or of one between."""
    while s.parent[i] >= 0 and s.names[i] not in goal["rotation"]:
        if s.joint_names[i] in goal.get("angle", {}):
            return True
        i = s.parent[i]
    return False


def targets(s, goal, start):
    """Rotations that the goal asks for, by body."""
    asked = {} if goal["turn"] is None else {
        i: rotation(goal["turn"]) @ start[i] for i in range(s.n) if not led_by_angle(s, goal, i)}
    if goal["periodic"]:
        asked = {i: R for i, R in asked.items() if i == 0}
    for name, vector in goal["rotation"].items():
        asked.pop(s.names.index(name), None)
        if vector != "free":
            asked[s.names.index(name)] = rotation(vector)
    return asked


def joint_targets(s, goal, start):
    """How joints are to end, child to parent, by child."""
    asked = {}
    for i in s.order[1:]:
        if s.joint_names[i] in goal.get("angle", {}):
            turns = goal["angle"][s.joint_names[i]]
            before = {"universal": lambda: turns[0] * s.a[i], "ball": lambda: turns}.get(s.kind[i], lambda: np.zeros(3))()
            asked[i] = rotation(before) @ s.Q0[i] @ rotation(turns[-1] * s.b[i] if s.led[i] else np.zeros(3))
        elif goal.get("shape") == "start" or (goal["turn"] is not None and led_by_angle(s, goal, i)):
            asked[i] = relative(s, start, i)
    return asked


def goal_rows(s, goal, m, R, x):
    """The goal's conditions at the last node, zero where it is met."""
    rows = [vee(E.T @ R[i]) for i, E in targets(s, goal, m.start_R).items()]
    rows += [vee(E.T @ relative(s, R, i)) for i, E in joint_targets(s, goal, m.start_R).items()]
    rows += [x[c:c + 1] for c in range(3) if goal["move"][c] != "free"]
    return np.concatenate(rows) if rows else np.zeros(0)


def path_length(s, i):
    """Sum of |c_ia| along the path from the root to body i, (1.2)."""
    total, leave = 0.0, np.zeros(3)
    while i >= 0:
        total += np.linalg.norm(leave - s.d_ip[i])
        leave, i = s.d_pi[i], s.parent[i]
    return total


def last_digit(s, way, far):
    """kg m²/s times the step: what a last digit of each rotation and position makes of momenta, below (6.22)."""
    turned, shifted = np.zeros(s.n), 0.0
    for i in range(s.n):
        moment = np.linalg.norm(s.M[i]) * (s.length + way + path_length(s, i))
        shifted += moment
        led, arm, leave, a = np.linalg.norm(s.J[i]), 0.0, np.zeros(3), i
        while a >= 0:
            arm += np.linalg.norm(leave - s.d_ip[a])
            turned[a] += led + moment * arm
            if not s.led[a]:  # a ball joint's child turns by itself
                led = arm = 0.0
            leave, a = s.d_pi[a], s.parent[a]
    return 2.0**-52 * math.sqrt(np.sum(turned**2) + (shifted * far) ** 2)


def least_gradient(s, m, problem, mu):
    """What (6.5) divides by at least, where nothing but effort and smoothness costs: of motions that may go on by themselves."""
    weight, most = problem["effort"] * m.weight.max(), max(
        np.abs(mu[..., :s.freedoms - 3]).max(), s.length * np.abs(mu[..., s.position]).max())
    if problem["goal"]["periodic"]:
        return 1e-3 * weight * most / m.duration
    if not np.any(m.start_v):
        return 0.0
    worth = weight * (most + max(np.linalg.norm(J) for J in s.J) / m.h) / m.h
    spent = weight * np.abs(m.a @ s.basis).max()
    if spent <= 1e-12 * worth:
        return 1e-7 * worth
    return min(1e-7 * worth, spent * max(1e-6 / problem["tolerance"], 1))


def check_round_off_of_kkt(s, m, S, mu, of_moments, report):
    """What one last digit of the moments leaves of kkt, below (6.22): of smoothness by second differences of them."""
    problem, factor, share = S["problem"], 1.0, 1e-6
    weight = 0.0 if problem["control"]["kind"] == "spline" else smoothness(problem)
    if weight and ("free_duration" in problem or not weighs_smoothness_at_most(problem)):
        return report.skip("kkt_round_off: of smoothness beside free durations and other weights")
    if weight:
        whole = np.abs(cost_by_moments(s, m, problem) @ s.basis).max()
        whole = max(whole, least_gradient(s, m, problem, mu))
        factor = max(1.0, 4 * weight / m.h * np.abs(m.a @ s.basis).max() / whole) if whole > 0 else 1.0
        if not s.told_axes:
            share = 2.0  # largest components along axes that may lie otherwise in their plane
    report.same("kkt_round_off", min(1e-6, of_moments * factor), S["certificate"]["kkt_round_off"], share)


def read_motion(S, s):
    """The arrays of solution.json, and the moments along each joint's own axes."""
    problem = S["problem"]
    m = SimpleNamespace(N=problem["steps"], duration=float(problem["duration"]))
    m.t, m.x, m.R, u = (np.array(S[key], float) for key in ("time", "position", "rotation", "control"))
    shapes = [(m.N + 1,), (m.N + 1, 3), (m.N + 1, s.n, 3, 3), (m.N + 1, len(problem["joints"]), 3)]
    if [q.shape for q in (m.t, m.x, m.R, u)] != shapes or not all(np.isfinite(q).all() for q in (m.t, m.x, m.R, u)):
        raise ValueError("arrays do not fit steps, bodies and joints, or are not finite")
    m.h = m.duration / m.N
    m.tau = np.full(m.N + 1, m.h)  # of the forces, (4.5)
    m.tau[[0, -1]] /= 2
    m.weight = m.tau if problem["cost_rule"] == "trapezoid" else np.full(m.N + 1, m.h)  # of the cost, (5.1)
    m.a, m.control_error = np.zeros((m.N + 1, s.moments)), 0.0
    for i in s.order[1:]:
        part, Q, moment = s.moment[i], relative(s, m.R, i), u[:, s.joint[i]]
        axes = np.broadcast_to(np.eye(3), Q.shape) if not s.led[i] else Q @ joint_axes(s, Q, i)
        m.a[:, part] = times(T(axes), moment)
        kept = s.basis[part] @ s.basis[part].T
        m.control_error = max(m.control_error, largest(moment - times(axes @ kept, m.a[:, part])))
    m.control_error /= max(largest(u), 1e-300)
    start = problem["start"]
    m.start_R, m.start_x = np.array(start["rotation"], float), np.array(start["position"], float)
    m.start_v = np.zeros(s.freedoms)
    turning, m.start_v[s.position] = np.array(start["angular_velocity"], float), start["linear_velocity"]
    for i in s.order:
        m.start_v[s.part[i]] = turning[i] if not s.led[i] else np.linalg.lstsq(
            joint_axes(s, relative(s, m.start_R, i), i),
            turning[i] - relative(s, m.start_R, i).T @ turning[s.parent[i]], rcond=None)[0]
    return m


class Report:
    """Prints one line per check and remembers whether all were kept."""

    def __init__(self):
        self.good = True

    def line(self, name, own, stored, mark, kept):
        def word(q):
            return "—" if q is None else q if isinstance(q, str) else f"{q:.10g}" if abs(q) >= 1e-2 else f"{q:.2e}"

        print(f"{'✓' if kept else '✗'} {name:34} own {word(own):16} stored {word(stored):16} mark {word(mark)}")
        self.good = self.good and bool(kept)

    def error(self, name, own, stored, mark):
        """An error: at most its mark, and not ten times the stored one and above a tenth of the mark."""
        self.line(name, own, stored, mark, own <= mark and (stored is None or own <= max(10 * stored, mark / 10)))

    def same(self, name, own, stored, share, least=0.0):
        """A value that is stored: the same but for a share of it."""
        self.line(name, own, stored, f"{share:g} of it", abs(own - stored) <= share * abs(stored) + least)

    def skip(self, what):
        print(f"· not covered: {what}")


def check_bodies(s, density, report):
    """M, J and body_inertia from the semi-axes and the fluid's density, (1.4) to (1.11) and (1.23)."""
    for i in range(s.n):
        added, inertia_, own = ellipse(s.semi_axes[i]) if s.ellipse[i] else ellipsoid(s.semi_axes[i])
        errors = [np.abs(found - stored).max() / max(np.abs(stored).max(), 1e-300) for found, stored in (
            (np.diag(s.mass[i] * own), s.own_inertia[i]),
            (s.mass[i] * np.eye(3) + density * np.diag(added), s.M[i]),
            (s.own_inertia[i] + density * np.diag(inertia_), s.J[i]))]
        if max(errors) > 1e-9:
            report.skip(f"matrices of {s.names[i]}: not those of its semi-axes ({max(errors):.1e} off), as if given")
        else:
            report.error(f"matrices of {s.names[i]} by semi-axes", max(errors), None, 1e-9)


def check_motion(s, m, S, report):
    """Feasibility: (6.1) to (6.4) and what belongs to them. Leaves the velocities at the nodes in m.v."""
    problem, certificate, goal = S["problem"], S["certificate"], S["problem"]["goal"]
    gait, N, h, R, x = goal["periodic"], m.N, m.h, m.R, m.x
    report.error("time_error", np.abs(m.t - np.arange(N + 1) * h).max() / m.duration, certificate["time_error"], 1e-9)
    report.error("control_error", m.control_error, certificate["control_error"], 1e-9)
    bodies = 1 if problem.get("free_shape") else s.n
    report.error("start_error", max(distance(m.start_R[:bodies], R[0, :bodies]), np.abs(x[0] - m.start_x).max()),
                 certificate["start_error"], 1e-9)
    errors = [distance(E, R[-1, i]) for i, E in targets(s, goal, R[0] if gait else m.start_R).items()]
    errors += [distance(E, relative(s, R[-1], i)) for i, E in joint_targets(s, goal, m.start_R).items()]
    errors += [abs(x[-1, c] - m.start_x[c] - goal["move"][c]) for c in range(3) if goal["move"][c] != "free"]
    errors += [distance(R[0, 0].T @ R[0], R[-1, 0].T @ R[-1])] if gait else []
    report.error("goal_error", max(errors, default=0.0), certificate["goal_error"], 1e-9)
    report.error("rotation_drift", np.abs(T(R) @ R - np.eye(3)).max(), certificate["rotation_drift"], 1e-9)
    closed = 0.0
    for i in s.order[1:]:
        Q = relative(s, R, i)
        if s.kind[i] == "hinge":
            closed = max(closed, largest(Q @ s.b[i] - s.Q0[i] @ s.b[i]))
        elif s.kind[i] == "universal":
            closed = max(closed, np.abs(Q @ s.b[i] @ s.a[i]).max())
        elif s.kind[i] == "fixed":
            closed = max(closed, distance(s.Q0[i], Q))
    if any(s.led):
        report.error("joints closed", closed, None, 1e-9)

    left, right = momenta(s, R[:-1], R[1:], np.diff(x, axis=0), h)
    U = joint_forces(s, R, m.a)
    size = lambda v: max([largest(v[..., part]) for part in s.part] + [s.length * largest(v[..., s.position])])
    scale = max(size(left), h * size(U))  # (6.1)
    mu = np.concatenate([left - h / 2 * U[:-1], right[-1:] + h / 2 * U[-1:]])  # (4.5)
    if gait:
        mu[[0, -1]] = left[0] - h / 2 * U[0], right[-1] + h / 2 * U[-1]
        ends = mu[:1] - mu[-1:]
    else:
        ends = mu[:1] - continuous_momentum(s, R[:1], m.start_v[None])
    digit = last_digit(s, largest(x - x[0]), largest(x)) / h
    scale = max(scale, 16 * digit)  # at rest all is round-off
    round_off = min(1e-8, 16 * digit / scale)  # (6.22)
    report.same("momentum_round_off", round_off, certificate["momentum_round_off"], 1e-6)
    moment = np.linalg.norm(np.array(S["control"], float), axis=-1).max()
    if "kkt_round_off" in certificate and moment > 0:
        check_round_off_of_kkt(s, m, S, mu, digit / (h * moment), report)
    residual = max(size(left[1:] - right[:-1] - h * U[1:-1]) if N > 1 else 0.0, size(ends)) / scale
    report.error("equation_residual", residual, certificate["equation_residual"], max(1e-10, round_off))
    linear, angular = total_momentum(s, R[:-1], x[:-1] - x[0], left)
    if np.any(m.start_v) or gait:
        linear, angular = linear - linear[0], angular - angular[0]
    report.error("momentum_drift", max(s.length * largest(linear), largest(angular)) / scale,
                 certificate["momentum_drift"], max(1e-11, round_off))
    if goal["rest"]:
        asked = carried_as_one(s, m, R[-1], x[-1]) if goal["rest"] == "joints" else 0.0
        report.error("rest_error", size(mu[-1:] - asked) / scale, certificate["rest_error"], 1e-9)
    elif not gait:
        report.same("rest_error (rest is not asked)", size(mu[-1:]) / scale, certificate["rest_error"], 1e-6, 1e-12)

    m.v = np.linalg.solve(inertia(s, R), mu[..., None])[..., 0]
    turns, V = velocities(s, R, m.v)
    X, W = centres(s, R, x), times(R, V)
    own = {"linear": (s.mass[:, None] * W).sum(1),  # (2.11)
           "angular": (cross(X, s.mass[:, None] * W) + times(R, times(s.own_inertia, turns))).sum(1)}
    total = dict(zip(("linear", "angular"), total_momentum(s, R, x, mu)))
    errors = [np.abs(found - stored).max() / max(largest(stored.reshape(-1, 3)), 1e-300) for found, stored in (
        (V[:, 0], np.array(S["velocity"]["linear"])), (turns, np.array(S["velocity"]["angular"])))]
    for kind in own:
        stored = {key: np.array(S["momentum"][kind][key]) for key in ("bodies", "fluid", "total")}
        most = max(max(largest(q) for q in stored.values()), scale / (s.length if kind == "linear" else 1))
        errors += [np.abs(found - stored[key]).max() / most for key, found in (
            ("bodies", own[kind]), ("fluid", total[kind] - own[kind]), ("total", total[kind]))]
    report.error("velocity_error", max(errors), certificate["velocity_error"], 1e-6)


def check(S):
    """All checks of one solution; whether all were kept."""
    problem, certificate, report = S["problem"], S["certificate"], Report()
    s = read_swimmer(problem)
    m = read_motion(S, s)
    if "density" in problem:
        check_bodies(s, problem["density"], report)
    else:
        report.skip("matrices of the bodies: the file does not tell the fluid's density")
    if not weighs_smoothness_at_most(problem):
        report.skip("cost: weights beside effort, time and smoothness")
    else:
        cost = problem["effort"] * 0.5 * (m.weight @ (m.a**2).sum(1)) + problem.get("time_weight", 0) * m.duration
        cost += smoothness(problem) * 0.5 * (np.diff(m.a, axis=0)**2).sum() / m.h
        report.same("cost", cost, S["cost"], 1e-9)  # (5.1)
    check_motion(s, m, S, report)
    number, missing = optimality(s, m, S)
    if missing:
        report.skip(f"kkt: {missing}")
    else:
        mark, stored = max(problem["tolerance"], certificate.get("kkt_round_off", 0.0)), certificate["kkt"]
        report.line("kkt", number, stored, mark,
                    number <= mark and (stored is None or number <= max(10 * stored, mark)))
    if certificate["replay"] is None:
        report.skip("replay: none is stored")
    else:
        found, stored = replay(s, m, certificate["replay"]["window"]), certificate["replay"]["rotation_error"]
        report.same("replay.rotation_error, rad", found, stored, 0.05, 2e-7)
    if "limits" in certificate:
        for key, mark in (("violation", 1e-7), ("complementarity", 5e-7), ("negative", 1e-6)):
            stored = certificate["limits"][key]
            report.line("limits." + key + ", as stored", None, stored, mark, abs(stored) <= mark)
        report.skip("limits: what is stored about them is held to its marks, not recomputed")
    report.skip("second order, clearance, feedback, whole replay, refinement, search")
    return report.good


def main(arguments):
    if len(arguments) != 1 or arguments[0].startswith("-"):
        print("usage: python3 check_solution.py DIR   (a folder with solution.json)", file=sys.stderr)
        return 2
    file = pathlib.Path(arguments[0]) / "solution.json"
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeError) as error:
        print(f"cannot read {file}: {error}", file=sys.stderr)
        return 2
    try:
        S = json.loads(text)
        problem = S["problem"]
        missing = ("schemes above order 2" if problem["scheme"] not in ("paper", "trapezoid", "midpoint") else
                   "moments on splines" if problem["control"]["kind"] != "steps" else
                   "simulated marches" if S["certificate"] is None or problem["goal"] is None else None)
        if missing:
            print(f"not covered: {missing}", file=sys.stderr)
            return 2
        good = check(S)
    except (ValueError, KeyError, TypeError, IndexError, AttributeError) as error:
        print(f"{file} is no solution that can be read: {type(error).__name__}: {error}", file=sys.stderr)
        return 2
    print("all kept" if good else "NOT all kept")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
