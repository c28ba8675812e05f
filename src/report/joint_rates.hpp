// How fast joints turn, from the stored rotations and velocities.
#pragma once

#include <Eigen/Core>

#include "result/results.hpp"

namespace lamprey::report {

/// rad/s, of the child against the parent at a node, parent's frame.
Eigen::Vector3d joint_rate(const result::Results& results, std::size_t node, const result::ResolvedJoint& joint);

/// The same over the step after a node: the turn of the child against the parent by the time.
Eigen::Vector3d step_rate(const result::Results& results, std::size_t node, const result::ResolvedJoint& joint);

/// The axes of a universal joint as they lie at a node, orthogonal, and the normal to both, parent's frame; of others the identity.
Eigen::Matrix3d axes_at(const result::Results& results, std::size_t node, const result::ResolvedJoint& joint);

}  // namespace lamprey::report
