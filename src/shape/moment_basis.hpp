// All moments that a swimmer's joints can exert as one vector.
#pragma once

#include <vector>

#include "shape/shape_step.hpp"

namespace lamprey::shape {

/// Moments along the actuation of all joints, then the idle ones that nothing drives (places control_count … size − 1), as
/// many as make the impulses along the shape's coordinates complete.
class MomentBasis {
 public:
  MomentBasis(const model::System& system, const MatrixXd& shape_basis, const mechanics::Rotations& rotation);
  int size() const { return static_cast<int>(column_.size()); }
  /// The joint of a place.
  int joint(int place) const { return column_[static_cast<std::size_t>(place)].joint; }
  /// What the joints exert when the idle moments are left out, [joints] N m.
  void controls(const VectorXd& moment, mechanics::Moments& by_joint) const;
  /// Virtual work of unit moments along each coordinate of a shape, [shape_size][size].
  void virtual_work(const mechanics::Rotations& rotation, MatrixXd& work) const;
  /// Whether all joints are ball joints that exert moments about any axis, and all coordinates are there: moments then
  /// follow joint by joint from what they do.
  bool joint_by_joint() const { return by_joint_.size() > 0; }
  /// Where joint_by_joint, with W the virtual_work: x becomes W⁻¹ x, or W⁻ᵀ x.
  void solve(const mechanics::Rotations& rotation, VectorXd& x);
  void solve_transposed(const mechanics::Rotations& rotation, VectorXd& x);
  /// Derivative of the controls' virtual work along `freedoms`, which turn the bodies by `turns` and not the root, by the
  /// shape: [controls][shape_size].
  void virtual_work_by_shape(const mechanics::Rotations& rotation, mechanics::NodeTurns along,
                             MatrixXd& by_shape) const;

 private:
  struct Column {
    int joint;
    Vector3d direction;
  };
  const model::System& system_;
  std::vector<Column> column_;
  VectorXd by_joint_;  // [size], where joint_by_joint
};

}  // namespace lamprey::shape
