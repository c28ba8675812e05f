// First guesses: random smooth shape motions, and the finer grid of a coarser answer.
#pragma once

#include <cstdint>
#include <functional>

#include "maneuver/maneuver.hpp"
#include "maneuver/node_path.hpp"

namespace lamprey::guess {

using Eigen::Vector3d;
using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::Problem;

/// Rises from 0 to 1 as s does, at rest at both ends.
double blend(double s);

/// rad, of a joint from its way from start to end: a rotation vector of free joints, else by its angles; at a fraction of the
/// duration.
using Swing = std::function<Vector3d(int joint, double fraction)>;

/// rad, [joints]: multiples of a full turn along a direction of each joint, in which Swing is; zero where a joint makes none.
using WholeTurns = std::vector<Vector3d>;

/// A motion whose joints swing so between start and end shape, and turn round meanwhile where turns are given, while the root goes
/// straight to its goal; momentum and moments are left to the solver.
NodePath swung(const model::System& system, const Maneuver& maneuver, const Swing& swing, const WholeTurns& turns = {});

/// A motion whose joints swing at random between start and end shape while the root goes straight to its goal; momentum and
/// moments are left to the solver. The same for the same seed on every machine. Never the still motion, a singular point.
NodePath random_guess(const model::System& system, const Maneuver& maneuver, std::uint64_t seed);

/// The motion that stays as it starts; above order 2 at the nodes of all stages.
NodePath at_rest(const model::System& system, const Maneuver& maneuver, integrator::Scheme scheme);

/// Whether staying so meets the goal and takes no moments: from rest to where the start is, in a given duration, by no waypoint,
/// with no spring and no work per distance. Limits are not asked.
bool rest_meets_goal(const model::System& system, const Problem& problem, const Maneuver& maneuver);

/// Whether besides no displacement is paid for, so that nothing can cost less.
bool met_by_rest(const model::System& system, const Problem& problem, const Maneuver& maneuver);

/// A motion near another one: its joints swing further, at random as random_guess's do. The root stays where it was.
NodePath perturbed(const model::System& system, const NodePath& path, std::uint64_t seed);

/// The motion with joints that begin as in `start`, [bodies] body → world, and by less and less of the difference from what they
/// were: by nothing at the end. The root turns as it did.
NodePath led_to_start(const model::System& system, const NodePath& path, const mechanics::Rotations& start);

/// The motion with joints that leave their straight way from its first shape to its last by a share of what they did. The root turns
/// as it did.
NodePath calmed(const model::System& system, const NodePath& path, double share);

/// What is left of a motion after this share of its time, on as many steps, by the same splines as `refined`.
NodePath rest_of(const model::System& system, const NodePath& path, double share);

/// The motion on a grid of `steps`: cubic splines through its quaternions, positions and controls, so that velocities stay smooth.
NodePath refined(const model::System& system, const NodePath& coarse, int steps);

/// The same, with the error that the grids share taken off (Richardson, equation 9.11): `coarser` is the same solution on
/// a grid whose nodes are among those of `coarse`, `order` that of the scheme.
NodePath extrapolated(const model::System& system, const NodePath& coarse, const NodePath& coarser, int order,
                      int steps);

/// The same at the nodes of all stages of a scheme above order 2, with the polynomials of its moments.
NodePath refined(const model::System& system, const NodePath& coarse, int steps, integrator::Scheme scheme);

/// Every `stages`-th node of a motion.
NodePath nodes_of_steps(const NodePath& path, int stages);

}  // namespace lamprey::guess
