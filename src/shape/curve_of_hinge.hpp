// The curve along which a swimmer moves that bends in a single hinge and has no momentum.
#pragma once

#include "maneuver/end_rows.hpp"
#include "maneuver/maneuver.hpp"

namespace lamprey::shape {

using Eigen::VectorXd;

class CurveOfHinge {
 public:
  struct Place {
    mechanics::Rotations rotation;
    Eigen::Vector3d position;  // m
    double angle = 0.0;        // rad
  };

  /// At the maneuver's start. Both must outlive it.
  CurveOfHinge(const model::System& system, const maneuver::Maneuver& maneuver, int joint);

  /// The joint bends by so much, rad, the root moved as it is half way.
  void bend(double by);

  /// The whole has moved from where the curve begins as it did on the way from a place with the same angle to another one, so many
  /// times; from where it has moved so once less.
  void move_as(const Place& from, const Place& to, int times);

  const Place& now() const { return now_; }
  void go_to(const Place& there) { now_ = there; }

  /// What the goal is missed by there, in the rows' units; of gaits by the root alone.
  VectorXd missed();
  const std::vector<maneuver::EndRow>& rows() const { return rows_; }

 private:
  void place(const Eigen::Matrix3d& root, double angle);

  const model::System& system_;
  const maneuver::Maneuver& maneuver_;
  int joint_;
  std::vector<maneuver::EndRow> rows_;
  Eigen::RowVectorXd derivative_;
  mechanics::Vectors rate_;
  Place now_;
};

}  // namespace lamprey::shape
