// What marches do to total momentum, to rotations and to energy.
#pragma once

#include <algorithm>
#include <vector>

#include "integrator/marching.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {

/// Largest changes over a march: of the momentum relative to the largest momentum of a body, and of RᵀR.
struct Drift {
  double linear = 0.0, angular = 0.0, rotation = 0.0;
};

inline Drift drift_of_march(const Moving& swimmer, integrator::Scheme scheme, double h, int steps,
                            const TimedControl& control) {
  const auto momentum = [&](const integrator::State& state) {
    return mechanics::spatial_momentum(swimmer.system, state.rotation, state.position, state.momentum);
  };
  const auto start = momentum(swimmer.start);
  double scale = 0.0;
  Drift drift;
  marched(swimmer.system, scheme, h, steps, swimmer.start, control, [&](int, const integrator::State& state) {
    const auto total = momentum(state);
    drift.linear = std::max(drift.linear, (total.linear - start.linear).lpNorm<Eigen::Infinity>());
    drift.angular = std::max(drift.angular, (total.angular - start.angular).lpNorm<Eigen::Infinity>());
    for (const auto& R : state.rotation)
      drift.rotation = std::max(drift.rotation, (R.transpose() * R - Matrix3d::Identity()).lpNorm<Eigen::Infinity>());
    scale = std::max(scale, state.momentum.lpNorm<Eigen::Infinity>());
  });
  drift.linear /= scale;
  drift.angular /= scale;
  return drift;
}

/// A free march of the tumbling chain: momentum against its value at the start, angular about the starting point, and
/// energy in equally spaced samples.
struct FreeMarch {
  double linear = 0.0, angular = 0.0;  // largest change, relative to the momentum at the start
  double rotation = 0.0;               // largest entry of RᵀR − I
  std::vector<double> energy;          // change relative to the start, at each sample

  double energy_band() const {
    double largest = 0.0;
    for (double e : energy) largest = std::max(largest, std::abs(e));
    return largest;
  }
};

inline FreeMarch free_march(integrator::Scheme scheme, double h, int steps, int steps_for_each_sample) {
  const Moving chain = tumbling_chain();
  const auto energy = [&](const integrator::State& state) {
    return mechanics::kinetic_energy(chain.system, state.rotation, integrator::velocity_of_state(chain.system, state));
  };
  const auto momentum = [&](const integrator::State& state) {
    return mechanics::spatial_momentum(chain.system, state.rotation, state.position, state.momentum);
  };
  const double first_energy = energy(chain.start);
  const auto first = momentum(chain.start);
  FreeMarch result;
  marched(chain.system, scheme, h, steps, chain.start, {}, [&](int step, const integrator::State& state) {
    if ((step + 1) % steps_for_each_sample != 0) return;
    result.energy.push_back(energy(state) / first_energy - 1.0);
    const auto now = momentum(state);
    result.linear = std::max(result.linear, (now.linear - first.linear).norm() / first.linear.norm());
    result.angular = std::max(result.angular, (now.angular - first.angular).norm() / first.angular.norm());
    for (const Matrix3d& R : state.rotation)
      result.rotation = std::max(result.rotation, (R.transpose() * R - Matrix3d::Identity()).lpNorm<Eigen::Infinity>());
  });
  return result;
}

/// Slope of the straight line through means of equally long blocks, times the duration, and its standard error from the
/// scatter of those means about the line: means of long blocks are nearly independent even though samples are not.
struct Trend {
  double change;
  double standard_error;
};

inline Trend trend(const std::vector<double>& samples, int blocks = 20) {
  const std::size_t length = samples.size() / static_cast<std::size_t>(blocks);
  std::vector<double> mean;
  for (int b = 0; b < blocks; ++b) {
    const auto begin = samples.begin() + static_cast<std::ptrdiff_t>(static_cast<std::size_t>(b) * length);
    double sum = 0.0;
    for (auto sample = begin; sample != begin + static_cast<std::ptrdiff_t>(length); ++sample) sum += *sample;
    mean.push_back(sum / static_cast<double>(length));
  }
  double sum_tt = 0.0, sum_te = 0.0, average = 0.0, residual = 0.0;
  for (double e : mean) average += e / blocks;
  const auto time = [&](int b) { return (b + 0.5) / blocks - 0.5; };
  for (int b = 0; b < blocks; ++b) {
    sum_tt += time(b) * time(b);
    sum_te += time(b) * (mean[static_cast<std::size_t>(b)] - average);
  }
  const double slope = sum_te / sum_tt;
  for (int b = 0; b < blocks; ++b) {
    const double off = mean[static_cast<std::size_t>(b)] - average - slope * time(b);
    residual += off * off;
  }
  return {slope, std::sqrt(residual / (blocks - 2) / sum_tt)};
}

}  // namespace lamprey::tests
