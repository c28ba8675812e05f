// What second derivatives say of a stationary motion, plain numbers, and their marks.
#pragma once

#include <optional>

#include "evidence/findings.hpp"

namespace lamprey::optimality {

using evidence::unset;

inline constexpr double proof_mark = 1e-6;      // of kkt: beyond, a proof would rest on a loose tolerance
inline constexpr double curvature_mark = 1e-6;  // of the effort's own
inline constexpr double no_curvature = 1e8;     // likewise: more is a limit's doing

/// Eigenvalues of the Lagrangian's Hessian among changes of the moments that keep the goal, against the effort metric.
struct SecondOrder {
  double smallest_eigenvalue = unset;  // 1: pure effort
  bool positive = false;               // smallest eigenvalue above 1e-6
  std::optional<int> negative_eigenvalues = {};
  bool costs_nothing =
      false;  // and nothing less can be, so that other directions, of a duration or a first shape, may be flat; not stored
  std::optional<double> along_phase =
      {};  // set aside of the numbers above: that of beginning elsewhere along a gait, within ±1e-6
  /// Whether limits leave next to nothing of the directions: what they hold is no curvature, but as stiff as digits can tell.
  bool held() const { return smallest_eigenvalue > no_curvature; }
  /// Whether round-off hides how many directions lower the cost, and how steeply.
  bool lost() const { return !positive && !negative_eigenvalues && smallest_eigenvalue < -curvature_mark; }
};

/// The same with every direction moved that actuated joints leave free: control_axes set aside.
struct AllAxes {
  double kkt = unset;  // among all these moments; unless it is small the eigenvalues mean nothing and are unset
  SecondOrder second_order;
};

}  // namespace lamprey::optimality
