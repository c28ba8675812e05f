#include "mechanics/tree_elimination.hpp"

#include <cmath>

#include <Eigen/LU>

#include "mechanics/four_bodies.hpp"

namespace lamprey::mechanics {

namespace {

using model::at;
using model::Body;
using model::Joint;
using model::System;
using Vector6 = Eigen::Matrix<double, 6, 1>;

bool inverted(const Matrix3d& m, Matrix3d& inverse) {
  const double determinant = m.determinant();
  if (!(std::abs(determinant) > 0.0) || !std::isfinite(determinant)) return false;
  inverse = m.inverse();
  return true;
}

// From a body's own joint, the root's mass centre, to a joint that it bears; body frame.
Vector3d between_joints(const System& system, const Joint& joint) {
  const int up = system.body(joint.parent).joint;
  return up < 0 ? joint.parent_offset : Vector3d(joint.parent_offset - system.joint(up).child_offset);
}

// Blocks about the mass centres become blocks about the joints: δ = j + R' d̂ η', n − d × RᵀP.
void move_to_joints(const System& system, const Rotations& left, const Rotations& right,
                    std::vector<BodyBlock>& blocks) {
  for_each_four(blocks.size(), [&](const FourBodies& four) {
    const Four3 d = four.read([&](std::size_t i) {
      const int up = system.bodies()[i].joint;
      return up < 0 ? Vector3d(Vector3d::Zero()) : system.joint(up).child_offset;
    });
    const Four33 shift_by_turn = times_hat(four.read(right), d), lever = transposed(times_hat(four.read(left), d));
    const Four33 force_by_shift = four.read(blocks, &BodyBlock::force_by_shift);
    const Four33 moment_by_shift = four.read(blocks, &BodyBlock::moment_by_shift);
    const Four33 force_by_turn = four.read(blocks, &BodyBlock::force_by_turn) + force_by_shift * shift_by_turn;
    const Four33 moment_by_turn =
        four.read(blocks, &BodyBlock::moment_by_turn) + moment_by_shift * shift_by_turn + lever * force_by_turn;
    four.write(force_by_turn, blocks, &BodyBlock::force_by_turn);
    four.write(moment_by_turn, blocks, &BodyBlock::moment_by_turn);
    four.write(moment_by_shift + lever * force_by_shift, blocks, &BodyBlock::moment_by_shift);
  });
}

}  // namespace

TreeElimination::TreeElimination(const System& system)
    : nodes_(at(system.body_count())),
      led_nodes_(system.only_free_joints() ? 0 : nodes_.size()),
      walk_(at(system.body_count())) {}

bool TreeElimination::eliminate(const System& system, const Rotations& left, const Rotations& right,
                                std::vector<BodyBlock>& condensed, const std::vector<Matrix3d>& damping, int i) {
  const Body& body = system.body(i);
  const Joint& joint = system.joint(body.joint);
  const BodyBlock& b = condensed[at(i)];
  Node& node = nodes_[at(i)];
  const int p = body.parent;
  const Vector3d between = between_joints(system, joint);
  const Matrix3d parent_shift = lie::times_hat(right[at(p)], between);
  const Matrix3d parent_lever = -lie::times_hat(left[at(p)], between).transpose();
  BodyBlock& parent = condensed[at(p)];
  const bool damped = !damping.empty() && joint.damping > 0.0;
  node.led = !joint.free() || damped;

  if (!node.led) {
    if (!inverted(b.moment_by_turn, node.inverse)) return false;
    node.turn_by_shift = node.inverse * b.moment_by_shift;
    node.force_by_rest = b.force_by_turn * node.inverse;
    const Matrix3d rest = b.force_by_shift - b.force_by_turn * node.turn_by_shift;
    const Matrix3d by_turn = rest * parent_shift;
    parent.force_by_shift += rest;
    parent.force_by_turn -= by_turn;
    parent.moment_by_shift += parent_lever * rest;
    parent.moment_by_turn -= parent_lever * by_turn;
    return true;
  }

  LedNode& led = led_nodes_[at(i)];
  led.at_joint = b;
  led.left = joint_frame(joint, left[at(p)], left[at(i)]);
  led.right = joint_frame(joint, right[at(p)], right[at(i)]);
  led.left_axes = damped_axes(joint, led.left);
  led.right_axes = damped_axes(joint, led.right);
  const Matrix3d& S = led.left_axes;
  const Matrix3d& S_right = led.right_axes;
  Matrix3d pivot = S.transpose() * b.moment_by_turn * S_right;
  if (damped) pivot += damping[at(i)];
  for (int f = body.freedoms; f < 3; ++f) pivot(f, f) = 1.0;
  if (!inverted(pivot, node.inverse)) return false;
  const Matrix3d moment_column = b.moment_by_turn * S_right * node.inverse;
  const Matrix3d force_column = b.force_by_turn * S_right * node.inverse;
  const Matrix3d row_by_turn = S.transpose() * b.moment_by_turn;
  const Matrix3d row_by_shift = S.transpose() * b.moment_by_shift;
  const Matrix3d& Q = led.left.child_to_parent;
  const Matrix3d Q_right = led.right.child_to_parent.transpose();
  const Matrix3d moment_by_shift = b.moment_by_shift - moment_column * row_by_shift;
  const Matrix3d force_by_shift = b.force_by_shift - force_column * row_by_shift;
  const Matrix3d moment_by_turn =
      (b.moment_by_turn - moment_column * row_by_turn) * Q_right - moment_by_shift * parent_shift;
  const Matrix3d force_by_turn =
      (b.force_by_turn - force_column * row_by_turn) * Q_right - force_by_shift * parent_shift;
  parent.force_by_shift += force_by_shift;
  parent.force_by_turn += force_by_turn;
  parent.moment_by_shift += Q * moment_by_shift + parent_lever * force_by_shift;
  parent.moment_by_turn += Q * moment_by_turn + parent_lever * force_by_turn;
  return true;
}

bool TreeElimination::factor(const System& system, const Rotations& left, const Rotations& right,
                             std::vector<BodyBlock>& blocks, const std::vector<Matrix3d>& damping) {
  move_to_joints(system, left, right, blocks);
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position)
    if (*position != 0 && !eliminate(system, left, right, blocks, damping, *position)) return false;
  const BodyBlock& root = blocks[0];
  // of the two three-row halves the displacement's is always well conditioned: condense it away
  Matrix3d shift_inverse, turn_inverse;
  if (!inverted(root.force_by_shift, shift_inverse)) return false;
  const Matrix3d from_turn = shift_inverse * root.force_by_turn;
  const Matrix3d to_moment = root.moment_by_shift * shift_inverse;
  if (!inverted(root.moment_by_turn - root.moment_by_shift * from_turn, turn_inverse)) return false;
  root_inverse_.topLeftCorner<3, 3>() = turn_inverse;
  root_inverse_.topRightCorner<3, 3>() = -turn_inverse * to_moment;
  root_inverse_.bottomLeftCorner<3, 3>() = -from_turn * turn_inverse;
  root_inverse_.bottomRightCorner<3, 3>() = shift_inverse + from_turn * turn_inverse * to_moment;
  return root_inverse_.allFinite();
}

template <bool transposed>
void TreeElimination::solve_tree(const System& system, const Rotations& near, const Rotations& far, Freedoms& freedoms,
                                 Vector3d& linear) {
  const auto block = [](const auto& m) -> decltype(auto) {
    if constexpr (transposed) {
      return m.transpose();
    } else {
      return (m);
    }
  };
  for (Walk& w : walk_) w.moment.setZero(), w.force.setZero();
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const Body& body = system.body(i);
    if (body.parent < 0) break;
    const Joint& joint = system.joint(body.joint);
    const Node& node = nodes_[at(i)];
    Walk& w = walk_[at(i)];
    Walk& parent = walk_[at(body.parent)];
    Vector3d& t = freedoms[at(i)];
    if (!node.led) {
      t -= w.moment;
      w.force += block(transposed ? node.turn_by_shift : node.force_by_rest) * t;
      t = (block(node.inverse) * t).eval();
    } else {
      const LedNode& led = led_nodes_[at(i)];
      const Matrix3d& Q = (transposed ? led.right : led.left).child_to_parent;
      if (joint.free()) parent.moment -= Q * t;
      t = (block(node.inverse) * (t - (transposed ? led.right_axes : led.left_axes).transpose() * w.moment)).eval();
      const Vector3d turn = (transposed ? led.left_axes : led.right_axes) * t;
      w.moment += block(led.at_joint.moment_by_turn) * turn;
      w.force += block(transposed ? led.at_joint.moment_by_shift : led.at_joint.force_by_turn) * turn;
      parent.moment += Q * w.moment;
    }
    parent.force += w.force;
    parent.moment += between_joints(system, joint).cross(near[at(body.parent)].transpose() * w.force);
  }
  Vector6 rest;
  rest << freedoms[0] - walk_[0].moment, linear - walk_[0].force;
  const Vector6 root = block(root_inverse_) * rest;
  freedoms[0] = walk_[0].turn = root.head<3>();
  linear = walk_[0].shift = root.tail<3>();
  for (int i : order) {
    const Body& body = system.body(i);
    if (body.parent < 0) continue;
    const Joint& joint = system.joint(body.joint);
    const Node& node = nodes_[at(i)];
    const Walk& parent = walk_[at(body.parent)];
    Walk& w = walk_[at(i)];
    w.shift = parent.shift - far[at(body.parent)] * between_joints(system, joint).cross(parent.turn);
    Vector3d& t = freedoms[at(i)];
    if (!node.led) {
      t -= block(transposed ? node.force_by_rest : node.turn_by_shift) * w.shift;
      w.turn = t;
    } else {
      const LedNode& led = led_nodes_[at(i)];
      const Vector3d carried = (transposed ? led.left : led.right).child_to_parent.transpose() * parent.turn;
      const Matrix3d& moment_by_shift = transposed ? led.at_joint.force_by_turn : led.at_joint.moment_by_shift;
      t -= block(node.inverse) * ((transposed ? led.right_axes : led.left_axes).transpose() *
                                  (block(led.at_joint.moment_by_turn) * carried + block(moment_by_shift) * w.shift));
      w.turn = carried + (transposed ? led.left_axes : led.right_axes) * t;
      if (joint.free()) t = w.turn;
    }
  }
}

void TreeElimination::solve(const System& system, const Rotations& left, const Rotations& right, Freedoms& freedoms,
                            Vector3d& linear) {
  solve_tree<false>(system, left, right, freedoms, linear);
}

void TreeElimination::solve_transposed(const System& system, const Rotations& left, const Rotations& right,
                                       Freedoms& freedoms, Vector3d& linear) {
  solve_tree<true>(system, right, left, freedoms, linear);
}

void TreeElimination::solve_rows(const System& system, const Rotations& left, const Rotations& right,
                                 std::vector<Rows3>& freedoms, Rows3& linear) {
  const Eigen::Index rows = linear.rows();
  for (FreedomRows* kept : {&row_moment_, &row_force_}) {
    kept->resize(nodes_.size());
    for (Rows3& zeroed : *kept) {
      zeroed.resize(rows, 3);
      clear_rows(rows, zeroed);
    }
  }
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const Body& body = system.body(i);
    if (body.parent < 0) break;
    const Joint& joint = system.joint(body.joint);
    const Node& node = nodes_[at(i)];
    Rows3& moment = row_moment_[at(i)];
    Rows3& force = row_force_[at(i)];
    Rows3& parent_moment = row_moment_[at(body.parent)];
    Rows3& t = freedoms[at(i)];
    if (!node.led) {
      if (!body.children.empty()) add_rows(-1.0, moment, rows, t);
      add_product(node.force_by_rest, t, rows, force);
      set_product(node.inverse, t, rows, t);
    } else {
      const LedNode& led = led_nodes_[at(i)];
      if (joint.free()) add_product(-led.left.child_to_parent, t, rows, parent_moment);
      add_product(-led.left_axes.transpose(), moment, rows, t);
      set_product(node.inverse, t, rows, t);
      add_product(led.at_joint.moment_by_turn * led.right_axes, t, rows, moment);
      add_product(led.at_joint.force_by_turn * led.right_axes, t, rows, force);
      add_product(led.left.child_to_parent, moment, rows, parent_moment);
    }
    add_rows(1.0, force, rows, row_force_[at(body.parent)]);
    add_product(-lie::times_hat(left[at(body.parent)], between_joints(system, joint)).transpose(), force, rows,
                parent_moment);
  }
  // from here on row_moment_ holds the bodies' turns and row_force_ their joints' shifts
  Rows3& moment = row_moment_[0];
  Rows3& force = row_force_[0];
  add_rows(-1.0, freedoms[0], rows, moment);  // both with their signs changed
  add_rows(-1.0, linear, rows, force);
  set_product(-root_inverse_.topLeftCorner<3, 3>(), moment, rows, freedoms[0]);
  add_product(-root_inverse_.topRightCorner<3, 3>(), force, rows, freedoms[0]);
  set_product(-root_inverse_.bottomLeftCorner<3, 3>(), moment, rows, linear);
  add_product(-root_inverse_.bottomRightCorner<3, 3>(), force, rows, linear);
  copy_rows(freedoms[0], rows, moment);
  copy_rows(linear, rows, force);
  for (int i : order) {
    const Body& body = system.body(i);
    if (body.parent < 0) continue;
    const Joint& joint = system.joint(body.joint);
    const Node& node = nodes_[at(i)];
    const Rows3& parent_turn = row_moment_[at(body.parent)];
    Rows3& turn = row_moment_[at(i)];
    Rows3& shift = row_force_[at(i)];
    Rows3& t = freedoms[at(i)];
    copy_rows(row_force_[at(body.parent)], rows, shift);
    add_product(-lie::times_hat(right[at(body.parent)], between_joints(system, joint)), parent_turn, rows, shift);
    if (!node.led) {
      add_product(-node.turn_by_shift, shift, rows, t);
      copy_rows(t, rows, turn);
    } else {
      const LedNode& led = led_nodes_[at(i)];
      set_product(led.right.child_to_parent.transpose(), parent_turn, rows, turn);
      const Matrix3d row = node.inverse * led.left_axes.transpose();
      add_product(-row * led.at_joint.moment_by_turn, turn, rows, t);
      add_product(-row * led.at_joint.moment_by_shift, shift, rows, t);
      add_product(led.right_axes, t, rows, turn);
      if (joint.free()) copy_rows(turn, rows, t);
    }
  }
}

}  // namespace lamprey::mechanics
