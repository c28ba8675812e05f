// Coordinates of a swimmer's shape.
//
// A shape is the bodies' rotations seen from the root. Its coordinates are the freedoms of all bodies but the root: turns
// against the root in the body's own frame, or turns about the joint's axes.
#pragma once

#include "mechanics/continuous.hpp"
#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::maneuver {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Number of coordinates of a shape.
inline int shape_size(const model::System& system) { return system.velocity_count() - 6; }

/// Where a body's coordinates begin; not of the root.
inline int shape_offset(const model::Body& body) { return body.velocity_offset - 3; }

/// Coordinates of a shape as freedoms of all bodies, of which the root's are left as they are.
void write_shape(const model::System& system, const VectorXd& shape, mechanics::Freedoms& freedoms);
/// The other way round, the root left aside: [shape_size].
void read_shape(const model::System& system, const mechanics::Freedoms& freedoms, Eigen::Ref<VectorXd> shape);

/// Whether a basis is the identity. Eigen's isIdentity says so of the first columns of one as well.
inline bool is_identity(const MatrixXd& basis) { return basis.rows() == basis.cols() && basis.isIdentity(0.0); }

/// The coordinates in which a motion's shapes and poses vary: all, or those that its symmetry leaves. Orthonormal columns.
struct ShapeCoordinates {
  MatrixXd shape;  // [shape_size][f]
  MatrixXd pose;   // [6][p] root's world turn and position
  /// All of them.
  explicit ShapeCoordinates(const model::System& system);
};

/// Moves a shape along all its coordinates, [shape_size]; rotations seen from the root.
void move_shape(const model::System& system, const mechanics::Rotations& shape, const VectorXd& along,
                mechanics::Interval& buffer, mechanics::Rotations& moved);

}  // namespace lamprey::maneuver
