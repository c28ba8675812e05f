// Second-order optimality: the Hessian of the Lagrangian on the tangent space of the dynamics and the goal, against the
// effort metric (chapter 6).
#pragma once

#include "certificate/certificate.hpp"
#include "certificate/chain.hpp"
#include "certificate/goal_check.hpp"
#include "certificate/limit_check.hpp"
#include "certificate/reached_tangent.hpp"

namespace lamprey::certificate {

/// The motion with costates: gradients of the Lagrangian by the states at the nodes.
struct Costates {
  std::vector<VectorXd> at_node;  // [N + 1][n] as integrator::StateLayout
  VectorXd goal;                  // [rows of goal_rows] multipliers; those of dependent rows are zero
  double residual;                // largest change of a moment's gradient that the multipliers leave / largest gradient
};

/// The chain of the effort alone: what moments reach along the motion, and the goal's independent rows there. In a gait a
/// stage before the others sets the first state, and its inputs ride along as states to the end, which has to fit them.
struct EffortChain {
  Chain chain;
  StepTangents tangents;
  std::vector<MatrixXd> basis;   // [N + 1], the first unset but in gaits
  GoalRows goal;                 // in gaits those of the closure follow
  std::vector<int> independent;  // rows of the goal
  MatrixXd goal_by_carried;      // [rows][carried] inputs of the start, then the difference of the moments at both ends
  Eigen::Index closure = 0;      // first row of the closure
  MatrixXd start;                // [n][free] directions of a gait's first state, in units of the tangents
  std::size_t first = 0;         // stage of node 0
};

/// Nothing where a step is singular or the reached spaces do not fit together.
std::optional<EffortChain> effort_chain(const StoredMotion& motion, double momentum_scale);

/// Multipliers by least squares (equation 6.11). At a stationary motion, and there alone, they are costates.
Costates costates_by_least_squares(const StoredMotion& motion, const EffortChain& effort,
                                   const std::vector<PullingBound>& bounds);

/// The Hessian of the Lagrangian with these costates, as a form of the moments along the motion (equation 6.13). Limits
/// and waypoints that pull are kept by a penalty. Where the duration is free and none of its bounds pulls, its logarithm is
/// the first input of a stage before the others.
Chain lagrangian_chain(const StoredMotion& motion, EffortChain effort, const Costates& costates,
                       const std::vector<PullingBound>& bounds);

/// For moments free at each node, at a stationary motion that meets its goal, from a given start or a gait.
/// Nothing where it cannot be told.
std::optional<SecondOrder> second_order(const StoredMotion& motion, double momentum_scale);

}  // namespace lamprey::certificate
