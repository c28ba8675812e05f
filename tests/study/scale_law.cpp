// A swimmer so many times as large in as dense a fluid is the same swimmer in other units: it is searched alike, down to a tenth
// of a millimetre and up to a kilometre.
#include <gtest/gtest.h>

#include "certificate/certify.hpp"
#include "file/problem_file.hpp"
#include "maneuver/simulate.hpp"
#include "search/solve.hpp"
#include "search/solver.hpp"
#include "study/answer.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;

// Three bodies that move forward; the last one's joint is a ball joint with motors, or a sprung hinge without.
maneuver::Problem swimmer(double scale, double time_scale, bool passive) {
  maneuver::Problem problem;
  problem.swimmer.density = 1000.0;
  const std::array<Vector3d, 3> axes = {Vector3d(0.25, 0.06, 0.1), Vector3d(0.125, 0.04, 0.08),
                                        Vector3d(0.0625, 0.02, 0.12)};
  for (std::size_t i = 0; i < 3; ++i) {
    model::BodyDescription body;
    body.name = std::to_string(i);
    body.semi_axes = scale * axes[i];
    problem.swimmer.bodies.push_back(body);
    if (i == 0) continue;
    model::JointDescription joint;
    joint.name = joint.child = body.name;
    joint.parent = std::to_string(i - 1);
    joint.parent_offset = scale * Vector3d(-axes[i - 1][0] - 0.01, 0.0, 0.0);
    joint.child_offset = scale * Vector3d(axes[i][0] + 0.01, 0.0, 0.0);
    if (passive) {
      joint.kind = model::JointKind::hinge;
      joint.axis = Vector3d(0.0, 0.0, 1.0);
      joint.actuated = i == 1;
      joint.stiffness = i == 2 ? 5.0 * std::pow(scale, 5) / (time_scale * time_scale) : 0.0;
    }
    problem.swimmer.joints.push_back(joint);
  }
  problem.start.rotation.assign(3, Vector3d::Zero());
  problem.start.angular_velocity.assign(3, Vector3d::Zero());
  problem.goal.emplace();
  problem.goal->move[0] = 0.03 * scale;
  if (passive) {
    problem.goal->turn.reset();
    problem.goal->move[1] = problem.goal->move[2] = std::nullopt;
  }
  problem.duration.value = 2.0 * time_scale;
  problem.steps = passive ? 50 : 100;
  problem.search.starts = passive ? 1 : 4;
  return problem;
}

class Scale : public ::testing::TestWithParam<bool> {};

TEST_P(Scale, of_length_and_time_changes_nothing_but_units) {
  const auto solved = [&](double scale, double time_scale) {
    const maneuver::Problem problem = swimmer(scale, time_scale, GetParam());
    return search::solve(model::System(problem.swimmer), problem, search::SolveOptions()).front();
  };
  const maneuver::Solution one = solved(1.0, 1.0);
  ASSERT_EQ(one.status, maneuver::Status::optimal) << one.message;
  for (const auto& [scale, time_scale] : {std::pair(0x1p-12, 1.0), std::pair(0x1p12, 1.0), std::pair(1.0, 0x1p-8),
                                          std::pair(1.0, 0x1p8), std::pair(0x1p-10, 0x1p-4)}) {
    const maneuver::Solution other = solved(scale, time_scale);
    EXPECT_EQ(other.status, one.status) << other.message << " at " << scale << ", " << time_scale;
    const double moment = std::pow(scale, 5) / (time_scale * time_scale), unit = moment * moment * time_scale;
    EXPECT_NEAR(other.cost / unit, one.cost, tolerance(1e-12) * one.cost) << scale << ", " << time_scale;
    EXPECT_EQ(other.search.solved, one.search.solved);
    EXPECT_EQ(other.solver.iterations, one.solver.iterations);
  }
}

INSTANTIATE_TEST_SUITE_P(Swimmers, Scale, ::testing::Bool(),
                         [](const auto& instance) { return instance.param ? "sprung" : "moved"; });

// The same question to a swimmer so many times as large, whose tissues and fluid are as dense.
maneuver::Problem scaled(maneuver::Problem problem, double scale) {
  for (model::BodyDescription& body : problem.swimmer.bodies) {
    body.semi_axes *= scale;
    if (body.mass_matrix) *body.mass_matrix *= std::pow(scale, 3);
    if (body.inertia_matrix) *body.inertia_matrix *= std::pow(scale, 5);
  }
  for (model::JointDescription& joint : problem.swimmer.joints) {
    joint.parent_offset *= scale;
    joint.child_offset *= scale;
  }
  problem.start.position *= scale;
  for (auto& move : problem.goal->move)
    if (move) *move *= scale;
  for (maneuver::Waypoint& waypoint : problem.waypoints)
    for (auto& move : waypoint.move)
      if (move) *move *= scale;
  for (maneuver::KeepOutSphere& sphere : problem.limits.spheres) {
    sphere.centre *= scale;
    sphere.radius *= scale;
  }
  for (maneuver::KeepOutHalfSpace& half : problem.limits.half_spaces) half.point *= scale;
  if (problem.limits.clearance) *problem.limits.clearance *= scale;
  return problem;
}

// Where in the world a swimmer is changes no verdict, as long as its positions have digits; nor does it hide forgeries.
TEST(Places, change_no_verdict) {
  maneuver::Problem problem = swimmer(1.0, 1.0, false);
  problem.search.starts = 1;
  search::SolveOptions options;
  options.refinement = false;
  for (const double away : {0.0, 1e2, 1e3}) {
    problem.start.position = Vector3d(away, -0.3 * away, 0.0);
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << away << ": " << answer.solution.message;
    EXPECT_LE(answer.certificate.iterates_momentum, 1e-11) << away;
  }
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  for (const double away : {0.0, 1e6}) {
    maneuver::Problem heavier = problem;
    maneuver::Solution moved = answer.solution;
    const Vector3d shift(away, 0.0, 0.0);
    heavier.start.position += shift;
    for (Vector3d& x : moved.position) x += shift;
    heavier.swimmer.density *= 1.5;
    EXPECT_GT(certificate::certify(model::System(heavier.swimmer), heavier, moved).equation_residual, 1e-3) << away;
  }
}

TEST(Scale, of_length_changes_no_momentum_over_the_iterates) {
  for (const double scale : {1e-4, 1e4}) {
    maneuver::Problem problem = swimmer(scale, 1.0, false);
    problem.search.starts = 1;
    search::SolveOptions options;
    options.refinement = false;
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
    EXPECT_LE(answer.certificate.iterates_momentum, 1e-11) << scale;
    EXPECT_GT(answer.certificate.iterates_momentum, 0.0);
  }
}

// Limits that hold are kept in the second-order test in units of the swimmer's.
void expect_one_proof_at_all_scales(maneuver::Problem problem) {
  problem.search.starts = 1;
  search::SolveOptions options;
  options.refinement = false;
  std::vector<double> smallest;
  for (const double scale : {0x1p-10, 1.0, 0x1p10}) {
    maneuver::Problem asked = scaled(problem, scale);
    asked.cost_weights.work *= std::pow(scale, 5);
    asked.cost_weights.transport *= std::pow(scale, 6);
    const study::Answer answer = study::answer(model::System(asked.swimmer), asked, options);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << scale << ": " << answer.solution.message;
    ASSERT_TRUE(answer.certificate.second_order);
    smallest.push_back(answer.certificate.second_order->smallest_eigenvalue);
  }
  EXPECT_NEAR(smallest[0] / smallest[1], 1.0, 1e-4);
  EXPECT_NEAR(smallest[2] / smallest[1], 1.0, 1e-4);
}

TEST(Scale, of_length_changes_no_proof_of_a_gait_within_limits) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/examples/gait_within_limits.toml");
  problem.steps = 100;
  expect_one_proof_at_all_scales(problem);
}

// Costs have states of their own, moments and work, beside turns and displacements.
TEST(Scale, of_length_changes_no_proof_of_other_costs) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  problem.steps = 60;
  problem.cost_weights.smoothness = 1e-3;
  expect_one_proof_at_all_scales(problem);
  problem.cost_weights.power = 0.1;
  problem.cost_weights.work = 1e-3;
  expect_one_proof_at_all_scales(problem);
  problem.cost_weights = {};
  problem.goal->move = {problem.goal->move[0], std::nullopt, std::nullopt};
  problem.cost_weights.transport = 1e-4;
  expect_one_proof_at_all_scales(problem);
  problem.cost_weights = {};
  problem.cost_weights.smoothness = 1e-3;
  problem.goal->periodic = problem.start.free_shape = true;
  problem.goal->rest = false;
  for (const char* joint : {"b1", "b2"}) problem.limits.angle[joint] = {{-1.2, 1.2}};
  expect_one_proof_at_all_scales(problem);
}

// Ipopt's search, too: on splines, by shooting, and of a start in motion.
TEST(Scale, of_length_changes_nothing_but_units_for_ipopt) {
  for (const char* kind : {"spline", "shooting", "motion"}) {
    maneuver::Problem problem = swimmer(1.0, 1.0, false);
    problem.search.starts = 1;
    problem.steps = 40;
    const bool moving = kind == std::string("motion");
    if (moving) {
      problem.start.linear_velocity = Vector3d(0.01, 0.0, 0.0);
      problem.goal->rest = false;
    } else {
      problem.scheme = maneuver::Scheme::paper;
      problem.control = maneuver::ControlKind::spline;
      problem.points = 11;
      if (kind == std::string("shooting")) problem.search.method = maneuver::SearchMethod::shooting;
    }
    std::vector<maneuver::Solution> found;
    for (const double scale : {1.0, 0x1p-8, 0x1p8}) {
      maneuver::Problem asked = scaled(problem, scale);
      asked.start.linear_velocity *= scale;
      found.push_back(search::solve(model::System(asked.swimmer), asked, search::SolveOptions()).front());
      EXPECT_EQ(found.back().status, found.front().status) << kind << " at " << scale << ": " << found.back().message;
      EXPECT_NEAR(found.back().cost / std::pow(scale, 10), found.front().cost, tolerance(1e-8) * found.front().cost)
          << kind << " at " << scale;
    }
    EXPECT_EQ(found.front().status, maneuver::Status::optimal) << kind << ": " << found.front().message;
  }
}

// Where it gets by itself is where its momentum takes it, and what is beside that is as far beside it for its size.
TEST(Scale, of_length_changes_nothing_of_where_a_drifting_swimmer_gets_by_itself) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/drifting_turn.toml");
  problem.search.starts = 1;
  problem.start.rotation[1] = Vector3d(0.0, 0.0, 0.5);
  problem.goal->turn.reset();
  const model::System own(problem.swimmer);
  const double by_itself =
      maneuver::simulate(own, problem, maneuver::no_control(own), maneuver::SimulateOptions()).position.back()[0] -
      problem.start.position[0];
  for (const double beside : {0.0, 1e-5}) {
    problem.goal->move[0] = by_itself + beside;
    const auto solved = [&](double scale) {
      maneuver::Problem asked = scaled(problem, scale);
      asked.start.linear_velocity *= scale;
      return search::solve(model::System(asked.swimmer), asked, search::SolveOptions()).front();
    };
    const maneuver::Solution one = solved(1.0);
    EXPECT_EQ(one.status, maneuver::Status::optimal) << one.message;
    EXPECT_EQ(one.solver.name, beside > 0.0 ? "lamprey newton" : "without moments");
    for (const double scale : {0x1p-20, 0x1p-10, 0x1p10}) {
      const maneuver::Solution other = solved(scale);
      EXPECT_EQ(other.status, one.status) << scale << ": " << other.message;
      EXPECT_EQ(other.message, one.message) << scale;
      EXPECT_EQ(other.solver.name, one.solver.name) << scale;
      EXPECT_NEAR(other.cost / std::pow(scale, 10), one.cost, tolerance(1e-6) * one.cost) << scale;
    }
  }
}

// A goal that asks for what follows from the rest of it, and for something else: out of the plane by so much of the swimmer.
TEST(Scale, of_length_changes_nothing_of_what_a_solver_calls_out_of_reach) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/examples/translation.toml");
  problem.search.starts = 1;
  problem.steps = 40;
  problem.goal->move[2] = 0.0;
  for (const double scale : {0x1p-20, 0x1p-10, 1.0, 0x1p10}) {
    const maneuver::Problem asked = scaled(problem, scale);
    const model::System system(asked.swimmer);
    search::Solver solver(system, asked, search::solve(system, asked, search::SolveOptions()).front());
    maneuver::Goal goal = *asked.goal;
    goal.move[2] = 1e-3 * scale;
    solver.set_goal(goal);
    const optimizer::Outcome outcome = solver.solve();
    EXPECT_EQ(outcome.termination, optimizer::Termination::infeasible) << scale;
    EXPECT_NE(outcome.reason.find("cannot reach: goal.move along e₃ is missed by"), std::string::npos)
        << scale << ": " << outcome.reason;
  }
}

// Rates that hold from the first step on are kept by the moments of the start alone.
TEST(Scale, of_length_changes_no_proof_within_rates) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  problem.steps = 24;
  problem.limits.angular_velocity = 4.5;
  expect_one_proof_at_all_scales(problem);
}

// Multipliers of a duration are for all of it, those of limits on the way for each second.
TEST(Scale, of_time_changes_no_proof_within_angles_in_a_free_duration) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  problem.search.starts = 1;
  problem.steps = 40;
  for (const char* joint : {"b1", "b2"}) problem.limits.angle[joint] = {{-0.6, 0.6}};
  search::SolveOptions options;
  options.refinement = false;
  for (const double seconds : {1e-4, 1.0, 1e9}) {
    problem.duration = {.free = true, .value = seconds, .min = 0.1 * seconds, .max = 2.0 * seconds};
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << seconds << ": " << answer.solution.message;
  }
}

// What a cost is counted in is nobody's unit.
TEST(Scale, of_the_costs_weight_changes_no_minimum) {
  for (const maneuver::Scheme scheme : {maneuver::Scheme::trapezoid, maneuver::Scheme::order4}) {
    maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/examples/translation.toml");
    problem.scheme = scheme;
    if (scheme == maneuver::Scheme::order4) problem.rule.reset();
    problem.steps = scheme == maneuver::Scheme::order4 ? 50 : 100;
    problem.search.starts = 6;
    const auto solved = [&](double weight) {
      maneuver::Problem asked = problem;
      asked.effort = weight;
      return search::solve(model::System(asked.swimmer), asked, {}).front();
    };
    const maneuver::Solution one = solved(1.0);
    for (const double weight : {0x1p-30, 0x1p30}) {
      const maneuver::Solution other = solved(weight);
      EXPECT_EQ(other.search.solved, one.search.solved) << weight;
      EXPECT_NEAR(other.cost / weight, one.cost, tolerance(1e-9) * one.cost) << weight;
      EXPECT_EQ(other.solver.iterations, one.solver.iterations) << weight;
    }
  }
}

TEST(Scale, of_length_changes_no_certificate_of_bodies_that_touch_an_obstacle) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/examples/around_an_obstacle.toml");
  problem.steps = 40;
  problem.search.starts = 1;
  search::SolveOptions options;
  options.refinement = false;
  const auto answered = [&](double scale) {
    const maneuver::Problem asked = scaled(problem, scale);
    return study::answer(model::System(asked.swimmer), asked, options);
  };
  const study::Answer one = answered(1.0);
  ASSERT_TRUE(one.certificate.second_order && one.certificate.limits) << one.solution.message;
  EXPECT_FALSE(one.solution.limit_multipliers.empty());
  for (const double scale : {0x1p-10, 0x1p10}) {
    const study::Answer other = answered(scale);
    ASSERT_TRUE(other.certificate.second_order) << other.solution.message;
    EXPECT_EQ(other.certificate.verdict, one.certificate.verdict) << scale;
    EXPECT_LE(other.certificate.kkt, 1e-9);
    EXPECT_NEAR(other.certificate.second_order->smallest_eigenvalue, one.certificate.second_order->smallest_eigenvalue,
                1e-6);
    EXPECT_NEAR(other.solution.cost / std::pow(scale, 10), one.solution.cost, tolerance(1e-9) * one.solution.cost);
  }
}

// What a given duration costs is a constant: it changes no motion and no verdict, and hides no limit that pulls where it is not reached.
TEST(Scale, of_what_a_given_duration_costs_changes_no_verdict) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
  problem.steps = 60;
  problem.search.starts = 1;
  const auto answered = [](const maneuver::Problem& asked) {
    search::SolveOptions options;
    options.refinement = false;
    return study::answer(model::System(asked.swimmer), asked, options);
  };
  double widest = 0.0;
  for (const maneuver::Vectors& angles : answered(problem).solution.joint_angle)
    widest = std::max(widest, angles[0].cwiseAbs().maxCoeff());
  const double narrow = 0.8 * widest;
  problem.limits.angle["b1"] = {{-narrow, narrow}};
  const study::Answer cheap = answered(problem);
  ASSERT_EQ(cheap.certificate.verdict, certificate::Verdict::proved) << cheap.solution.message;
  problem.time_weight = 1e10;
  const study::Answer dear = answered(problem);
  EXPECT_EQ(dear.certificate.verdict, certificate::Verdict::proved) << dear.solution.message;
  EXPECT_NEAR(dear.certificate.second_order->smallest_eigenvalue, cheap.certificate.second_order->smallest_eigenvalue,
              tolerance(1e-6));
  EXPECT_NEAR(dear.certificate.limits->complementarity, cheap.certificate.limits->complementarity, 1e-9);
  maneuver::Problem wider = problem;
  wider.limits.angle["b1"] = {{-1.2 * narrow, 1.2 * narrow}};
  const certificate::Certificate forged = certificate::certify(model::System(wider.swimmer), wider, dear.solution);
  EXPECT_EQ(forged.verdict, certificate::Verdict::not_optimal);
}

}  // namespace
}  // namespace lamprey::tests
