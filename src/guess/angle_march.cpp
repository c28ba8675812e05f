#include "guess/angle_march.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <sstream>
#include <utility>

#include "maneuver/end_rows.hpp"
#include "maneuver/maneuver.hpp"
#include "maneuver/motion.hpp"
#include "maneuver/node_path.hpp"
#include "maneuver/seen_shape.hpp"
#include "mechanics/connection.hpp"
#include "shape/moment_basis.hpp"
#include "shape/pose_at_end.hpp"

namespace lamprey::guess {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using maneuver::append_node;
using maneuver::cayley_between;
using maneuver::describe_motion;
using maneuver::in_words;
using maneuver::joint_rate;
using maneuver::NodePath;
using maneuver::read_shape;
using maneuver::shape_size;
using maneuver::ShapeCoordinates;
using maneuver::start_state;
using maneuver::Status;
using mechanics::Rotations;
using model::at;
using model::Joint;
using model::System;
using shape::follow_root;
using shape::MomentBasis;
using shape::seen_from_root;
using shape::ShapeKernel;
using shape::ShapeStep;
using shape::turns_too_far;

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

// What a joint has turned and how fast, as JointAngles and velocity_of_rates have them.
struct JointMotion {
  Vector3d turn = Vector3d::Zero(), rate = Vector3d::Zero();
};

JointMotion motion_of_joint(const System& system, int joint, const integrator::State& state) {
  const Joint& own = system.joint(joint);
  const Matrix3d Q = mechanics::child_to_parent(state.rotation, own);
  const VectorXd velocity = integrator::velocity_of_state(system, state);
  const Vectors angular = mechanics::angular_velocities(system, state.rotation, velocity);
  return {mechanics::turn_from_zero(own, Q, Vector3d::Zero()), joint_rate(system, own, Q, angular, velocity)};
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
    first_passive_.resize(at(system.joint_count()));
    const integrator::State bent = angles.passive_start ? start_state(system, *angles.passive_start) : asked;
    for (int j = 0; j < system.joint_count(); ++j)
      if (passive(j)) first_passive_[at(j)] = motion_of_joint(system, j, bent);
    passive_turn_.push_back(passive_numbers([&](int j) { return first_passive_[at(j)].turn; }));
    last_rate_ = passive_numbers([&](int j) { return first_passive_[at(j)].rate; });
    Rotations first = shape_at(0.0, passive_turn_.front());
    for (Matrix3d& R : first) R = lie::renormalized(asked.rotation[0] * R);
    path_.rotation.push_back(std::move(first));
    path_.position.push_back(asked.position);
  }

  /// At the first node and, once the march is done, at the last.
  integrator::State state_at_node(int k) const { return state_with(k, k == 0 ? first_rate() : last_rate_); }

  /// Step k; false where no motion is found or one that turns too far.
  bool advance(int k) {
    VectorXd passive = guessed_passive(k);
    if (!(passive.size() == 0 ? try_step(k, passive) : find_passive(k, passive))) return false;
    const Rotations& left = path_.rotation[at(k)];
    Rotations next(left.size());
    follow_root(left, next_shape_, step_, next);
    if (turns_too_far(left, next)) return false;
    path_.cayley.emplace_back();
    cayley_between(left, next, path_.cayley.back());
    path_.position.emplace_back(path_.position[at(k)] + step_.interval.displacement);
    path_.rotation.push_back(std::move(next));
    passive_turn_.push_back(passive);
    minus_.push_back(step_.minus);
    plus_.push_back(step_.plus);
    return true;
  }

  int steps() const { return static_cast<int>(path_.cayley.size()); }

  /// The nodes with the moments between what the joints' momenta are before and after each.
  const NodePath& with_moments() {
    if (last_rate_.size() > 0) find_last_rate();
    for (int k = 0; k <= steps(); ++k) {
      VectorXd impulse = k < steps() ? minus_[at(k)] : shape_momentum(k);
      impulse -= k > 0 ? plus_[at(k - 1)] : shape_momentum(k);
      const double time = k > 0 && k < steps() ? h_ : 0.5 * h_;
      MomentBasis basis(system_, coordinates_.shape, path_.rotation[at(k)]);
      const VectorXd moments = moments_for(k, VectorXd(impulse / time), basis);
      note_idle(k, moments, basis);
      path_.control.push_back(moments.head(system_.control_count()));
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
         << (joint.actuation.cols() == 0 ? "actuated = false" : "control_axes") << "); let it be driven"
         << (joint.actuation.cols() == 0 ? ", or leave its angles out, and it moves as it likes"
                                         : ", or march under moments (controls), which moves such joints as they like");
    return text.str();
  }

 private:
  bool passive(int joint) const { return !angles_.passive.empty() && angles_.passive[at(joint)]; }

  // Numbers of the passive joints' freedoms, one after the other, of three for each joint.
  template <typename Function>
  VectorXd passive_numbers(const Function& of_joint) const {
    std::vector<double> numbers;
    for (int j = 0; j < system_.joint_count(); ++j) {
      if (!passive(j)) continue;
      const Vector3d own = of_joint(j);
      numbers.insert(numbers.end(), own.data(), own.data() + system_.body(system_.joint(j).child).freedoms);
    }
    return Eigen::Map<VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
  }

  // And back, in the place of what stands for these joints.
  void put_passive(const VectorXd& numbers, Vectors& by_joint) const {
    Eigen::Index next = 0;
    for (int j = 0; j < system_.joint_count(); ++j) {
      if (!passive(j)) continue;
      const int freedoms = system_.body(system_.joint(j).child).freedoms;
      by_joint[at(j)].setZero();
      by_joint[at(j)].head(freedoms) = numbers.segment(next, freedoms);
      next += freedoms;
    }
  }

  VectorXd first_rate() const {
    return passive_numbers([&](int j) { return first_passive_[at(j)].rate; });
  }

  integrator::State state_with(int k, const VectorXd& passive_rate) const {
    const Rotations& R = path_.rotation[at(k)];
    const Vector3d& x = path_.position[at(k)];
    Vectors rates = joint_rates(system_, angles_, k * h_);
    put_passive(passive_rate, rates);
    return integrator::state_of_velocity(system_, R, x, mechanics::velocity_of_rates(system_, R, x, rates, total_));
  }

  // Rotations seen from the root.
  Rotations shape_at(double time, const VectorXd& passive_turn) const {
    Vectors turn = angles_.turn(time);
    put_passive(passive_turn, turn);
    return mechanics::shape_at_turns(system_, turn);
  }

  // Going on as they went.
  VectorXd guessed_passive(int k) const {
    const VectorXd& now = passive_turn_[at(k)];
    return k == 0 ? VectorXd(now + h_ * first_rate()) : VectorXd(2.0 * now - passive_turn_[at(k - 1)]);
  }

  // Step k to the angles at its end and these of the passive joints.
  bool try_step(int k, const VectorXd& passive_turn) {
    const Rotations& left = path_.rotation[at(k)];
    next_shape_ = shape_at((k + 1) * h_, passive_turn);
    return kernel_.solve(h_, left, next_shape_, step_, seen_from_root(total_, left[0], path_.position[at(k)]));
  }

  // Newton's method by differences: the passive joints' turns under which step k takes no moment of them (equation 9.33).
  bool find_passive(int k, VectorXd& turn) {
    constexpr int most_rounds = 20;
    constexpr double difference = 1e-6, longest = 0.3, settled = 1e-10;  // rad
    const VectorXd arrived = k > 0 ? plus_[at(k - 1)] : shape_momentum(0);
    const auto idle = [&](const VectorXd& tried) -> std::optional<VectorXd> {
      if (!try_step(k, tried)) return std::nullopt;
      return idle_of_passive(k, VectorXd(step_.minus - arrived));
    };
    for (int round = 0; round < most_rounds; ++round) {
      const std::optional<VectorXd> here = idle(turn);
      if (!here) return false;
      MatrixXd slope(turn.size(), turn.size());
      for (Eigen::Index d = 0; d < turn.size(); ++d) {
        const std::optional<VectorXd> there = idle(turn + difference * VectorXd::Unit(turn.size(), d));
        if (!there) return false;
        slope.col(d) = (*there - *here) / difference;
      }
      const VectorXd change = -slope.partialPivLu().solve(*here);
      const double size = change.lpNorm<Eigen::Infinity>();
      if (!std::isfinite(size)) return false;
      turn += std::min(1.0, longest / size) * change;
      if (size < settled) return try_step(k, turn);
    }
    return false;
  }

  // At the end passive joints have the rates at which what has arrived needs no moment of them: it is affine in these.
  void find_last_rate() {
    const int N = steps();
    const auto idle = [&](const VectorXd& rate) {
      last_rate_ = rate;
      return idle_of_passive(N, VectorXd(shape_momentum(N) - plus_[at(N - 1)]));
    };
    const VectorXd none = VectorXd::Zero(last_rate_.size()), at_rest = idle(none);
    MatrixXd slope(none.size(), none.size());
    for (Eigen::Index d = 0; d < none.size(); ++d) slope.col(d) = idle(VectorXd::Unit(none.size(), d)) - at_rest;
    last_rate_ = -slope.partialPivLu().solve(at_rest);
  }

  VectorXd shape_momentum(int k) const {
    mechanics::Freedoms momenta(at(system_.body_count()));
    mechanics::unpack(system_, state_at_node(k).momentum, momenta);
    VectorXd along(shape_size(system_));
    read_shape(system_, momenta, along);
    return along;
  }

  // Moments that do what is asked along the shape's coordinates: along the joints' actuation, then those that nothing exerts.
  VectorXd moments_for(int k, VectorXd asked, MomentBasis& basis) const {
    const Rotations& R = path_.rotation[at(k)];
    if (basis.joint_by_joint()) {
      basis.solve(R, asked);
      return asked;
    }
    MatrixXd work(asked.size(), basis.size());
    basis.virtual_work(R, work);
    return work.partialPivLu().solve(asked);
  }

  // Of them those about the passive joints' freedoms.
  VectorXd idle_of_passive(int k, const VectorXd& impulse) const {
    MomentBasis basis(system_, coordinates_.shape, path_.rotation[at(k)]);
    const VectorXd moments = moments_for(k, impulse, basis);
    VectorXd idle(passive_turn_.front().size());
    Eigen::Index next = 0;
    for (int place = system_.control_count(); place < basis.size(); ++place)
      if (passive(basis.joint(place))) idle[next++] = moments[place];
    return idle;
  }

  void note_idle(int k, const VectorXd& moments, const MomentBasis& basis) {
    largest_moment_ = std::max(largest_moment_, moments.lpNorm<Eigen::Infinity>());
    for (int place = system_.control_count(); place < basis.size(); ++place)
      if (const double moment = std::abs(moments[place]); moment > idle_.moment)
        idle_ = {moment, basis.joint(place), k};
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
  std::vector<JointMotion> first_passive_;  // [joints] of the start
  std::vector<VectorXd> passive_turn_;      // [nodes][passive freedoms] rad
  VectorXd last_rate_;                      // [passive freedoms] rad/s, at the last node
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
      solution.message = "Interrupted at t = " + in_words(k * problem.time_step()) + " s.";
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
      solution.message = "at t = " + in_words(static_cast<double>(k) * problem.time_step()) +
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

}  // namespace lamprey::guess
