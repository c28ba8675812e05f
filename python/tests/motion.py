"""Laws of a motion from its arrays alone."""
import numpy as np


def total_momentum(motion):
    """Linear and angular momentum (nodes, 3) about the world origin, from velocities and matrices, down the tree."""
    problem, R = motion.problem, motion.rotation
    turn = np.einsum("nbij,nbj->nbi", R, motion.velocity["angular"])  # world
    place, speed = {0: motion.position}, {0: np.einsum("nij,nj->ni", R[:, 0], motion.velocity["linear"])}
    joints = list(problem["joints"])
    while joints:
        joint = next(j for j in joints if j["parent"] in place)
        joints.remove(joint)
        parent, child = joint["parent"], joint["child"]
        to_joint = R[:, parent] @ np.array(joint["parent_offset"])
        from_joint = -R[:, child] @ np.array(joint["child_offset"])
        place[child] = place[parent] + to_joint + from_joint
        speed[child] = speed[parent] + np.cross(turn[:, parent], to_joint) + np.cross(turn[:, child], from_joint)
    linear, angular = 0.0, 0.0
    for i, body in enumerate(problem["bodies"]):
        M, J = np.array(body["mass_matrix"]), np.array(body["inertia_matrix"])
        p = np.einsum("nij,jk,nlk,nl->ni", R[:, i], M, R[:, i], speed[i])
        linear = linear + p
        angular = angular + np.cross(place[i], p) + np.einsum("nij,jk,nk->ni", R[:, i], J, motion.velocity["angular"][:, i])
    return linear, angular


def orthogonality(rotation):
    return np.abs(np.swapaxes(rotation, -1, -2) @ rotation - np.eye(3)).max()


def about_e3(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
