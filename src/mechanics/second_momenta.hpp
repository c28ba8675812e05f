// How a body's momenta change along a second direction when they have changed along a first one (equation 8.31): written
// once for one body or four, and for one second direction or four.
#pragma once

#include "mechanics/step_balance.hpp"

namespace lamprey::mechanics {

/// A body's step and how it moves along the first direction; M: Matrix3d or Four33, K: its vectors.
template <typename M, typename K>
struct FirstMotion {
  M R, F;
  K w, gamma, beta;               // shift, γ and β
  TurnAndShift<K> seen;           // a_1, b_1
  K turn, seen_turn;              // η_1, and Fᵀη_1
  K seen_centre;                  // Rᵀδ_1
  K force_change, moment_change;  // η_1 × β + β_1, a_1 × γ + γ_1
  K shift_rate;                   // β_1

  FirstMotion(const M& R_, const M& F_, const K& w_, const TurnAndShift<K>& gradient, const K& turn_, const K& centre,
              const TurnAndShift<K>& seen_, const TurnAndShift<K>& rate)
      : R(R_),
        F(F_),
        w(w_),
        gamma(gradient.turn),
        beta(gradient.shift),
        seen(seen_),
        turn(turn_),
        seen_turn(transposed(F_) * turn_),
        seen_centre(transposed(R_) * centre),
        force_change(cross(turn_, gradient.shift) + rate.shift),
        moment_change(cross(seen_.turn, gradient.turn) + rate.turn),
        shift_rate(rate.shift) {}
};

/// Of body n.
inline FirstMotion<Matrix3d, Vector3d> first_motion(const Interval& interval, const DiscreteMomenta& p,
                                                    const StepRate& first, std::size_t n) {
  return {interval.rotation[n], interval.relative_rotation[n],
          p.shift[n],           BodyGradient{p.turn[n], p.impulse[n]},
          first.turn[n],        first.centre[n],
          first.seen[n],        first.gradient[n]};
}

/// A second direction as the body sees it, and how the first one changes along it.
template <typename V>
struct SecondMotion {
  V turn;                                          // η_2
  TurnAndShift<V> seen;                            // a_2, b_2
  TurnAndShift<V> rate;                            // γ_2, β_2
  V turn_change, next_turn_change, centre_change;  // η_12, η'_12, δD_12
};

/// P_12 (world), π⁻_12 and π⁺_12.
template <typename V>
struct SecondMomenta {
  V force, moment, next;
};

/// `second_rate` (along a_2, b_2) is the gradient's along both directions held, `rate` (along anything) its rate.
template <typename M, typename K, typename V, typename SecondRate, typename Rate>
SecondMomenta<V> second_momenta(const FirstMotion<M, K>& first, const SecondMotion<V>& second,
                                const SecondRate& second_rate, const Rate& rate) {
  const V& eta_2 = second.turn;
  const V& eta_12 = second.turn_change;
  const auto& [a_2, b_2] = second.seen;
  const V a_12 = second.next_turn_change - transposed(first.F) * eta_12 + cross(a_2, first.seen_turn);
  const V b_12 = cross(b_2, first.turn) + cross(first.w, eta_12) - cross(eta_2, first.seen_centre) +
                 transposed(first.R) * second.centre_change;
  const TurnAndShift<V> held = second_rate(second.seen), changed = rate(TurnAndShift<V>{a_12, b_12});
  const V gamma_12 = held.turn + changed.turn;
  const V beta_12 = held.shift + changed.shift;
  return {first.R * V(cross(eta_2, first.force_change) + cross(eta_12, first.beta) +
                      cross(first.turn, second.rate.shift) + beta_12),
          first.F * V(cross(a_2, first.moment_change) + cross(a_12, first.gamma) +
                      cross(first.seen.turn, second.rate.turn) + gamma_12) +
              cross(b_12, first.beta) + cross(first.seen.shift, second.rate.shift) + cross(b_2, first.shift_rate) +
              cross(first.w, beta_12),
          gamma_12};
}

}  // namespace lamprey::mechanics
