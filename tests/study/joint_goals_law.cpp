// Goals that tell how joints end, and leave free how the whole is turned.
#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "lie/so3.hpp"
#include "maneuver/goal_miss.hpp"
#include "marched_answers.hpp"
#include "mechanics/tree_motion.hpp"
#include "model/input_error.hpp"
#include "search/first_motion.hpp"
#include "search/solver.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem turning_chain(maneuver::Scheme scheme) {
  maneuver::Problem problem = chain_problem(40, 1.0);
  problem.scheme = scheme;
  problem.goal->turn = Vector3d(0.05, -0.03, 0.08);
  problem.goal->move = {0.1, std::nullopt, std::nullopt};
  return problem;
}

study::Answer proven(const maneuver::Problem& problem, const search::SolveOptions& options = {}) {
  study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  return answer;
}

search::SolveOptions beginning_at(const maneuver::Problem& problem, const maneuver::Solution& solution) {
  search::SolveOptions options;
  options.first = search::first_motion(model::System(problem.swimmer), problem, solution);
  return options;
}

Matrix3d joint_of(const model::Joint& joint, const maneuver::Solution& solution, bool last) {
  return mechanics::child_to_parent(last ? solution.rotation.back() : solution.rotation.front(), joint);
}

// What asks for less costs no more; and asking for the attitude that comes of itself changes nothing.
TEST(JointGoals, cost_no_more_than_goals_that_tell_the_attitude_as_well) {
  for (maneuver::Scheme scheme : {maneuver::Scheme::trapezoid, maneuver::Scheme::order4}) {
    maneuver::Problem turned = turning_chain(scheme), shaped = turned;
    shaped.goal->turn.reset();
    shaped.goal->shape_of_start = true;
    const model::System system(turned.swimmer);
    const maneuver::Solution whole = proven(turned).solution;
    const maneuver::Solution free = proven(shaped, beginning_at(shaped, whole)).solution;
    EXPECT_LT(free.cost, 0.99 * whole.cost);
    for (const model::Joint& joint : system.joints())
      EXPECT_LT(lie::rotation_angle(joint_of(joint, free, false).transpose() * joint_of(joint, free, true)), 1e-9);
    turned.goal->turn = lie::log(free.rotation.back()[0] * free.rotation.front()[0].transpose());
    EXPECT_GT(turned.goal->turn->norm(), 1e-3);
    EXPECT_NEAR(proven(turned, beginning_at(turned, free)).solution.cost / free.cost, 1.0, 1e-8);
  }
}

// Where one attitude is told as well all of them are: it is the same question as that by rotations.
TEST(JointGoals, beside_an_attitude_ask_what_rotations_of_all_bodies_do) {
  maneuver::Problem by_angles = chain_problem(40, 1.0);
  by_angles.swimmer = swimmer_of_mixed_joints();
  by_angles.start.rotation.assign(4, Vector3d::Zero());
  by_angles.start.angular_velocity.assign(4, Vector3d::Zero());
  by_angles.scheme = maneuver::Scheme::midpoint;
  const model::System system(by_angles.swimmer);
  const auto joint = [&](int j) { return system.joint(j).name; };
  maneuver::Problem by_rotations = by_angles;
  by_angles.goal->turn = Vector3d(0.1, 0.2, -0.1);
  by_angles.goal->angle = {{joint(1), {0.3, -0.2}}};  // the third keeps its start's
  mechanics::Rotations end(4);
  end[0] = lie::exp(Vector3d(0.1, 0.2, -0.1));
  end[1] = end[0];
  end[2] = end[1] * mechanics::joint_rotation(system.joint(1), Vector3d(0.3, -0.2, 0.0));
  end[3] = end[2];
  by_rotations.goal->turn.reset();
  for (std::size_t i = 0; i < 4; ++i) by_rotations.goal->rotation[system.bodies()[i].name] = lie::log(end[i]);
  const maneuver::Solution one = proven(by_angles).solution, other = proven(by_rotations).solution;
  EXPECT_NEAR(one.cost / other.cost, 1.0, 1e-9);
  maneuver::Problem by_a_child = by_rotations;
  by_a_child.goal->rotation = {{system.bodies()[3].name, lie::log(end[3])}};
  by_a_child.goal->shape_of_start = true;
  by_a_child.goal->angle = {{joint(1), {0.3, -0.2}}};
  EXPECT_NEAR(proven(by_a_child).solution.cost / other.cost, 1.0, 1e-9) << "the root follows its children";
}

// The chain with all bodies in a row, the last on the second.
maneuver::Problem straight_row(model::JointKind first) {
  maneuver::Problem problem = chain_problem(40, 1.0);
  problem.start.rotation.assign(3, Vector3d::Zero());
  model::JointDescription &front = problem.swimmer.joints[0], &last = problem.swimmer.joints[1];
  last.parent = front.child;
  last.parent_offset = -front.child_offset;
  last.child_offset = -last.child_offset;
  front.kind = first;
  if (first == model::JointKind::universal) front.axes = {{Vector3d(0.0, 1.0, 0.0), Vector3d(0.0, 0.0, 1.0)}};
  problem.goal->turn.reset();
  problem.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  return problem;
}

// A ball joint alone whose parent a joint leads, or turns on its own.
TEST(JointGoals, of_one_joint_leave_the_others_free_and_hold_for_the_other_solver) {
  for (const model::JointKind first : {model::JointKind::ball, model::JointKind::universal}) {
    maneuver::Problem problem = straight_row(first);
    const model::System system(problem.swimmer);
    const Vector3d turn(0.2, 0.4, -0.3);
    problem.goal->angle = {{system.joint(1).name, {turn[0], turn[1], turn[2]}}};
    const maneuver::Solution solution = proven(problem).solution;
    const Matrix3d end = joint_of(system.joint(1), solution, true);
    EXPECT_LT((mechanics::turn_from_zero(system.joint(1), end, turn) - turn).norm(), 1e-9);
    EXPECT_GT(lie::log(joint_of(system.joint(0), solution, true)).norm(), 1e-3);
    search::SolveOptions options = beginning_at(problem, solution);
    options.solver = search::Backend::ipopt;
    EXPECT_NEAR(proven(problem, options).solution.cost / solution.cost, 1.0, 1e-8);
  }
}

// What moments never bend otherwise is out of reach, and told so.
TEST(JointGoals, beside_the_axis_that_moments_bend_about_are_out_of_reach) {
  maneuver::Problem problem = turning_chain(maneuver::Scheme::trapezoid);
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0.0, 0.0, 1.0)};
  problem.goal->turn.reset();
  const std::string joint = problem.swimmer.joints[0].name;
  problem.goal->angle[joint] = {0.3, 0.2, 0.1};
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.solution.status, maneuver::Status::infeasible);
  EXPECT_NE(answer.solution.message.find("bend joint " + joint + " about e₃ alone"), std::string::npos)
      << answer.solution.message;
  problem.goal->angle[joint] = {0.0, 0.0, 0.3};
  proven(problem);
}

// A fixed joint ends as it begins, whatever is told of the others: with one hinge more that is a shape.
TEST(JointGoals, of_the_only_hinge_that_ends_as_it_begins_get_nowhere) {
  maneuver::Problem problem = turning_chain(maneuver::Scheme::trapezoid);
  model::JointDescription &hinge = problem.swimmer.joints[0], &fixed = problem.swimmer.joints[1];
  hinge.kind = model::JointKind::hinge;
  hinge.axis = Vector3d(0.0, 0.0, 1.0);
  fixed.kind = model::JointKind::fixed;
  fixed.reference_rotation = problem.start.rotation[2];
  problem.limits.angle[hinge.name] = {{-1.0, 2.0}};
  problem.goal->turn.reset();
  for (const bool by_shape : {false, true}) {
    problem.goal->shape_of_start = by_shape;
    problem.goal->angle = {};
    if (!by_shape) problem.goal->angle[hinge.name] = {0.0};
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
    EXPECT_NE(answer.solution.message.find("scallop"), std::string::npos) << answer.solution.message;
  }
}

// Parts of a way tell attitudes, which in a vacuum tell where the root is: there a goal that leaves them free has none.
TEST(JointGoals, in_a_vacuum_are_searched_without_parts) {
  maneuver::Problem problem = turning_chain(maneuver::Scheme::trapezoid);
  problem.swimmer.density = 0.0;
  for (model::BodyDescription& body : problem.swimmer.bodies) {
    body.mass = 1.0;
    body.mass_matrix.reset();
    body.inertia_matrix.reset();
  }
  for (model::JointDescription& joint : problem.swimmer.joints) {
    joint.kind = model::JointKind::hinge;
    joint.axis = Vector3d(0.0, 0.0, 1.0);
    problem.limits.angle[joint.name] = {{-0.9, 0.9}};
  }
  problem.goal->turn.reset();
  problem.goal->shape_of_start = true;
  problem.goal->move = {-4.0, std::nullopt, std::nullopt};
  problem.search.time_limit = 10.0;
  EXPECT_NO_THROW(study::answer(model::System(problem.swimmer), problem, {}));
}

// A vehicle that folds while it swims: the joint's goal moves, from the last answer on.
TEST(JointGoals, move_in_a_solver) {
  maneuver::Problem problem = turning_chain(maneuver::Scheme::trapezoid);
  problem.swimmer.joints[0].kind = model::JointKind::hinge;
  problem.swimmer.joints[0].axis = Vector3d(0.0, 0.0, 1.0);
  problem.goal->turn.reset();
  const std::string hinge = problem.swimmer.joints[0].name;
  problem.goal->angle[hinge] = {0.4};
  const model::System system(problem.swimmer);
  search::Solver solver(system, problem, proven(problem).solution);
  EXPECT_TRUE(solver.answers());
  maneuver::Goal moved = *problem.goal;
  moved.angle[hinge] = {0.43};
  solver.set_goal(moved);
  EXPECT_EQ(solver.solve().termination, optimizer::Termination::converged);
  const Matrix3d end = joint_of(system.joint(0), solver.solution(), true);
  EXPECT_NEAR(mechanics::joint_angles(system.joint(0), end)[0], 0.43, 1e-9);
  problem.goal = moved;
  const auto miss = maneuver::goal_miss(system, problem, solver.solution());
  ASSERT_TRUE(miss);
  EXPECT_LT(miss->rotation, 1e-9);
  moved.angle[problem.swimmer.joints[1].name] = {0.1, 0.0, 0.0};
  EXPECT_THROW(solver.set_goal(moved), model::InputError) << "it was free";
  moved.angle = {{hinge, {40.0}}};
  EXPECT_THROW(solver.set_goal(moved), model::InputError) << "meant in degrees";
}

}  // namespace
}  // namespace lamprey::tests
