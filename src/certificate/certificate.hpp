// Certificate: the numbers that prove an answer, in the words of solution.json. NaN: not computed (written as null).
#pragma once

#include <limits>
#include <optional>
#include <string>

namespace lamprey::certificate {

inline constexpr double unset = std::numeric_limits<double>::quiet_NaN();

struct SecondOrder {
  double smallest_eigenvalue = unset;
  bool positive = false;
};

/// The stored controls through an independent high-order integrator of the continuous equations.
struct Replay {
  std::string scheme;
  double window = unset;                   // s between restarts from the stored state
  double rotation_error = unset;           // rad, largest at a window's end
  double position_error = unset;           // m, largest at a window's end
  double whole_rotation_error = unset;     // rad, never restarted
  double whole_position_error = unset;     // m, never restarted
  double growth_rate = unset;              // 1/s of small perturbations
  double feedback_rotation_error = unset;  // rad, never restarted, with the stored gains; at the end
  double feedback_position_error = unset;  // m, likewise
};

struct Refinement {
  double cost_half_step = unset;
  double observed_order = unset;
};

struct Certificate {
  double goal_error = unset;      // max over goal rows, rad or m
  double rest_error = unset;      // max |μ_N| / scale
  double momentum_drift = unset;  // max |p − p_0| / scale
  double rotation_drift = unset;  // max |RᵀR − I|
  double kkt = unset;             // scaled, in the space of controls
  std::optional<SecondOrder> second_order;
  std::optional<Replay> replay;
  std::optional<Refinement> refinement;
  double equation_residual = unset;  // largest residual of the discrete equations, both ends included, / scale
  double start_error = unset;        // largest difference of node 0 from the problem's start, rad or m
  double control_error = unset;      // largest part of a moment that joints or control kind forbid / largest moment
};

}  // namespace lamprey::certificate
