// Mass centres of all bodies from what results store: the root's position and every rotation.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "result/results.hpp"

namespace lamprey::report {

/// Indices of the joints, each after the joint that carries its parent. Throws std::invalid_argument when the joints do
/// not hang every body on the root exactly once.
std::vector<int> joint_order(const result::ResolvedProblem& problem);

/// Mass centres x_i = x_p + R_p d_pi − R_i d_ip, [bodies] m, world; `order` from joint_order.
std::vector<Eigen::Vector3d> body_centres(const result::ResolvedProblem& problem, const std::vector<int>& order,
                                          const Eigen::Vector3d& root, const std::vector<Eigen::Matrix3d>& rotation);

/// Whether all bodies stay in one plane normal to e₃, where they turn about e₃ alone.
bool planar(const result::Results& results);

/// Throws std::invalid_argument, naming the array, where a shape is not that of solution.json.
void ensure_shapes(const result::Results& results);

}  // namespace lamprey::report
