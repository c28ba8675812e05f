"""Replay of a motion's moments through the continuous equations by DOP853, restarted from the motion's own states."""
import numpy
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

TOLERANCE = 1e-11


def control_of_step(motion, k):
    """Moments by s in [0, 1] within step k."""
    u, u_next = motion.path.control[k], motion.path.control[k + 1]
    if motion.middle_control is None:
        return lambda s: u + s * (u_next - u)
    u_middle = motion.middle_control[k]
    return lambda s: (1.0 - s) * (1.0 - 2.0 * s) * u + 4.0 * s * (1.0 - s) * u_middle + s * (2.0 * s - 1.0) * u_next


def rates(numbers, control):
    count = numbers.count

    def rate(s, y, h):
        q, x_rate = y[:4 * count].reshape(count, 4), y[-3:]
        Omega = y[4 * count + 3:-3].reshape(count, 3)
        R = Rotation.from_quat(q, scalar_first=True).as_matrix()
        acceleration = numbers.accelerations(R, Omega, x_rate, control(s))
        q_rate = numpy.empty_like(q)
        q_rate[:, 0] = -0.5 * (q[:, 1:] * Omega).sum(axis=1)
        q_rate[:, 1:] = 0.5 * (q[:, :1] * Omega + numpy.cross(q[:, 1:], Omega))
        return h * numpy.concatenate([q_rate.ravel(), x_rate, acceleration])

    return rate


def windowed_errors(problem, numbers, motion, window):
    """Largest rotation error, rad, and position error, m, at the ends of windows, as lamprey's certificate defines them (6.7)."""
    path, count = motion.path, len(problem.bodies)
    h = problem.duration / path.steps
    length = max(1, round(window / h))
    angle = way = 0.0
    for first in range(0, path.steps, length):
        last = min(first + length, path.steps)
        y = numpy.concatenate([path.quaternion[first].ravel(), path.position[first], motion.spin[first].ravel(),
                               motion.velocity[first]])
        for k in range(first, last):
            found = solve_ivp(rates(numbers, control_of_step(motion, k)), (0.0, 1.0), y, method="DOP853", args=(h,),
                              rtol=TOLERANCE, atol=TOLERANCE)
            if not found.success:
                return numpy.inf, numpy.inf
            y = found.y[:, -1]
        replayed = Rotation.from_quat(y[:4 * count].reshape(count, 4), scalar_first=True)
        stored = Rotation.from_quat(path.quaternion[last], scalar_first=True)
        angle = max(angle, (stored.inv() * replayed).magnitude().max())
        way = max(way, numpy.linalg.norm(y[4 * count:4 * count + 3] - path.position[last]))
    return angle, way
