// A limit that gives way by its excess is just kept, in the units of its bound.
#include "maneuver/limit_rows.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "chains.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using maneuver::LimitRow;
using Kind = LimitRow::Kind;

struct Case {
  Kind kind;
  double bound;
  double way;  // +1: the bound is an upper one
  const char* unit;
};

TEST(LimitRows, are_just_kept_when_they_give_way_by_their_excess) {
  const model::System system(paper_chain());
  const double h = 0.01;
  const mechanics::Rotations before{lie::exp(Vector3d(0.1, 0.2, -0.3)), lie::exp(Vector3d(0.7, -0.2, 0.1)),
                                    lie::exp(Vector3d(-0.4, 0.5, 0.9))};
  mechanics::Rotations now = before;
  now[1] = before[1] * lie::exp(Vector3d(0.03, -0.02, 0.05));
  const Vector3d position(0.2, -0.1, 0.3);
  VectorXd moment(system.control_count());
  for (Eigen::Index c = 0; c < moment.size(); ++c) moment[c] = 3.0 + static_cast<double>(c);
  const maneuver::LimitedNode node{now, before, position, moment, h, 100 * h};
  for (const Case& limit : {Case{Kind::torque, 2.0, 1.0, "N m"}, Case{Kind::torque_component, 1.5, 1.0, "N m"},
                            Case{Kind::swing, 0.3, 1.0, "rad"}, Case{Kind::twist, 0.01, 1.0, "rad"},
                            Case{Kind::speed, 2.0, 1.0, "rad/s"}, Case{Kind::clearance, 30.0, -1.0, "m"},
                            Case{Kind::not_longer, 0.4, 1.0, "s"}, Case{Kind::not_shorter, 2.5, -1.0, "s"}}) {
    LimitRow row;
    row.kind = limit.kind;
    row.joint = 0;
    row.component = 0;
    row.body = 0;
    row.other_body = 1;
    row.bound = limit.bound;
    row.unit = 0.7;
    const double value = maneuver::limit_value(system, row, node, 1e9);
    ASSERT_LT(value, 0.0) << row.unit_name() << " is kept: nothing is tested";
    EXPECT_STREQ(row.unit_name(), limit.unit);
    row.bound += limit.way * row.excess(-value, h);
    EXPECT_NEAR(maneuver::limit_value(system, row, node, 1e9), 0.0, tolerance(1e-12)) << limit.bound;
  }
}

// The paper's chain, its first joint a universal one with any axes and any zero.
model::System with_universal_joint(Random& random) {
  model::SwimmerDescription described = paper_chain();
  model::JointDescription& joint = described.joints[0];
  joint.kind = model::JointKind::universal;
  joint.reference_rotation = random.vector(0.5);
  const Matrix3d zero = lie::exp(joint.reference_rotation);
  const Vector3d second = random.vector().normalized();
  joint.axes = {(zero * second).cross(random.vector()).normalized(), second};
  return model::System(described);
}

// Two roads to the angles of a universal joint: twists of its rotation, and where each axis has moved the other.
TEST(LimitRows, of_angles_see_each_axis_of_a_universal_joint) {
  Random random(3);
  for (int sample = 0; sample < 20; ++sample) {
    const model::System system = with_universal_joint(random);
    const model::Joint& universal = system.joint(0);
    const Vector3d angles(random.uniform(-1.3, 1.3), random.uniform(-1.3, 1.3), 0.0);
    mechanics::Rotations R = {random.rotation(), Matrix3d::Identity(), random.rotation()};
    R[1] = R[0] * mechanics::joint_rotation(universal, angles);
    for (int axis = 0; axis < 2; ++axis)
      for (const Kind kind : {Kind::angle_above, Kind::angle_below}) {
        LimitRow row;
        row.kind = kind;
        row.joint = 0;
        row.component = axis;
        row.bound = 0.2;
        const double value = maneuver::limit_value(system, row, {R, R, Vector3d::Zero(), VectorXd(), 0.1, 1.0}, 1e9);
        EXPECT_NEAR(value, kind == Kind::angle_above ? angles[axis] - 0.2 : 0.2 - angles[axis], tolerance(1e-12));
      }
  }
}

// Of each axis of a universal joint by itself, across the cut of its angle too; what is broken is told in rad/s.
TEST(LimitRows, of_angle_rates_see_what_each_axis_turns_by_in_a_step) {
  Random random(5);
  constexpr double h = 0.1, bound = 2.0;
  for (int sample = 0; sample < 20; ++sample) {
    const model::System system = with_universal_joint(random);
    const Vector3d before(random.uniform(-1.3, 1.3), std::numbers::pi - 0.1, 0.0);
    const Vector3d change(random.uniform(-0.9, 0.9), random.uniform(0.11, 0.9), 0.0);
    const auto rotations = [&](const Vector3d& angles) {
      mechanics::Rotations R = {random.rotation(), Matrix3d::Identity(), random.rotation()};
      R[1] = R[0] * mechanics::joint_rotation(system.joint(0), angles);
      return R;
    };
    const mechanics::Rotations from = rotations(before), to = rotations(before + change);
    for (int axis = 0; axis < 2; ++axis)
      for (const Kind kind : {Kind::rate_above, Kind::rate_below}) {
        LimitRow row;
        row.kind = kind;
        row.joint = 0;
        row.component = axis;
        row.bound = bound;
        const double rate = (kind == Kind::rate_above ? 1.0 : -1.0) * change[axis] / h;
        const double value = maneuver::limit_value(system, row, {to, from, Vector3d::Zero(), VectorXd(), h, 1.0}, 1e9);
        EXPECT_NEAR(value, 1.0 + rate / bound, tolerance(1e-12));
        EXPECT_NEAR(row.excess(-value, h), -rate - bound, tolerance(1e-11));
      }
  }
}

// A joint of the paper's chain that turned by `angle` about an axis in a step of `time_step` s, its parent turned besides.
class Rate {
 public:
  Rate(double bound, double time_step, double angle) : time_step_(time_step) {
    row_.kind = Kind::speed;
    row_.joint = 0;
    row_.bound = bound;
    row_.unit = 0.7;
    const model::Joint& joint = system_.joint(0);
    now_ = before_;
    now_[at(joint.parent)] = before_[at(joint.parent)] * lie::exp(Vector3d(0.3, 0.1, -0.2));
    const Eigen::Matrix3d turned = lie::exp(angle * Vector3d(2.0, -1.0, 2.0) / 3.0);
    now_[at(joint.child)] = now_[at(joint.parent)] * mechanics::child_to_parent(before_, joint) * turned;
  }
  double price() const { return maneuver::price_of_bound(row_, time_step_, value()); }
  double value(double stretch = 1.0) const { return maneuver::limit_value(system_, row_, node(stretch), 1e9); }
  void derivatives(VectorXd& gradient, Eigen::MatrixXd& hessian, double stretch = 1.0) const {
    maneuver::limit_derivatives(system_, row_, node(stretch), gradient, hessian);
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  maneuver::LimitedNode node(double stretch) const {
    return {now_, before_, position_, moment_, stretch * time_step_, 100.0 * stretch * time_step_};
  }
  model::System system_{paper_chain()};
  LimitRow row_;
  double time_step_;
  mechanics::Rotations before_{lie::exp(Vector3d(0.1, 0.2, -0.3)), lie::exp(Vector3d(0.7, -0.2, 0.1)),
                               lie::exp(Vector3d(-0.4, 0.5, 0.9))};
  mechanics::Rotations now_;
  Vector3d position_ = Vector3d::Zero();
  VectorXd moment_ = VectorXd::Zero(6);
};

// A step shows half a turn at most: every motion keeps to a larger rate, and none to one just below it.
TEST(LimitRows, of_rates_beyond_half_a_turn_a_step_hold_in_every_motion) {
  for (const double angle : {0.0, 0.5, 2.0, 3.0, 3.14})
    for (const double allowed : {3.2, 2.0 * std::numbers::pi, 9.0, 12.0, 100.0})
      EXPECT_GT(Rate(allowed / 0.1, 0.1, angle).value(), 0.0) << angle << " of " << allowed;
  EXPECT_LT(Rate(3.1 / 0.1, 0.1, 3.14).value(), 0.0);
}

TEST(LimitRows, of_rates_have_the_derivatives_by_the_time_step_of_their_values) {
  for (const double allowed : {0.5, 2.0, 3.0, 3.3, 9.0}) {
    const Rate rate(allowed / 0.1, 0.1, 1.3);
    VectorXd gradient, ahead, behind;
    Eigen::MatrixXd hessian, unused;
    rate.derivatives(gradient, hessian);
    const Eigen::Index time = gradient.size() - 1;
    std::vector<double> error;
    for (const double step : {2e-3, 1e-3}) {
      const double slope = (rate.value(std::exp(step)) - rate.value(std::exp(-step))) / (2.0 * step);
      error.push_back(std::abs(slope - gradient[time]));
      rate.derivatives(ahead, unused, std::exp(step));
      rate.derivatives(behind, unused, std::exp(-step));
      const VectorXd bend = (ahead - behind) / (2.0 * step);
      error.push_back((bend - hessian.col(time)).norm());
    }
    EXPECT_NEAR(std::log2(error[0] / error[2]), 2.0, 0.1) << allowed;
    EXPECT_NEAR(std::log2(error[1] / error[3]), 2.0, 0.1) << allowed;
  }
}

// What is left to the bound is small beside 1 in short steps: no digits of it are lost.
TEST(LimitRows, of_rates_keep_their_digits_in_short_steps) {
  for (const double h : {1e-1, 1e-3, 1e-5}) {
    const double allowed = 2.0 * h, turned = 1.5 * h;
    const double expected = 4.0 * std::sin(0.5 * (allowed + turned)) * std::sin(0.5 * (allowed - turned)) /
                            (allowed * allowed) / 0.7;  // 2 cos a − 2 cos b as a product
    EXPECT_NEAR(Rate(2.0, h, turned).value() / expected, 1.0, tolerance(1e-15 / h)) << h;
  }
}

// Multipliers of rows are prices of their limits wherever the rows stand, at the bound or before it.
TEST(LimitRows, of_rates_have_the_price_of_the_rate_that_is_left) {
  constexpr double h = 0.1, e = 1e-5;
  for (const double bound : {2.0, 15.0, 30.0})
    for (const double rate : {0.5, 1.9, 14.0, 29.0}) {
      const double change =
          (Rate(bound, h, (rate - e) * h).value() - Rate(bound, h, (rate + e) * h).value()) / (2.0 * e);
      EXPECT_NEAR(Rate(bound, h, rate * h).price(), change, 1e-8 * std::abs(change)) << bound << ", " << rate;
    }
}

TEST(LimitRows, of_swing_have_the_price_of_the_angle_that_is_left) {
  const model::System system(paper_chain());
  constexpr double h = 0.1, e = 1e-5;
  const Vector3d position = Vector3d::Zero();
  const VectorXd moment = VectorXd::Zero(6);
  const model::Joint& joint = system.joint(0);
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (const double bound : {0.3, 1.5, 3.0})
    for (const double swing : {0.1, 0.7, 2.5}) {
      LimitRow row;
      row.kind = Kind::swing;
      row.joint = 0;
      row.bound = bound;
      row.unit = 0.7;
      const auto value =
          [&](double angle) {  // about an axis across the child's arm, which is along the parent's at zero
            mechanics::Rotations now(3, lie::exp(Vector3d(0.1, 0.2, -0.3)));
            const Vector3d across = joint.child_offset.cross(Vector3d(0.3, 1.0, -0.4)).normalized();
            now[at(joint.child)] = now[at(joint.child)] * lie::exp(angle * across);
            return maneuver::limit_value(system, row, {now, now, position, moment, h, 1.0}, 1e9);
          };
      ASSERT_LT(std::abs(value(bound)), 1e-12) << "arms of this chain are not along each other: nothing is tested";
      const double change = (value(swing - e) - value(swing + e)) / (2.0 * e);
      EXPECT_NEAR(maneuver::price_of_bound(row, h, value(swing)), change, 1e-8 * std::abs(change))
          << bound << ", " << swing;
    }
}

}  // namespace
}  // namespace lamprey::tests
