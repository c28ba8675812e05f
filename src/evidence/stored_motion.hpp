// The plain data that a certificate starts from: rotations, positions and moments at the nodes, and the problem.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "integrator/step.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::evidence {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// An answer read as a discrete motion. Refers to its three sources, which must outlive it.
struct StoredMotion {
  const model::System& system;
  const maneuver::Problem& problem;
  const maneuver::Solution& solution;
  int steps;
  double time_step;  // s
  mechanics::DiscreteLagrangian lagrangian;
  std::vector<mechanics::Moments> control;  // [N+1] along the joints
  /// Whether each step obeys the discrete Lagrangian between its two nodes: not above order 2, whose steps have nodes
  /// within, nor where a march divided its steps or was not the scheme's.
  bool steps_known;

  StoredMotion(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution);
};

/// Whether shape and momenta at the end are those at the start, and free.
bool periodic(const StoredMotion& motion);

/// Step k as the nodes k and k + 1 have it, updated: F_i = R_{i,k}ᵀ R_{i,k+1}.
void read_interval(const StoredMotion& motion, int k, mechanics::Interval& interval);

/// Start of the problem, not of the answer.
integrator::State start_of(const model::System& system, const maneuver::Start& start);

/// E⁻ and E⁺ of a step, generalised: the discrete momenta and the halved impulses of the joints' dampers.
struct StepMomenta {
  VectorXd minus;  // p⁻ + ψ⁻ at the beginning
  VectorXd plus;   // p⁺ − ψ⁺ at the end
};

/// A node's state by its stored velocities.
integrator::State stored_state(const StoredMotion& motion, int k);

StepMomenta step_momenta(const StoredMotion& motion, int k);

/// States at the nodes, [N+1]: μ_k = E⁻_k − (h/2) U_k, at the end E⁺_N + (h/2) U_N (equation 4.5).
std::vector<integrator::State> node_states(const StoredMotion& motion);

/// Rotations of all bodies with one body turned along one of its freedoms, by the angle `by` in rad.
mechanics::Rotations with_turn(const model::System& system, const mechanics::Rotations& R, int body, int freedom,
                               double by);

/// Rotations turned along freedoms of all bodies at once, [turns] rad, along exponentials.
mechanics::Rotations turned_along(const model::System& system, const mechanics::Rotations& R, const VectorXd& along);

/// Keeps the largest of numbers; anything not finite counts as infinite.
class Largest {
 public:
  void add(double value) { value_ = std::isfinite(value) ? std::max(value_, value) : infinite; }
  double value() const { return value_; }
  /// value / scale, and 0 where both vanish.
  double relative_to(double scale) const { return value_ == 0.0 ? 0.0 : value_ / scale; }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  double value_ = 0.0;
};

}  // namespace lamprey::evidence
