#include "maneuver/tracking.hpp"

#include <algorithm>

#include "algebra/row_space.hpp"
#include "lie/so3.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/random.hpp"
#include "mechanics/connection.hpp"

namespace lamprey::maneuver {

namespace {

using model::at;
using model::System;

constexpr double answered = 1e-9;         // of the largest gain
constexpr double surely_answered = 0.05;  // rad

}  // namespace

Start turned_start(const System& system, const Start& start, double angle, std::uint64_t seed, const MatrixXd& turns) {
  Random random(seed);
  VectorXd drawn(turns.cols());
  for (double& entry : drawn) entry = random.normal();
  const VectorXd turn = turns * drawn;
  mechanics::Rotations R;
  for (const Eigen::Vector3d& vector : start.rotation) R.push_back(lie::exp(vector));
  mechanics::Rotations turned = R;
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    for (int f = 0; f < body.freedoms; ++f) along[f] = turn[body.velocity_offset + f];
    if (along.norm() > answered * turn.norm()) along *= angle / along.norm();
    if (body.freedoms == 3) {
      turned[at(i)] = R[at(i)] * lie::exp(along);
      continue;
    }
    const model::Joint& joint = system.joint(body.joint);
    const Eigen::Vector3d angles = mechanics::joint_angles(joint, mechanics::child_to_parent(R, joint));
    turned[at(i)] = turned[at(body.parent)] * mechanics::joint_rotation(joint, angles + along);
  }
  Start off = start;
  for (std::size_t i = 0; i < turned.size(); ++i) off.rotation[i] = lie::log(turned[i]);
  return off;
}

Start with_momentum_of(const System& planned, const Start& plan, const System& system, const Start& start) {
  const integrator::State state = start_state(planned, plan);
  if (state.momentum.isZero(0.0)) return start;
  const auto total = mechanics::spatial_momentum(planned, state.rotation, state.position, state.momentum);
  mechanics::Rotations R;
  for (const Eigen::Vector3d& vector : start.rotation) R.push_back(lie::exp(vector));
  VectorXd velocity = mechanics::velocity_of_bodies(system, R, start.angular_velocity, start.linear_velocity);
  for (int twice = 0; twice < 2; ++twice)  // of joints that hardly turn the round-off of the whole would be left
    velocity = mechanics::with_momentum(system, R, start.position, velocity, total);
  Start carried = start;
  carried.angular_velocity = mechanics::angular_velocities(system, R, velocity);
  carried.linear_velocity = velocity.tail<3>();
  return carried;
}

MatrixXd answered_turns(const System& system, const Feedback& feedback) {
  const Eigen::Index turns = system.velocity_count() - 3;
  MatrixXd all(0, turns);
  for (const MatrixXd& gain : feedback.gain) {
    MatrixXd both(all.rows() + gain.rows(), turns);
    both << all, gain.leftCols(turns);
    all = algebra::condensed_rows(both);
  }
  return algebra::span_of_rows(all, answered);
}

Tracking tracking_of(const integrator::FeedbackLaw& law, const Solution& marched, double from) {
  Tracking tracking;
  for (std::size_t k = 0; k < marched.time.size(); ++k) {
    const double time = from + marched.time[k];
    const integrator::ReferenceState planned = law.path().at_time(time);
    tracking.rotation_error = 0.0;
    for (std::size_t i = 0; i < planned.rotation.size(); ++i)
      tracking.rotation_error = std::max(tracking.rotation_error,
                                         lie::rotation_angle(planned.rotation[i].transpose() * marched.rotation[k][i]));
    if (tracking.rotation_error > surely_answered && !tracking.off_from) tracking.off_from = marched.time[k];
    tracking.position_error = (marched.position[k] - planned.position).norm();
    tracking.largest_rotation_error = std::max(tracking.largest_rotation_error, tracking.rotation_error);
    tracking.largest_position_error = std::max(tracking.largest_position_error, tracking.position_error);
    const Vectors moments = mechanics::applied_moments(law.path().system(), marched.rotation[k], law.planned(time));
    for (std::size_t j = 0; j < moments.size(); ++j)
      tracking.largest_correction = std::max(tracking.largest_correction, (marched.control[k][j] - moments[j]).norm());
  }
  return tracking;
}

}  // namespace lamprey::maneuver
