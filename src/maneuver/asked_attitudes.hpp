// What a goal asks of attitudes: of bodies in the world, of joints between bodies that are free in it.
#pragma once

#include <optional>
#include <vector>

#include "maneuver/problem.hpp"
#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::maneuver {

struct AskedAttitudes {
  std::vector<std::optional<Eigen::Matrix3d>> rotation;  // [bodies] body → world; nothing: free
  /// [joints] child → parent; nothing: free, fixed, or told by the rotations of both bodies.
  std::vector<std::optional<Eigen::Matrix3d>> joint;
};

/// Of bodies that are turned so at the start. A body whose rotation is not stated follows its parent or its child where the
/// joint between them is told how to end, and with `turn` below a joint of `angle` as the start's joints have it.
/// Throws model::InputError where joints and rotations contradict each other.
AskedAttitudes asked_attitudes(const model::System& system, const Goal& goal, const mechanics::Rotations& start);

}  // namespace lamprey::maneuver
