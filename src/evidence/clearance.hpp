// Do bodies pass through each other? The least gap of any two over a stored motion.
#pragma once

#include <optional>

#include "evidence/findings.hpp"
#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

/// Parts into which each step is cut: 10, and fewer (at least 1) where steps × bodies exceed a million, so that no more
/// than ten million bodies are placed in all unless the nodes alone are more.
int parts_of_step(int steps, int bodies);

/// Bodies between node k and node k + 1, at the fraction s of the step: the root's rotation and each body's rotation
/// relative to its parent turn evenly about one axis, the root moves straight, and joints hold exactly.
/// Led bodies stay within a hinge's freedom; in a universal joint they leave it by less than the square of the turn.
struct Placement {
  mechanics::Rotations rotation;   // [bodies] body → world
  std::vector<Vector3d> position;  // [bodies] m, mass centres, world
};

class StepPath {
 public:
  StepPath(const StoredMotion& motion, int k);
  Placement at(double fraction) const;

 private:
  const model::System& system_;
  Vector3d position_;
  Vector3d shift_;
  mechanics::Rotations relative_;  // to the parent; the root's to the world
  std::vector<Vector3d> turn_;     // rotation vector over the step, child's frame
};

/// Least gap (equation 1.19) at the nodes and at the ends of the parts between them, with the time and the two bodies;
/// the earliest of equal ones. Nothing for a single body; NaN where stored numbers are not finite.
std::optional<Clearance> clearance(const StoredMotion& motion);

/// m, between the two bodies of `place` at its time; NaN where the motion has no such time.
double gap_at(const StoredMotion& motion, const Clearance& place);

}  // namespace lamprey::evidence
