// The linearised motion as a chain of inputs with the effort as its form: where the second-order test begins (chapter 6).
#pragma once

#include "evidence/goal_check.hpp"
#include "optimality/chain.hpp"
#include "optimality/reached_tangent.hpp"

namespace lamprey::optimality {

/// The chain of the effort alone: what moments reach along the motion, and the goal's independent rows there. In a gait a
/// stage before the others sets the first state, and its inputs ride along as states to the end, which has to fit them.
struct EffortChain {
  Chain chain;
  MatrixXd input;     // [inputs][stages] moments at the nodes, or coefficients of the steps' polynomials
  double cost = 0.0;  // (N m)² s, the effort
  StepTangents tangents;
  std::vector<MatrixXd> basis;   // [N + 1], the first set in gaits and, in free time, of starts in motion alone
  evidence::GoalRows goal;       // in gaits those of the closure follow
  std::vector<int> independent;  // rows of the goal
  MatrixXd goal_by_carried;      // [rows][carried] inputs of the start, then the difference of the moments at both ends
  Eigen::Index closure = 0;      // first row of the closure
  MatrixXd start;                // [n][free] directions of a gait's first state, in units of the tangents
  std::size_t first = 0;         // stage of node 0
  VectorXd start_by_duration;    // [reached] first state by the duration's logarithm, of a start in motion; else empty
  std::vector<VectorXd> by_duration;  // [N][reached] next states by it, where springs or dampers tell it
};

/// With the moments at the nodes as inputs. Nothing where a step is singular or the reached spaces do not fit together.
std::optional<EffortChain> effort_chain(const StoredMotion& motion, double momentum_scale);

/// With the coefficients of each step's polynomials as inputs, of a scheme above order 2.
std::optional<EffortChain> effort_chain(const StoredMotion& motion, const StageMotion& stages, double momentum_scale);

}  // namespace lamprey::optimality
