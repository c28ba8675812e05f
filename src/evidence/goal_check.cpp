#include "evidence/goal_check.hpp"

#include <Eigen/LU>

#include "evidence/joints_at_rest.hpp"
#include "integrator/step_derivatives.hpp"
#include "model/world_axes.hpp"

namespace lamprey::evidence {

namespace {

using model::at;

// Largest number of rows a goal can state for a swimmer.
int row_bound(const model::System& system) { return 9 * system.body_count() + 3; }

// Whether a body hangs below a joint that goal.angle tells how to end, and no rotation of its own or of one between is stated.
bool led_by_angle(const model::System& system, const maneuver::Goal& goal, int i) {
  for (; system.body(i).parent >= 0; i = system.body(i).parent) {
    if (goal.rotation.contains(system.body(i).name)) return false;
    if (goal.angle.contains(system.joint(system.body(i).joint).name)) return true;
  }
  return false;
}

}  // namespace

std::vector<std::optional<Matrix3d>> asked_rotations(const model::System& system, const maneuver::Problem& problem) {
  std::vector<std::optional<Matrix3d>> asked(at(system.body_count()));
  if (!problem.goal) return asked;
  const int bodies = problem.goal->periodic ? 1 : system.body_count();  // the others close their shape
  for (int i = 0; i < bodies; ++i) {
    const auto named = problem.goal->rotation.find(system.body(i).name);
    if (named != problem.goal->rotation.end()) {
      if (named->second) asked[at(i)] = lie::exp(*named->second);
    } else if (problem.goal->turn && !led_by_angle(system, *problem.goal, i)) {
      asked[at(i)] = lie::exp(*problem.goal->turn) * lie::exp(problem.start.rotation[at(i)]);
    }
  }
  return asked;
}

std::vector<AskedJoint> asked_joints(const model::System& system, const maneuver::Problem& problem) {
  std::vector<AskedJoint> asked;
  if (!problem.goal || problem.goal->periodic) return asked;
  const maneuver::Goal& goal = *problem.goal;
  mechanics::Rotations start;
  for (const Vector3d& vector : problem.start.rotation) start.push_back(lie::exp(vector));
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    if (const auto turn = goal.turn_of_joint(joint.name))
      asked.push_back({j, mechanics::rotation_at_turn(joint, *turn)});
    else if (goal.shape_of_start || (goal.turn && led_by_angle(system, goal, joint.child)))
      asked.push_back({j, mechanics::child_to_parent(start, joint)});
  }
  return asked;
}

GoalMiss largest_miss(const StoredMotion& motion) {
  const model::System& system = motion.system;
  GoalMiss largest{0.0, "", true};
  const auto add = [&](double error, const std::string& condition, bool is_turn) {
    if (error > largest.error || std::isnan(error)) largest = {error, condition, is_turn};
  };
  const auto asked = asked_rotations(system, motion.problem);
  const auto& end = motion.solution.rotation.back();
  const auto name = [&](std::size_t i) { return system.body(static_cast<int>(i)).name; };
  for (std::size_t i = 0; i < asked.size(); ++i)
    if (asked[i]) add(lie::rotation_angle(asked[i]->transpose() * end[i]), "the end attitude of " + name(i), true);
  for (const AskedJoint& asked_joint : asked_joints(system, motion.problem)) {
    const model::Joint& joint = system.joint(asked_joint.joint);
    add(lie::rotation_angle(asked_joint.rotation.transpose() * mechanics::child_to_parent(end, joint)),
        "the end of joint " + joint.name, true);
  }
  for (int c = 0; c < 3; ++c)
    if (const auto& move = motion.problem.goal->move[at(c)])
      add(std::abs(motion.solution.position.back()[c] - motion.problem.start.position[c] - *move),
          std::string("goal.move along ") + model::world_axes[at(c)], false);
  const auto& begin = motion.solution.rotation.front();
  for (std::size_t i = 1; i < end.size() && motion.problem.goal->periodic; ++i)
    add(lie::rotation_angle((begin[0].transpose() * begin[i]).transpose() * (end[0].transpose() * end[i])),
        "the shape of " + name(i) + " at the end of the period", true);
  return largest;
}

double start_error(const StoredMotion& motion) {
  Largest error;
  const integrator::State start = start_of(motion.system, motion.problem.start);
  const std::size_t given = motion.problem.start.free_shape ? 1 : start.rotation.size();
  for (std::size_t i = 0; i < given; ++i)
    error.add(lie::rotation_angle(start.rotation[i].transpose() * motion.solution.rotation.front()[i]));
  error.add((start.position - motion.solution.position.front()).norm());
  return error.value();
}

GoalRows goal_rows(const model::System& system, const maneuver::Problem& problem, const integrator::State& end,
                   double momentum_scale) {
  const integrator::StateLayout layout{system};
  const maneuver::Goal& goal = *problem.goal;
  GoalRows rows{VectorXd::Zero(row_bound(system)), MatrixXd::Zero(row_bound(system), layout.size()),
                VectorXd::Ones(row_bound(system))};
  int count = 0;
  const auto asked = asked_rotations(system, problem);
  for (int i = 0; i < system.body_count(); ++i) {
    if (!asked[at(i)]) continue;
    const Vector3d error = lie::log(asked[at(i)]->transpose() * end.rotation[at(i)]);
    rows.value.segment<3>(count) = error;
    rows.by_end_state.block(count, 0, 3, layout.position()) =
        lie::exp_tangent(error).inverse() * mechanics::turn_by_freedoms(system, end.rotation, i);
    count += 3;
  }
  for (const AskedJoint& asked_joint : asked_joints(system, problem)) {
    const model::Joint& joint = system.joint(asked_joint.joint);
    const Matrix3d now = mechanics::child_to_parent(end.rotation, joint);
    const int child = joint.child, freedoms = system.body(child).freedoms;
    if (freedoms < 3) {
      const Vector3d angle = mechanics::joint_angles(joint, now),
                     wanted = mechanics::joint_angles(joint, asked_joint.rotation);
      for (int f = 0; f < freedoms; ++f) rows.value[count + f] = lie::shorter_way(angle[f] - wanted[f]);
      rows.by_end_state.block(count, layout.freedom(child), freedoms, freedoms).setIdentity();
    } else {
      const Vector3d error = lie::log(asked_joint.rotation.transpose() * now);
      rows.value.segment<3>(count) = error;
      rows.by_end_state.block(count, 0, 3, layout.position()) =
          lie::exp_tangent(error).inverse() *
          (mechanics::turn_by_freedoms(system, end.rotation, child) -
           now.transpose() * mechanics::turn_by_freedoms(system, end.rotation, joint.parent));
    }
    count += freedoms;
  }
  for (int c = 0; c < 3; ++c) {
    if (!goal.move[at(c)]) continue;
    rows.value[count] = end.position[c] - problem.start.position[c] - *goal.move[at(c)];
    rows.by_end_state(count, layout.position() + c) = 1.0;
    rows.unit[count] = system.length_unit();
    ++count;
  }
  if (goal.joints_rest) {
    const CarriedAtRest carried = carried_at_rest(system, problem, end.rotation, end.position);
    rows.value.segment(count, carried.momentum.size()) = -carried.momentum;
    rows.by_end_state.block(count, 0, carried.momentum.size(), system.velocity_count()) = -carried.by_configuration;
  }
  for (int i = 1; i < system.body_count() && goal.stills_joints(); ++i) {
    const int freedoms = system.body(i).freedoms;
    rows.value.segment(count, freedoms) += end.momentum.segment(layout.freedom(i), freedoms);
    rows.by_end_state.block(count, layout.momentum(i), freedoms, freedoms).setIdentity();
    rows.unit.segment(count, freedoms).setConstant(momentum_scale);
    count += freedoms;
  }
  rows.value.conservativeResize(count);
  rows.by_end_state.conservativeResize(count, Eigen::NoChange);
  rows.unit.conservativeResize(count);
  return rows;
}

}  // namespace lamprey::evidence
