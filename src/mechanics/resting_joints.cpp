#include "mechanics/resting_joints.hpp"

#include <Eigen/Cholesky>

#include "lie/so3.hpp"

namespace lamprey::mechanics {

namespace {

using model::at;
using model::System;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Momentum = RestingJoints::Momentum;

}  // namespace

namespace resting {

// Something of the shape next to it: its value, its change along a first and a second direction, and along both.
template <typename T>
struct Expansion {
  T value, first, second, both;
};

template <typename T>
Expansion<T> constant(const T& value) {
  const T none = 0.0 * value;
  return {value, none, none, none};
}
template <typename T>
Expansion<T> operator+(const Expansion<T>& a, const Expansion<T>& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second, a.both + b.both};
}
template <typename T>
Expansion<T> operator-(const Expansion<T>& a, const Expansion<T>& b) {
  return {a.value - b.value, a.first - b.first, a.second - b.second, a.both - b.both};
}
// Of anything that is linear in a and in b.
template <typename A, typename B, typename Product>
auto product(const Expansion<A>& a, const Expansion<B>& b, const Product& of) {
  using T = decltype(of(a.value, b.value));
  return Expansion<T>{of(a.value, b.value), T(of(a.first, b.value) + of(a.value, b.first)),
                      T(of(a.second, b.value) + of(a.value, b.second)),
                      T(of(a.both, b.value) + of(a.first, b.second) + of(a.second, b.first) + of(a.value, b.both))};
}
template <typename A, typename Linear>
auto image(const Expansion<A>& a, const Linear& of) {
  using T = decltype(of(a.value));
  return Expansion<T>{of(a.value), of(a.first), of(a.second), of(a.both)};
}
Expansion<Vector3d> operator*(const Expansion<Matrix3d>& A, const Expansion<Vector3d>& v) {
  return product(A, v, [](const Matrix3d& M, const Vector3d& w) -> Vector3d { return M * w; });
}
Expansion<Vector3d> operator*(const Expansion<Matrix3d>& A, const Vector3d& v) {
  return image(A, [&](const Matrix3d& M) -> Vector3d { return M * v; });
}
Expansion<Vector3d> operator*(const Matrix3d& A, const Expansion<Vector3d>& v) {
  return image(v, [&](const Vector3d& w) -> Vector3d { return A * w; });
}
Expansion<Matrix3d> operator*(const Expansion<Matrix3d>& A, const Expansion<Matrix3d>& B) {
  return product(A, B, [](const Matrix3d& M, const Matrix3d& N) -> Matrix3d { return M * N; });
}
Expansion<Vector3d> cross(const Expansion<Vector3d>& u, const Expansion<Vector3d>& v) {
  return product(u, v, [](const Vector3d& a, const Vector3d& b) -> Vector3d { return a.cross(b); });
}
Expansion<Matrix3d> transposed(const Expansion<Matrix3d>& A) {
  return image(A, [](const Matrix3d& M) -> Matrix3d { return M.transpose(); });
}
Expansion<Matrix3d> hat(const Expansion<Vector3d>& v) {
  return image(v, [](const Vector3d& w) -> Matrix3d { return lie::hat(w); });
}

// A body next to the shape, seen from the root.
struct Placed {
  Expansion<Matrix3d> rotation;
  Expansion<Vector3d> centre, turn, shift;  // m, rad/s, m/s; the last two by rates of the joints
};

}  // namespace resting

using resting::constant;
using resting::Expansion;
using resting::Placed;

struct RestingJoints::Space {
  explicit Space(const System& of);
  void take(const Rotations& seen);
  void look_along(int first, int second);
  Expansion<Momentum> moved(const VectorXd& rates);
  Expansion<Matrix6d> locked() const;
  Eigen::Index count() const { return by_total.rows(); }
  Momentum by_total_of(Eigen::Index coordinate) const { return by_total.leftCols<6>().row(coordinate).transpose(); }

  const System& system;
  Rotations shape;
  Rotations axes;              // [bodies] of the joint that leads it
  std::vector<Freedoms> unit;  // [f] one coordinate alone
  std::vector<Vectors> turn;   // [f][bodies] what it turns, body frames
  Vectors change, changed;     // [bodies] how turns change
  Freedoms rate;
  std::vector<Placed> placed;     // [bodies]
  Eigen::LLT<Matrix6d> whole;     // inertia of all
  MatrixXd by_total;              // [f][6]
  VectorXd one;                   // [f]
  std::vector<Matrix6d> by_turn;  // [f] of the inertia
  std::vector<Momentum> answer;   // [f] of what multiplies the total
};

RestingJoints::Space::Space(const System& of)
    : system(of),
      shape(at(of.body_count()), Matrix3d::Identity()),
      axes(shape),
      change(shape.size(), Vector3d::Zero()),
      changed(change),
      rate(change),
      placed(shape.size()),
      by_total(MatrixXd::Zero(of.velocity_count() - 6, 6)),
      one(by_total.rows()),
      by_turn(static_cast<std::size_t>(by_total.rows())),
      answer(by_turn.size()) {
  VectorXd all(of.velocity_count());
  for (Eigen::Index c = 0; c < count(); ++c) {
    unit.emplace_back(shape.size(), Vector3d::Zero());
    unpack(of, all.setUnit(3 + c), unit.back());
    turn.emplace_back(shape.size(), Vector3d::Zero());
  }
}

// The bodies next to the shape along two coordinates, and along both: Q exp(η̂ + …), to second order.
void RestingJoints::Space::look_along(int first, int second) {
  const Vectors &a = turn[at(first)], &b = turn[at(second)];
  body_turn_changes(system, shape, unit[at(first)], a, unit[at(second)], change);
  body_turn_changes(system, shape, unit[at(second)], b, unit[at(first)], changed);
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    const Matrix3d& Q = shape[at(i)];
    const Matrix3d A = lie::hat(a[at(i)]), B = lie::hat(b[at(i)]);
    Placed& now = placed[at(i)];
    now.rotation = {Q, Q * A, Q * B, 0.5 * (Q * (A * B + B * A + lie::hat(change[at(i)] + changed[at(i)])))};
    now.centre = constant(Vector3d(Vector3d::Zero()));
    if (body.parent < 0) continue;
    const model::Joint& joint = system.joint(body.joint);
    const Placed& before = placed[at(body.parent)];
    now.centre = before.centre + before.rotation * joint.parent_offset - now.rotation * joint.child_offset;
  }
}

// The whole's momentum where the joints turn at these rates and the root stands.
Expansion<Momentum> RestingJoints::Space::moved(const VectorXd& rates) {
  for (int i = 1; i < system.body_count(); ++i)
    for (int f = 0; f < system.body(i).freedoms; ++f) rate[at(i)][f] = rates[system.body(i).velocity_offset - 3 + f];
  Expansion<Vector3d> angular = constant(Vector3d(Vector3d::Zero())), linear = angular;
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    Placed& now = placed[at(i)];
    if (body.parent < 0) {
      now.turn = now.shift = constant(Vector3d(Vector3d::Zero()));
      continue;
    }
    const model::Joint& joint = system.joint(body.joint);
    const Placed& before = placed[at(body.parent)];
    if (body.freedoms == 3) {
      now.turn = now.rotation * rate[at(i)];
    } else {
      // a first axis of two stays with the parent, the last with the child
      now.turn = before.turn;
      const int last = body.freedoms - 1;
      if (last == 1)
        now.turn =
            now.turn + before.rotation * Vector3d(child_to_parent(shape, joint) * axes[at(i)].col(0) * rate[at(i)][0]);
      if (last >= 0) now.turn = now.turn + now.rotation * Vector3d(axes[at(i)].col(last) * rate[at(i)][last]);
    }
    now.shift = before.shift + cross(before.turn, before.rotation * joint.parent_offset) -
                cross(now.turn, now.rotation * joint.child_offset);
    const Expansion<Matrix3d> to_body = transposed(now.rotation);
    const Expansion<Vector3d> own_turn = to_body * now.turn, own_shift = to_body * now.shift;
    const Expansion<Vector3d> push = now.rotation * (body.mass_matrix * own_shift + body.coupling_matrix * own_turn);
    const Matrix3d coupled = body.coupling_matrix.transpose();
    const Expansion<Vector3d> spin = now.rotation * (body.inertia_matrix * own_turn + coupled * own_shift);
    linear = linear + push;
    angular = angular + spin + cross(now.centre, push);
  }
  const auto both = [](const Vector3d& first, const Vector3d& second) {
    Momentum one_after_other;
    one_after_other << first, second;
    return one_after_other;
  };
  return {both(angular.value, linear.value), both(angular.first, linear.first), both(angular.second, linear.second),
          both(angular.both, linear.both)};
}

// Inertia of the whole, moving as one.
Expansion<Matrix6d> RestingJoints::Space::locked() const {
  Expansion<Matrix3d> turning = constant(Matrix3d(Matrix3d::Zero())), mixed = turning, moving = turning;
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    const Expansion<Matrix3d>& Q = placed[at(i)].rotation;
    const auto seen = [&](const Matrix3d& own) { return Q * constant(own) * transposed(Q); };
    const Expansion<Matrix3d> M = seen(body.mass_matrix), C = seen(body.coupling_matrix),
                              lever = hat(placed[at(i)].centre);
    const Expansion<Matrix3d> by_turn_of_whole = C - M * lever;
    moving = moving + M;
    mixed = mixed + by_turn_of_whole;
    turning = turning + seen(body.inertia_matrix) - transposed(C) * lever + lever * by_turn_of_whole;
  }
  const auto put = [](const Matrix3d& J, const Matrix3d& C, const Matrix3d& M) {
    Matrix6d all;
    all << J, C.transpose(), C, M;
    return all;
  };
  return {put(turning.value, mixed.value, moving.value), put(turning.first, mixed.first, moving.first),
          put(turning.second, mixed.second, moving.second), put(turning.both, mixed.both, moving.both)};
}

void RestingJoints::Space::take(const Rotations& seen) {
  shape = seen;
  for (int i = 1; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    axes[at(i)] = joint_frame(system.joint(body.joint), shape[at(body.parent)], shape[at(i)]).axes;
  }
  for (Eigen::Index c = 0; c < count(); ++c)
    body_turns(system, shape, unit[static_cast<std::size_t>(c)], turn[static_cast<std::size_t>(c)]);
  if (count() == 0) return;
  look_along(0, 0);
  whole.compute(locked().value);
  for (Eigen::Index c = 0; c < count(); ++c) by_total.row(c) = whole.solve(moved(one.setUnit(c)).value).transpose();
}

RestingJoints::RestingJoints(const System& system) : space_(std::make_unique<Space>(system)) {}
RestingJoints::~RestingJoints() = default;
RestingJoints::RestingJoints(RestingJoints&&) noexcept = default;
RestingJoints& RestingJoints::operator=(RestingJoints&&) noexcept = default;

void RestingJoints::take(const Rotations& shape) { space_->take(shape); }

const MatrixXd& RestingJoints::by_total() const { return space_->by_total; }

// d(L⁻¹ m) = L⁻¹ (dm − dL L⁻¹ m), with ω = L⁻¹ total on its left.
void RestingJoints::rates(const Momentum& total, MatrixXd& rates) {
  Space& s = *space_;
  const Momentum velocity = s.whole.solve(total);
  for (Eigen::Index a = 0; a < s.count(); ++a) {
    s.look_along(static_cast<int>(a), static_cast<int>(a));
    const Momentum carried = s.locked().first * velocity;
    for (Eigen::Index c = 0; c < s.count(); ++c)
      rates(c, a) = velocity.dot(s.moved(s.one.setUnit(c)).first) - carried.dot(s.by_total_of(c));
  }
}

void RestingJoints::curvature(const VectorXd& multiplier, const Momentum& total, MatrixXd& form, MatrixXd& by_total) {
  Space& s = *space_;
  const Momentum velocity = s.whole.solve(total);
  Momentum answer = Momentum::Zero();
  for (Eigen::Index c = 0; c < s.count(); ++c) answer += multiplier[c] * s.by_total_of(c);
  const auto count = static_cast<int>(s.count());
  for (int a = 0; a < count; ++a) {
    s.look_along(a, a);
    s.by_turn[at(a)] = s.locked().first;
    s.answer[at(a)] = s.whole.solve(Momentum(s.moved(multiplier).first - s.by_turn[at(a)] * answer));
    by_total.row(a) = s.answer[at(a)].transpose();
  }
  for (int a = 0; a < count; ++a)
    for (int b = 0; b <= a; ++b) {
      s.look_along(a, b);
      const Momentum twice = s.moved(multiplier).both - s.locked().both * answer - s.by_turn[at(a)] * s.answer[at(b)] -
                             s.by_turn[at(b)] * s.answer[at(a)];
      form(a, b) = form(b, a) = velocity.dot(twice);
    }
}

}  // namespace lamprey::mechanics
