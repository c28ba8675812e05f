// How bodies turn by the coordinates of a swimmer's shape, and how these turns change along them, where joints lead bodies.
// Workspaces included: nothing here asks for memory but the constructor.
#pragma once

#include "shape/shape_step.hpp"

namespace lamprey::shape {

class ShapeTurns {
 public:
  ShapeTurns(const model::System& system, const MatrixXd& shape_basis);

  /// Turn of a body by the coordinates of the shape, its own frame: [3][f]; none of the root. Until the next call.
  const MatrixXd& of_body(const mechanics::Rotations& R, int body);
  /// Adds Γ·(change of the bodies' turns along two coordinates of the shape), [f] squared. `pull`: Γ, [3 bodies], body
  /// frames. Nothing where all joints are free.
  void add_curvature(const mechanics::Rotations& R, const Eigen::Ref<const VectorXd>& pull, Eigen::Ref<MatrixXd> to);

 private:
  const model::System& system_;
  MatrixXd shape_basis_;                   // [shape_size][f]
  std::vector<mechanics::Freedoms> unit_;  // [shape_size][bodies] along each coordinate of a whole shape
  std::vector<mechanics::Vectors> turns_;  // [shape_size][bodies] of the bodies along these
  mechanics::Vectors changes_;             // [bodies]
  MatrixXd by_freedoms_;                   // [3][shape_size + 3]
  MatrixXd of_body_;                       // [3][f]
  MatrixXd curvature_, half_;              // [shape_size] squared, [shape_size][f]
};

}  // namespace lamprey::shape
