// One body's share of a discrete Lagrangian, l(F, w): its relative rotation F over a step and the displacement w of its
// mass centre, seen from the body at the step's beginning; gradient, Hessian and third derivatives (equations 8.8 to 8.13).
#pragma once

#include "lie/so3.hpp"
#include "mechanics/plain_share.hpp"
#include "model/system.hpp"

namespace lamprey::mechanics {

/// paper: left-rectangle with the paper's trace form, order 1. trapezoid, midpoint: symmetric, order 2.
enum class DiscreteLagrangian { paper, trapezoid, midpoint };

/// Weights of the energy of translation with the body's orientation at the left node, half way and at the right node.
struct Quadrature {
  double left;
  double middle;
  double right;
  bool trace_form;  // the d_ip–d_ip part by a trace with J' = J − d̂ M d̂ (paper, equations 12 and 14)
};

Quadrature quadrature(DiscreteLagrangian lagrangian);

/// J_d = ½ tr(J) I − J: what the rotational trace term tr[(I − F) J_d] weighs.
inline Matrix3d trace_weight(const Matrix3d& J) { return 0.5 * J.trace() * Matrix3d::Identity() - J; }

/// The inertia matrix in the rotational trace term: J, or J' = J − d̂ M d̂ of a non-root body with the paper's trace form.
Matrix3d trace_inertia(const model::System& system, const Quadrature& weights, int body);

/// A body's motion over a step, as seen from the body at the step's beginning.
struct BodyStep {
  const Matrix3d& rotation;                 // F
  const Matrix3d& rotation_minus_identity;  // F − I, without cancellation
  const Vector3d& cayley;                   // ζ: F = cayley(ζ)
  Vector3d shift;                           // w, m
};

/// By F and by w: γ, kg m²/s, and β, kg m/s.
using BodyGradient = TurnAndShift<Vector3d>;

/// Change of F (F → F exp(turn)) and of w: a, rad, and b, m.
using BodyDirection = TurnAndShift<Vector3d>;

/// Rates of the gradient: rows turn and shift, columns by a and by b.
struct BodyHessian {
  Matrix3d turn_by_turn;
  Matrix3d turn_by_shift;
  Matrix3d shift_by_turn;
  Matrix3d shift_by_shift;
};

/// Derivative of something scalar by a body's inertia; each entry counts as a number of its own.
struct BodyInertiaGradient {
  Matrix3d mass_matrix = Matrix3d::Zero();
  Matrix3d inertia_matrix = Matrix3d::Zero();
  Matrix3d coupling_matrix = Matrix3d::Zero();
  Vector3d child_offset = Vector3d::Zero();  // through the paper's trace form alone
};

/// l of one body for one scheme and time step.
class BodyLagrangian {
 public:
  BodyLagrangian(const model::System& system, DiscreteLagrangian lagrangian, double time_step, int body);

  double value(const BodyStep& step) const;
  BodyGradient gradient(const BodyStep& step) const;
  BodyHessian hessian(const BodyStep& step) const;
  /// Rate of the gradient along a constant direction or four (equation 8.11).
  template <typename V>
  TurnAndShift<V> gradient_rate(const BodyStep& step, const TurnAndShift<V>& along) const;
  /// Rate along `second` of the rate along `first`, both directions constant (equation 8.12).
  template <typename V>
  TurnAndShift<V> gradient_second_rate(const BodyStep& step, const BodyDirection& first,
                                       const TurnAndShift<V>& second) const;
  /// Adds weight times the derivative by the inertia of l's rate along a direction.
  void add_inertia_gradient(const BodyStep& step, const BodyDirection& along, double weight,
                            BodyInertiaGradient& result) const;

 private:
  bool plain() const { return !coupled_ && !trace_form_ && weights_.middle == 0.0; }
  PlainShare<Matrix3d, Vector3d> plain_share(const BodyStep& step) const {
    return {M_, *Jd_, weights_.left, weights_.right, rate_, step.rotation, step.shift};
  }
  const Matrix3d& M_;
  const Matrix3d& C_;
  const Matrix3d& J_;
  const Matrix3d* Jd_;                   // the body's own, or own_Jd_ with the trace form
  const Matrix3d& system_trace_weight_;  // the body's own
  Matrix3d own_Jd_;                      // left unset without the trace form
  Quadrature weights_;
  Vector3d arm_;  // joint → mass centre where the trace form takes its part out; else unset
  double rate_;   // 1/h
  bool coupled_;
  bool trace_form_;
};

}  // namespace lamprey::mechanics
