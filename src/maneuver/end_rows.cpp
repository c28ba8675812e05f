#include "maneuver/end_rows.hpp"

#include <cmath>
#include <numbers>
#include <sstream>

#include "lie/so3.hpp"
#include "model/world_axes.hpp"

namespace lamprey::maneuver {

namespace {

using model::at;
using model::System;

// How a component of a body's turn, `along` in its own frame, changes with the shape's coordinates; the root turns nothing.
void read_turn(const System& system, const mechanics::Rotations& R, int i, Vector3d along,
               Eigen::Ref<Eigen::RowVectorXd> derivative) {
  for (; system.body(i).parent >= 0; i = system.body(i).parent) {
    const model::Body& body = system.body(i);
    if (body.freedoms == 3) {
      derivative.segment<3>(shape_offset(body)) = along;
      return;
    }
    const mechanics::JointFrame frame = mechanics::joint_frame(system.joint(body.joint), R[at(body.parent)], R[at(i)]);
    for (int f = 0; f < body.freedoms; ++f) derivative[shape_offset(body) + f] = along.dot(frame.axes.col(f));
    along = frame.child_to_parent * along;
  }
}

double angle_of(const model::Joint& joint, const Matrix3d& child_to_parent, int axis) {
  return mechanics::joint_angles(joint, child_to_parent)[axis];
}

// Whether it is of a ball joint between two bodies that turn as the root sees them: others change as coordinates do.
bool bends(const System& system, const EndRow& row) {
  return row.kind == EndRow::Kind::joint && system.body(row.index).freedoms == 3 && system.body(row.index).parent > 0;
}

// Its derivative by the shape's coordinates; the root's pose does not count.
double joint_row(const System& system, const Maneuver& maneuver, const EndRow& row, const mechanics::Rotations& R,
                 Eigen::Ref<Eigen::RowVectorXd> derivative) {
  const model::Body& body = system.body(row.index);
  const model::Joint& joint = system.joint(body.joint);
  const Matrix3d &asked = *maneuver.end_joint[at(body.joint)], now = mechanics::child_to_parent(R, joint);
  if (joint.free()) {
    const Vector3d error = lie::log(asked.transpose() * now);
    const Vector3d by_turn = lie::log_tangent(error).row(row.component);
    read_turn(system, R, row.index, by_turn, derivative);
    read_turn(system, R, joint.parent, -now * by_turn, derivative);
    return error[row.component];
  }
  derivative[shape_offset(body) + row.component] = 1.0;
  return lie::shorter_way(angle_of(joint, now, row.component) - angle_of(joint, asked, row.component));
}

// What swings all bodies by a radian and back, once over the duration; a power of two, N m.
double moment_unit(const System& system, double duration) {
  double inertia = 0.0;
  for (const model::Body& body : system.bodies()) inertia += body.inertia_matrix.trace() / 3.0;
  const double frequency = 2.0 * std::numbers::pi / duration;
  return std::exp2(std::round(std::log2(inertia * frequency * frequency)));
}

}  // namespace

std::string in_words(double value, int digits) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

std::vector<EndRow> stated_end_rows(const System& system, const Maneuver& maneuver,
                                    const std::vector<int>& unactuated) {
  std::vector<EndRow> rows;
  const bool root = maneuver.end_rotation[0].has_value();
  if (maneuver.periodic)
    for (int i = 1; i < system.body_count(); ++i)
      for (int c = 0; c < system.body(i).freedoms; ++c) rows.push_back({EndRow::Kind::closure, i, c});
  for (int i = 0; i < (maneuver.periodic ? 1 : system.body_count()); ++i)
    if (maneuver.end_rotation[at(i)])
      for (int c = 0; c < 3; ++c)
        rows.push_back({i > 0 && root ? EndRow::Kind::shape : EndRow::Kind::orientation, i, c});
  for (int i = 1; i < system.body_count(); ++i)
    if (maneuver.tells_joint(system.body(i).joint))
      for (int c = 0; c < system.body(i).freedoms; ++c) rows.push_back({EndRow::Kind::joint, i, c});
  for (int c = 0; c < 3; ++c)
    if (maneuver.end_position[at(c)]) rows.push_back({EndRow::Kind::position, 0, c, system.length_unit()});
  if (maneuver.rest || maneuver.periodic)
    for (int place : unactuated)
      rows.push_back({EndRow::Kind::moment, place, 0, moment_unit(system, maneuver.duration)});
  return rows;
}

std::string end_row_in_words(const System& system, const EndRow& row, double missed) {
  const std::string size = in_words(row.unit * missed);
  const char* axis = model::world_axes[at(row.component)];
  switch (row.kind) {
    case EndRow::Kind::position:
      return std::string("goal.move along ") + axis + " is missed by " + size + " m";
    case EndRow::Kind::moment:
      return "joints that nothing drives do not end as asked by themselves: it would take a moment of " + size + " N m";
    case EndRow::Kind::closure:
      return "the shape of " + system.body(row.index).name + " does not close by " + size + " rad";
    case EndRow::Kind::joint:
      return "the end of joint " + system.joint(system.body(row.index).joint).name + " is missed by " + size + " rad";
    case EndRow::Kind::orientation:
    case EndRow::Kind::shape:
      break;
  }
  return "the end attitude of " + system.body(row.index).name + " is missed by " + size + " rad";
}

double end_row(const System& system, const Maneuver& maneuver, const EndRow& row, const mechanics::Rotations& R,
               const Vector3d& position, Eigen::Ref<Eigen::RowVectorXd> derivative) {
  const int shape = shape_size(system);
  derivative.setZero();
  if (row.kind == EndRow::Kind::position) {
    derivative[shape + 3 + row.component] = 1.0 / row.unit;
    return (position[row.component] - *maneuver.end_position[at(row.component)]) / row.unit;
  }
  if (row.kind == EndRow::Kind::joint) return joint_row(system, maneuver, row, R, derivative);
  const Matrix3d& asked = *maneuver.end_rotation[at(row.index)];
  const Matrix3d& now = R[at(row.index)];
  if (row.kind == EndRow::Kind::shape) {
    const Matrix3d asked_shape = maneuver.end_rotation[0]->transpose() * asked;
    const Vector3d error = lie::log(asked_shape.transpose() * (R[0].transpose() * now));
    read_turn(system, R, row.index, lie::log_tangent(error).row(row.component), derivative);
    return error[row.component];
  }
  // exp(ρ̂) R asked⁻¹ = exp(e + T ρ): the turn comes from the left
  const Vector3d error = lie::log(now * asked.transpose());
  const Eigen::RowVector3d by_turn = lie::log_tangent(-error).row(row.component);
  if (row.index > 0) read_turn(system, R, row.index, now.transpose() * by_turn.transpose(), derivative);
  derivative.segment<3>(shape) = by_turn;
  return error[row.component];
}

EndCurvature::EndCurvature(const System& system, const std::vector<EndRow>& rows, const MatrixXd& shapes,
                           const MatrixXd& poses)
    : system_(system),
      shapes_(shapes),
      turns_of_root_(poses.topRows<3>()),
      whole_(MatrixXd::Zero(shapes.rows() + 3, shapes.rows() + 3)),
      half_(whole_.rows(), shapes.cols()),
      mixed_(poses.cols(), shapes.cols()),
      along_(whole_.rows()),
      first_(at(system.body_count()), Vector3d::Zero()),
      second_(first_),
      turns_(first_),
      changes_(first_) {
  for (const EndRow& row : rows) {
    if (row.kind == EndRow::Kind::orientation) any_ = any_ || row.index > 0;
    if (row.kind == EndRow::Kind::shape) any_ = any_ || system.body(row.index).freedoms < 3;
    if (bends(system, row)) any_ = true;
  }
}

void EndCurvature::add(const std::vector<EndRow>& rows, const mechanics::Rotations& R, const VectorXd& multipliers,
                       int shape_place, int pose_place, MatrixXd& form) {
  if (!any_) return;
  whole_.setZero();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const EndRow& row = rows[r];
    const Vector3d pull = multipliers[static_cast<Eigen::Index>(r)] * Vector3d::Unit(row.component);
    if (bends(system_, row)) add_joint(row.index, pull, R);
    if (row.index == 0 || (row.kind != EndRow::Kind::orientation && row.kind != EndRow::Kind::shape)) continue;
    if (row.kind == EndRow::Kind::shape) {
      add_turns(row.index, pull, R);
    } else {
      add_turns(row.index, R[at(row.index)].transpose() * pull, R);
      add_root_and_shape(row.index, pull, R);
    }
  }
  const Eigen::Index all = shapes_.rows(), f = shapes_.cols(), p = turns_of_root_.cols();
  algebra::set_product(whole_.leftCols(all), shapes_, half_);
  algebra::add_product(1.0, shapes_.transpose(), half_.topRows(all), form.block(shape_place, shape_place, f, f));
  algebra::set_product(turns_of_root_.transpose(), half_.bottomRows(3), mixed_);
  form.block(pose_place, shape_place, p, f) += mixed_;
  form.block(shape_place, pose_place, f, p) += mixed_.transpose();
}

// pull · (second-order part of a body's turn, its own frame) along the joints between the root and the body.
void EndCurvature::add_turns(int body, const Vector3d& pull, const mechanics::Rotations& R) {
  const auto on_the_way = [&](auto visit) {
    for (int i = body; system_.body(i).parent >= 0; i = system_.body(i).parent) {
      for (int f = 0; f < system_.body(i).freedoms; ++f) visit(i, f);
      if (system_.body(i).freedoms == 3) return;
    }
  };
  on_the_way([&](int i, int f) {
    first_[at(i)][f] = 1.0;
    mechanics::body_turns(system_, R, first_, turns_);
    on_the_way([&](int j, int g) {
      second_[at(j)][g] = 1.0;
      mechanics::body_turn_changes(system_, R, first_, turns_, second_, changes_);
      const double half = 0.5 * pull.dot(changes_[at(body)]);
      const int a = shape_offset(system_.body(i)) + f, b = shape_offset(system_.body(j)) + g;
      whole_(a, b) += half;
      whole_(b, a) += half;
      second_[at(j)][g] = 0.0;
    });
    first_[at(i)][f] = 0.0;
  });
}

// log(exp(−Qᵀŷ) exp(x̂)) = x − Qᵀy − ½ Qᵀy × x + …, y the turn of the parent, x that of the child, each in its own frame.
void EndCurvature::add_joint(int body, const Vector3d& pull, const mechanics::Rotations& R) {
  const int parent = system_.body(body).parent, place = shape_offset(system_.body(body));
  const Matrix3d Q = R[at(parent)].transpose() * R[at(body)];
  add_turns(parent, -Q * pull, R);
  for (int c = 0; c < 3; ++c) {
    // pull · (Qᵀy × e_c) = (e_c × pull) · Qᵀy
    along_.setZero();
    read_turn(system_, R, parent, Q * Vector3d::Unit(c).cross(pull), along_);
    for (int a = 0; a < shape_size(system_); ++a) {
      whole_(place + c, a) -= 0.5 * along_[a];
      whole_(a, place + c) -= 0.5 * along_[a];
    }
  }
}

// log(exp(ρ̂) exp(x̂)) = ρ + x + ½ ρ × x + …, x the turn by the shape as the world sees it; pull in the world.
void EndCurvature::add_root_and_shape(int body, const Vector3d& pull, const mechanics::Rotations& R) {
  const int shape = shape_size(system_);
  for (int c = 0; c < 3; ++c) {
    // pull · (e_c × x) = (pull × e_c) · x
    along_.setZero();
    read_turn(system_, R, body, R[at(body)].transpose() * pull.cross(Vector3d::Unit(c)), along_);
    for (int a = 0; a < shape; ++a) {
      whole_(shape + c, a) += 0.5 * along_[a];
      whole_(a, shape + c) += 0.5 * along_[a];
    }
  }
}

double closure_row(const System& system, const EndRow& row, const mechanics::Rotations& first,
                   const mechanics::Rotations& last, Eigen::Ref<Eigen::RowVectorXd> by_first,
                   Eigen::Ref<Eigen::RowVectorXd> by_last) {
  const model::Body& body = system.body(row.index);
  by_first.setZero();
  by_last.setZero();
  const int place = shape_offset(body);
  if (body.freedoms == 3) {
    const Vector3d error = lie::log(first[at(row.index)].transpose() * last[at(row.index)]);
    by_last.segment<3>(place) = lie::log_tangent(error).row(row.component);
    by_first.segment<3>(place) = -lie::log_tangent(-error).row(row.component);
    return error[row.component];
  }
  const model::Joint& joint = system.joint(body.joint);
  const auto angle = [&](const mechanics::Rotations& R) {
    return angle_of(joint, mechanics::child_to_parent(R, joint), row.component);
  };
  by_last[place + row.component] = 1.0;
  by_first[place + row.component] = -1.0;
  return lie::shorter_way(angle(last) - angle(first));
}

}  // namespace lamprey::maneuver
