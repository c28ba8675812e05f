#include "maneuver/reach.hpp"

#include <algorithm>
#include <map>

#include "maneuver/row_space.hpp"
#include "maneuver/shape_program.hpp"

namespace lamprey::maneuver {

namespace {

using model::at;
using model::System;
using optimizer::Stage;
using optimizer::StageModel;

constexpr double dependence_threshold = 1e-9;  // singular directions end this far below the leading one
constexpr double reach_threshold = 1e-7;
constexpr double end_row_threshold = 1e-6;  // above what reach_threshold makes of round-off
constexpr int window_steps = 6;

// How much of some rows lies outside the span of orthonormal ones: of the row that has most.
double beyond(const MatrixXd& span, const MatrixXd& rows) {
  if (rows.rows() == 0) return 0.0;
  const MatrixXd left = rows - (rows * span.transpose()) * span;
  return left.rowwise().norm().maxCoeff();
}

// Rows of no length but round-off are none: next to the longest of their kind, whatever a moment moves a body by.
template <typename Rows>
void normalize_rows(Rows&& rows) {
  if (rows.rows() == 0) return;
  const double longest = rows.rowwise().norm().maxCoeff();
  for (Eigen::Index r = 0; r < rows.rows(); ++r) {
    const double length = rows.row(r).norm();
    rows.row(r) *= length > dependence_threshold * longest ? 1.0 / length : 0.0;
  }
}

// What is missed by no more than round-off is none.
void normalize_gap(Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>> gap) {
  const double length = gap.norm();
  gap *= length > dependence_threshold ? 1.0 / length : 0.0;
}

// Orthonormal rows that span what moments on the way can move at the end. Step by step: along an unstable motion all that early
// moments move would be next to one direction.
MatrixXd reached_at_end(const StageModel& model) {
  MatrixXd reached(0, model.C.cols());
  for (const Stage& stage : model.stage) {
    MatrixXd moved = reached * stage.A.transpose(), driven = stage.B.transpose();
    normalize_rows(moved);
    normalize_rows(driven);
    MatrixXd both(moved.rows() + driven.rows(), reached.cols());
    both << moved, driven;
    reached = span_of_rows(both, reach_threshold).transpose();
  }
  return reached;
}

}  // namespace

std::optional<ShapeCoordinates> reachable_coordinates(const System& system, const Maneuver& asked,
                                                      const NodePath& path) {
  Maneuver maneuver = asked;  // what is free besides the moments does not matter here
  maneuver.periodic = maneuver.free_duration = false;
  maneuver.cost_weights = {};
  const ShapeCoordinates all(system);
  ShapeProgram program(system, maneuver, all, {}, {}, Steps::rough);
  if (!program.go_to(path)) return std::nullopt;
  const optimizer::StageSizes sizes = program.sizes();
  StageModel model(sizes);
  program.linearize(model);
  const Eigen::Index shape = all.shape.cols();
  const bool unsupported = program.merit().violation > dependence_threshold;  // idle moments that nothing exerts
  MatrixXd reached(0, sizes.states);  // rows span what moments before a node can move there
  MatrixXd shapes(0, shape), poses(0, 6);
  const auto gather = [](MatrixXd& rows, const MatrixXd& more) {
    if (rows.rows() > 0 && beyond(rows, more) <= reach_threshold) return;
    MatrixXd both(rows.rows() + more.rows(), more.cols());
    both << rows, more;
    rows = span_of_rows(both, reach_threshold).transpose();
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
      normalize_rows(moved);
      normalize_rows(driven.topRows(sizes.inputs));
      if (unsupported) {
        driven.bottomRows<1>() = stage.gap.transpose();
        normalize_gap(driven.bottomRows<1>());
      }
      MatrixXd both(moved.rows() + driven.rows(), sizes.states);
      both << moved, driven;
      reached = span_of_rows(both, reach_threshold).transpose();
      gather(shapes, reached.middleCols(shape, shape));
      gather(poses, reached.rightCols(6));
    }
  }
  ShapeCoordinates found = all;
  if (shapes.rows() < shape) found.shape = shapes.transpose();
  if (poses.rows() < 6) found.pose = poses.transpose();
  return found;
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
  ShapeProgram program(system, maneuver, coordinates, stated, {}, Steps::rough);
  StageModel model(program.sizes());
  if (!program.go_to(path)) return std::nullopt;
  program.linearize(model);
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
  for (int r : independent_rows(sensitivity, end_row_threshold)) kept[at(r)] = 1;
  std::vector<EndRow> independent;
  for (std::size_t r = 0; r < stated.size(); ++r)
    if (kept[r]) independent.push_back(stated[r]);
  return independent;
}

}  // namespace lamprey::maneuver
