#include "shape/four_steps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shape/step_lanes.hpp"

namespace lamprey::shape {

namespace {

using Eigen::Index;
using maneuver::is_identity;
using maneuver::shape_offset;
using maneuver::shape_size;
using mechanics::DiscreteLagrangian;
using mechanics::Four;
using mechanics::Four3;
using mechanics::Four33;
using mechanics::Rotations;
using model::at;
using model::System;

constexpr int most_rounds = 40;
constexpr double slowly = 3e-2;            // contraction that calls for a new inverse
constexpr double longest_root_turn = 0.5;  // rad, of the root in one iteration
constexpr double lost = 10.0;              // rad, a turn that leads nowhere

Four absolute(const Four& a) { return a < 0.0 ? -a : a; }
Four larger(const Four& a, const Four& b) { return a > b ? a : b; }
Four largest(const Four3& v) { return larger(absolute(v.x), larger(absolute(v.y), absolute(v.z))); }
double largest(const Four& a) { return std::max(std::max(a[0], a[1]), std::max(a[2], a[3])); }

Four33 identity() { return plus_identity(Four33::zero()); }

// (I + v̂)(I − v̂)⁻¹, v half the turn.
Four33 cayley(const Four3& v) {
  const Four factor = 2.0 / (1.0 + dot(v, v));
  return plus_identity(factor * plus_hat(minus_diagonal(dyad(v, v), dot(v, v)), v));
}

// Next to a rotation: R (3 I − RᵀR)/2.
Four33 renormalized(const Four33& R) {
  return R * (-0.5 * minus_diagonal(transposed(R) * R, Four{3.0, 3.0, 3.0, 3.0}));
}

}  // namespace

bool FourSteps::serves(const System& system, DiscreteLagrangian lagrangian) {
  for (const model::Joint& joint : system.joints())
    if (joint.free() && (joint.stiffness != 0.0 || joint.damping != 0.0)) return false;
  return shape_size(system) > 0 && !system.coupled() && lagrangian != DiscreteLagrangian::paper;
}

FourSteps::FourSteps(const System& system, DiscreteLagrangian lagrangian, const MatrixXd& coordinates)
    : system_(system),
      at_half_way_(lagrangian == DiscreteLagrangian::midpoint),
      coordinates_(coordinates),
      all_coordinates_(is_identity(coordinates)),
      noise_(system),
      left_(at(system.body_count()), identity()),
      right_(left_),
      momenta_(at(system.body_count())),
      led_left_(system),
      led_right_(system) {
  const auto count = at(system.body_count());
  second_.body.resize(count);
  third_.body.resize(count);
  second_.block.assign(at(blocks() * blocks()), Four33::zero());
  third_.block.assign(at(blocks() * blocks()), mechanics::ThreeByThree<algebra::DualFour>::zero());
  answer_turn_.resize(at(2 * shapes()));
  answer_shift_.resize(at(2 * shapes()));
  half_turn_ = half_shift_ = pose_turn_ = pose_shift_ = by_turn_ = answer_turn_;
  shape_vector_.resize(at(2 * shapes()));
  form_.resize(at(4 * shapes() * shapes()));
  symmetric_.resize(form_.size());
  takes_effort_ = all_coordinates_;
  for (const model::Joint& joint : system.joints())
    takes_effort_ = takes_effort_ && joint.free() && joint.actuation.cols() == 3;
  plus_.resize(at(2 * shapes() * shapes()));
  moment_.resize(at(3 * shapes() * shapes()));
  weighed_ = moment_;
  moment_form_.resize(at(9 * shapes() * shapes()));
  by_control_.resize(at(shapes() * shapes()));
  const int size = 6 * shapes(), along = 2 * static_cast<int>(coordinates.rows());
  flat_.resize(at(size * size));
  half_.resize(flat_.size());
  if (!led_left_.any()) return;
  for (int i = 1; i < system.body_count(); ++i) {
    const model::Joint& joint = system.joint(system.body(i).joint);
    for (int f = 0; f < system.body(i).freedoms && (joint.stiffness != 0.0 || joint.damping != 0.0); ++f)
      compliant_.push_back({system.body(i).joint, f, shape_offset(system.body(i)) + f, joint.stiffness, joint.damping,
                            Four{}, Four{}, Four{}});
  }
  gradient_ = gradient_change_ = shape_vector_;
  along_.resize(at(along));
  bend_.resize(at(along * along));
  turned_ = bend_;
  seen_.resize(at(size * along));
}

void FourSteps::take_shapes(double time_step, const ForFour<const Rotations*>& left,
                            const ForFour<const Rotations*>& right) {
  time_step_ = time_step;
  for (int i = 1; i < system_.body_count(); ++i) {
    left_[at(i)] = matrices_of_lanes([&](std::size_t l) -> const Matrix3d& { return (*left[l])[at(i)]; });
    right_[at(i)] = matrices_of_lanes([&](std::size_t l) -> const Matrix3d& { return (*right[l])[at(i)]; });
  }
  if (!led_left_.any()) return;
  led_left_.take(left_);
  led_right_.take(right_);
  take_compliant_angles(left, right);
}

void FourSteps::take_root(const ForFour<const ShapeStep*>& step) {
  turn_ = renormalized(matrices_of_lanes([&](std::size_t l) -> const Matrix3d& { return step[l]->root_turn; }));
  shift_ = vectors_of_lanes([&](std::size_t l) -> const Vector3d& { return step[l]->root_shift; });
}

// Gradients by the bodies' turns at the end, and forces; scale: the largest of what is summed.
void FourSteps::find_momenta(Four& scale) {
  const double rate = 1.0 / time_step_;
  scale = Four{};
  for (int i : system_.root_to_leaves()) {
    const model::Body& body = system_.body(i);
    Momenta& m = momenta_[at(i)];
    m.right = i == 0 ? turn_ : turn_ * right_[at(i)];
    m.shift = shift_;
    m.arm = Four3::zero();
    if (i > 0) {
      const Momenta& p = momenta_[at(body.parent)];
      const Vector3d &a = parent_offset(system_, i), b = child_offset(system_, i);
      m.shift = p.shift + (p.right - left_[at(body.parent)]) * a - (m.right - left_[at(i)]) * b;
      m.arm = p.arm + p.right * a - m.right * b;
    }
    if (at_half_way_) {
      m.half_way = HalfWay<Four>(body.mass_matrix, left_[at(i)], m.right, m.shift);
      m.own = rate * m.half_way.by_shift();
      m.left_turn = rate * m.half_way.by_left();
      m.turn = rate * m.half_way.by_right();
    } else {
      const Four3 left_seen = transposed(left_[at(i)]) * m.shift;
      m.right_seen = transposed(m.right) * m.shift;
      const Four3 p_left = (0.5 * rate) * (body.mass_matrix * left_seen);
      const Four3 p_right = (0.5 * rate) * (body.mass_matrix * m.right_seen);
      m.own = left_[at(i)] * p_left + m.right * p_right;
      m.left_turn = cross(p_left, left_seen);
      m.turn = cross(p_right, m.right_seen);
    }
    m.force = m.own;
    m.turn += rate * vee_twice(body.trace_weight * (transposed(left_[at(i)]) * m.right));
    scale = larger(scale, larger(largest(m.turn), noise_.length * largest(m.own)));
  }
  for (auto i = system_.root_to_leaves().rbegin(); i != system_.root_to_leaves().rend(); ++i) {
    Momenta& m = momenta_[at(*i)];
    if (*i == 0) break;
    Momenta& p = momenta_[at(system_.body(*i).parent)];
    p.force += m.force;
    m.turn -= cross(child_offset(system_, *i), transposed(m.right) * m.force);
    const Four3 by_child = cross(parent_offset(system_, *i), transposed(p.right) * m.force);
    p.turn += by_child;
    scale = larger(scale, larger(largest(m.turn), largest(by_child)));
  }
}

FourSteps::RightEnd FourSteps::right_end(int i) const {
  const double rate = 1.0 / time_step_;
  const model::Body& body = system_.body(i);
  const Momenta& m = momenta_[at(i)];
  const Matrix3d& M = body.mass_matrix;
  const Four33 &L = left_[at(i)], &R = m.right;
  const Four33 X = body.trace_weight * (transposed(L) * R);
  const Four33 of_turn = minus_diagonal(transposed(X), trace(X));
  if (at_half_way_) {
    const HalfWay<Four>::Second second = m.half_way.second(M);
    return {rate * second.shift_shift, rate * (R * second.shift_right * transposed(R)),
            rate * (R * (second.right_right - of_turn) * transposed(R))};
  }
  const Four3& w = m.right_seen;
  const Four3 Mw = M * w;
  const Four33 Mw_hat = times_hat(M, w);
  const Four33 of_shift = minus_diagonal(dyad(w, Mw), dot(Mw, w)) - hat_times(w, Mw_hat);
  return {(0.5 * rate) * (L * (M * transposed(L)) + R * (M * transposed(R))),
          (0.5 * rate) * (R * plus_hat(Mw_hat, -Mw) * transposed(R)),
          rate * (R * (0.5 * of_shift - of_turn) * transposed(R))};
}

// The Hessian by the root's turn (seen from the root at the beginning) and shift, all bodies following it.
void FourSteps::find_root_inverse() {
  Four33 by_shift = Four33::zero(), by_turn = Four33::zero();
  root_.shift_by_turn = Four33::zero();
  for (int i = 0; i < system_.body_count(); ++i) {
    const Momenta& m = momenta_[at(i)];
    const RightEnd own = right_end(i);
    const Four33 along_turn = own.shift_by_turn - times_hat(own.by_shift, m.arm);
    by_shift += own.by_shift;
    root_.shift_by_turn += along_turn;
    by_turn += hat_times(m.arm, along_turn) - times_hat(transposed(own.shift_by_turn), m.arm) + own.by_turn +
               second_turn(m.own, m.arm);
  }
  root_.shift_inverse = inverse(by_shift);
  root_.turn_inverse = inverse(by_turn - transposed(root_.shift_by_turn) * (root_.shift_inverse * root_.shift_by_turn));
}

void FourSteps::RootInverse::apply(Four3& turn, Four3& shift) const {
  turn = turn_inverse * (turn - transposed(shift_by_turn) * (shift_inverse * shift));
  shift = shift_inverse * (shift - shift_by_turn * turn);
}

bool FourSteps::solve(const ForFour<ShapeStep*>& step) {
  take_root({step[0], step[1], step[2], step[3]});
  const double noise = noise_.of_rotations(time_step_);
  Four before = Four{} + std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < most_rounds; ++iteration) {
    Four scale;
    find_momenta(scale);
    Four3 turn = Four3::zero(), shift = momenta_[0].force;
    for (const Momenta& m : momenta_) turn += m.right * m.turn;
    const Four residual = larger(largest(turn), noise_.length * largest(shift));
    const auto open =
        ~((residual <= MomentumNoise::of_sums * scale) | ((residual <= noise) & (residual >= 0.5 * before)));
    if (!(open[0] || open[1] || open[2] || open[3])) {
      read_momenta(step);
      return true;
    }
    const Four contraction = open ? residual / before : Four{};
    if (iteration == 0 || largest(contraction) > slowly) find_root_inverse();
    root_.apply(turn, shift);
    const Four turned = open ? algebra::square_root(dot(turn, turn)) : Four{};
    if (!(turned[0] < lost && turned[1] < lost && turned[2] < lost && turned[3] < lost)) return false;
    const Four share = open ? -(turned > longest_root_turn ? longest_root_turn / turned : Four{} + 1.0) : Four{};
    turn_ = cayley((0.5 * share) * turn) * turn_;
    shift_ += share * shift;
    before = residual;
  }
  return false;
}

// −∂L/∂η of a body, after find_momenta.
Four3 FourSteps::momentum_at_left(int i) const {
  const double rate = 1.0 / time_step_;
  const model::Body& body = system_.body(i);
  const Momenta& m = momenta_[at(i)];
  const Four33& L = left_[at(i)];
  Four3 minus = rate * vee_twice((transposed(L) * m.right) * body.trace_weight) - m.left_turn -
                cross(child_offset(system_, i), transposed(L) * m.force);
  for (int c : body.children) minus += cross(parent_offset(system_, c), transposed(L) * momenta_[at(c)].force);
  return minus;
}

void FourSteps::read_momenta(const ForFour<ShapeStep*>& step) {
  Four3 angular = Four3::zero();
  Four largest_square = Four{};
  for (int i = 0; i < system_.body_count(); ++i) {
    const Four3 minus = momentum_at_left(i);
    angular += left_[at(i)] * minus;
    largest_square = larger(largest_square, dot(minus, minus));
    if (i == 0) continue;
    shape_vector_[at(at_left(i))] = minus;
    shape_vector_[at(at_right(i))] = momenta_[at(i)].turn;
  }
  Matrix3d turn[4];
  mechanics::write_four(turn_, turn[0], turn[1], turn[2], turn[3]);
  const bool led = led_left_.any();
  if (led) {
    led_left_.gather(shape_vector_.data(), along_.data());
    led_right_.gather(shape_vector_.data() + shapes(), along_.data() + led_left_.size());
    add_compliant_momenta(along_.data());
  }
  const auto along_coordinates = [&](int first, std::size_t l, VectorXd& values) {
    values.setZero(coordinates_.cols());
    if (led) {
      const Four* of_all = along_.data() + (first == 0 ? 0 : led_left_.size());
      for (int a = 0; a < led_left_.size(); ++a) {
        if (all_coordinates_)
          values[a] = of_all[a][l];
        else
          for (Index c = 0; c < values.size(); ++c) values[c] += coordinates_(a, c) * of_all[a][l];
      }
      return;
    }
    for (int j = 0; j < shapes(); ++j) {
      const Four3& of_all = shape_vector_[at(first + j)];
      const Vector3d one(of_all.x[l], of_all.y[l], of_all.z[l]);
      if (all_coordinates_)
        values.segment<3>(3 * j) = one;
      else
        for (Index c = 0; c < values.size(); ++c) values[c] += coordinates_.col(c).segment<3>(3 * j).dot(one);
    }
  };
  const Four3& linear = momenta_[0].force;
  for (std::size_t l = 0; l < 4; ++l) {
    step[l]->root_turn = turn[l];
    step[l]->root_shift = Vector3d(shift_.x[l], shift_.y[l], shift_.z[l]);
    along_coordinates(0, l, step[l]->minus);
    along_coordinates(shapes(), l, step[l]->plus);
    step[l]->momentum << angular.x[l], angular.y[l], angular.z[l], linear.x[l], linear.y[l], linear.z[l];
    step[l]->largest_momentum = std::sqrt(largest_square[l]);
  }
}

}  // namespace lamprey::shape
