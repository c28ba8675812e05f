#include "maneuver/angle_march.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <utility>

#include "maneuver/maneuver.hpp"
#include "maneuver/moment_basis.hpp"
#include "maneuver/motion.hpp"
#include "maneuver/node_path.hpp"
#include "mechanics/connection.hpp"

namespace lamprey::maneuver {

namespace {

using mechanics::Rotations;
using model::at;
using model::Joint;
using model::System;

// Joints' rates as mechanics::velocity_of_rates takes them: of a ball joint the child's angular velocity, parent's frame.
Vectors joint_rates(const System& system, const JointAngles& angles, double time) {
  Vectors rates = angles.rate(time);
  const Vectors turn = angles.turn(time);
  for (int j = 0; j < system.joint_count(); ++j)
    if (system.joint(j).free()) {
      const Vector3d on_child_side = lie::exp_tangent(turn[at(j)]) * rates[at(j)];
      rates[at(j)] = lie::exp(turn[at(j)]) * on_child_side;
    }
  return rates;
}

// One march: nodes by momentum, then moments by what the joints' momenta change by.
class AngleMarch {
 public:
  AngleMarch(const System& system, const Problem& problem, const JointAngles& angles)
      : system_(system),
        angles_(angles),
        lagrangian_(integrator::composition(problem.scheme).lagrangian),
        h_(problem.time_step()),
        coordinates_(system),
        kernel_(system, lagrangian_, coordinates_.shape),
        step_(system),
        next_shape_(at(system.body_count())) {
    const integrator::State asked = start_state(system, problem.start);
    total_ = mechanics::spatial_momentum(system, asked.rotation, asked.position, asked.momentum);
    Rotations first = shape_at(0.0);
    for (Matrix3d& R : first) R = lie::renormalized(asked.rotation[0] * R);
    path_.rotation.push_back(std::move(first));
    path_.position.push_back(asked.position);
  }

  integrator::State state_at_node(int k) const {
    const Rotations& R = path_.rotation[at(k)];
    const Vector3d& x = path_.position[at(k)];
    return integrator::state_of_velocity(
        system_, R, x, mechanics::velocity_of_rates(system_, R, x, joint_rates(system_, angles_, k * h_), total_));
  }

  /// Step k; false where no motion is found or one that turns too far.
  bool advance(int k) {
    const Rotations& left = path_.rotation[at(k)];
    next_shape_ = shape_at((k + 1) * h_);
    const Vector3d arm = path_.position[at(k)].cross(total_.linear);
    Vector6d carried;
    carried << left[0].transpose() * (total_.angular - arm), left[0].transpose() * total_.linear;
    if (!kernel_.solve(h_, left, next_shape_, step_, carried)) return false;
    Rotations next(left.size());
    follow_root(left, next_shape_, step_, next);
    if (turns_too_far(left, next)) return false;
    path_.cayley.emplace_back();
    cayley_between(left, next, path_.cayley.back());
    path_.position.emplace_back(path_.position[at(k)] + step_.interval.displacement);
    path_.rotation.push_back(std::move(next));
    minus_.push_back(step_.minus);
    plus_.push_back(step_.plus);
    return true;
  }

  int steps() const { return static_cast<int>(path_.cayley.size()); }

  /// The nodes with the moments between what the joints' momenta are before and after each.
  const NodePath& with_moments() {
    for (int k = 0; k <= steps(); ++k) {
      VectorXd impulse = k < steps() ? minus_[at(k)] : shape_momentum(k);
      impulse -= k > 0 ? plus_[at(k - 1)] : shape_momentum(k);
      const double time = k > 0 && k < steps() ? h_ : 0.5 * h_;
      path_.control.push_back(moments(k, VectorXd(impulse / time)).head(system_.control_count()));
    }
    return path_;
  }

  /// In words, the largest moment of a joint that nothing exerts though the angles take it; empty where all are round-off.
  std::string beyond_actuation() const {
    constexpr double round_off = 1e-6;  // of the largest moment
    if (!(idle_.moment > round_off * largest_moment_)) return "";
    const Joint& joint = system_.joint(idle_.joint);
    std::ostringstream text;
    text << "these angles take a moment of " << idle_.moment << " N m of joint " << joint.name
         << " at t = " << idle_.node * h_ << " s about an axis that nothing drives ("
         << (joint.actuation.cols() == 0 ? "actuated = false" : "control_axes")
         << "); let it be driven, or march under moments (controls), which moves such joints as they like";
    return text.str();
  }

 private:
  // Rotations seen from the root.
  Rotations shape_at(double time) const {
    const Vectors turn = angles_.turn(time);
    Rotations shape(at(system_.body_count()), Matrix3d::Identity());
    for (int i : system_.root_to_leaves()) {
      const model::Body& body = system_.body(i);
      if (body.parent < 0) continue;
      shape[at(i)] =
          shape[at(body.parent)] * mechanics::rotation_at_turn(system_.joint(body.joint), turn[at(body.joint)]);
    }
    return shape;
  }

  VectorXd shape_momentum(int k) const {
    mechanics::Freedoms momenta(at(system_.body_count()));
    mechanics::unpack(system_, state_at_node(k).momentum, momenta);
    VectorXd along(shape_size(system_));
    read_shape(system_, momenta, along);
    return along;
  }

  // Moments that do what is asked along the shape's coordinates: along the joints' actuation, then those that nothing exerts,
  // of which the largest is noted.
  VectorXd moments(int k, VectorXd asked) {
    const Rotations& R = path_.rotation[at(k)];
    MomentBasis basis(system_, coordinates_.shape, R);
    if (basis.joint_by_joint()) {
      basis.solve(R, asked);
    } else {
      MatrixXd work(asked.size(), basis.size());
      basis.virtual_work(R, work);
      asked = work.partialPivLu().solve(asked);
    }
    largest_moment_ = std::max(largest_moment_, asked.lpNorm<Eigen::Infinity>());
    for (int place = system_.control_count(); place < basis.size(); ++place)
      if (const double moment = std::abs(asked[place]); moment > idle_.moment) idle_ = {moment, basis.joint(place), k};
    return asked;
  }

  const System& system_;
  const JointAngles& angles_;
  mechanics::DiscreteLagrangian lagrangian_;
  double h_;  // s
  ShapeCoordinates coordinates_;
  ShapeKernel kernel_;
  ShapeStep step_;
  mechanics::SpatialMomentum total_;
  Rotations next_shape_;
  NodePath path_;
  struct Idle {
    double moment = 0.0;  // N m
    int joint = 0, node = 0;
  };
  Idle idle_;                           // the largest
  double largest_moment_ = 0.0;         // N m, of all
  std::vector<VectorXd> minus_, plus_;  // [steps][f] E⁻ at each step's beginning and E⁺ at its end, without controls
};

std::string stopped(int k, double time_step) {
  std::ostringstream text;
  text << "step " << k << " at t = " << k * time_step
       << " s finds no motion along these joint angles in which no body turns by more than a quarter turn; try more "
          "steps, or look at the angles and their rates at that time";
  return text.str();
}

}  // namespace

bool follows_angles(Scheme scheme) { return integrator::single_step(scheme); }

Start start_along(const System& system, const Problem& problem, const JointAngles& angles) {
  const integrator::State state = AngleMarch(system, problem, angles).state_at_node(0);
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  Start start;
  start.position = state.position;
  for (const Matrix3d& R : state.rotation) start.rotation.push_back(lie::log(R));
  start.angular_velocity = mechanics::angular_velocities(system, state.rotation, velocity);
  start.linear_velocity = velocity.tail<3>();
  return start;
}

Solution march_along(const System& system, const Problem& problem, const JointAngles& angles,
                     const std::function<bool()>& interrupted) {
  Solution solution;
  solution.status = Status::simulated;
  solution.cost = std::numeric_limits<double>::quiet_NaN();
  AngleMarch march(system, problem, angles);
  for (int k = 0; k < problem.steps && solution.status == Status::simulated; ++k) {
    if (interrupted && interrupted()) {
      solution.status = Status::interrupted;
      solution.message = "Interrupted at t = " + std::to_string(k * problem.time_step()) + " s.";
    } else if (!march.advance(k)) {
      solution.status = Status::stalled;
      solution.message = stopped(k, problem.time_step());
    }
  }
  if (march.steps() == 0) {
    append_node(system, 0.0, march.state_at_node(0), mechanics::Moments(at(system.joint_count()), Vector3d::Zero()),
                solution);
    return solution;
  }
  const NodePath& path = march.with_moments();
  describe_motion(system, integrator::composition(problem.scheme).lagrangian, problem.time_step(), path, solution);
  for (std::size_t k = 0; k < path.control.size(); ++k)
    if (!path.control[k].allFinite()) {
      solution.status = Status::stalled;
      solution.message = "at t = " + std::to_string(static_cast<double>(k) * problem.time_step()) +
                         " s no finite moments turn the joints so: the angles change beyond all numbers; look at "
                         "them at that time";
      return solution;
    }
  if (const std::string beyond = march.beyond_actuation(); !beyond.empty()) {
    solution.status = Status::stalled;
    solution.message = beyond;
  }
  if (solution.status == Status::simulated)
    solution.message = "Marched " + std::to_string(problem.steps) +
                       " steps along the given joint angles; the moments are those that turn the joints so.";
  return solution;
}

}  // namespace lamprey::maneuver
