// Derivatives of discrete momenta by formula: first for Newton and the tangent, second contracted with a direction (chapter 4).
// Perturbations of a step have one layout: η_i of R_{i,k} (3n, body side), η'_i of R_{i,k+1} (3n, body side),
// then the change of the root's displacement (3, world).
#pragma once

#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::mechanics {

/// Column of a perturbation in the layout above.
struct StepLayout {
  int bodies;
  int left(int body) const { return 3 * body; }
  int right(int body) const { return 3 * (bodies + body); }
  int displacement() const { return 6 * bodies; }
  int size() const { return 6 * bodies + 3; }
};

/// Gradient and Hessian in exponential coordinates (symmetric) of a scalar of one step.
struct StepQuadratic {
  VectorXd gradient;  // [6n+3]
  MatrixXd hessian;   // [6n+3][6n+3]
  explicit StepQuadratic(int bodies);
};

/// Scratch arrays of the functions below; one for each thread.
struct DerivativeWorkspace {
  using Rows3 = Eigen::Matrix<double, 3, Eigen::Dynamic>;
  Rows3 centre, centre_rate;   // world displacement of a mass centre, and its rate along the direction
  Rows3 body_side, body_rate;  // the same seen from the body
  Rows3 weighted;              // products with M and N
  explicit DerivativeWorkspace(int bodies);
};

/// L_d to second order around a step: gradient (−p⁻, p⁺, p_x) and Hessian.
void lagrangian_quadratic(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                          const Interval& interval, DerivativeWorkspace& work, StepQuadratic& result);

/// A constant body-side direction of a step: the scalar DL_d[direction] = −p⁻·left + p⁺·right + p_x·displacement.
struct StepDirection {
  std::vector<Vector3d> left;   // [bodies] body frames at k
  std::vector<Vector3d> right;  // [bodies] body frames at k + 1
  Vector3d displacement;        // world
  explicit StepDirection(int bodies);
};

/// DL_d[direction] to second order around a step: what the Hessian of multiplier · momenta is made of.
void directional_quadratic(const model::System& system, DiscreteLagrangian lagrangian, double time_step,
                           const Interval& interval, const StepDirection& direction, DerivativeWorkspace& work,
                           StepQuadratic& result);

/// Jacobians of the discrete momenta by the perturbations of the step; columns in the layout above.
struct MomentumJacobian {
  MatrixXd minus;   // [3n][6n+3]
  MatrixXd plus;    // [3n][6n+3]
  MatrixXd linear;  // [3][6n+3]
  explicit MomentumJacobian(int bodies);
};

/// dp⁻, dp⁺, dp_x from the second-order expansion of L_d: rows of its Hessian plus half of ĝ on the diagonal blocks.
void momentum_jacobian(const StepQuadratic& lagrangian, MomentumJacobian& result);

}  // namespace lamprey::mechanics
