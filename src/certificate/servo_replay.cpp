#include "certificate/servo_replay.hpp"

#include "lie/so3.hpp"
#include "maneuver/control_path.hpp"
#include "mechanics/connection.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::certificate {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using mechanics::Rotations;
using mechanics::Vectors;
using model::at;
using model::System;

constexpr int fewest_steps = 3;  // that a cubic goes through
constexpr double still = 1e-9;   // rad

// Turns of the joints from their zero angles at the nodes, whole turns counted, [3 · joints][N + 1] rad.
MatrixXd turns_of_joints(const StoredMotion& motion) {
  const System& system = motion.system;
  MatrixXd turns = MatrixXd::Zero(3 * system.joint_count(), motion.steps + 1);
  for (int j = 0; j < system.joint_count(); ++j) {
    Vector3d turn = Vector3d::Zero();
    for (int k = 0; k <= motion.steps; ++k) {
      const model::Joint& joint = system.joint(j);
      turn = mechanics::turn_from_zero(joint, mechanics::child_to_parent(motion.solution.rotation[at(k)], joint), turn);
      turns.block<3, 1>(3 * j, k) = turn;
    }
  }
  return turns;
}

// Whether moments reach all that moves in the joints.
bool driven_throughout(const System& system, const MatrixXd& turns) {
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Axes& axes = system.joint(j).actuation;
    if (axes.cols() == model::freedoms_of(system.joint(j).kind)) continue;
    const MatrixXd moved = turns.middleRows<3>(3 * j).colwise() - turns.col(0).segment<3>(3 * j);
    if ((moved - axes * (axes.transpose() * moved)).cwiseAbs().maxCoeff() > still) return false;
  }
  return true;
}

struct Root {
  Matrix3d rotation;  // body → world
  Vector3d position;  // m
};

// Rates of the root: of a rotation vector that is `turned` beside where its step began, and of its position.
struct RootRate {
  Vector3d turn;      // rad/s
  Vector3d position;  // m/s
};

class ServoMarch {
 public:
  ServoMarch(const StoredMotion& motion, const MatrixXd& turns)
      : motion_(motion),
        path_(maneuver::Interpolation::not_a_knot_cubic,
              Eigen::Map<const VectorXd>(motion.solution.time.data(), motion.steps + 1), turns),
        first_(evidence::node_states(motion).front()) {
    total_ = mechanics::spatial_momentum(motion.system, first_.rotation, first_.position, first_.momentum);
  }

  Root end() const {
    Root root{first_.rotation[0], first_.position};
    const std::vector<double>& time = motion_.solution.time;
    for (int k = 0; k < motion_.steps; ++k) advance(time[at(k)], time[at(k + 1)] - time[at(k)], root);
    return root;
  }

 private:
  // The classical rule of order four, twice that of the steps.
  void advance(double t, double h, Root& root) const {
    const RootRate a = rate(t, root, Vector3d::Zero(), Vector3d::Zero());
    const RootRate b = rate(t + 0.5 * h, root, 0.5 * h * a.turn, 0.5 * h * a.position);
    const RootRate c = rate(t + 0.5 * h, root, 0.5 * h * b.turn, 0.5 * h * b.position);
    const RootRate d = rate(t + h, root, h * c.turn, h * c.position);
    root.rotation *= lie::exp(h / 6.0 * (a.turn + 2.0 * (b.turn + c.turn) + d.turn));
    root.position += h / 6.0 * (a.position + 2.0 * (b.position + c.position) + d.position);
  }

  RootRate rate(double t, const Root& root, const Vector3d& turned, const Vector3d& shifted) const {
    const System& system = motion_.system;
    const VectorXd turn = path_.value(t), slope = path_.slope(t);
    Vectors turns, rates;
    for (int j = 0; j < system.joint_count(); ++j) {
      const Vector3d own = turn.segment<3>(3 * j), speed = slope.segment<3>(3 * j);
      turns.push_back(own);
      rates.push_back(system.joint(j).free() ? Vector3d(lie::exp(own) * (lie::exp_tangent(own) * speed)) : speed);
    }
    Rotations rotation = mechanics::shape_at_turns(system, turns);
    const Matrix3d heading = root.rotation * lie::exp(turned);
    for (Matrix3d& R : rotation) R = heading * R;
    const VectorXd velocity = mechanics::velocity_of_rates(system, rotation, root.position + shifted, rates, total_);
    return {lie::log_tangent(turned) * velocity.segment<3>(system.body(0).velocity_offset), velocity.tail<3>()};
  }

  const StoredMotion& motion_;
  maneuver::ControlPath path_;
  integrator::State first_;
  mechanics::SpatialMomentum total_;
};

}  // namespace

void replay_with_servos(const StoredMotion& motion, Replay& result) {
  if (motion.steps < fewest_steps) return;
  const MatrixXd turns = turns_of_joints(motion);
  if (!driven_throughout(motion.system, turns)) return;
  const Root end = ServoMarch(motion, turns).end();
  result.servo_rotation_error = lie::rotation_angle(motion.solution.rotation.back()[0].transpose() * end.rotation);
  result.servo_position_error = (motion.solution.position.back() - end.position).norm();
}

}  // namespace lamprey::certificate
