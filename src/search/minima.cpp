#include "search/minima.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lie/so3.hpp"

namespace lamprey::search {

namespace {

constexpr double same_cost = 1e-6;      // relative, of what is spent
constexpr double cost_of_phase = 1e-4;  // relative, by which a gait may cost more where it begins between two nodes
constexpr double same_turning = 1e-3;   // relative, of each joint

bool near_by(double value, double other, double relative) {
  return std::abs(value - other) <= relative * std::max(std::abs(value), std::abs(other));
}

}  // namespace

Minimum minimum_of(const model::System& system, const maneuver::Problem& problem, double cost,
                   const std::vector<mechanics::Rotations>& rotation) {
  Minimum minimum{cost, cost - problem.cost_of_given_duration(), {}};
  if (!problem.goal || !problem.goal->periodic || rotation.empty()) return minimum;
  minimum.turning.setZero(system.joint_count());
  for (int j = 0; j < system.joint_count(); ++j)
    for (std::size_t k = 0; k + 1 < rotation.size(); ++k) {
      const model::Joint& joint = system.joint(j);
      const double turn = lie::rotation_angle(mechanics::child_to_parent(rotation[k], joint).transpose() *
                                              mechanics::child_to_parent(rotation[k + 1], joint));
      minimum.turning[j] += static_cast<double>(rotation.size() - 1) * turn * turn;
    }
  return minimum;
}

bool same_minimum(const Minimum& one, const Minimum& other) {
  if (near_by(one.spent, other.spent, same_cost)) return true;
  if (one.turning.size() == 0 || one.turning.size() != other.turning.size() ||
      !near_by(one.spent, other.spent, cost_of_phase))
    return false;
  for (Eigen::Index j = 0; j < one.turning.size(); ++j)
    if (!near_by(one.turning[j], other.turning[j], same_turning)) return false;
  return true;
}

void DistinctMinima::add(Minimum minimum) {
  if (std::none_of(all_.begin(), all_.end(), [&](const Minimum& own) { return same_minimum(own, minimum); }))
    all_.push_back(std::move(minimum));
}

int DistinctMinima::below(double cost) const {
  return static_cast<int>(std::count_if(all_.begin(), all_.end(), [&](const Minimum& own) { return own.cost < cost; }));
}

}  // namespace lamprey::search
