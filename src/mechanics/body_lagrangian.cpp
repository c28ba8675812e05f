#include "mechanics/body_lagrangian.hpp"

#include <cmath>

namespace lamprey::mechanics {

namespace {

using lie::hat;
using lie::vee;

// Where the orientation of M is taken within the step: y = Gᵀw, and a turn a of F on its right turns G by N a.
struct Node {
  double weight;
  Matrix3d G;
  Matrix3d N;
  Vector3d quarter;  // z = tan(θ/4) about F's axis: N = ½ (I + ẑ) half way; zero at the ends
  bool middle;
};

// Calls f with each node that has weight.
template <typename Function>
void for_each_node(const Quadrature& weights, const BodyStep& step, const Function& f) {
  if (weights.left != 0.0) f(Node{weights.left, Matrix3d::Identity(), Matrix3d::Zero(), Vector3d::Zero(), false});
  if (weights.right != 0.0) f(Node{weights.right, step.rotation, Matrix3d::Identity(), Vector3d::Zero(), false});
  if (weights.middle != 0.0) {
    const Vector3d z = step.cayley / (1.0 + std::sqrt(1.0 + step.cayley.squaredNorm()));
    f(Node{weights.middle, lie::cayley(z), 0.5 * (Matrix3d::Identity() + hat(z)), z, true});
  }
}

// ż = ½ (I + ẑ + zzᵀ) c: change of the Cayley vector z when cayley(z) turns by c on its right.
template <typename V>
V cayley_rate(const Vector3d& z, const V& c) {
  return 0.5 * (c + cross(z, c) + along(dot(z, c), z));
}

// φ = vee(F) stands for hΩ in the coupling energy; its rates along constant turns, and transposed maps.
struct Spin {
  explicit Spin(const Matrix3d& F_) : F(F_), value(vee(F_)), trace(F_.trace()) {}
  const Matrix3d& F;
  Vector3d value;
  double trace;
  template <typename V>
  V rate(const V& a) const {
    return 0.5 * (trace * a - Matrix3d(F.transpose()) * a);
  }
  template <typename V>
  V second_rate(const Vector3d& a1, const V& a2) const {
    return along(-dot(value, a2), a1) + 0.5 * cross(a2, Vector3d(F.transpose() * a1));
  }
  template <typename V>
  V pull(const V& p) const {
    return 0.5 * (trace * p - F * p);
  }
  template <typename V, typename W>
  auto pull_rate(const V& a, const W& p) const {
    const auto turned = cross(a, p);
    return decltype(turned)(along(-dot(value, a), p) - 0.5 * (F * turned));
  }
  template <typename V>
  V pull_second_rate(const Vector3d& a1, const V& a2, const Vector3d& p) const {
    return along(-dot(a1, rate(a2)), p) - 0.5 * (F * cross(a2, Vector3d(a1.cross(p))));
  }
};

}  // namespace

Quadrature quadrature(DiscreteLagrangian lagrangian) {
  switch (lagrangian) {
    case DiscreteLagrangian::paper:
      return {1.0, 0.0, 0.0, true};
    case DiscreteLagrangian::trapezoid:
      return {0.5, 0.0, 0.5, false};
    case DiscreteLagrangian::midpoint:
      break;
  }
  return {0.0, 1.0, 0.0, false};
}

Matrix3d trace_inertia(const model::System& system, const Quadrature& weights, int i) {
  const model::Body& body = system.body(i);
  if (!weights.trace_form || body.parent < 0) return body.inertia_matrix;
  const Matrix3d d = hat(system.joint(body.joint).child_offset);
  return body.inertia_matrix - d * body.mass_matrix * d;
}

BodyLagrangian::BodyLagrangian(const model::System& system, DiscreteLagrangian lagrangian, double time_step, int i)
    : M_(system.body(i).mass_matrix),
      C_(system.body(i).coupling_matrix),
      J_(system.body(i).inertia_matrix),
      Jd_(&system.body(i).trace_weight),
      system_trace_weight_(system.body(i).trace_weight),
      weights_(quadrature(lagrangian)),
      rate_(1.0 / time_step),
      coupled_(system.body(i).coupled),
      trace_form_(weights_.trace_form && system.body(i).parent >= 0) {
  if (!trace_form_) return;
  arm_ = -system.joint(system.body(i).joint).child_offset;
  own_Jd_ = mechanics::trace_weight(trace_inertia(system, weights_, i));
  Jd_ = &own_Jd_;
}

double BodyLagrangian::value(const BodyStep& step) const {
  double value = -(step.rotation_minus_identity * *Jd_).trace();
  const Vector3d C_spin = coupled_ ? Vector3d(C_ * vee(step.rotation)) : Vector3d(Vector3d::Zero());
  for_each_node(weights_, step, [&](const Node& node) {
    const Vector3d y = node.G.transpose() * step.shift;
    value += node.weight * y.dot(0.5 * (M_ * y) + C_spin);
  });
  if (trace_form_) {
    const Vector3d s = step.rotation_minus_identity * arm_;
    value -= 0.5 * s.dot(M_ * s);
  }
  return value * rate_;
}

BodyGradient BodyLagrangian::gradient(const BodyStep& step) const {
  // 2 vee(J_d (F − I)) = 2/(1 + |ζ|²) (Jζ + Jζ × ζ)
  const Vector3d& zeta = step.cayley;
  const Vector3d spin_momentum = J_ * zeta;
  BodyGradient result{2.0 / (1.0 + zeta.squaredNorm()) * (spin_momentum + spin_momentum.cross(zeta)), Vector3d::Zero()};
  if (weights_.middle == 0.0 && !coupled_) {
    const BodyGradient translation = plain_share(step).translation_gradient();
    result.turn += translation.turn;
    result.shift = translation.shift;
  } else {
    const Spin spin(step.rotation);
    const Vector3d C_spin = C_ * spin.value;
    Vector3d mean = Vector3d::Zero();
    for_each_node(weights_, step, [&](const Node& node) {
      const Vector3d y = node.G.transpose() * step.shift;
      const Vector3d p = node.weight * (M_ * y + C_spin);
      result.turn += node.N.transpose() * p.cross(y);
      result.shift += node.G * p;
      mean += node.weight * y;
    });
    if (coupled_) result.turn += spin.pull(Vector3d(C_.transpose() * mean));
  }
  if (trace_form_) {  // J' = J − d̂ M d̂, and what s takes out
    result.turn += 2.0 * vee((*Jd_ - system_trace_weight_) * step.rotation_minus_identity);
    result.turn -= arm_.cross(step.rotation.transpose() * (M_ * (step.rotation_minus_identity * arm_)));
  }
  result.turn *= rate_;
  result.shift *= rate_;
  return result;
}

BodyHessian BodyLagrangian::hessian(const BodyStep& step) const {
  const Matrix3d& F = step.rotation;
  const Matrix3d X = *Jd_ * F;
  BodyHessian H{X.trace() * Matrix3d::Identity() - X.transpose(), Matrix3d::Zero(), Matrix3d::Zero(), Matrix3d::Zero()};
  if (weights_.middle == 0.0 && !coupled_) {
    const auto translation = plain_share(step).translation_hessian();
    H.turn_by_turn += translation.turn_by_turn;
    H.turn_by_shift = translation.shift_by_turn.transpose();
    H.shift_by_turn = translation.shift_by_turn;
    H.shift_by_shift = translation.shift_by_shift;
  } else {
    const Spin spin(F);
    const Matrix3d spin_map = 0.5 * (spin.trace * Matrix3d::Identity() - F.transpose());
    const Vector3d C_spin = C_ * spin.value;
    const Matrix3d C_map = C_ * spin_map;
    Vector3d mean = Vector3d::Zero();
    Matrix3d mean_by_turn = Matrix3d::Zero();
    Matrix3d mean_by_shift = Matrix3d::Zero();
    for_each_node(weights_, step, [&](const Node& node) {
      const double k = node.weight;
      const Vector3d y = node.G.transpose() * step.shift;
      const Matrix3d y_by_turn = hat(y) * node.N;
      const Vector3d p = k * (M_ * y + C_spin);
      const Matrix3d p_by_turn = k * (M_ * y_by_turn + C_map);
      const Matrix3d p_by_shift = k * (M_ * node.G.transpose());
      H.shift_by_turn += node.G * (p_by_turn - hat(p) * node.N);
      H.shift_by_shift += node.G * p_by_shift;
      H.turn_by_turn += node.N.transpose() * (hat(p) * y_by_turn - hat(y) * p_by_turn);
      H.turn_by_shift += node.N.transpose() * (hat(p) * node.G.transpose() - hat(y) * p_by_shift);
      if (node.middle) {
        const Vector3d& z = node.quarter;
        H.turn_by_turn += 0.25 * hat(p.cross(y)) * (Matrix3d::Identity() + hat(z) + z * z.transpose()) * node.N;
      }
      mean += k * y;
      mean_by_turn += k * y_by_turn;
      mean_by_shift += k * node.G.transpose();
    });
    if (coupled_) {
      const Vector3d p = C_.transpose() * mean;
      const Matrix3d pull = 0.5 * (spin.trace * Matrix3d::Identity() - F) * C_.transpose();
      H.turn_by_turn += 0.5 * F * hat(p) - p * spin.value.transpose() + pull * mean_by_turn;
      H.turn_by_shift += pull * mean_by_shift;
    }
  }
  if (trace_form_) {
    const Vector3d q = F.transpose() * (M_ * (step.rotation_minus_identity * arm_));
    H.turn_by_turn += hat(arm_) * (F.transpose() * M_ * F * hat(arm_) - hat(q));
  }
  H.turn_by_turn *= rate_;
  H.turn_by_shift *= rate_;
  H.shift_by_turn *= rate_;
  H.shift_by_shift *= rate_;
  return H;
}

template <typename V>
TurnAndShift<V> BodyLagrangian::gradient_rate(const BodyStep& step, const TurnAndShift<V>& direction) const {
  const V& a = direction.turn;
  const V& b = direction.shift;
  if (plain()) return plain_share(step).gradient_rate(direction);
  const Matrix3d& F = step.rotation;
  const Matrix3d Ft = F.transpose();
  const Matrix3d Xt = Ft * *Jd_;
  V by_turn = Xt.trace() * a - Xt * a;
  const Spin spin(F);
  const Matrix3d Ct = C_.transpose();
  const Vector3d C_spin = coupled_ ? Vector3d(C_ * spin.value) : Vector3d(Vector3d::Zero());
  const V C_spin_rate = coupled_ ? V(C_ * spin.rate(a)) : zero_direction<V>();
  Vector3d mean = Vector3d::Zero();
  V mean_rate = zero_direction<V>(), by_shift = zero_direction<V>();
  for_each_node(weights_, step, [&](const Node& node) {
    const double k = node.weight;
    const Matrix3d Gt = node.G.transpose();
    const V c = node.N * a;
    const Vector3d y = Gt * step.shift;
    const V y_rate = cross(y, c) + Gt * b;
    const Vector3d p = k * (M_ * y + C_spin);
    const V p_rate = k * (M_ * y_rate + C_spin_rate);
    by_shift += node.G * V(cross(c, p) + p_rate);
    by_turn += Matrix3d(node.N.transpose()) * V(cross(p_rate, y) + cross(p, y_rate));
    if (node.middle) by_turn += 0.5 * cross(Vector3d(p.cross(y)), cayley_rate(node.quarter, c));
    mean += k * y;
    mean_rate += k * y_rate;
  });
  if (coupled_) by_turn += spin.pull_rate(a, Vector3d(Ct * mean)) + spin.pull(V(Ct * mean_rate));
  if (trace_form_) {
    const Vector3d q = Ft * (M_ * (step.rotation_minus_identity * arm_));
    const V turned = F * cross(a, arm_);
    by_turn -= cross(arm_, V(cross(q, a) + Ft * V(M_ * turned)));
  }
  return {rate_ * by_turn, rate_ * by_shift};
}

template <typename V>
TurnAndShift<V> BodyLagrangian::gradient_second_rate(const BodyStep& step, const BodyDirection& first,
                                                     const TurnAndShift<V>& second) const {
  if (plain()) return PlainSecondRate<Matrix3d, Vector3d>(plain_share(step), first).along_second(second);
  const Matrix3d& F = step.rotation;
  const Matrix3d Ft = F.transpose();
  const Vector3d& a1 = first.turn;
  const V& a2 = second.turn;
  const V& b2 = second.shift;
  const Matrix3d X = *Jd_ * F;
  V by_turn = along(-2.0 * dot(vee(X), a2), a1) + cross(a2, Vector3d(X.transpose() * a1));
  const Spin spin(F);
  const Matrix3d Ct = C_.transpose();
  const Vector3d none = Vector3d::Zero();
  const V zero = zero_direction<V>();
  const Vector3d C_spin = coupled_ ? Vector3d(C_ * spin.value) : none;
  const Vector3d C_spin_1 = coupled_ ? Vector3d(C_ * spin.rate(a1)) : none;
  const V C_spin_2 = coupled_ ? V(C_ * spin.rate(a2)) : zero;
  const V C_spin_12 = coupled_ ? V(C_ * spin.second_rate(a1, a2)) : zero;
  Vector3d mean = none, mean_1 = none;
  V mean_2 = zero, mean_12 = zero, by_shift = zero;
  for_each_node(weights_, step, [&](const Node& node) {
    const double k = node.weight;
    const Matrix3d& N = node.N;
    const Matrix3d Gt = node.G.transpose();
    const Vector3d& z = node.quarter;
    const Vector3d c1 = N * a1;
    const V c2 = N * a2;
    // rates of N and of z, which are there half way alone
    const Vector3d z_1 = node.middle ? cayley_rate(z, c1) : none;
    const V z_2 = node.middle ? cayley_rate(z, c2) : zero;
    const V c_12 = 0.5 * cross(z_2, a1);
    const V z_12 =
        node.middle ? V(cayley_rate(z, c_12) + 0.5 * (cross(z_2, c1) + along(z.dot(c1), z_2) + along(dot(c1, z_2), z)))
                    : zero;
    const Vector3d y = Gt * step.shift;
    const Vector3d seen_1 = Gt * first.shift;
    const Vector3d y_1 = y.cross(c1) + seen_1;
    const V y_2 = cross(y, c2) + Gt * b2;
    const V y_12 = cross(y_2, c1) + cross(y, c_12) - cross(c2, seen_1);
    const Vector3d p = k * (M_ * y + C_spin), p_1 = k * (M_ * y_1 + C_spin_1);
    const V p_2 = k * (M_ * y_2 + C_spin_2), p_12 = k * (M_ * y_12 + C_spin_12);
    by_shift += node.G * V(cross(c2, Vector3d(c1.cross(p) + p_1)) + cross(c_12, p) + cross(c1, p_2) + p_12);
    const Vector3d q = p.cross(y);
    const Vector3d q_1 = p_1.cross(y) + p.cross(y_1);
    const V q_2 = cross(p_2, y) + cross(p, y_2);
    const V q_12 = cross(p_12, y) + cross(p_1, y_2) + cross(p_2, y_1) + cross(p, y_12);
    by_turn += Matrix3d(N.transpose()) * q_12 + 0.5 * (cross(q, z_12) + cross(q_2, z_1) + cross(q_1, z_2));
    mean += k * y;
    mean_1 += k * y_1;
    mean_2 += k * y_2;
    mean_12 += k * y_12;
  });
  if (coupled_)
    by_turn += spin.pull_second_rate(a1, a2, Vector3d(Ct * mean)) + spin.pull_rate(a1, V(Ct * mean_2)) +
               spin.pull_rate(a2, Vector3d(Ct * mean_1)) + spin.pull(V(Ct * mean_12));
  if (trace_form_) {
    const Matrix3d weighed = Ft * M_ * F;
    const Vector3d q = Ft * (M_ * (step.rotation_minus_identity * arm_));
    const Vector3d e1 = a1.cross(arm_);
    const V q_2 = cross(q, a2) + weighed * cross(a2, arm_);
    const V q_12 = cross(q_2, a1) + cross(Vector3d(weighed * e1), a2) + weighed * cross(a2, e1);
    by_turn -= cross(arm_, q_12);
  }
  return {rate_ * by_turn, rate_ * by_shift};
}

template TurnAndShift<Vector3d> BodyLagrangian::gradient_rate(const BodyStep&, const TurnAndShift<Vector3d>&) const;
template TurnAndShift<Four3> BodyLagrangian::gradient_rate(const BodyStep&, const TurnAndShift<Four3>&) const;
template TurnAndShift<Vector3d> BodyLagrangian::gradient_second_rate(const BodyStep&, const BodyDirection&,
                                                                     const TurnAndShift<Vector3d>&) const;
template TurnAndShift<Four3> BodyLagrangian::gradient_second_rate(const BodyStep&, const BodyDirection&,
                                                                  const TurnAndShift<Four3>&) const;

void BodyLagrangian::add_inertia_gradient(const BodyStep& step, const BodyDirection& along, double weight,
                                          BodyInertiaGradient& result) const {
  const Matrix3d& F = step.rotation;
  const Vector3d& a = along.turn;
  const double f = weight * rate_;
  const Matrix3d FA = F * hat(a);
  // −tr(F â J_d) with J_d = ½ tr(J) I − J
  const Matrix3d by_trace_inertia = f * (0.5 * (FA + FA.transpose()) - 0.5 * FA.trace() * Matrix3d::Identity());
  result.inertia_matrix += by_trace_inertia;
  const Spin spin(F);
  const Vector3d spin_rate = spin.rate(a);
  for_each_node(weights_, step, [&](const Node& node) {
    const Vector3d y = node.G.transpose() * step.shift;
    const Vector3d y_rate = y.cross(node.N * a) + node.G.transpose() * along.shift;
    result.mass_matrix += 0.5 * f * node.weight * (y * y_rate.transpose() + y_rate * y.transpose());
    result.coupling_matrix += f * node.weight * (y_rate * spin.value.transpose() + y * spin_rate.transpose());
  });
  if (!trace_form_) return;
  // −½ s·Ms with s = (F − I) arm, and J' = J − d̂ M d̂ in the trace
  const Vector3d s = step.rotation_minus_identity * arm_;
  const Vector3d s_rate = F * a.cross(arm_);
  const Matrix3d d = hat(arm_);
  result.mass_matrix -= 0.5 * f * (s * s_rate.transpose() + s_rate * s.transpose());
  result.mass_matrix -= d.transpose() * by_trace_inertia * d.transpose();
  // by the arm: −(rate of s·M ds) and the trace through d̂
  const Vector3d by_s = -f * (M_ * s_rate);
  const Vector3d by_s_rate = -f * (M_ * s);
  Vector3d by_arm = step.rotation_minus_identity.transpose() * by_s - a.cross(F.transpose() * by_s_rate);
  const Matrix3d by_d = -(by_trace_inertia * d.transpose() * M_ + M_ * d.transpose() * by_trace_inertia);
  by_arm += 2.0 * vee(by_d);
  result.child_offset -= by_arm;
}

}  // namespace lamprey::mechanics
