// A body's share of a discrete Lagrangian, l(F, w), where neither coupling, midpoint nor the paper's trace form ask for
// more: formulas written once for one body and for four (equations 8.8 to 8.13).
#pragma once

#include "mechanics/directions.hpp"

namespace lamprey::mechanics {

/// Two parts, by or of F (body side on the right) and w; V: Vector3d, or Four3 of four directions or bodies at once.
template <typename V>
struct TurnAndShift {
  V turn, shift;
};

/// M: Matrix3d, or Four33 of four bodies; K: their vectors.
template <typename M, typename K>
struct PlainShare {
  const M& mass;
  const M& trace_weight;
  double left, right;  // weights of the translation's energy at the two nodes
  double rate;         // 1/h
  const M& F;
  const K& w;  // m

  /// What translation adds to the gradient.
  TurnAndShift<K> translation_gradient() const {
    const K y = transposed(F) * w;
    const K q = right * (mass * y);
    return {cross(q, y), left * (mass * w) + F * q};
  }

  /// And to the Hessian, before the rate; turn_by_shift is the transpose of shift_by_turn.
  struct TranslationHessian {
    M turn_by_turn, shift_by_turn, shift_by_shift;
  };
  TranslationHessian translation_hessian() const {
    const K y = transposed(F) * w;
    const K p = right * (mass * y);
    const M FM = right * (F * mass);
    const M p_by_turn = right * times_hat(mass, y);
    // p̂ŷ = y pᵀ − (p·y) I
    return {minus_diagonal(dyad(y, p), dot(p, y)) - hat_times(y, p_by_turn), times_hat(FM, y) - times_hat(F, p),
            left * mass + FM * transposed(F)};
  }

  /// Rate of the gradient along a constant direction.
  template <typename V>
  TurnAndShift<V> gradient_rate(const TurnAndShift<V>& d) const {
    const V &a = d.turn, &b = d.shift;
    const M Ft = transposed(F);
    const M Xt = Ft * trace_weight;
    const K y = Ft * w;
    const K p = right * (mass * y);
    const V y_rate = cross(y, a) + Ft * b;
    const V p_rate = right * (mass * y_rate);
    const V by_turn = along(trace(Xt), a) - Xt * a + cross(p_rate, y) + cross(p, y_rate);
    const V by_shift = left * (mass * b) + F * V(cross(a, p) + p_rate);
    return {rate * by_turn, rate * by_shift};
  }
};

inline Vector3d vee_twice(const Matrix3d& X) { return {X(2, 1) - X(1, 2), X(0, 2) - X(2, 0), X(1, 0) - X(0, 1)}; }

/// Rates along second directions of the rate along a first one, both constant.
template <typename M, typename K>
class PlainSecondRate {
 public:
  PlainSecondRate(const PlainShare<M, K>& share, const TurnAndShift<K>& first)
      : share_(share), a1_(first.turn), Ft_(transposed(share.F)) {
    const M X = share.trace_weight * share.F;
    axis_ = vee_twice(X);
    turned_ = transposed(X) * a1_;
    y_ = Ft_ * share.w;
    seen_1_ = Ft_ * first.shift;
    y_1_ = cross(y_, a1_) + seen_1_;
    const K p = share.right * (share.mass * y_);
    p_ = p;
    p_1_ = share.right * (share.mass * y_1_);
    left_ = cross(a1_, p) + p_1_;
  }

  template <typename V>
  TurnAndShift<V> along_second(const TurnAndShift<V>& second) const {
    const V &a2 = second.turn, &b2 = second.shift;
    const V y_2 = cross(y_, a2) + Ft_ * b2;
    const V y_12 = cross(y_2, a1_) - cross(a2, seen_1_);
    const V p_2 = share_.right * (share_.mass * y_2), p_12 = share_.right * (share_.mass * y_12);
    const V by_shift = share_.F * V(cross(a2, left_) + cross(a1_, p_2) + p_12);
    const V by_turn = along(-dot(axis_, a2), a1_) + cross(a2, turned_) + cross(p_12, y_) + cross(p_1_, y_2) +
                      cross(p_2, y_1_) + cross(p_, y_12);
    return {share_.rate * by_turn, share_.rate * by_shift};
  }

 private:
  const PlainShare<M, K>& share_;
  K a1_, axis_, turned_, y_, seen_1_, y_1_, p_, p_1_, left_;
  M Ft_;
};

}  // namespace lamprey::mechanics
