#include "shape/led_turns.hpp"

#include "shape/shape_step.hpp"

namespace lamprey::shape {

namespace {

using maneuver::shape_offset;
using maneuver::shape_size;

}  // namespace

using mechanics::Four;
using mechanics::Four3;
using mechanics::Four33;
using model::at;
using model::Body;
using model::Joint;
using model::System;

LedTurns::LedTurns(const System& system)
    : system_(system), column_(at(shape_size(system))), shape_(at(system.body_count())), body_turn_(shape_.size()) {
  for (int i : system.root_to_leaves()) {
    if (i == 0) continue;
    const Body& body = system.body(i);
    const bool led = body.freedoms < 3;
    any_ = any_ || led;
    std::vector<int> before;  // that turn the body's joint
    for (int b = body.parent; led && b > 0; b = system.body(b).parent) {
      for (int f = 0; f < system.body(b).freedoms; ++f) before.push_back(shape_offset(system.body(b)) + f);
      if (system.body(b).freedoms == 3) break;
    }
    if (!led) free_body_.push_back({i, shape_offset(body)});
    for (int c : before) column_[at(c)].turned.push_back({i, Four3::zero(), Four3::zero()});
    for (int f = 0; f < body.freedoms; ++f) {
      const int place = shape_offset(body) + f;
      Column& column = column_[at(place)];
      column.body = i;
      column.freedom = f;
      column.led = led;
      column.turned.push_back({i, Four3::zero(), Four3::zero()});
      column.before = before;
      if (led) before.push_back(place);
    }
  }
}

void LedTurns::take(const std::vector<Four33>& shape) {
  shape_ = shape;
  for (Column& column : column_) {
    const Body& body = system_.body(column.body);
    const Joint& joint = system_.joint(body.joint);
    const Four33& own = shape_[at(column.body)];
    if (!column.led)
      column.axis = column.freedom == 0 ? own.x : column.freedom == 1 ? own.y : own.z;
    else if (joint.kind == model::JointKind::universal && column.freedom == 0)
      column.axis = shape_[at(body.parent)] * joint.parent_axis;
    else
      column.axis = own * joint.child_axis;
    for (Turned& turned : column.turned) turned.turn = transposed(shape_[at(turned.body)]) * column.axis;
  }
}

void LedTurns::gather(const Four3* moment, Four* along) const {
  for (const Column& column : column_) {
    Four sum{};
    for (const Turned& turned : column.turned) sum += dot(turned.turn, moment[turned.body - 1]);
    *along++ = sum;
  }
}

void LedTurns::spread(const Four* along, Four3* turn) {
  body_turn_[0] = Four3::zero();
  for (int i : system_.root_to_leaves()) {
    if (i == 0) continue;
    const Body& body = system_.body(i);
    Four3& own = body_turn_[at(i)];
    own = body.freedoms == 3 ? Four3::zero() : body_turn_[at(body.parent)];
    for (int f = 0; f < body.freedoms; ++f) {
      const int place = shape_offset(body) + f;
      own += along[place] * column_[at(place)].axis;
    }
    turn[i - 1] = transposed(shape_[at(i)]) * own;
  }
  for (Column& column : column_) {
    const Body& body = system_.body(column.body);
    const bool with_parent =
        column.led && column.freedom == 0 && system_.joint(body.joint).kind == model::JointKind::universal;
    column.axis_change = cross(body_turn_[at(with_parent ? body.parent : column.body)], column.axis);
    for (Turned& turned : column.turned)
      turned.change =
          transposed(shape_[at(turned.body)]) * (column.axis_change - cross(body_turn_[at(turned.body)], column.axis));
  }
}

void LedTurns::project_columns(int rows, const Four* by_bodies, Four* by_coordinates) const {
  for (const Column& column : column_) {
    for (int r = 0; r < rows; ++r) by_coordinates[r] = Four{};
    for (const Turned& turned : column.turned) {
      const Four3& turn = turned.turn;
      const Four* from = by_bodies + 3 * (turned.body - 1) * rows;
      for (int r = 0; r < rows; ++r)
        by_coordinates[r] += turn.x * from[r] + turn.y * from[rows + r] + turn.z * from[2 * rows + r];
    }
    by_coordinates += rows;
  }
}

void LedTurns::project_rows(int columns, const Four* by_bodies, int stride, Four* by_coordinates, int to_stride,
                            bool changes) const {
  for (int c = 0; c < columns; ++c, by_bodies += stride, by_coordinates += to_stride) {
    Four* to = by_coordinates;
    for (const Column& column : column_) {
      Four sum{};
      for (const Turned& turned : column.turned) {
        const Four3& turn = changes ? turned.change : turned.turn;
        const Four* from = by_bodies + 3 * (turned.body - 1);
        sum += turn.x * from[0] + turn.y * from[1] + turn.z * from[2];
      }
      *to++ = sum;
    }
  }
}

// Moments on all bodies that a coordinate turns, seen from the root.
Four3 LedTurns::pull(const Column& column, const Four3* moment) const {
  Four3 sum = Four3::zero();
  for (const Turned& turned : column.turned) sum += shape_[at(turned.body)] * moment[turned.body - 1];
  return sum;
}

void LedTurns::add_bend(const Four3* moment, Four* form, int stride) const {
  for (int b = 0; b < size(); ++b) {
    const Column& column = column_[at(b)];
    if (column.before.empty()) continue;
    const Four3 bent = cross(column.axis, pull(column, moment));
    for (int a : column.before) form[b * stride + a] += dot(column_[at(a)].axis, bent);
  }
}

void LedTurns::add_symmetric_bend(const Four3* moment, Four* form, int stride) const {
  for (int b = 0; b < size(); ++b) {
    const Column& column = column_[at(b)];
    if (column.before.empty()) continue;
    const Four3 bent = 0.5 * cross(column.axis, pull(column, moment));
    for (int a : column.before) {
      const Four value = dot(column_[at(a)].axis, bent);
      form[b * stride + a] += value;
      form[a * stride + b] += value;
    }
  }
}

void LedTurns::add_bend_change(const Four3* moment, const Four3* moment_change, Four* form, int stride) const {
  for (int b = 0; b < size(); ++b) {
    const Column& column = column_[at(b)];
    if (column.before.empty()) continue;
    const Four3 pulled = pull(column, moment);
    Four3 change = pull(column, moment_change);
    for (const Turned& turned : column.turned)
      change += cross(body_turn_[at(turned.body)], shape_[at(turned.body)] * moment[turned.body - 1]);
    const Four3 bent = 0.5 * cross(column.axis, pulled);
    const Four3 bent_change = 0.5 * (cross(column.axis_change, pulled) + cross(column.axis, change));
    for (int a : column.before) {
      const Column& other = column_[at(a)];
      const Four value = dot(other.axis_change, bent) + dot(other.axis, bent_change);
      form[b * stride + a] += value;
      form[a * stride + b] += value;
    }
  }
}

void LedTurns::add_twice_bent(int body, const Four3& moment, const Four* along, Four* form, int stride) const {
  const Four3 pulled = shape_[at(body)] * moment;
  for (int b = 0; b < size(); ++b) {  // nearer to the root
    const Column& first = column_[at(b)];
    if (first.before.empty()) continue;
    Four3 carried = Four3::zero();
    for (int a : first.before) carried += along[a] * column_[at(a)].axis;
    const Four3 once = cross(carried, first.axis);
    for (int c = 0; c < size(); ++c) {
      const Column& second = column_[at(c)];
      bool turns = false, after = c == b;
      for (const Turned& turned : second.turned) turns = turns || turned.body == body;
      for (int a : second.before) after = after || a == b;
      if (!second.led || !turns || !after) continue;
      const Four value = dot(cross(once, second.axis), pulled);
      form[c * stride + b] += value;
      if (c != b) form[b * stride + c] += value;
    }
  }
}

}  // namespace lamprey::shape
