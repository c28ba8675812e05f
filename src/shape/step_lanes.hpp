// What formulas of four steps at once share: a lane from each step, and where joints are.
#pragma once

#include "mechanics/four_bodies.hpp"

namespace lamprey::shape {

/// `of` gives the vector or matrix of a lane.
template <typename Of>
mechanics::Four3 vectors_of_lanes(const Of& of) {
  return mechanics::four_of(of(0), of(1), of(2), of(3));
}
template <typename Of>
mechanics::Four33 matrices_of_lanes(const Of& of) {
  return mechanics::four_of(of(0), of(1), of(2), of(3));
}

/// m, of the joint to the parent: in the parent's frame and in the body's own; zero of the root.
inline const Eigen::Vector3d& parent_offset(const model::System& system, int body) {
  return system.joint(system.body(body).joint).parent_offset;
}
inline Eigen::Vector3d child_offset(const model::System& system, int body) {
  if (body == 0) return Eigen::Vector3d::Zero();
  return system.joint(system.body(body).joint).child_offset;
}

}  // namespace lamprey::shape
