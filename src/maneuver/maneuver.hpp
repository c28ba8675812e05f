// Maneuver: a problem's question in the terms of mechanics, all angles turned into rotations, names into indices.
#pragma once

#include <optional>
#include <vector>

#include "integrator/step.hpp"
#include "maneuver/problem.hpp"

namespace lamprey::maneuver {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

inline constexpr double same_pose = 1e-9;  // rad; of the swimmer's size: poses that differ by less are one

struct Maneuver {
  integrator::State start;                            // configuration and momentum at t = 0
  mechanics::SpatialMomentum total;                   // conserved, world, about the origin
  std::vector<std::optional<Matrix3d>> end_rotation;  // [bodies] body → world; nothing: free
  /// [joints] child → parent, between bodies that are free; nothing: free. Empty: all are.
  std::vector<std::optional<Matrix3d>> end_joint;
  std::array<std::optional<double>, 3> end_position;  // m, root's mass centre; nothing: free
  bool rest = true;            // no joint moves at the end: with total momentum zero nothing does
  bool periodic = false;       // shape and its velocity at the end are those at the start, and free
  bool free_shape = false;     // whether the shape at the start of a periodic motion is free too
  bool free_duration = false;  // `duration` is a first guess
  bool whole_turns = false;    // whether nothing but whole turns of its only joint angle gets the swimmer anywhere
  std::vector<char>
      may_turn_round;        // [joints] whether nothing keeps one from turning all the way round; empty: none may
  double time_weight = 0.0;  // (N m)², what a second costs
  CostWeights cost_weights;  // of the other costs; of a given distance its share in work
  mechanics::DiscreteLagrangian lagrangian = mechanics::DiscreteLagrangian::trapezoid;
  double duration = 1.0;  // s
  int steps = 0;
  double effort = 1.0;    // weight of ∫ ½ Σ_j |u_j|² dt
  VectorXd node_weight;   // [N+1] s, the cost is ½ Σ_k weight_k Σ_j |u_jk|²
  int spline_points = 0;  // 0: one free value at each node

  double time_step() const { return duration / steps; }
  bool tells_joint(int joint) const { return !end_joint.empty() && end_joint[model::at(joint)].has_value(); }
};

/// Start state of a problem.
integrator::State start_state(const model::System& system, const Start& start);

/// Bodies that joints lead follow their parents at the angles nearest to what they have.
void fit_to_joints(const model::System& system, mechanics::Rotations& rotation);

/// The same of rotations that joints allow but for `most` rad. Throws model::InputError, its key `key` and the body's name, of others;
/// `as` says what errs so much.
mechanics::Rotations fitted_to_joints(const model::System& system, const mechanics::Rotations& seen, double most,
                                      const std::string& key, const std::string& as);

/// Start state whose joints turn as in `start`, while the whole moves as total momentum zero demands: what is seen of a
/// swimmer's shape and its rates, made to fit joints and law. The start's linear velocity says nothing.
/// Throws model::InputError where a body is turned by more beside its joint than a measurement errs.
integrator::State start_without_momentum(const model::System& system, const Start& start);

/// The same of a swimmer whose whole moves as it is seen to, by the root's velocities, and carries the momentum that this makes.
integrator::State start_as_seen(const model::System& system, const Start& start);

/// kg m²/s, the largest momentum of any body, linear ones by the swimmer's length unit.
double bodies_momentum(const model::System& system, const integrator::State& state);
/// Whether the whole has linear or angular momentum, beyond 1e-10 of what the bodies have.
bool has_momentum(const model::System& system, const integrator::State& state);
/// The same of a problem's start.
bool has_momentum(const model::System& system, const Start& start);

/// The maneuver of a problem marched with `steps` steps. Throws InputError where the goal contradicts mechanics.
Maneuver make_maneuver(const model::System& system, const Problem& problem, int steps);

/// Whether the goal asks for the shape of the start.
bool ends_in_first_shape(const model::System& system, const Maneuver& maneuver);

/// How a joint is to end, child → parent; nothing: free.
std::optional<Matrix3d> joint_at_end(const model::System& system, const Maneuver& maneuver, int joint);

/// Whether nothing keeps a joint within half a turn, whatever it turns about: no limit, and no spring.
bool may_turn_round(const model::Joint& joint, const Limits& limits);

/// Whether it shall end elsewhere than it began.
bool asks_to_move(const model::System& system, const Maneuver& maneuver);

/// Costs as a maneuver has them: work per distance is work where its start and its end fix the distance. Throws InputError where
/// they are one point.
CostWeights weights_along(const Maneuver& maneuver, CostWeights asked);

/// Weights of the cost rule, [N+1] in s, times the effort weight.
VectorXd node_weights(CostRule rule, double effort, double time_step, int steps);

}  // namespace lamprey::maneuver
