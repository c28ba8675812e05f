// Second-order optimality: the Hessian of the Lagrangian on the tangent space of the dynamics and the goal, against the
// effort metric (chapter 6).
#pragma once

#include "optimality/curvature.hpp"
#include "optimality/effort_chain.hpp"
#include "optimality/limit_pulls.hpp"

namespace lamprey::optimality {

inline constexpr double costates_hold = 1e-4;  // residual: beyond it multipliers are no costates

/// The motion with costates: gradients of the Lagrangian by the states at the nodes.
struct Costates {
  std::vector<VectorXd> at_node;  // [N + 1][n] as integrator::StateLayout
  VectorXd goal;                  // [rows of goal_rows] multipliers; those of dependent rows are zero
  double residual;                // largest change of a moment's gradient that the multipliers leave / largest gradient
  double gradient = 0.0;          // that largest gradient of the cost by a moment
};

/// Multipliers by least squares (equation 6.11) of the chain's inputs. At a stationary motion, and there alone, they are costates.
Costates costates_by_least_squares(const StoredMotion& motion, const EffortChain& effort,
                                   const std::vector<PullingBound>& bounds);

/// The Hessian of the Lagrangian with these costates, as a form of the moments along the motion (equation 6.13). Limits
/// and waypoints that pull are rows that its stages keep. Where the duration is free and none of its bounds pulls, its logarithm is
/// the first input of a stage before the others.
Chain lagrangian_chain(const StoredMotion& motion, EffortChain effort, const Costates& costates,
                       const std::vector<PullingBound>& bounds);

/// The same of a scheme above order 2, a stage for each step: its coefficients are the inputs, its own stages condensed.
Chain lagrangian_chain(const StoredMotion& motion, const StageMotion& stages, EffortChain effort,
                       const Costates& costates);

/// Costates at the nodes, and the goal's multipliers, from costates along the reached bases at the beginnings of the chain's
/// stages and at its end; beyond the bases the motion tells them. `pulled` [N + 1][n]: gradients by the states beside the goal's.
void spread_costates(const EffortChain& effort, const std::vector<VectorXd>& reached,
                     const std::vector<VectorXd>& pulled, Costates& costates);

/// For moments free at each node or on splines, at a stationary motion that meets its goal, from a given start or a gait.
/// `kkt` is what the conditions of first order are missed by: bounds hold whose pulls are well above that. Nothing where it cannot
/// be told.
std::optional<SecondOrder> second_order(const StoredMotion& motion, double momentum_scale, double kkt);

/// For moments as polynomials of each step of a scheme above order 2.
std::optional<SecondOrder> second_order(const StoredMotion& motion, const StageMotion& stages, double momentum_scale);

}  // namespace lamprey::optimality
