#include "shape/reach.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "algebra/row_space.hpp"
#include "lie/so3.hpp"
#include "model/input_error.hpp"
#include "model/world_axes.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::shape {

namespace {

using maneuver::asks_to_move;
using maneuver::bodies_momentum;
using maneuver::ends_in_first_shape;
using maneuver::has_momentum;
using maneuver::in_words;
using maneuver::same_pose;
using maneuver::stated_end_rows;
using model::at;
using model::System;
using optimizer::Stage;
using optimizer::StageModel;

constexpr double dependence_threshold = 1e-9;  // singular directions end this far below the leading one
constexpr double reach_threshold = 1e-7;
constexpr double end_row_threshold = 1e-6;  // above what reach_threshold makes of round-off
constexpr int window_steps = 6;

constexpr const char* goes_back_in_words =
    "a single joint angle that cannot turn right round goes back the way it came, so that where it ends in its first "
    "shape "
    "nothing has moved or turned (scallop theorem)";

// Whether it does.
bool goes_back(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates) {
  return coordinates.shape.cols() == 1 && !maneuver.whole_turns && ends_in_first_shape(system, maneuver) &&
         !has_momentum(system, maneuver.start);
}

// What can be reached does not depend on what it costs, and costs beside effort have states of their own.
Maneuver without_costs(Maneuver maneuver) {
  maneuver.cost_weights = {};
  return maneuver;
}

// As people name it: one of the axes or three numbers.
std::string axis_in_words(const Vector3d& axis) {
  for (int c = 0; c < 3; ++c)
    if (std::abs(axis[c]) > 1.0 - reach_threshold) return model::world_axes[static_cast<std::size_t>(c)];
  return "(" + in_words(axis[0]) + ", " + in_words(axis[1]) + ", " + in_words(axis[2]) + ")";
}

using Place = std::array<std::optional<double>, 3>;

// How far a displacement to a place is from those along the columns, m.
double beyond_shifts(const Maneuver& maneuver, const Place& place, const MatrixXd& shifts) {
  std::vector<int> asked;
  for (int c = 0; c < 3; ++c)
    if (place[at(c)]) asked.push_back(c);
  if (asked.empty()) return 0.0;
  MatrixXd rows(static_cast<Eigen::Index>(asked.size()), shifts.cols());
  VectorXd distance(rows.rows());
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    const int c = asked[static_cast<std::size_t>(r)];
    rows.row(r) = shifts.row(c);
    distance[r] = *place[at(c)] - maneuver.start.position[c];
  }
  rows = (rows.array().abs() > reach_threshold).select(rows, 0.0);
  return algebra::beyond_rows(distance, rows.transpose(), reach_threshold).norm();
}

// What keeps an axis of the world along a motion.
class KeptAxis {
 public:
  KeptAxis(const Maneuver& maneuver, const Vector3d& axis, const NodePath& motion)
      : maneuver_(maneuver), axis_(axis), kept_(maneuver.start.rotation.size()) {
    for (std::size_t i = 0; i < kept_.size(); ++i)
      kept_[i] = std::all_of(motion.rotation.begin(), motion.rotation.end(),
                             [&](const mechanics::Rotations& R) { return keeps(i, R[i]); });
  }

  // A body whose end attitude, unlike all those it takes along the motion, moves the axis; nobody: −1.
  int body_turned_out() const {
    for (std::size_t i = 0; i < kept_.size(); ++i)
      if (kept_[i] && maneuver_.end_rotation[i] && !keeps(i, *maneuver_.end_rotation[i])) return static_cast<int>(i);
    return -1;
  }

  // The same of a joint's end; none: −1.
  int joint_bent_out(const System& system) const {
    for (int j = 0; j < system.joint_count(); ++j) {
      const std::size_t parent = at(system.joint(j).parent), child = at(system.joint(j).child);
      if (!maneuver_.tells_joint(j) || !kept_[parent] || !kept_[child]) continue;
      if ((*maneuver_.end_joint[at(j)] * seen(child) - seen(parent)).norm() >= reach_threshold) return j;
    }
    return -1;
  }

 private:
  Vector3d seen(std::size_t body) const { return maneuver_.start.rotation[body].transpose() * axis_; }
  bool keeps(std::size_t body, const Matrix3d& R) const { return (R * seen(body) - axis_).norm() < reach_threshold; }

  const Maneuver& maneuver_;
  Vector3d axis_;
  std::vector<char> kept_;  // [bodies]
};

// Gram and Schmidt's rows.
MatrixXd orthonormal(MatrixXd rows) {
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    for (Eigen::Index before = 0; before < r; ++before)
      rows.row(r) -= rows.row(r).dot(rows.row(before)) * rows.row(before);
    rows.row(r).normalize();
  }
  return rows;
}

// Orthonormal rows of turns (rad) and displacements, from those whose displacements are in a unit. Displacements without a turn
// come apart first: beside turns they would be lost in round-off where the unit is far from 1 m.
MatrixXd in_metres(const MatrixXd& poses, double unit) {
  if (unit == 1.0) return poses;
  const MatrixXd turns = algebra::span_of_rows(poses.leftCols<3>().transpose(), reach_threshold);
  MatrixXd still(0, 6);
  if (turns.cols() < poses.rows()) {
    still = algebra::null_space(turns.transpose()).transpose() * poses;
    still.leftCols<3>().setZero();
  }
  MatrixXd all(poses.rows(), 6);
  all << still, turns.transpose() * poses;
  all.bottomRows(turns.cols()).rightCols<3>() *= unit;
  return orthonormal(all);
}

// How much of some rows lies outside the span of orthonormal ones: of the row that has most.
double beyond(const MatrixXd& span, const MatrixXd& rows) {
  if (rows.rows() == 0) return 0.0;
  const MatrixXd left = rows - (rows * span.transpose()) * span;
  return left.rowwise().norm().maxCoeff();
}

// What is missed by no more than round-off is none.
void normalize_gap(Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> gap) {
  const double length = gap.norm();
  gap *= length > dependence_threshold ? 1.0 / length : 0.0;
}

// States that are displacements in units of the swimmer, beside its turns in rad.
void measure_in_units(const System& system, const ShapeCoordinates& coordinates, StageModel& model) {
  const double unit = system.length_unit();
  for (Eigen::Index p = 0; p < coordinates.pose.cols(); ++p) {
    if (coordinates.pose.col(p).head<3>().norm() > reach_threshold) continue;
    const Eigen::Index place = 2 * coordinates.shape.cols() + p;
    for (Stage& stage : model.stage) {
      stage.A.row(place) /= unit;
      stage.A.col(place) *= unit;
      stage.B.row(place) /= unit;
      stage.gap[place] /= unit;
    }
    model.C.col(place) *= unit;
  }
}

// Orthonormal rows that span what moments on the way can move at the end. Step by step: along an unstable motion all that early
// moments move would be next to one direction.
MatrixXd reached_at_end(const StageModel& model) {
  MatrixXd reached(0, model.C.cols());
  for (const Stage& stage : model.stage) {
    MatrixXd moved = reached * stage.A.transpose(), driven = stage.B.transpose();
    algebra::normalize_rows(moved, dependence_threshold);
    algebra::normalize_rows(driven, dependence_threshold);
    MatrixXd both(moved.rows() + driven.rows(), reached.cols());
    both << moved, driven;
    reached = algebra::span_of_rows(both, reach_threshold).transpose();
  }
  return reached;
}

// kg m²/s, what total momentum about the root's mass centre, linear by the unit of length, has beside such turns and displacements.
Vector6d beside(const System& system, const integrator::State& state, const MatrixXd& pose) {
  if (pose.cols() == pose.rows()) return Vector6d::Zero();
  const auto total = mechanics::spatial_momentum(system, state.rotation, Vector3d::Zero(), state.momentum);
  const double length = system.length_unit();
  VectorXd carried(6);
  carried << total.angular, length * total.linear;
  MatrixXd moved = pose;
  moved.bottomRows<3>() /= length;
  return algebra::beyond_rows(carried, moved.transpose(), reach_threshold);
}

}  // namespace

std::optional<ShapeCoordinates> reachable_coordinates(const System& system, const Maneuver& asked,
                                                      const NodePath& path) {
  Maneuver maneuver = without_costs(asked);
  maneuver.periodic = maneuver.free_duration = false;  // what is free besides the moments does not matter here
  const ShapeCoordinates all(system);
  ShapeProgram program(system, maneuver, all, {}, {}, Steps::rough);
  if (!program.go_to(path)) return std::nullopt;
  const optimizer::StageSizes sizes = program.sizes();
  StageModel model(sizes);
  program.linearize(model);
  measure_in_units(system, all, model);
  const Eigen::Index shape = all.shape.cols();
  const bool unsupported = program.merit().violation > dependence_threshold;  // idle moments that nothing exerts
  MatrixXd reached(0, sizes.states);  // rows span what moments before a node can move there
  MatrixXd shapes(0, shape), poses(0, 6);
  const auto gather = [](MatrixXd& rows, const MatrixXd& more) {
    if (rows.rows() > 0 && beyond(rows, more) <= reach_threshold) return;
    MatrixXd both(rows.rows() + more.rows(), more.cols());
    both << rows, more;
    rows = algebra::span_of_rows(both, reach_threshold).transpose();
  };
  // over short windows: what is unstable would carry round-off everywhere
  const auto all_reached = [&] { return shapes.rows() == shape && poses.rows() == 6; };
  for (int begin = 0; begin + window_steps <= maneuver.steps && !all_reached(); ++begin) {
    reached.resize(0, sizes.states);
    for (int k = begin; k < begin + window_steps; ++k) {
      const Stage& stage = model.stage[at(k)];
      MatrixXd moved = reached * stage.A.transpose();
      MatrixXd driven(sizes.inputs + (unsupported ? 1 : 0), sizes.states);
      driven.topRows(sizes.inputs) = stage.B.transpose();
      algebra::normalize_rows(moved, dependence_threshold);
      algebra::normalize_rows(driven.topRows(sizes.inputs), dependence_threshold);
      if (unsupported) {
        driven.bottomRows<1>() = stage.gap.transpose();
        normalize_gap(driven.bottomRows<1>());
      }
      MatrixXd both(moved.rows() + driven.rows(), sizes.states);
      both << moved, driven;
      reached = algebra::span_of_rows(both, reach_threshold).transpose();
      gather(shapes, reached.middleCols(shape, shape));
      gather(poses, reached.rightCols(6));
    }
  }
  ShapeCoordinates found = all;
  if (shapes.rows() < shape) found.shape = shapes.transpose();
  if (poses.rows() < 6) found.pose = in_metres(poses, system.length_unit()).transpose();
  return found;
}

namespace {

// Of a swimmer that moments keep in a plane or on a line.
void refuse_price_beside_reach(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates) {
  const Vector3d& price = maneuver.cost_weights.displacement;
  if (price.isZero(0.0) || has_momentum(system, maneuver.start)) return;
  const MatrixXd shifts = algebra::span_of_rows(coordinates.pose.bottomRows<3>().transpose(), reach_threshold);
  if ((shifts.transpose() * price).norm() > reach_threshold * price.norm()) return;
  throw model::InputError("cost.displacement", "found a price along " + axis_in_words(price.normalized()) +
                                                   ", along which the joints' moments move nothing; leave it out, or "
                                                   "add joints or control_axes that bend that way");
}

}  // namespace

void refuse_price_of_no_displacement(const System& system, const Maneuver& maneuver,
                                     const ShapeCoordinates& coordinates) {
  refuse_price_beside_reach(system, maneuver, coordinates);
  if (!goes_back(system, maneuver, coordinates)) return;
  const auto refuse = [](const char* key, const char* found) {
    throw model::InputError(key, std::string("found ") + found + ", but " + goes_back_in_words +
                                     "; leave it out, or add a second joint or axis");
  };
  if (maneuver.cost_weights.of_displacement()) refuse("cost.displacement", "a price of displacement");
  if (maneuver.cost_weights.transport > 0.0 && !asks_to_move(system, maneuver))
    refuse("cost.transport", "a price of each metre");
}

double momentum_beside(const System& system, const integrator::State& state, const MatrixXd& pose) {
  if (!has_momentum(system, state)) return 0.0;
  return beside(system, state, pose).norm() / bodies_momentum(system, state);
}

mechanics::SpatialMomentum momentum_within(const System& system, const integrator::State& state, const MatrixXd& pose) {
  auto total = mechanics::spatial_momentum(system, state.rotation, state.position, state.momentum);
  const Vector6d taken = beside(system, state, pose);
  const Vector3d linear = taken.tail<3>() / system.length_unit();
  total.angular -= taken.head<3>() + state.position.cross(linear);
  total.linear -= linear;
  return total;
}

std::string out_of_reach(const System& system, const Maneuver& maneuver,
                         const std::vector<maneuver::Waypoint>& waypoints, const ShapeCoordinates& coordinates,
                         const NodePath& path) {
  if (momentum_beside(system, maneuver.start, coordinates.pose) > reach_threshold) return "";
  if (goes_back(system, maneuver, coordinates) && asks_to_move(system, maneuver))
    return std::string(goes_back_in_words) + "; a second joint or axis would change that";
  const MatrixXd turns = algebra::span_of_rows(coordinates.pose.topRows<3>().transpose(), reach_threshold);
  const MatrixXd shifts = algebra::span_of_rows(coordinates.pose.bottomRows<3>().transpose(), reach_threshold);
  if (turns.cols() > 1 && shifts.cols() == 3) return "";
  const std::string cure =
      "; joints or control_axes that bend out of it would reach further, or a goal that leaves this \"free\"";
  const auto asks_out_of = [&](const char* key, const Place& place) {
    const double beyond = beyond_shifts(maneuver, place, shifts);
    if (beyond <= same_pose * system.size()) return std::string();
    std::string kept = "where they are";
    if (shifts.cols() == 2)
      kept = "in the plane normal to " + axis_in_words(algebra::null_space(shifts.transpose()).col(0));
    if (shifts.cols() == 1) kept = "on the line along " + axis_in_words(shifts.col(0));
    return "the joints' moments keep the root's mass centre " + kept + ", and " + key + " asks for " +
           in_words(beyond) + " m out of it" + cure;
  };
  if (const std::string words = asks_out_of("goal.move", maneuver.end_position); !words.empty()) return words;
  for (const maneuver::Waypoint& waypoint : waypoints) {
    Place place;
    for (int c = 0; c < 3; ++c)
      if (waypoint.move[at(c)]) place[at(c)] = maneuver.start.position[c] + *waypoint.move[at(c)];
    if (const std::string words = asks_out_of("a waypoint's move", place); !words.empty()) return words;
  }
  ShapeProgram program(system, maneuver, coordinates, {}, {}, Steps::rough);
  if (turns.cols() != 1 || !program.go_to(path)) return "";
  const NodePath motion = program.path();
  const KeptAxis kept(maneuver, turns.col(0), motion);
  const std::string about = " about " + axis_in_words(turns.col(0)) + " alone, and the ";
  if (const int body = kept.body_turned_out(); body >= 0)
    return "the joints' moments turn " + system.body(body).name + about +
           "attitude that the goal asks of it is turned otherwise" + cure;
  if (const int joint = kept.joint_bent_out(system); joint >= 0)
    return "the joints' moments bend joint " + system.joint(joint).name + about +
           "end that the goal asks of it is bent otherwise" + cure;
  return "";
}

std::vector<EndRow> all_end_rows(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates) {
  std::vector<int> idle;
  const auto moments = static_cast<int>(coordinates.shape.cols());
  for (int place = system.control_count(); place < moments; ++place) idle.push_back(place);
  return stated_end_rows(system, maneuver, idle);
}

std::optional<std::vector<EndRow>> independent_end_rows(const System& system, const Maneuver& maneuver,
                                                        const ShapeCoordinates& coordinates, const NodePath& path) {
  const std::vector<EndRow> stated = all_end_rows(system, maneuver, coordinates);
  ShapeProgram program(system, without_costs(maneuver), coordinates, stated, {}, Steps::rough);
  StageModel model(program.sizes());
  if (!program.go_to(path)) return std::nullopt;
  program.linearize(model);
  measure_in_units(system, coordinates, model);
  const auto rows = static_cast<Eigen::Index>(stated.size());
  MatrixXd sensitivity = model.C * reached_at_end(model).transpose();
  std::map<EndRow::Kind, double> unit;  // rad, m and N m side by side: each kind counts by its largest row
  for (Eigen::Index r = 0; r < rows; ++r) {
    double& size = unit[stated[static_cast<std::size_t>(r)].kind];
    size = std::max(size, sensitivity.row(r).norm());
  }
  for (Eigen::Index r = 0; r < rows; ++r)
    if (const double size = unit[stated[static_cast<std::size_t>(r)].kind]; size > 0.0) sensitivity.row(r) /= size;
  std::vector<char> kept(stated.size());
  for (int r : algebra::independent_rows(sensitivity, end_row_threshold)) kept[at(r)] = 1;
  std::vector<EndRow> independent;
  for (std::size_t r = 0; r < stated.size(); ++r)
    if (kept[r]) independent.push_back(stated[r]);
  return independent;
}

}  // namespace lamprey::shape
