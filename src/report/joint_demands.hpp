// What a motion asks of its joints: how far, how fast, how hard; for whoever chooses the motors.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "result/results.hpp"

namespace lamprey::report {

struct JointDemand {
  std::string joint;  // its name; "fin 1" and "fin 2" of a universal joint with a moment about each of its axes
  double largest_moment = 0.0;  // N m, |u| at any node, of schemes above order 2 at those of the stages
  double largest_rate = 0.0;    // rad/s, of the child against the parent, mean over any step or at any node
  double largest_power = 0.0;   // W, |u·ω| at any node
  double work = 0.0;  // J, ∫ |u·ω| dt: nothing is won back from joint to joint; above order 2 within the steps
  bool ball = false;  // whether a ball joint's
  /// rad, least and largest at any node: of a hinge or of one axis of a universal joint one, of a universal joint
  /// without two moments two, of a ball joint how far it is from its zero
  /// angle. Of files without joint angles none.
  std::vector<std::pair<double, double>> angles;
};

/// By drive (see model::Drive), those of one joint together; work as the cost counts it (equation 13.3). Nothing where there is no motion.
std::optional<std::vector<JointDemand>> joint_demands(const result::Results& results);

}  // namespace lamprey::report
