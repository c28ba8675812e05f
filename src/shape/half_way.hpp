// What the midpoint makes of a body's translation in a step: its inertia is taken half way of its turn (equations 3.7 and
// 9.26). Of four steps at once. S: Four, or Four with their rates.
#pragma once

#include "mechanics/four3.hpp"

namespace lamprey::shape {

/// R_m = R cayley(z), R' = R_m cayley(z). A turn η at the left end turns R_m by ½ (I − ẑ) η, a turn η' at the right end by
/// ½ (I + ẑ) η', and z changes by W η' − Wᵀη. Energies are over unit time.
template <typename S>
class HalfWay {
 public:
  using Vector = mechanics::Three<S>;
  using Matrix = mechanics::ThreeByThree<S>;

  HalfWay() = default;
  HalfWay(const Eigen::Matrix3d& mass, const Matrix& left, const Matrix& right, const Vector& shift) {
    const Matrix F = transposed(left) * right;
    const S root = algebra::square_root(trace(F) + 1.0);  // 2 cos(θ/2)
    quarter_ = (1.0 / (root * (root + 2.0))) * vee_twice(F);
    const Matrix bent = plus_hat(minus_diagonal(dyad(quarter_, quarter_), dot(quarter_, quarter_)), quarter_);
    turn_ = plus_identity((0.5 * root + 1.0) * bent);
    rotation_ = left * turn_;
    seen_ = transposed(rotation_) * shift;
    momentum_ = mass * seen_;
  }

  /// Of ½ Δx·R_m M R_mᵀΔx by Δx, world.
  Vector by_shift() const { return rotation_ * momentum_; }
  /// By the turn at the left end, and at the right end.
  Vector by_left() const {
    const Vector by_turn = 0.5 * cross(momentum_, seen_);
    return by_turn + cross(quarter_, by_turn);
  }
  Vector by_right() const {
    const Vector by_turn = 0.5 * cross(momentum_, seen_);
    return by_turn - cross(quarter_, by_turn);
  }

  /// Second derivatives.
  struct Second {
    Matrix shift_shift;              // world
    Matrix shift_left, shift_right;  // rows seen from the body at the left end; at the right end
    Matrix left_left, right_right, left_right;
  };
  Second second(const Eigen::Matrix3d& mass) const {
    const Matrix momentum_hat = times_hat(mass, seen_);
    const Matrix pull = plus_hat(momentum_hat, -momentum_);
    const Matrix own = minus_diagonal(dyad(seen_, momentum_), dot(seen_, momentum_)) - hat_times(seen_, momentum_hat);
    const S square = dot(quarter_, quarter_);
    const Matrix W = 0.5 * plus_hat(minus_diagonal(dyad(quarter_, quarter_), 0.5 * (square + -1.0)), quarter_);
    const Vector half_by_turn = 0.5 * cross(momentum_, seen_);
    const Matrix bent = hat_times(half_by_turn, W);
    const Matrix own_by_left = along_left(own), own_by_right = along_right(own);
    return {rotation_ * (mass * transposed(rotation_)),
            turn_ * along_left(pull),
            transposed(turn_) * along_right(pull),
            seen_left(own_by_left) + hat_times(half_by_turn, transposed(W)),
            seen_right(own_by_right) + bent,
            seen_left(own_by_right) - bent};
  }

 private:
  // Columns by a turn of R_m become columns by one at an end; rows likewise.
  Matrix along_left(const Matrix& A) const { return 0.5 * (A - times_hat(A, quarter_)); }
  Matrix along_right(const Matrix& A) const { return 0.5 * (A + times_hat(A, quarter_)); }
  Matrix seen_left(const Matrix& A) const { return 0.5 * (A + hat_times(quarter_, A)); }
  Matrix seen_right(const Matrix& A) const { return 0.5 * (A - hat_times(quarter_, A)); }

  Vector quarter_;          // z
  Matrix turn_, rotation_;  // cayley(z), R_m
  Vector seen_, momentum_;  // m, R_mᵀΔx; kg m, M R_mᵀΔx
};

}  // namespace lamprey::shape
