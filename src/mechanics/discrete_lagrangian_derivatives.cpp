#include "mechanics/discrete_lagrangian_derivatives.hpp"

#include <span>

namespace lamprey::mechanics {

namespace {

using lie::double_cross;
using lie::hat;
using lie::vee;
using model::Body;
using model::PathPoint;
using model::System;

using model::at;

Matrix3d without_trace(const Matrix3d& X) { return 0.5 * (X + X.transpose()) - X.trace() * Matrix3d::Identity(); }

// A displacement D = [Δx] + Σ_a (R'_a − R_a) c_a weighed by body i's mass matrix.
struct Displacement {
  int body;
  double factor;       // ±1/h
  double left, right;  // κ at the two nodes
  std::span<const PathPoint> path;
  bool with_root;  // whether Δx is part of it
};

// Adds displacement terms to a quadratic; with a direction, those of their rate along it.
class DisplacementTerms {
 public:
  DisplacementTerms(const System& system, const Interval& step, const StepDirection* direction,
                    DerivativeWorkspace& work, StepQuadratic& result)
      : system_(system), step_(step), direction_(direction), work_(work), result_(result), at_{system.body_count()} {}

  void add(const Displacement& term) {
    lay_maps(term);
    world_force_.setZero();
    world_rate_force_.setZero();
    if (term.left != 0.0) add_node(term, term.left, step_.rotation[at(term.body)], at_.left(term.body), false);
    if (term.right != 0.0) add_node(term, term.right, step_.next_rotation[at(term.body)], at_.right(term.body), true);
    add_curvature_of_rotations(term);
  }

 private:
  // Fills centre = dD, centre_rate = dḊ and the values D, Ḋ.
  void lay_maps(const Displacement& term) {
    work_.centre.setZero();
    D_ = term.with_root ? step_.displacement : Vector3d::Zero();
    if (term.with_root) work_.centre.middleCols<3>(at_.displacement()).setIdentity();
    if (direction_) {
      work_.centre_rate.setZero();
      rate_ = term.with_root ? direction_->displacement : Vector3d::Zero();
    }
    for (const PathPoint& point : term.path) {
      const int a = point.body;
      const Matrix3d& R = step_.rotation[at(a)];
      const Matrix3d& R_next = step_.next_rotation[at(a)];
      D_ += R * (step_.relative_rotation_minus_identity[at(a)] * point.offset);
      work_.centre.middleCols<3>(at_.left(a)) = R * hat(point.offset);
      work_.centre.middleCols<3>(at_.right(a)) = -R_next * hat(point.offset);
      if (!direction_) continue;
      const Vector3d e = direction_->left[at(a)].cross(point.offset);
      const Vector3d e_next = direction_->right[at(a)].cross(point.offset);
      rate_ += R_next * e_next - R * e;
      work_.centre_rate.middleCols<3>(at_.left(a)) = R * hat(e);
      work_.centre_rate.middleCols<3>(at_.right(a)) = -R_next * hat(e_next);
    }
  }

  // One node's share: t = ½ w·Mw, or along a direction t = w·Mẇ + ½ w·Nw, with w = RᵀD, ẇ = RᵀḊ.
  void add_node(const Displacement& term, double weight, const Matrix3d& R, int column, bool next) {
    const double f = term.factor * weight;
    const Matrix3d& M = system_.body(term.body).mass_matrix;
    const Vector3d w = R.transpose() * D_;
    auto own = result_.hessian.middleRows<3>(column);
    work_.body_side.noalias() = R.transpose() * work_.centre;
    if (!direction_) {
      const Vector3d t_w = f * (M * w);
      own.noalias() += hat(t_w) * work_.body_side;
      result_.hessian.middleCols<3>(column).noalias() += work_.body_side.transpose() * hat(t_w).transpose();
      own.middleCols<3>(column) += double_cross(t_w, w);
      work_.body_side.middleCols<3>(column) += hat(w);
      work_.weighted.noalias() = f * M * work_.body_side;
      result_.hessian.noalias() += work_.body_side.transpose() * work_.weighted;
      result_.gradient.noalias() += work_.body_side.transpose() * t_w;
      world_force_ += R * t_w;
      return;
    }
    const Vector3d v = next ? direction_->right[at(term.body)] : direction_->left[at(term.body)];
    const Matrix3d N = hat(v) * M - M * hat(v);
    const Vector3d w_rate = R.transpose() * rate_;
    const Vector3d t_w = f * (M * w_rate + N * w);
    const Vector3d t_rate = f * (M * w);
    work_.body_rate.noalias() = R.transpose() * work_.centre_rate;
    work_.weighted.noalias() = hat(t_w) * work_.body_side + hat(t_rate) * work_.body_rate;
    own += work_.weighted;
    result_.hessian.middleCols<3>(column) += work_.weighted.transpose();
    own.middleCols<3>(column) += double_cross(t_w, w) + double_cross(t_rate, w_rate);
    work_.body_side.middleCols<3>(column) += hat(w);
    work_.body_rate.middleCols<3>(column) += hat(w_rate);
    // WᵀNW + WᵀMẆ + ẆᵀMW = WᵀG + GᵀW with G = ½NW + MẆ
    work_.weighted.noalias() = 0.5 * f * N * work_.body_side + f * M * work_.body_rate;
    result_.hessian.noalias() += work_.body_side.transpose() * work_.weighted;
    result_.hessian.noalias() += work_.weighted.transpose() * work_.body_side;
    result_.gradient.noalias() += work_.body_side.transpose() * t_w;
    result_.gradient.noalias() += work_.body_rate.transpose() * t_rate;
    world_force_ += R * t_w;
    world_rate_force_ += R * t_rate;
  }

  // D and Ḋ are curved in the rotations: second derivatives of R_a c_a along exponentials.
  void add_curvature_of_rotations(const Displacement& term) {
    for (const PathPoint& point : term.path) {
      const int a = point.body;
      const Matrix3d& R = step_.rotation[at(a)];
      const Matrix3d& R_next = step_.next_rotation[at(a)];
      Matrix3d left = double_cross(R.transpose() * world_force_, point.offset);
      Matrix3d right = double_cross(R_next.transpose() * world_force_, point.offset);
      if (direction_) {
        left += double_cross(R.transpose() * world_rate_force_, direction_->left[at(a)].cross(point.offset));
        right += double_cross(R_next.transpose() * world_rate_force_, direction_->right[at(a)].cross(point.offset));
      }
      result_.hessian.block<3, 3>(at_.left(a), at_.left(a)) -= left;
      result_.hessian.block<3, 3>(at_.right(a), at_.right(a)) += right;
    }
  }

  const System& system_;
  const Interval& step_;
  const StepDirection* direction_;
  DerivativeWorkspace& work_;
  StepQuadratic& result_;
  StepLayout at_;
  Vector3d D_, rate_, world_force_, world_rate_force_;
};

// Adds factor · tr(F K) of body i.
void add_trace_term(const Matrix3d& F, const Matrix3d& K, double factor, int left, int right, StepQuadratic& result) {
  const Matrix3d X = F * K;
  const Matrix3d Y = K * F;
  result.gradient.segment<3>(left) += 2.0 * factor * vee(X);
  result.gradient.segment<3>(right) -= 2.0 * factor * vee(Y);
  const Matrix3d cross = -(X - X.trace() * Matrix3d::Identity()) * F;
  result.hessian.block<3, 3>(left, left) += factor * without_trace(X);
  result.hessian.block<3, 3>(right, right) += factor * without_trace(Y);
  result.hessian.block<3, 3>(left, right) += factor * cross;
  result.hessian.block<3, 3>(right, left) += factor * cross.transpose();
}

void expand(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
            const StepDirection* direction, DerivativeWorkspace& work, StepQuadratic& result) {
  const Quadrature weights = quadrature(lagrangian);
  const StepLayout layout{system.body_count()};
  result.gradient.setZero();
  result.hessian.setZero();
  DisplacementTerms displacements(system, step, direction, work, result);
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    displacements.add({i, 1.0 / h, weights.left, weights.right, body.path, true});
    if (weights.trace_form && body.parent >= 0)
      displacements.add({i, -1.0 / h, 1.0, 0.0, std::span(body.path).last(1), false});
    const Matrix3d Jd = trace_weight(trace_inertia(system, weights, i));
    const Matrix3d K = direction ? Matrix3d(hat(direction->right[at(i)]) * Jd - Jd * hat(direction->left[at(i)])) : Jd;
    add_trace_term(step.relative_rotation[at(i)], K, -1.0 / h, layout.left(i), layout.right(i), result);
  }
}

}  // namespace

StepQuadratic::StepQuadratic(int bodies)
    : gradient(VectorXd::Zero(StepLayout{bodies}.size())),
      hessian(MatrixXd::Zero(StepLayout{bodies}.size(), StepLayout{bodies}.size())) {}

DerivativeWorkspace::DerivativeWorkspace(int bodies)
    : centre(3, StepLayout{bodies}.size()),
      centre_rate(3, StepLayout{bodies}.size()),
      body_side(3, StepLayout{bodies}.size()),
      body_rate(3, StepLayout{bodies}.size()),
      weighted(3, StepLayout{bodies}.size()) {}

StepDirection::StepDirection(int bodies)
    : left(at(bodies), Vector3d::Zero()), right(at(bodies), Vector3d::Zero()), displacement(Vector3d::Zero()) {}

MomentumJacobian::MomentumJacobian(int bodies)
    : minus(3 * bodies, StepLayout{bodies}.size()),
      plus(3 * bodies, StepLayout{bodies}.size()),
      linear(3, StepLayout{bodies}.size()) {}

void lagrangian_quadratic(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                          DerivativeWorkspace& work, StepQuadratic& result) {
  expand(system, lagrangian, h, step, nullptr, work, result);
}

void directional_quadratic(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                           const StepDirection& direction, DerivativeWorkspace& work, StepQuadratic& result) {
  expand(system, lagrangian, h, step, &direction, work, result);
}

void momentum_jacobian(const StepQuadratic& lagrangian, MomentumJacobian& result) {
  const int bodies = static_cast<int>(result.minus.rows()) / 3;
  const StepLayout layout{bodies};
  result.minus = -lagrangian.hessian.topRows(3 * bodies);
  result.plus = lagrangian.hessian.middleRows(3 * bodies, 3 * bodies);
  result.linear = lagrangian.hessian.bottomRows<3>();
  for (int i = 0; i < bodies; ++i) {
    const Vector3d left = lagrangian.gradient.segment<3>(layout.left(i));
    const Vector3d right = lagrangian.gradient.segment<3>(layout.right(i));
    result.minus.block<3, 3>(3 * i, layout.left(i)) -= 0.5 * hat(left);
    result.plus.block<3, 3>(3 * i, layout.right(i)) += 0.5 * hat(right);
  }
}

}  // namespace lamprey::mechanics
