#include "guess/strokes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algebra/row_space.hpp"
#include "maneuver/random.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::guess {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::Limits;
using maneuver::Random;
using model::at;
using model::System;
using shape::ShapeProgram;
using shape::Steps;

constexpr int rounds = 40;
constexpr int halvings = 6;
constexpr double most_swing = 1.4;      // rad
constexpr double unlimited = 1e3;       // rad
constexpr double most_amplitude = 4.0;  // rad, of a sine before it flattens
constexpr double least_swing = 1e-2;    // rad
constexpr double within_limits = 0.95;
constexpr double first_swing = 0.3;     // rad
constexpr double longest_change = 0.2;  // rad, of an amplitude in a round
constexpr double difference = 1e-5;     // rad
constexpr double arrived = 1e-6;        // units of the end rows
constexpr double damping = 1e-3;        // of the largest sensitivity

// x, but for what goes beyond a largest size.
template <typename Vector>
Vector bounded(const Vector& x, double largest) {
  return x * (largest / std::sqrt(largest * largest + x.squaredNorm()));
}

class Waves {
 public:
  Waves(const System& system, const StrokeLimits& limits, int strokes)
      : system_(system), limits_(limits), strokes_(strokes) {}

  // Of amplitudes: of sine and cosine along each actuated direction.
  Eigen::Index size() const { return 2 * system_.control_count(); }

  // rad: waves that grow in the first half stroke, fade in the last one, and flatten where the joint may not swing further.
  Vector3d swing(const VectorXd& amplitudes, int j, double s) const {
    const double edge = std::min({1.0, 2.0 * strokes_ * s, 2.0 * strokes_ * (1.0 - s)});
    const double phase = 2.0 * std::numbers::pi * strokes_ * s;
    const MatrixXd& actuation = system_.joint(j).actuation;
    const Eigen::Index count = actuation.cols();
    const VectorXd own =
        bounded(VectorXd(amplitudes.segment(2 * system_.joint(j).first_control, 2 * count)), limits_.amplitude[at(j)]);
    const Vector3d wave = actuation * (std::sin(phase) * own.head(count) + std::cos(phase) * own.tail(count));
    return blend(std::max(edge, 0.0)) * bounded(wave, limits_.swing[at(j)]);
  }

 private:
  const System& system_;
  const StrokeLimits& limits_;
  int strokes_;
};

class Adjustment {
 public:
  Adjustment(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
             const std::vector<EndRow>& rows, const StrokeLimits& limits, int strokes, const WholeTurns& turns)
      : system_(system),
        maneuver_(maneuver),
        program_(system, maneuver_, coordinates, rows, {}, Steps::rough),
        waves_(system, limits, strokes),
        turns_(turns) {}

  Strokes run(Random& random) {
    amplitudes_.resize(waves_.size());
    for (double& one : amplitudes_) one = first_swing * random.normal();
    while (!miss(amplitudes_, missed_))
      if ((amplitudes_ *= 0.5).norm() < difference) return {};
    for (int round = 0; round < rounds && missed_.lpNorm<1>() > arrived; ++round)
      if (!improve()) break;
    if (!miss(amplitudes_, missed_)) return {};
    return {program_.path(), missed_.lpNorm<1>()};
  }

 private:
  bool miss(const VectorXd& amplitudes, VectorXd& missed) {
    const auto swing = [&](int joint, double s) { return waves_.swing(amplitudes, joint, s); };
    if (!program_.go_to(swung(system_, maneuver_, swing, turns_))) return false;
    missed = program_.end_rows();
    return missed.allFinite();
  }

  // A step of Gauss and Newton, the shortest one, as far as it misses less.
  bool improve() {
    MatrixXd by_amplitudes(missed_.size(), amplitudes_.size());
    VectorXd changed = amplitudes_, missed;
    for (Eigen::Index p = 0; p < changed.size(); ++p) {
      changed[p] += difference;
      if (!miss(changed, missed)) return false;
      by_amplitudes.col(p) = (missed - missed_) / difference;
      changed[p] = amplitudes_[p];
    }
    const double largest = by_amplitudes.colwise().norm().maxCoeff();
    if (!(largest > 0.0)) return false;
    MatrixXd rows(missed_.size() + changed.size(), changed.size());
    rows << by_amplitudes, damping * largest * MatrixXd::Identity(changed.size(), changed.size());
    VectorXd values = VectorXd::Zero(rows.rows());
    values.head(missed_.size()) = -missed_;
    VectorXd step = algebra::least_squares(rows, values);
    step *= std::min(1.0, longest_change / step.lpNorm<Eigen::Infinity>());
    for (int halving = 0; halving < halvings; ++halving, step *= 0.5) {
      if (!miss(amplitudes_ + step, missed) || !(missed.norm() < missed_.norm())) continue;
      amplitudes_ += step;
      missed_ = missed;
      return true;
    }
    return false;
  }

  const System& system_;
  const Maneuver& maneuver_;
  ShapeProgram program_;
  Waves waves_;
  const WholeTurns& turns_;
  VectorXd amplitudes_, missed_;
};

}  // namespace

StrokeLimits no_stroke_limits(const System& system) {
  const std::vector<double> any(at(system.joint_count()), unlimited);
  return {any, any};
}

StrokeLimits stroke_limits(const System& system, const Problem& problem, const integrator::State& start,
                           double duration, int strokes) {
  const Limits& limits = problem.limits;
  const double rate = 2.0 * std::numbers::pi * strokes / duration;  // 1/s
  StrokeLimits result;
  for (const model::Joint& joint : system.joints()) {
    // a joint's own bound stands in the place of that of all
    const auto of_joint = [&](const std::optional<double>& all, const std::map<std::string, double>& by_joint) {
      const auto own = by_joint.find(joint.name);
      return own != by_joint.end() ? std::optional(own->second) : all;
    };
    double swing = most_swing;
    double velocity = of_joint(limits.angular_velocity, limits.joint_angular_velocity).value_or(most_amplitude * rate);
    if (!joint.free())
      velocity = std::min(
          velocity,
          of_joint(limits.angular_velocity_component, limits.joint_angular_velocity_component).value_or(velocity));
    const auto stay_within = [&](const std::map<std::string, double>& by_joint) {
      if (const auto found = by_joint.find(joint.name); found != by_joint.end())
        swing = std::min(swing, within_limits * found->second);
    };
    stay_within(limits.swing);
    stay_within(limits.twist);
    if (const auto angle = limits.angle.find(joint.name); angle != limits.angle.end()) {
      const Matrix3d Q = mechanics::child_to_parent(start.rotation, joint);
      const Vector3d first = mechanics::joint_angles(joint, Q);
      for (std::size_t axis = 0; axis < angle->second.size(); ++axis) {
        const auto& [low, high] = angle->second[axis];
        const double now = first[static_cast<Eigen::Index>(axis)];
        swing = std::min(swing, within_limits * std::min(high - now, now - low));
      }
    }
    result.swing.push_back(std::max(swing, least_swing));
    result.amplitude.push_back(std::max(within_limits * velocity / rate, least_swing));
  }
  return result;
}

Strokes strokes_to_goal(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
                        const std::vector<EndRow>& rows, const StrokeLimits& limits, int strokes, std::uint64_t seed,
                        const WholeTurns& turns) {
  Random random(seed);
  return Adjustment(system, maneuver, coordinates, rows, limits, strokes, turns).run(random);
}

}  // namespace lamprey::guess
