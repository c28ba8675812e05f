#include "maneuver/condensed_step.hpp"

#include "algebra/tiles.hpp"
#include "lie/so3.hpp"
#include "model/system.hpp"
#include "optimizer/small_dense.hpp"

namespace lamprey::maneuver {

using Eigen::Index;
using model::at;
using optimizer::add_image;
using optimizer::add_lower_product;
using optimizer::add_product;
using optimizer::add_transposed_image;
using optimizer::mirror_lower;
using optimizer::set_transposed;

CondensingSpace::CondensingSpace(const StepLayout& layout)
    : equations(mechanics::rows_for(layout.shape), 2 * layout.shape),
      momentum(layout.shape, layout.columns()),
      ends(2 * layout.shape + 3, layout.columns()),
      bent(ends),
      all_ends(layout.columns(), layout.stages() * ends.rows()),
      all_bent(all_ends.cols(), all_ends.rows()),
      by_shape(layout.moments, layout.columns()),
      mixed(layout.inputs(), layout.columns()),
      gram(layout.columns(), layout.columns()),
      gram_turn(3, layout.columns()),
      all_rates(layout.columns() - 1, layout.stages() * layout.shape),
      all_weighed(all_rates.cols(), all_rates.rows()),
      metric(layout.columns() - 1, layout.columns() - 1),
      pose(layout.poses(), layout.columns()),
      by_pose(pose) {
  equations.setZero();
}

CondensedStep::CondensedStep(const StepLayout& layout)
    : link(at(layout.stages())),
      force(at(layout.stages() + 1)),
      layout_(layout),
      shape_(at(layout.stages() + 1), MatrixXd::Zero(layout.shape, layout.columns())),
      pose_(at(layout.stages() + 1), MatrixXd::Zero(6, layout.columns())),
      inverse_(at(layout.stages()), MatrixXd(layout.shape, layout.shape)) {
  shape_.front().leftCols(layout.shape).setIdentity();
}

// Time that a node's moments act, half of each stage beside it, within the step.
double CondensedStep::half_time(int node) const {
  double time = 0.0;
  if (node > 0) time += 0.5 * layout_.time[at(node - 1)];
  if (node < layout_.stages()) time += 0.5 * layout_.time[at(node)];
  return time;
}

bool CondensedStep::invert(int s, MatrixXd& equations) {
  const int f = layout_.shape;
  equations.topLeftCorner(f, f) = link[at(s)].tangent.minus.rightCols(f);
  equations.topRightCorner(f, f).setIdentity();
  algebra::solve_columns(f, equations);
  inverse_[at(s)] = equations.topRightCorner(f, f);
  return inverse_[at(s)].allFinite();
}

void CondensedStep::add_force(int node, double weight, MatrixXd& rows) const {
  const StageForce& at_node = force[at(node)];
  for (int term = 0; term < layout_.terms; ++term)
    for (int c = 0; c < layout_.moments; ++c)
      algebra::add_multiple(weight * at_node.value[term], at_node.impulse.col(c),
                            rows.col(2 * layout_.shape + term * layout_.moments + c));
}

// The next shape, momentum and pose from those at node s.
void CondensedStep::eliminate(int s, MatrixXd& momentum) {
  const int f = layout_.shape;
  const StageLink& stage = link[at(s)];
  const ShapeTangent& by = stage.tangent;
  const double half = 0.5 * layout_.time[at(s)];
  const MatrixXd& here = shape_[at(s)];
  MatrixXd& next = shape_[at(s + 1)];
  add_product(-1.0, by.minus.leftCols(f), here, momentum);
  momentum.col(layout_.columns() - 1) -= stage.missing;
  add_force(s, half, momentum);
  next.setZero();
  add_product(1.0, inverse_[at(s)], momentum, next);
  momentum.setZero();
  add_product(1.0, by.plus.leftCols(f), here, momentum);
  add_product(1.0, by.plus.rightCols(f), next, momentum);
  add_force(s + 1, half, momentum);
  MatrixXd& pose = pose_[at(s + 1)];
  pose = pose_[at(s)];
  for (Index c = 0; c < pose.cols(); ++c) pose.col(c).tail<3>() -= stage.displacement.cross(pose.col(c).head<3>());
  add_product(1.0, by.pose.leftCols(f), here, pose);
  add_product(1.0, by.pose.rightCols(f), next, pose);
}

// The Hessians of all stages, by the columns.
void CondensedStep::add_curvature(CondensingSpace& space) const {
  const int f = layout_.shape, size = 2 * f + 3;
  for (int s = 0; s < layout_.stages(); ++s) {
    space.ends.topRows(f) = shape_[at(s)];
    space.ends.middleRows(f, f) = shape_[at(s + 1)];
    space.ends.bottomRows<3>() = pose_[at(s + 1)].topRows<3>();
    space.bent.setZero();
    add_product(1.0, link[at(s)].hessian, space.ends, space.bent);
    set_transposed(space.ends, space.all_ends.middleCols(s * size, size));
    space.all_bent.middleRows(s * size, size) = space.bent;
    space.gram_turn += space.bent.bottomRows<3>();
  }
  add_lower_product(1.0, space.all_ends, space.all_bent, space.gram);
  mirror_lower(space.gram);
}

// What moments and shapes have to do with each other at the nodes.
void CondensedStep::add_mixed(CondensingSpace& space) const {
  space.mixed.setZero();
  for (int node = 0; node <= layout_.stages(); ++node) {
    const StageForce& at_node = force[at(node)];
    space.by_shape.setZero();
    add_product(half_time(node), at_node.control_by_shape, shape_[at(node)], space.by_shape);
    for (int term = 0; term < layout_.terms; ++term)
      space.mixed.middleRows(term * layout_.moments, layout_.moments) += at_node.value[term] * space.by_shape;
  }
  space.gram.middleRows(2 * layout_.shape, layout_.inputs()) += space.mixed;
  space.gram.middleCols(2 * layout_.shape, layout_.inputs()) += space.mixed.transpose();
}

bool CondensedStep::condense(CondensingSpace& space, optimizer::Stage& stage) {
  for (int s = 0; s < layout_.stages(); ++s)
    if (!invert(s, space.equations)) return false;
  space.momentum.setZero();
  space.momentum.middleCols(layout_.shape, layout_.shape).setIdentity();
  for (int s = 0; s < layout_.stages(); ++s) eliminate(s, space.momentum);
  space.gram.setZero();
  space.gram_turn.setZero();
  add_curvature(space);
  add_mixed(space);
  write_motion(space, stage);
  write_curvature(space, stage);
  return true;
}

void CondensedStep::write_motion(CondensingSpace& space, optimizer::Stage& stage) const {
  const int f = layout_.shape, inputs = layout_.inputs(), poses = layout_.poses();
  const MatrixXd &shape = shape_.back(), &momentum = space.momentum;
  Vector3d shift = Vector3d::Zero();
  for (const StageLink& one : link) shift += one.displacement;
  Matrix6d carried = Matrix6d::Identity();
  carried.bottomLeftCorner<3, 3>() = -lie::hat(shift);
  space.pose.noalias() = layout_.pose_basis.transpose() * pose_.back();
  stage.A.topLeftCorner(f, 2 * f) = shape.leftCols(2 * f);
  stage.A.block(f, 0, f, 2 * f) = momentum.leftCols(2 * f);
  stage.A.block(2 * f, 0, poses, 2 * f) = space.pose.leftCols(2 * f);
  stage.A.bottomRightCorner(poses, poses) = layout_.pose_basis.transpose() * carried * layout_.pose_basis;
  stage.B.topRows(f) = shape.middleCols(2 * f, inputs);
  stage.B.middleRows(f, f) = momentum.middleCols(2 * f, inputs);
  stage.B.bottomRows(poses) = space.pose.middleCols(2 * f, inputs);
  stage.gap.head(f) = shape.rightCols<1>();
  stage.gap.segment(f, f) = momentum.rightCols<1>();
  stage.gap.tail(poses) = space.pose.rightCols<1>();
}

void CondensedStep::write_curvature(CondensingSpace& space, optimizer::Stage& stage) const {
  const int f = layout_.shape, inputs = layout_.inputs(), poses = layout_.poses();
  const MatrixXd& gram = space.gram;
  const auto turn = layout_.pose_basis.topRows<3>();
  Matrix3d turn_turn = Matrix3d::Zero();
  for (const StageLink& one : link) turn_turn += one.hessian.bottomRightCorner<3, 3>();
  space.by_pose.noalias() = turn.transpose() * space.gram_turn;
  stage.Q.topLeftCorner(2 * f, 2 * f) = gram.topLeftCorner(2 * f, 2 * f);
  stage.Q.bottomLeftCorner(poses, 2 * f) = space.by_pose.leftCols(2 * f);
  stage.Q.topRightCorner(2 * f, poses) = space.by_pose.leftCols(2 * f).transpose();
  stage.Q.bottomRightCorner(poses, poses) = turn.transpose() * turn_turn * turn;
  stage.S.leftCols(2 * f) = gram.block(2 * f, 0, inputs, 2 * f);
  stage.S.rightCols(poses) = space.by_pose.middleCols(2 * f, inputs).transpose();
  stage.R = gram.block(2 * f, 2 * f, inputs, inputs);
  stage.q.head(2 * f) = gram.rightCols<1>().head(2 * f);
  stage.q.tail(poses) = space.by_pose.rightCols<1>();
  stage.r = gram.rightCols<1>().segment(2 * f, inputs);
}

void CondensedStep::pack(const VectorXd& state, const VectorXd& input, VectorXd& all) const {
  all.resize(layout_.columns());
  all << state.head(2 * layout_.shape), input, 1.0;
}

void CondensedStep::shape_along(int node, const VectorXd& all, Eigen::Ref<VectorXd> shape) const {
  shape.setZero();
  add_image(1.0, shape_[at(node)], all, shape);
}

void CondensedStep::carry_back(const VectorXd& state, const VectorXd& input, const StepCostate& end,
                               std::vector<StepCostate>& costate) const {
  const int f = layout_.shape;
  VectorXd all;
  pack(state, input, all);
  const Vector3d turn = layout_.pose_basis.topRows<3>() * state.tail(layout_.poses());
  const auto moments = [&](int node) {
    return VectorXd(input.reshaped(layout_.moments, layout_.terms) * force[at(node)].value);
  };
  StepCostate next = end;
  next.shape += half_time(layout_.stages()) * (force.back().control_by_shape.transpose() * moments(layout_.stages()));
  VectorXd ends(2 * f + 3), bent(2 * f + 3), by_ends(2 * f);
  for (int s = layout_.stages() - 1; s >= 0; --s) {
    const StageLink& stage = link[at(s)];
    const ShapeTangent& by = stage.tangent;
    ends << shape_[at(s)] * all, shape_[at(s + 1)] * all, turn + pose_[at(s + 1)].topRows<3>() * all;
    bent.setZero();
    add_image(1.0, stage.hessian, ends, bent);
    next.pose.head<3>() += bent.tail<3>();
    by_ends = bent.head(2 * f);
    add_transposed_image(1.0, by.plus, next.momentum, by_ends);
    add_transposed_image(1.0, by.pose, next.pose, by_ends);
    StepCostate& here = costate[at(s)];
    here.momentum = inverse_[at(s)].transpose() * (next.shape + by_ends.tail(f));
    here.shape = by_ends.head(f) - by.minus.leftCols(f).transpose() * here.momentum +
                 half_time(s) * (force[at(s)].control_by_shape.transpose() * moments(s));
    here.pose = next.pose;
    here.pose.head<3>() += stage.displacement.cross(next.pose.tail<3>());
    next = here;
  }
}

void CondensedStep::measure_rates(double scale, CondensingSpace& space, optimizer::Stage& stage) const {
  const int f = layout_.shape, inputs = layout_.inputs();
  const Index columns = space.metric.cols();
  for (int s = 0; s < layout_.stages(); ++s)
    for (int r = 0; r < f; ++r) {
      const double inertia = scale * std::abs(link[at(s)].tangent.minus(r, f + r));
      for (Index c = 0; c < columns; ++c) {
        const double rate = shape_[at(s + 1)](r, c) - shape_[at(s)](r, c);
        space.all_rates(c, s * f + r) = rate;
        space.all_weighed(s * f + r, c) = inertia * rate;
      }
    }
  space.metric.setZero();
  add_lower_product(1.0, space.all_rates, space.all_weighed, space.metric);
  mirror_lower(space.metric);
  stage.metric.topLeftCorner(2 * f, 2 * f) = space.metric.topLeftCorner(2 * f, 2 * f);
  stage.metric_mixed.setZero(inputs, layout_.states());
  stage.metric_mixed.leftCols(2 * f) = space.metric.bottomLeftCorner(inputs, 2 * f);
  stage.metric_input = space.metric.bottomRightCorner(inputs, inputs);
}

}  // namespace lamprey::maneuver
