// Steps four at a time, and what effort costs where shapes are the inputs (chapter 9, equation 9.20).
#include <algorithm>

#include "algebra/tiles.hpp"
#include "optimizer/small_dense.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::shape {

namespace {

using mechanics::Rotations;
using model::at;
using optimizer::add_product;
using optimizer::set_transposed;
using optimizer::Stage;
using optimizer::StageModel;
using optimizer::StageSlopes;

}  // namespace

// Derivatives by the root's pose at the beginning become those by its pose at the end.
void ShapeProgram::turn_to_end(const ShapeStep& step, ShapeTangent& tangent, MatrixXd& hessian) {
  pose_at_end_.take(tangent, step.interval.displacement);
  pose_at_end_.turn(hessian);
  pose_at_end_.turn_rows(tangent.plus);
}

// Tangents of up to four steps under the moments that the nodes hold and, for a model, their curvature with the nodes'
// multipliers.
void ShapeProgram::differentiate_four(int first, StageModel* model) {
  const double h = h_ * now_.stretch;
  const int count = std::min(4, steps_ - first);
  const auto multipliers = [&](int l) {
    const NodeModel &node = node_[at(l)], &next = node_[at(l + 1)];
    return ShapeMultipliers{node.multiplier, next.multiplier, pose_turn_[at(first + l + 1)],
                            pose_shift_[at(first + l + 1)]};
  };
  if (!four_steps_) {
    for (int l = 0; l < count; ++l) {
      ShapeStep& step = now_.step[at(first + l)];
      const mechanics::Moments &control = node_[at(l)].control, &control_next = node_[at(l + 1)].control;
      kernel_.tangent(h, control, control_next, step, four_tangents_[at(l)]);
      if (!model) continue;
      kernel_.curvature(h, control, control_next, step, multipliers(l), four_hessians_[at(l)]);
      if (drifts_in_free_time()) add_carried_in_time(multipliers(l), four_tangents_[at(l)], four_hessians_[at(l)]);
      if (drifts_)
        turn_to_end(step, four_tangents_[at(l)], four_hessians_[at(l)]);
      else
        turn_at_end(four_tangents_[at(l)], four_hessians_[at(l)]);
    }
    return;
  }
  // lanes beyond the last step repeat it
  const auto each = [&](auto of) {
    const auto lane = [&](int l) { return of(std::min(l, count - 1), l); };
    return ForFour<decltype(lane(0))>{lane(0), lane(1), lane(2), lane(3)};
  };
  const auto steps = each([&](int l, int) -> const ShapeStep* { return &now_.step[at(first + l)]; });
  const auto control = each([&](int l, int) -> const mechanics::Moments* { return &node_[at(l)].control; });
  const auto control_next = each([&](int l, int) -> const mechanics::Moments* { return &node_[at(l + 1)].control; });
  four_steps_->take_shapes(h, each([&](int l, int) -> const Rotations* { return &now_.shape[at(first + l)]; }),
                           each([&](int l, int) -> const Rotations* { return &now_.shape[at(first + l + 1)]; }));
  four_steps_->tangent(steps, control, control_next, each([&](int, int l) { return &four_tangents_[at(l)]; }));
  if (effort_in_fours()) {
    const ForFour<NodeEffort> effort = node_efforts(first);
    four_steps_->find_moments({&effort[0], &effort[1], &effort[2], &effort[3]}, first == 0);
  }
  if (!model) return;
  const auto of_lanes = each([&](int l, int) { return multipliers(l); });
  const auto form = [&](int l) {
    return hessians_in_place() ? &end_form(first + std::min(l, count - 1), *model) : &four_hessians_[at(l)];
  };
  four_steps_->curvature(steps, control, control_next, {&of_lanes[0], &of_lanes[1], &of_lanes[2], &of_lanes[3]},
                         {form(0), form(1), form(2), form(3)});
}

// Of the nodes where four steps begin; beyond the last it is repeated.
ForFour<NodeEffort> ShapeProgram::node_efforts(int first) const {
  const auto effort = [&](int l) {
    const int lane = std::min(l, steps_ - 1 - first), k = first + lane;
    return NodeEffort{impulse_time(now_, k), node_weight(now_, k), now_.moment[at(k)],
                      node_[at(lane)].control_by_shape};
  };
  return {effort(0), effort(1), effort(2), effort(3)};
}

template <typename Stages>
void ShapeProgram::add_effort_of_four(int first, Stages& stages) {
  const ForFour<NodeEffort> effort = node_efforts(first);
  const auto stage = [&](int l) { return &stages[at(std::min(first + l, steps_ - 1))]; };
  four_steps_->add_effort({&effort[0], &effort[1], &effort[2], &effort[3]}, std::min(4, steps_ - first),
                          {stage(0), stage(1), stage(2), stage(3)});
}

void ShapeProgram::add_effort(int first, std::vector<Stage>& stages) { add_effort_of_four(first, stages); }
void ShapeProgram::add_effort(int first, std::vector<StageSlopes::Slope>& stages) { add_effort_of_four(first, stages); }

// How moments at node k answer the shapes before, at and after it (equation 9.20).
void ShapeProgram::find_moments_by_shapes(int k) {
  const int n = shape_;
  equations_.topLeftCorner(n, n) = now_.impulse[at(k)];
  auto solved = equations_.middleCols(n, n + felt()).topRows(n);
  if (k > 0) {
    solved.leftCols(2 * n) = before_.plus.leftCols(2 * n);
    solved.leftCols(2 * n) *= -1.0;
  } else {
    solved.leftCols(2 * n).setZero();
  }
  solved.middleCols(n, n) += after_.minus.leftCols(n);
  if (drifts_) {
    find_impulses_by_pose(k, solved.middleCols(2 * n, pose_));
    solved.middleCols(2 * n, pose_) *= -1.0;
  }
  solved.rightCols(n) = after_.minus.middleCols(n, n);
  algebra::solve_columns(n, equations_.leftCols(2 * n + felt()));
  moments_by_shapes_ = solved;
  set_transposed(moments_by_shapes_, transposed_);
}

// Where shapes lead the root. All else that A and B hold stays.
void ShapeProgram::model_pose_by_shapes(int k, MatrixXd& A, MatrixXd& B) {
  const int n = shape_;
  if (B(n, 0) != 1.0) {
    A.block(0, n, n, n).setIdentity();
    B.middleRows(n, n).setIdentity();
    A.bottomRightCorner(pose_, pose_).setIdentity();
  }
  if (!all_poses_) {
    pose_step_ = pose_basis_.transpose().lazyProduct(after_.pose.leftCols(2 * n));
    A.block(2 * n, n, pose_, n) = pose_step_.leftCols(n);
    B.middleRows(2 * n, pose_) = pose_step_.rightCols(n);
    return carry_on(k, A);
  }
  A.block<6, Eigen::Dynamic>(2 * n, n, 6, n) = after_.pose.leftCols(n);
  B.middleRows<6>(2 * n) = after_.pose.middleCols(n, n);
  if (drifts_) return carry_on(k, A);
  A.block<3, 3>(2 * n + 3, 2 * n) = -lie::hat(now_.step[at(k)].interval.displacement);
}

// What the moments that shapes ask for cost: moments and, with them, the node's shape are weighed.
void ShapeProgram::model_stage_by_shapes(int k, const NodeModel& node, Stage& stage) {
  const int n = shape_;
  stage.shifted = stage.placed = n;
  model_pose_by_shapes(k, stage.A, stage.B);
  stage.weight = node_weight(now_, k);
  stage.gradient = stage.weight * std::max(now_.moment[at(k)].lpNorm<Eigen::Infinity>(), least_moment());
  if (stage.measured_by_input.size() == 0) {
    stage.measured_by_state.setZero(n, states());
    stage.measured_by_input.setZero(n, n);
  }
  stage.q.setZero();
  if (k == 0) stage.Q.setZero();
  if (effort_in_fours()) return;
  find_moments_by_shapes(k);
  const int s = felt();
  stage.measured_by_state.leftCols(s) = moments_by_shapes_.leftCols(s);
  stage.measured_by_input = moments_by_shapes_.rightCols(n);
  if (!moments_of_stage_.empty()) moments_of_stage_[at(k)] = moments_by_shapes_;

  weighed_.setZero();
  add_product(1.0, node.by_control_twice, moments_by_shapes_, weighed_);
  weighed_.middleCols(n, n) += node.control_by_shape;
  moment_form_.setZero();
  add_product(1.0, transposed_, weighed_, moment_form_);
  set_transposed(node.control_by_shape, equations_.topLeftCorner(n, n));
  add_product(1.0, equations_.topLeftCorner(n, n), moments_by_shapes_, moment_form_.middleRows(n, n));
  stage.S.leftCols(s) = moment_form_.bottomLeftCorner(n, s);
  stage.R = moment_form_.bottomRightCorner(n, n);
  stage.r.setZero();
  optimizer::add_image(1.0, transposed_.bottomRows(n), node.by_control, stage.r);
  if (k == 0) return;  // the first state does not move
  stage.Q.topLeftCorner(s, s) += moment_form_.topLeftCorner(s, s);
  optimizer::add_image(1.0, transposed_.topRows(s), node.by_control, stage.q.head(s));
}

}  // namespace lamprey::shape
