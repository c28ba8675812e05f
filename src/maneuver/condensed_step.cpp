#include "maneuver/condensed_step.hpp"

#include <Eigen/LU>

#include "lie/so3.hpp"
#include "model/system.hpp"

namespace lamprey::maneuver {

using model::at;

CondensedStep::CondensedStep(const StepLayout& layout)
    : link(at(layout.stages())),
      force(at(layout.stages() + 1)),
      layout_(layout),
      shape_(at(layout.stages() + 1), MatrixXd::Zero(layout.shape, columns())),
      pose_(at(layout.stages() + 1), MatrixXd::Zero(6, columns())),
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

void CondensedStep::add_force(int node, double weight, MatrixXd& rows) const {
  const StageForce& at_node = force[at(node)];
  for (int term = 0; term < layout_.terms; ++term)
    rows.middleCols(2 * layout_.shape + term * layout_.moments, layout_.moments) +=
        weight * at_node.value[term] * at_node.impulse;
}

// The next shape, momentum and pose from those at node s.
void CondensedStep::eliminate(int s) {
  const int f = layout_.shape;
  const StageLink& stage = link[at(s)];
  const double half = 0.5 * layout_.time[at(s)];
  MatrixXd& next = shape_[at(s + 1)];
  momentum_.noalias() -= stage.minus.leftCols(f) * shape_[at(s)];
  momentum_.col(columns() - 1) -= stage.missing;
  add_force(s, half, momentum_);
  next.noalias() = inverse_[at(s)] * momentum_;
  momentum_.noalias() = stage.plus.leftCols(f) * shape_[at(s)];
  momentum_.noalias() += stage.plus.rightCols(f) * next;
  add_force(s + 1, half, momentum_);
  MatrixXd& pose = pose_[at(s + 1)];
  pose.noalias() = stage.pose.leftCols(f) * shape_[at(s)];
  pose.noalias() += stage.pose.rightCols(f) * next;
  pose += pose_[at(s)];
  pose.bottomRows<3>().noalias() -= lie::hat(stage.displacement) * pose_[at(s)].topRows<3>();
}

void CondensedStep::add_curvature(int s) {
  const int f = layout_.shape;
  ends_.topRows(f) = shape_[at(s)];
  ends_.middleRows(f, f) = shape_[at(s + 1)];
  ends_.bottomRows<3>() = pose_[at(s)].topRows<3>();
  half_.noalias() = link[at(s)].hessian * ends_;
  gram_.noalias() += ends_.transpose() * half_;
  gram_turn_ += half_.bottomRows<3>();
  turn_turn_ += link[at(s)].hessian.bottomRightCorner<3, 3>();
}

void CondensedStep::add_mixed(int node, double weight) {
  const StageForce& at_node = force[at(node)];
  const MatrixXd by_shape = weight * at_node.control_by_shape * shape_[at(node)];
  for (int term = 0; term < layout_.terms; ++term) {
    const int first = 2 * layout_.shape + term * layout_.moments;
    gram_.middleRows(first, layout_.moments) += at_node.value[term] * by_shape;
    gram_.middleCols(first, layout_.moments) += at_node.value[term] * by_shape.transpose();
  }
}

bool CondensedStep::condense(optimizer::Stage& stage) {
  const int f = layout_.shape, inputs = layout_.inputs(), poses = layout_.poses(), stages = layout_.stages();
  momentum_.setZero(f, columns());
  momentum_.middleCols(f, f).setIdentity();
  ends_.resize(2 * f + 3, columns());
  gram_.setZero(columns(), columns());
  gram_turn_.setZero(3, columns());
  turn_turn_.setZero();
  Vector3d shift = Vector3d::Zero();
  for (int s = 0; s < stages; ++s) {
    inverse_[at(s)] = link[at(s)].minus.rightCols(f).partialPivLu().inverse();
    if (!inverse_[at(s)].allFinite()) return false;
    eliminate(s);
    add_curvature(s);
    shift += link[at(s)].displacement;
  }
  for (int node = 0; node <= stages; ++node) add_mixed(node, half_time(node));

  const MatrixXd pose = layout_.pose_basis.transpose() * pose_.back();
  Eigen::Matrix<double, 6, 6> carried = Eigen::Matrix<double, 6, 6>::Identity();
  carried.bottomLeftCorner<3, 3>() = -lie::hat(shift);
  stage.A.topLeftCorner(f, 2 * f) = shape_.back().leftCols(2 * f);
  stage.A.block(f, 0, f, 2 * f) = momentum_.leftCols(2 * f);
  stage.A.block(2 * f, 0, poses, 2 * f) = pose.leftCols(2 * f);
  stage.A.bottomRightCorner(poses, poses) = layout_.pose_basis.transpose() * carried * layout_.pose_basis;
  stage.B.topRows(f) = shape_.back().middleCols(2 * f, inputs);
  stage.B.middleRows(f, f) = momentum_.middleCols(2 * f, inputs);
  stage.B.bottomRows(poses) = pose.middleCols(2 * f, inputs);
  stage.gap.head(f) = shape_.back().rightCols<1>();
  stage.gap.segment(f, f) = momentum_.rightCols<1>();
  stage.gap.tail(poses) = pose.rightCols<1>();

  const auto turn = layout_.pose_basis.topRows<3>();
  const MatrixXd by_pose = turn.transpose() * gram_turn_;
  stage.Q.topLeftCorner(2 * f, 2 * f) = gram_.topLeftCorner(2 * f, 2 * f);
  stage.Q.bottomLeftCorner(poses, 2 * f) = by_pose.leftCols(2 * f);
  stage.Q.topRightCorner(2 * f, poses) = by_pose.leftCols(2 * f).transpose();
  stage.Q.bottomRightCorner(poses, poses) = turn.transpose() * turn_turn_ * turn;
  stage.S.leftCols(2 * f) = gram_.block(2 * f, 0, inputs, 2 * f);
  stage.S.rightCols(poses) = by_pose.middleCols(2 * f, inputs).transpose();
  stage.R = gram_.block(2 * f, 2 * f, inputs, inputs);
  stage.q.head(2 * f) = gram_.rightCols<1>().head(2 * f);
  stage.q.tail(poses) = by_pose.rightCols<1>();
  stage.r = gram_.rightCols<1>().segment(2 * f, inputs);
  return true;
}

VectorXd CondensedStep::packed(const VectorXd& state, const VectorXd& input) const {
  VectorXd all(columns());
  all << state.head(2 * layout_.shape), input, 1.0;
  return all;
}

VectorXd CondensedStep::shape_along(int node, const VectorXd& state, const VectorXd& input) const {
  return shape_[at(node)] * packed(state, input);
}

void CondensedStep::carry_back(const VectorXd& state, const VectorXd& input, const StepCostate& end,
                               std::vector<StepCostate>& costate) const {
  const int f = layout_.shape;
  const VectorXd all = packed(state, input);
  const Vector3d turn = layout_.pose_basis.topRows<3>() * state.tail(layout_.poses());
  const auto moments = [&](int node) {
    return VectorXd(input.reshaped(layout_.moments, layout_.terms) * force[at(node)].value);
  };
  StepCostate next = end;
  next.shape += half_time(layout_.stages()) * (force.back().control_by_shape.transpose() * moments(layout_.stages()));
  VectorXd ends(2 * f + 3);
  for (int s = layout_.stages() - 1; s >= 0; --s) {
    const StageLink& stage = link[at(s)];
    ends << shape_[at(s)] * all, shape_[at(s + 1)] * all, turn + pose_[at(s)].topRows<3>() * all;
    const VectorXd bent = stage.hessian * ends;
    const VectorXd by_ends =
        stage.plus.transpose() * next.momentum + stage.pose.transpose() * next.pose + bent.head(2 * f);
    StepCostate& here = costate[at(s)];
    here.momentum = inverse_[at(s)].transpose() * (next.shape + by_ends.tail(f));
    here.shape = by_ends.head(f) - stage.minus.leftCols(f).transpose() * here.momentum +
                 half_time(s) * (force[at(s)].control_by_shape.transpose() * moments(s));
    here.pose = next.pose;
    here.pose.head<3>() += stage.displacement.cross(next.pose.tail<3>()) + bent.tail<3>();
    next = here;
  }
}

void CondensedStep::measure_rates(double scale, optimizer::Stage& stage) const {
  const int f = layout_.shape, inputs = layout_.inputs();
  MatrixXd gram = MatrixXd::Zero(2 * f + inputs, 2 * f + inputs);
  for (int s = 0; s < layout_.stages(); ++s) {
    const VectorXd inertia = scale * link[at(s)].minus.rightCols(f).diagonal().cwiseAbs();
    const MatrixXd rate = (shape_[at(s + 1)] - shape_[at(s)]).leftCols(2 * f + inputs);
    gram.noalias() += rate.transpose() * inertia.asDiagonal() * rate;
  }
  stage.metric.topLeftCorner(2 * f, 2 * f) = gram.topLeftCorner(2 * f, 2 * f);
  stage.metric_mixed.setZero(inputs, layout_.states());
  stage.metric_mixed.leftCols(2 * f) = gram.bottomLeftCorner(inputs, 2 * f);
  stage.metric_input = gram.bottomRightCorner(inputs, inputs);
}

}  // namespace lamprey::maneuver
