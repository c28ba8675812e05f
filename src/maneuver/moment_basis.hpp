// All moments that a swimmer's joints can exert as one vector.
#pragma once

#include <vector>

#include "maneuver/shape_step.hpp"

namespace lamprey::maneuver {

/// Moments along the actuation of all joints, then the idle ones that nothing drives (places control_count … size − 1), as
/// many as make the impulses along the shape's coordinates complete.
class MomentBasis {
 public:
  MomentBasis(const model::System& system, const MatrixXd& shape_basis, const mechanics::Rotations& rotation);
  int size() const { return static_cast<int>(column_.size()); }
  /// What the joints exert when the idle moments are left out, [joints] N m.
  mechanics::Moments controls(const VectorXd& moment) const;
  /// Gathers what belongs to these moments, in their order, from three numbers for each joint.
  void gather(const mechanics::Moments& by_joint, Eigen::Ref<VectorXd> result) const;
  /// Virtual work of unit moments along each coordinate of a shape, [shape_size][size].
  MatrixXd virtual_work(const mechanics::Rotations& rotation) const;

 private:
  struct Column {
    int joint;
    Vector3d direction;
  };
  const model::System& system_;
  std::vector<Column> column_;
};

/// Calls f(freedoms, coordinate) with each coordinate of a shape as a unit of freedoms.
template <typename Function>
void for_each_coordinate(const model::System& system, const Function& f) {
  mechanics::Freedoms unit(model::at(system.body_count()), Vector3d::Zero());
  for (int i = 1; i < system.body_count(); ++i)
    for (int c = 0; c < system.body(i).freedoms; ++c) {
      unit[model::at(i)][c] = 1.0;
      f(unit, shape_offset(system.body(i)) + c);
      unit[model::at(i)][c] = 0.0;
    }
}

}  // namespace lamprey::maneuver
