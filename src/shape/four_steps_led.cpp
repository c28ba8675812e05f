// What it takes where joints lead their children: from the bodies' turns to coordinates, which bend (equations 9.21 to
// 9.25), and springs and dampers of angles (8.16, 8.17).
#include <algorithm>
#include <cmath>

#include "lie/so3.hpp"
#include "shape/four_steps.hpp"
#include "shape/step_lanes.hpp"

namespace lamprey::shape {

namespace {

using mechanics::Four;
using mechanics::Four3;
using mechanics::Four33;
using mechanics::Moments;
using mechanics::Rotations;
using model::at;

}  // namespace

// Of V by the bodies' turns at both ends.
void FourSteps::find_gradient() {
  Four scale;
  find_momenta(scale);
  for (int i = 1; i < system_.body_count(); ++i) {
    gradient_[at(at_left(i))] = -momentum_at_left(i);
    gradient_[at(at_right(i))] = momenta_[at(i)].turn;
  }
}

// How it changes along the multipliers, the root turning and shifting as given.
void FourSteps::find_gradient_change(const Four3& of_turn, const Four3& of_shift) {
  const int count = 2 * shapes();
  const auto& H = second_.block;
  for (int r = 0; r < count; ++r) {
    Four3 sum = H[place(r, at_right(0))] * of_turn + H[place(r, at_shift())] * of_shift;
    for (int c = 0; c < count; ++c) sum += H[place(r, c)] * shape_vector_[at(c)];
    gradient_change_[at(r)] = sum;
  }
}

// Multipliers along the coordinates as turns of the bodies.
void FourSteps::spread_multipliers(const ForFour<const ShapeMultipliers*>& multipliers) {
  const int n = led_left_.size();
  for (int a = 0; a < n; ++a)
    for (std::size_t l = 0; l < 4; ++l) {
      const auto along = [&](const VectorXd& values) {
        return all_coordinates_ ? values[a] : coordinates_.row(a).dot(values.transpose());
      };
      along_[at(a)][l] = -along(multipliers[l]->minus);
      along_[at(n + a)][l] = -along(multipliers[l]->plus);
    }
  led_left_.spread(along_.data(), shape_vector_.data());
  led_right_.spread(along_.data() + n, shape_vector_.data() + shapes());
}

// Columns of both ends, [rows][6 (bodies − 1)], as columns of their coordinates.
void FourSteps::project_ends(int rows, const std::vector<Four>& by_bodies, std::vector<Four>& by_coordinates) const {
  led_left_.project_columns(rows, by_bodies.data(), by_coordinates.data());
  led_right_.project_columns(rows, by_bodies.data() + 3 * shapes() * rows,
                             by_coordinates.data() + led_left_.size() * rows);
}

// Both columns and rows; through half_.
void FourSteps::project_form(const std::vector<Four>& by_bodies, std::vector<Four>& by_coordinates) {
  const int size = 6 * shapes(), n = led_left_.size();
  project_ends(size, by_bodies, half_);
  led_left_.project_rows(2 * n, half_.data(), size, by_coordinates.data(), 2 * n);
  led_right_.project_rows(2 * n, half_.data() + 3 * shapes(), size, by_coordinates.data() + n, 2 * n);
}

void FourSteps::take_compliant_angles(const ForFour<const Rotations*>& left, const ForFour<const Rotations*>& right) {
  for (CompliantAngle& angle : compliant_) {
    const model::Joint& joint = system_.joint(angle.joint);
    for (std::size_t l = 0; l < 4; ++l) {
      const auto at_end = [&](const Rotations& shape) {
        return mechanics::joint_angles(joint, mechanics::child_to_parent(shape, joint))[angle.freedom];
      };
      angle.left[l] = at_end(*left[l]);
      angle.right[l] = at_end(*right[l]);
      angle.turn[l] = lie::shorter_way(angle.right[l] - angle.left[l]);
    }
  }
}

// E⁻ and E⁺ along the coordinates at both ends: half of a spring's moment at each (equation 8.16), a damper's twice (8.17).
void FourSteps::add_compliant_momenta(Four* along) const {
  for (const CompliantAngle& angle : compliant_) {
    const double spring = 0.5 * time_step_ * angle.stiffness, damper = 0.5 * angle.damping;
    along[angle.place] += spring * angle.left + damper * angle.turn;
    along[led_left_.size() + angle.place] -= spring * angle.right + damper * angle.turn;
  }
}

// And −E⁻ and E⁺ by the coordinates. Nothing is left of these in curvature.
void FourSteps::add_compliant_rates(Four* form) const {
  const int n = led_left_.size(), stride = 2 * n;
  for (const CompliantAngle& angle : compliant_) {
    const double spring = 0.5 * time_step_ * angle.stiffness, damper = 0.5 * angle.damping;
    const int left = angle.place, right = n + angle.place;
    form[left * stride + left] += damper - spring;
    form[right * stride + left] -= Four{} + damper;
    form[left * stride + right] += Four{} + damper;
    form[right * stride + right] -= Four{} + (damper + spring);
  }
}

// A ball joint's moment acts on its parent as it is, in the parent's frame.
template <typename Add>
void FourSteps::for_moments_on_turning_parents(const ForFour<const Moments*>& control, const Add& add) const {
  for (int j = 0; j < system_.joint_count(); ++j) {
    const model::Joint& joint = system_.joint(j);
    if (!joint.free() || joint.parent == 0) continue;
    add(joint,
        (0.5 * time_step_) * vectors_of_lanes([&](std::size_t l) -> const Vector3d& { return (*control[l])[at(j)]; }));
  }
}

// What a tangent has besides: the coordinates' turns change under momenta and moments.
void FourSteps::bend_tangent(const ForFour<const Moments*>& control, const ForFour<const Moments*>& control_next) {
  find_gradient();
  gradient_change_ = gradient_;
  for_moments_on_turning_parents(control, [&](const model::Joint& joint, const Four3& impulse) {
    gradient_change_[at(at_left(joint.parent))] += impulse;
  });
  for_moments_on_turning_parents(control_next, [&](const model::Joint& joint, const Four3& impulse) {
    gradient_change_[at(at_right(joint.parent))] += impulse;
  });
  std::fill(bend_.begin(), bend_.end(), Four{});
  const int stride = 2 * led_left_.size();
  led_left_.add_bend(gradient_change_.data(), bend_of(false), stride);
  led_right_.add_bend(gradient_change_.data() + shapes(), bend_of(true), stride);
  add_compliant_rates(bend_.data());
}

// And what the Hessian along the multipliers has, after find_gradient_change.
void FourSteps::bend_curvature(const ForFour<const Moments*>& control, const ForFour<const Moments*>& control_next) {
  const int size = 6 * shapes(), n = led_left_.size(), stride = 2 * n, s = shapes();
  lay(symmetric_, flat_);
  project_ends(size, flat_, seen_);
  led_left_.project_rows(stride, seen_.data(), size, turned_.data(), stride, true);
  led_right_.project_rows(stride, seen_.data() + 3 * s, size, turned_.data() + n, stride, true);
  for (int c = 0; c < stride; ++c)
    for (int r = 0; r < stride; ++r)
      bend_[at(c * stride + r)] = turned_[at(c * stride + r)] + turned_[at(r * stride + c)];

  led_left_.project_rows(stride, seen_.data(), size, turned_.data(), stride);
  led_right_.project_rows(stride, seen_.data() + 3 * s, size, turned_.data() + n, stride);
  led_left_.add_symmetric_bend(gradient_.data(), turned_.data(), stride);
  led_right_.add_symmetric_bend(gradient_.data() + s, turned_.data() + n * (stride + 1), stride);
  for (const bool right : {false, true}) {
    const ForFour<const Moments*>& moments = right ? control_next : control;
    const std::vector<Four33>& Q = right ? right_ : left_;
    const int first = right ? s : 0;
    let_fields_turn(right);
    for_moments_on_turning_parents(moments, [&](const model::Joint& joint, const Four3& impulse) {
      const Four33 to_parent = transposed(Q[at(joint.parent)]) * Q[at(joint.child)];
      gradient_change_[at(first + joint.parent - 1)] +=
          cross(to_parent * shape_vector_[at(first + joint.child - 1)], impulse);
      led(right).add_twice_bent(joint.parent, impulse, along_.data() + (right ? n : 0), bend_of(right), stride);
    });
    led(right).add_bend_change(gradient_.data() + first, gradient_change_.data() + first, bend_of(right), stride);
  }
}

// The fields along which bodies turn on their own do not commute with the multipliers'; turned_: V's Hessian.
void FourSteps::let_fields_turn(bool right) {
  const int stride = 2 * led_left_.size(), place = right ? led_left_.size() : 0;
  for (const LedTurns::FreeBody& free : led(right).free_bodies()) {
    const Four3& turn = shape_vector_[at((right ? shapes() : 0) + free.body - 1)];
    const int first = place + free.place;
    for (int c = 0; c < stride; ++c) {
      const Four* from = turned_.data() + c * stride + first;
      const Four3 carried = cross(turn, Four3{from[0], from[1], from[2]});
      Four* column = bend_.data() + c * stride + first;
      column[0] += carried.x, column[1] += carried.y, column[2] += carried.z;
      Four* row = bend_.data() + first * stride + c;  // V's Hessian is symmetric
      row[0] += carried.x, row[stride] += carried.y, row[2 * stride] += carried.z;
    }
  }
}

}  // namespace lamprey::shape
