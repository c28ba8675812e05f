// What a maneuver asks of its end, row by row, in the coordinates of its last shapes and the root's pose.
#pragma once

#include <string>
#include <vector>

#include "maneuver/maneuver.hpp"
#include "maneuver/shape_coordinates.hpp"

namespace lamprey::maneuver {

/// A number as messages have it.
std::string in_words(double value, int digits = 3);

/// One scalar condition at the end.
struct EndRow {
  enum class Kind {
    orientation,  // log of the body's rotation against the one asked for, world axes, rad
    shape,        // the same of a body seen from the root, body axes, rad
    joint,  // an angle of a body's joint against the one asked for; of a ball joint log(Q_askedᵀ Q), child's frame, rad
    position,  // of the root's mass centre, m
    moment,    // of an unactuated direction of a joint, N m: rest and periodicity ask for none there
    closure    // a coordinate of a body's shape at the end against that at the start, rad
  } kind;
  int index;          // body; of a moment: its place among all moments
  int component;      // 0, 1, 2
  double unit = 1.0;  // rad, m or N m: rows are divided by it, so that they mean the same for swimmers of all sizes
};

/// Every condition that a maneuver states, redundant ones included. `unactuated`: places of moments that must vanish.
std::vector<EndRow> stated_end_rows(const model::System& system, const Maneuver& maneuver,
                                    const std::vector<int>& unactuated);

/// What it means that a row is missed by so much of its unit: "goal.move along e_1 is missed by 0.1 m".
std::string end_row_in_words(const model::System& system, const EndRow& row, double missed);

/// Value of a row over its unit, and its derivative by (shape, ρ, χ): the last shape's coordinates, the root's world turn and its
/// position. Not for moments.
double end_row(const model::System& system, const Maneuver& maneuver, const EndRow& row,
               const mechanics::Rotations& rotation, const Vector3d& position,
               Eigen::Ref<Eigen::RowVectorXd> derivative);

/// Value of a closure row: of log(Q_startᵀ Q_end) where a body turns on its own, of a joint's angle otherwise; its
/// derivatives by the first shape's and the last shape's coordinates, as end_row's. Rotations seen from the root.
double closure_row(const model::System& system, const EndRow& row, const mechanics::Rotations& first,
                   const mechanics::Rotations& last, Eigen::Ref<Eigen::RowVectorXd> by_first,
                   Eigen::Ref<Eigen::RowVectorXd> by_last);

/// Second derivatives of orientation, shape and joint rows where they hold, by (shape, ρ): turns of led bodies bend with the joints
/// before them, and a root's turn and a shape's do not commute (equation 9.13), nor do those of a ball joint's two bodies.
class EndCurvature {
 public:
  /// Along bases of shapes, [shape_size][f], and poses, [6][p].
  EndCurvature(const model::System& system, const std::vector<EndRow>& rows, const MatrixXd& shapes,
               const MatrixXd& poses);

  /// Adds multipliers · rows to a form of the last state, whose shape and pose begin at these places. `multipliers`: one for
  /// each of the rows, and more.
  void add(const std::vector<EndRow>& rows, const mechanics::Rotations& rotation, const VectorXd& multipliers,
           int shape_place, int pose_place, MatrixXd& form);

 private:
  void add_turns(int body, const Vector3d& pull, const mechanics::Rotations& rotation);
  void add_joint(int body, const Vector3d& pull, const mechanics::Rotations& rotation);
  void add_root_and_shape(int body, const Vector3d& pull, const mechanics::Rotations& rotation);

  const model::System& system_;
  MatrixXd shapes_, turns_of_root_;     // [shape_size][f], [3][p]
  bool any_ = false;                    // whether any row bends
  MatrixXd whole_;                      // [shape_size + 3]² symmetric, by (shape, ρ)
  MatrixXd half_, mixed_;               // [shape_size + 3][f], [p][f]
  Eigen::RowVectorXd along_;            // [shape_size + 3] one component of a body's turn by the shape
  mechanics::Freedoms first_, second_;  // [bodies]
  mechanics::Vectors turns_, changes_;  // [bodies]
};

}  // namespace lamprey::maneuver
