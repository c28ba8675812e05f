#include "shape/condensed_step.hpp"

#include "algebra/tiles.hpp"
#include "lie/so3.hpp"
#include "model/system.hpp"
#include "optimizer/small_dense.hpp"

namespace lamprey::shape {

using Eigen::Index;
using mechanics::rows_for;
using model::at;
using optimizer::add_image;
using optimizer::add_lower_product_transposed;
using optimizer::add_product;
using optimizer::add_product_transposed;
using optimizer::add_transposed_image;
using optimizer::mirror_lower;
using optimizer::set_transposed;

namespace {

Index rows_of(const StepLayout& layout) { return rows_for(layout.constant() + 1); }

}  // namespace

CondensingSpace::CondensingSpace(const StepLayout& layout)
    : equations(MatrixXd::Zero(rows_for(layout.shape), 2 * layout.shape)),
      momentum(rows_of(layout), layout.shape),
      shift(rows_of(layout), 3),
      hessian(2 * layout.shape + 3, 2 * layout.shape + 3),
      bent(rows_of(layout), 2 * layout.shape + 3),
      mixed(rows_of(layout), layout.inputs()),
      gram(rows_of(layout), rows_of(layout)),
      gram_turn(rows_of(layout), 3),
      rate(momentum),
      weighed(momentum),
      metric(gram),
      pose(rows_of(layout), layout.poses()),
      by_pose(pose) {}

CondensedStep::CondensedStep(const StepLayout& layout)
    : link(at(layout.stages())),
      force(at(layout.stages() + 1)),
      layout_(layout),
      nodes_(MatrixXd::Zero(rows_of(layout), (layout.stages() + 1) * (layout.shape + 3))),
      inverse_(at(layout.stages()), MatrixXd(layout.shape, layout.shape)) {
  shape(0).topRows(layout.shape).setIdentity();
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
  for (int term = 0; term < layout_.terms; ++term) {
    const double share = weight * at_node.value[term];
    const int first = 2 * layout_.shape + term * layout_.moments;
    for (int i = 0; i < layout_.shape; ++i) {
      const double* from = at_node.impulse.data() + i;
      double* to = rows.data() + i * rows.rows() + first;
      for (int c = 0; c < layout_.moments; ++c, from += layout_.shape) to[c] += share * *from;
    }
  }
}

// The next shape, momentum and pose from those at node s.
void CondensedStep::eliminate(int s, CondensingSpace& space) {
  const int f = layout_.shape;
  const StageLink& stage = link[at(s)];
  const ShapeTangent& by = stage.tangent;
  const double half = 0.5 * layout_.time[at(s)];
  MatrixXd& momentum = space.momentum;
  add_product_transposed(-1.0, shape(s), by.minus.leftCols(f), momentum);
  momentum.row(layout_.constant()) -= stage.missing.transpose();
  add_force(s, half, momentum);
  shape(s + 1).setZero();
  add_product_transposed(1.0, momentum, inverse_[at(s)], shape(s + 1));
  momentum.setZero();
  add_product_transposed(1.0, shape(s), by.plus.leftCols(f), momentum);
  add_product_transposed(1.0, shape(s + 1), by.plus.rightCols(f), momentum);
  add_force(s + 1, half, momentum);
  for (int i = 0; i < 3; ++i) {  // χ − d × ρ
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    algebra::add_multiple(-stage.displacement[j], turn(s).col(k), space.shift.col(i));
    algebra::add_multiple(stage.displacement[k], turn(s).col(j), space.shift.col(i));
  }
  turn(s + 1) = turn(s);
  add_product_transposed(1.0, shape(s), by.pose.topLeftCorner(3, f), turn(s + 1));
  add_product_transposed(1.0, shape(s + 1), by.pose.topRightCorner(3, f), turn(s + 1));
  add_product_transposed(1.0, shape(s), by.pose.bottomLeftCorner(3, f), space.shift);
  add_product_transposed(1.0, shape(s + 1), by.pose.bottomRightCorner(3, f), space.shift);
}

// From (left shape, right shape, ρ) to (left shape, ρ, right shape).
void CondensedStep::reorder(const MatrixXd& hessian, MatrixXd& ordered) const {
  const int f = layout_.shape;
  const Index size = 2 * f + 3;
  for (Index c = 0; c < size; ++c) {
    const double* from = hessian.data() + size * (c < f ? c : c < f + 3 ? c + f : c - 3);
    double* to = ordered.data() + size * c;
    for (int r = 0; r < f; ++r) to[r] = from[r], to[f + 3 + r] = from[f + r];
    for (int r = 0; r < 3; ++r) to[f + r] = from[2 * f + r];
  }
}

void CondensedStep::add_curvature(CondensingSpace& space) const {
  const int f = layout_.shape;
  space.gram.setZero();
  space.gram_turn.setZero();
  for (int s = 0; s < layout_.stages(); ++s) {
    reorder(link[at(s)].hessian, space.hessian);
    space.bent.setZero();
    add_product(1.0, ends(s), space.hessian, space.bent);
    add_lower_product_transposed(1.0, ends(s), space.bent, space.gram);
    space.gram_turn += space.bent.middleCols<3>(f);
  }
  mirror_lower(space.gram);
}

// What moments and shapes have to do with each other at the nodes.
void CondensedStep::add_mixed(CondensingSpace& space) const {
  space.mixed.setZero();
  for (int node = 0; node <= layout_.stages(); ++node)
    for (int term = 0; term < layout_.terms; ++term)
      add_product_transposed(half_time(node) * force[at(node)].value[term], shape(node),
                             force[at(node)].control_by_shape,
                             space.mixed.middleCols(term * layout_.moments, layout_.moments));
  const int first = 2 * layout_.shape;
  for (int c = 0; c < layout_.inputs(); ++c)
    for (Index r = 0; r < space.gram.rows(); ++r) {
      space.gram(r, first + c) += space.mixed(r, c);
      space.gram(first + c, r) += space.mixed(r, c);
    }
}

bool CondensedStep::condense(CondensingSpace& space, optimizer::Stage& stage) {
  for (int s = 0; s < layout_.stages(); ++s)
    if (!invert(s, space.equations)) return false;
  space.momentum.setZero();
  space.momentum.middleRows(layout_.shape, layout_.shape).setIdentity();
  space.shift.setZero();
  for (int s = 0; s < layout_.stages(); ++s) eliminate(s, space);
  add_curvature(space);
  add_mixed(space);
  write_motion(space, stage);
  write_curvature(space, stage);
  return true;
}

void CondensedStep::write_motion(CondensingSpace& space, optimizer::Stage& stage) const {
  const int f = layout_.shape, inputs = layout_.inputs(), poses = layout_.poses(), constant = layout_.constant();
  Vector3d shift = Vector3d::Zero();
  for (const StageLink& one : link) shift += one.displacement;
  Matrix6d carried = Matrix6d::Identity();
  carried.bottomLeftCorner<3, 3>() = -lie::hat(shift);
  stage.A.bottomRightCorner(poses, poses) = layout_.pose_basis.transpose() * carried * layout_.pose_basis;
  space.pose.setZero();
  add_product(1.0, turn(layout_.stages()), layout_.pose_basis.topRows(3), space.pose);
  add_product(1.0, space.shift, layout_.pose_basis.bottomRows(3), space.pose);
  const auto write = [&](const auto& rows, int first) {
    const int count = static_cast<int>(rows.cols());
    set_transposed(rows.topRows(2 * f), stage.A.block(first, 0, count, 2 * f));
    set_transposed(rows.middleRows(2 * f, inputs), stage.B.middleRows(first, count));
    stage.gap.segment(first, count) = rows.row(constant).transpose();
  };
  write(shape(layout_.stages()), 0);
  write(space.momentum, f);
  write(space.pose, 2 * f);
}

void CondensedStep::write_curvature(CondensingSpace& space, optimizer::Stage& stage) const {
  const int f = layout_.shape, inputs = layout_.inputs(), poses = layout_.poses(), constant = layout_.constant();
  const MatrixXd& gram = space.gram;
  const auto turn_basis = layout_.pose_basis.topRows<3>();
  Eigen::Matrix3d turn_turn = Eigen::Matrix3d::Zero();
  for (const StageLink& one : link) turn_turn += one.hessian.bottomRightCorner<3, 3>();
  space.by_pose.setZero();
  add_product(1.0, space.gram_turn, turn_basis, space.by_pose);
  stage.Q.topLeftCorner(2 * f, 2 * f) = gram.topLeftCorner(2 * f, 2 * f);
  stage.Q.topRightCorner(2 * f, poses) = space.by_pose.topRows(2 * f);
  set_transposed(space.by_pose.topRows(2 * f), stage.Q.bottomLeftCorner(poses, 2 * f));
  stage.Q.bottomRightCorner(poses, poses) = turn_basis.transpose() * turn_turn * turn_basis;
  stage.S.leftCols(2 * f) = gram.block(2 * f, 0, inputs, 2 * f);
  stage.S.rightCols(poses) = space.by_pose.middleRows(2 * f, inputs);
  stage.R = gram.block(2 * f, 2 * f, inputs, inputs);
  stage.q.head(2 * f) = gram.col(constant).head(2 * f);
  stage.q.tail(poses) = space.by_pose.row(constant).transpose();
  stage.r = gram.col(constant).segment(2 * f, inputs);
}

void CondensedStep::pack(const VectorXd& state, const VectorXd& input, VectorXd& all) const {
  all.setZero(nodes_.rows());
  all.head(2 * layout_.shape) = state.head(2 * layout_.shape);
  all.segment(2 * layout_.shape, layout_.inputs()) = input;
  all[layout_.constant()] = 1.0;
}

void CondensedStep::shape_along(int node, const VectorXd& all, Eigen::Ref<VectorXd> along) const {
  along.setZero();
  add_transposed_image(1.0, shape(node), all, along);
}

void CondensedStep::carry_back(const VectorXd& state, const VectorXd& input, const StepCostate& end,
                               std::vector<StepCostate>& costate) const {
  const int f = layout_.shape;
  VectorXd all;
  pack(state, input, all);
  const Vector3d first_turn = layout_.pose_basis.topRows<3>() * state.tail(layout_.poses());
  const auto moments = [&](int node) {
    return VectorXd(input.reshaped(layout_.moments, layout_.terms) * force[at(node)].value);
  };
  StepCostate next = end;
  next.shape += half_time(layout_.stages()) * (force.back().control_by_shape.transpose() * moments(layout_.stages()));
  VectorXd ends(2 * f + 3), bent(2 * f + 3), by_ends(2 * f);
  for (int s = layout_.stages() - 1; s >= 0; --s) {
    const StageLink& stage = link[at(s)];
    const ShapeTangent& by = stage.tangent;
    shape_along(s, all, ends.head(f));
    shape_along(s + 1, all, ends.segment(f, f));
    ends.tail<3>() = first_turn + turn(s + 1).transpose() * all;
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
  space.metric.setZero();
  for (int s = 0; s < layout_.stages(); ++s) {
    space.rate = shape(s + 1);
    space.rate -= shape(s);
    for (int c = 0; c < f; ++c)
      space.weighed.col(c) = scale * std::abs(link[at(s)].tangent.minus(c, f + c)) * space.rate.col(c);
    add_lower_product_transposed(1.0, space.rate, space.weighed, space.metric);
  }
  mirror_lower(space.metric);
  stage.metric.topLeftCorner(2 * f, 2 * f) = space.metric.topLeftCorner(2 * f, 2 * f);
  stage.metric_mixed.setZero(inputs, layout_.states());
  stage.metric_mixed.leftCols(2 * f) = space.metric.block(2 * f, 0, inputs, 2 * f);
  stage.metric_input = space.metric.block(2 * f, 2 * f, inputs, inputs);
}

}  // namespace lamprey::shape
