// Goals and costs at the edges of what a problem file can ask for end in an answer like any other.
#include <gtest/gtest.h>

#include <numbers>

#include "certificate/certify.hpp"
#include "file/problem_file.hpp"
#include "guess/guess.hpp"
#include "lie/so3.hpp"
#include "marched_answers.hpp"
#include "search/first_motion.hpp"
#include "search/grids.hpp"
#include "study/answer.hpp"
#include "study/hull_with_fins.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

maneuver::Problem planar_chain() {
  maneuver::Problem problem = chain_problem(40, 1.0);
  for (model::JointDescription& joint : problem.swimmer.joints) joint.control_axes = {Vector3d(0, 0, 1)};
  problem.goal->turn.reset();
  problem.goal->move = {std::nullopt, std::nullopt, std::nullopt};
  return problem;
}

study::Answer answered(const maneuver::Problem& problem) {
  return study::answer(model::System(problem.swimmer), problem, {});
}

// Without its cost on other grids.
study::Answer answered_on_its_grid(const maneuver::Problem& problem) {
  search::SolveOptions options;
  options.refinement = false;
  return study::answer(model::System(problem.swimmer), problem, options);
}

// From rest, to rest anywhere or where the swimmer is: nothing is to be done.
TEST(UnusualGoals, where_the_swimmer_rests_cost_nothing) {
  for (maneuver::Scheme scheme : {maneuver::Scheme::trapezoid, maneuver::Scheme::order4})
    for (bool here : {false, true})
      for (bool work : {false, true}) {
        maneuver::Problem problem = planar_chain();
        problem.scheme = scheme;
        if (here) problem.goal->turn = Vector3d::Zero();
        if (here) problem.goal->move = {0.0, 0.0, std::nullopt};
        if (work && scheme == maneuver::Scheme::trapezoid) problem.cost_weights.work = 2.0;
        const study::Answer answer = answered(problem);
        EXPECT_EQ(answer.solution.cost, 0.0);
        EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
        EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
      }
}

// Whatever else is free: moments along splines, a duration, a gait's first shape.
TEST(UnusualGoals, that_cost_nothing_are_proved_and_not_called_strict) {
  for (const std::string kind : {"splines", "duration", "gait"}) {
    maneuver::Problem problem = planar_chain();
    problem.goal->turn = Vector3d::Zero();
    if (kind == "splines") problem.control = maneuver::ControlKind::spline, problem.points = 8;
    if (kind == "duration") problem.duration.free = true, problem.duration.min = 1.0, problem.duration.max = 2.0;
    if (kind == "gait") {
      problem.goal->periodic = problem.start.free_shape = true;
      problem.goal->rest = false;
    }
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.solution.cost, 0.0) << kind;
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << kind << ": " << answer.solution.message;
    EXPECT_NE(answer.solution.message.find("It costs nothing, and nothing less can be."), std::string::npos)
        << kind << ": " << answer.solution.message;
    EXPECT_EQ(answer.solution.message.find("strict"), std::string::npos) << kind;
  }
}

// Where a joint's angle is called zero is nobody's way: its goal may be on the other side of half a turn.
TEST(UnusualGoals, do_not_depend_on_where_angles_begin) {
  for (const model::JointKind kind : {model::JointKind::hinge, model::JointKind::universal})
    for (const bool fine : {false, true})
      for (const bool within : {false, true}) {
        std::vector<double> costs;
        for (const double zero : {0.0, std::numbers::pi}) {
          maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/bench/problems/three_hinges.toml");
          model::JointDescription& joint = problem.swimmer.joints[0];
          if (kind == model::JointKind::universal) {
            joint.kind = kind;
            joint.axes = {{Vector3d(0.0, 0.0, 1.0), Vector3d(0.0, 1.0, 0.0)}};
            joint.axis.reset();
          }
          joint.reference_rotation = Vector3d(0.0, 0.0, zero);
          problem.start.rotation[1] = Vector3d(0.0, 0.0, 3.0);
          problem.goal->move = {std::nullopt, std::nullopt, std::nullopt};
          problem.goal->turn = Vector3d::Zero();
          problem.goal->rotation = {{"b1", Vector3d(0.0, 0.0, -3.0)}, {"b2", std::nullopt}};
          problem.scheme = fine ? maneuver::Scheme::order4 : maneuver::Scheme::trapezoid;
          if (fine) problem.rule.reset();
          if (within && !fine && kind == model::JointKind::hinge && zero == 0.0)
            problem.limits.angle["b1"] = {{-3.1, 3.1}};
          problem.steps = 40;
          problem.search.starts = 3;
          const study::Answer answer = answered(problem);
          EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
          costs.push_back(answer.solution.cost);
        }
        if (within && !fine && kind == model::JointKind::hinge)
          EXPECT_GT(costs[0] / costs[1], 10.0) << "a limit keeps it from the shorter way";
        else
          EXPECT_NEAR(costs[0] / costs[1], 1.0, 1e-8);
      }
}

// Times that differ by round-off are one: what is asked at both is asked there.
TEST(UnusualGoals, of_waypoints_at_one_time_are_all_met) {
  maneuver::Problem problem = planar_chain();
  problem.goal->turn = Vector3d::Zero();
  problem.goal->move[0] = 0.3;
  maneuver::Waypoint front, back;
  front.time = 0.3 * problem.duration.value;
  back.time = std::nextafter(front.time, 2.0);
  front.rotation["front"] = Vector3d(0.0, 0.0, 0.5);
  back.rotation["back"] = Vector3d(0.0, 0.0, -0.4);
  for (const bool swapped : {false, true}) {
    problem.waypoints = swapped ? std::vector{back, front} : std::vector{front, back};
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    const auto turned = [&](std::size_t body) { return lie::log(answer.solution.rotation[12][body])[2]; };
    EXPECT_NEAR(turned(1), 0.5, 1e-8);
    EXPECT_NEAR(turned(2), -0.4, 1e-8);
  }
}

// What a given duration costs is no reason to search otherwise.
TEST(UnusualGoals, in_a_given_duration_are_searched_alike_whatever_time_costs) {
  for (maneuver::Scheme scheme : {maneuver::Scheme::trapezoid, maneuver::Scheme::order4}) {
    maneuver::Problem problem = planar_chain();
    problem.scheme = scheme;
    problem.goal->turn = Vector3d::Zero();
    problem.goal->move[0] = 0.4;
    const maneuver::Solution free = answered(problem).solution;
    problem.time_weight = 1e4 * free.cost;
    const maneuver::Solution dear = answered(problem).solution;
    EXPECT_EQ(free.solver.iterations, dear.solver.iterations);
    EXPECT_EQ(free.status, dear.status);
    EXPECT_NEAR(dear.cost - problem.time_weight * problem.duration.value, free.cost, 1e-10 * dear.cost);
  }
}

// Bodies in a row on joints of one kind, each moved about z alone.
maneuver::Problem flapping_row(int bodies, model::JointKind kind) {
  maneuver::Problem problem;
  problem.steps = 60;
  problem.duration.value = 1.5;
  problem.search.seed = 1;
  problem.swimmer.density = 1000.0;
  problem.start.rotation.assign(model::at(bodies), Vector3d::Zero());
  problem.start.angular_velocity = problem.start.rotation;
  for (int i = 0; i < bodies; ++i) {
    model::BodyDescription body;
    body.name = "b" + std::to_string(i);
    body.semi_axes = Vector3d(0.1, 0.04, 0.06 - 0.01 * i);
    problem.swimmer.bodies.push_back(body);
    if (i == 0) continue;
    model::JointDescription joint;
    joint.kind = kind;
    joint.name = "j" + std::to_string(i);
    joint.parent = problem.swimmer.bodies[model::at(i - 1)].name;
    joint.child = body.name;
    joint.parent_offset = {-0.11, 0.0, 0.0};
    joint.child_offset = {0.11, 0.0, 0.0};
    if (kind == model::JointKind::hinge) joint.axis = Vector3d::UnitZ();
    if (kind == model::JointKind::universal) {
      joint.axes = std::array<Vector3d, 2>{Vector3d::UnitZ(), Vector3d::UnitY()};
      joint.control_axes = {Vector3d::UnitZ()};
    }
    problem.swimmer.joints.push_back(joint);
  }
  problem.goal.emplace();
  return problem;
}

// Moments in a plane of symmetry leave it to no swimmer: the second axis of a universal joint is not felt. Where coordinates that
// are left are the first ones of all, they are not all of them.
TEST(UnusualGoals, a_universal_joint_moved_about_one_axis_swims_as_a_hinge_does) {
  for (int bodies : {2, 3}) {
    std::vector<double> costs;
    for (const model::JointKind kind : {model::JointKind::universal, model::JointKind::hinge}) {
      maneuver::Problem problem = flapping_row(bodies, kind);
      if (bodies == 2) {
        problem.goal->rotation["b0"] = Vector3d(0.0, 0.0, 0.1);
        problem.goal->rotation["b1"] = std::nullopt;
      } else {
        problem.goal->move[0] = 0.01;
        problem.goal->turn = Vector3d::Zero();
      }
      const study::Answer answer = answered(problem);
      EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
      costs.push_back(answer.solution.cost);
    }
    EXPECT_NEAR(costs[0], costs[1], 1e-9 * costs[1]) << bodies << " bodies";
  }
}

// Two fins on hinges turn a hull; a free duration, begun in the middle of its bounds, ran away to one of them before the goal was met.
TEST(UnusualGoals, in_free_durations_within_angle_limits_are_found_by_way_of_given_ones) {
  maneuver::Problem problem = hull_with_fins(100, {0.5, 6.0});
  problem.search.starts = 4;
  for (const double weight : {0.05, 50.0}) {
    problem.time_weight = weight;
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
    EXPECT_LE(answer.solution.time.back(), 6.0 + 1e-9);
  }
}

// Springs that are bent at the start, momentum of the joints: to stay is no motion, or no rest.
TEST(UnusualGoals, where_the_swimmer_cannot_stay_are_searched) {
  maneuver::Problem problem = planar_chain();
  problem.goal->turn = Vector3d::Zero();
  const auto met = [](const maneuver::Problem& asked) {
    const model::System system(asked.swimmer);
    return guess::met_by_rest(system, asked, maneuver::make_maneuver(system, asked, asked.steps));
  };
  problem.goal->move[0] = 0.4;
  EXPECT_FALSE(met(problem));
  problem.goal->move = {0.0, std::nullopt, std::nullopt};
  EXPECT_TRUE(met(problem));
  maneuver::Problem other = problem;
  other.swimmer.joints[1].stiffness = 3.0;  // bent
  EXPECT_FALSE(met(other));
  other = problem;
  other.swimmer.joints[0].stiffness = 3.0;  // at its zero angle
  EXPECT_TRUE(met(other));
  other = problem;
  other.goal->rest = false;
  other.start.angular_velocity[1] = Vector3d(0, 0, 0.2);
  EXPECT_FALSE(met(other));
  other = problem;
  other.waypoints.emplace_back().time = 0.5;
  EXPECT_FALSE(met(other));
}

// On the coarser grids that a search begins with, two waypoints may share a node.
TEST(UnusualGoals, with_waypoints_a_step_apart_are_met_where_the_motion_passes_anyway) {
  maneuver::Problem problem = planar_chain();
  problem.goal->turn = Vector3d::Zero();
  problem.goal->move[0] = 0.5;
  const study::Answer free = answered(problem);
  for (int node : {20, 21}) {
    maneuver::Waypoint waypoint;
    waypoint.time = free.solution.time[static_cast<std::size_t>(node)];
    const Vector3d moved = free.solution.position[static_cast<std::size_t>(node)] - free.solution.position.front();
    waypoint.move = {moved[0], moved[1], std::nullopt};
    problem.waypoints.push_back(waypoint);
  }
  const study::Answer passing = answered(problem);
  EXPECT_EQ(passing.certificate.verdict, certificate::Verdict::proved) << passing.solution.message;
  EXPECT_NEAR(passing.solution.cost / free.solution.cost, 1.0, 1e-6);
}

TEST(UnusualGoals, to_pass_a_point_and_come_to_rest_anywhere_is_proved) {
  maneuver::Problem problem = planar_chain();
  maneuver::Waypoint waypoint;
  waypoint.time = 0.5;
  waypoint.move = {0.05, std::nullopt, std::nullopt};
  problem.waypoints.push_back(waypoint);
  const study::Answer answer = answered(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
}

// The second-order test of free durations asks how fast joints turn at the start.
TEST(UnusualGoals, free_durations_with_every_other_cost_are_proved) {
  for (double maneuver::CostWeights::*weight :
       {&maneuver::CostWeights::work, &maneuver::CostWeights::power, &maneuver::CostWeights::smoothness}) {
    maneuver::Problem problem = planar_chain();
    problem.goal->turn = Vector3d::Zero();
    problem.goal->move[0] = 0.5;
    problem.duration.free = true;
    problem.duration.min = 0.7;
    problem.duration.max = 2.0;
    problem.cost_weights.*weight = 0.01;
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  }
}

// A gait of no length costs nothing; a metre has to be worth more than the first ones cost before one longer pays.
TEST(UnusualGoals, as_far_as_it_is_worth_stay_where_no_displacement_pays_and_go_further_the_more_it_is_worth) {
  maneuver::Problem problem = planar_chain();
  problem.goal->turn = Vector3d::Zero();
  problem.goal->periodic = problem.start.free_shape = true;
  problem.goal->rest = false;
  double moved = 0.0;
  for (double worth : {2e3, 3e4, 1e5}) {
    problem.cost_weights.displacement[0] = worth;
    const study::Answer answer = answered(problem);
    const double further = answer.solution.position.back()[0] - answer.solution.position.front()[0];
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    if (worth < 1e4) {
      EXPECT_EQ(answer.solution.cost, 0.0);
      EXPECT_NE(answer.solution.message.find("cost.displacement"), std::string::npos) << answer.solution.message;
      continue;
    }
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
    EXPECT_LT(answer.solution.cost, 0.0);
    EXPECT_GT(further, moved + 0.1);
    moved = further;
  }
}

// What a metre costs more at the answer is what it is worth: the price of the goal of a gait that has to go so far.
TEST(UnusualGoals, as_far_as_it_is_worth_end_where_the_price_of_a_metre_is_its_worth) {
  maneuver::Problem problem = planar_chain();
  problem.goal->turn = Vector3d::Zero();
  problem.goal->periodic = problem.start.free_shape = true;
  problem.goal->rest = false;
  problem.cost_weights.displacement[0] = 1e5;
  const study::Answer furthest = answered(problem);
  const double moved = furthest.solution.position.back()[0] - furthest.solution.position.front()[0];
  problem.cost_weights = {};
  const auto cost_of = [&](double distance) {
    problem.goal->move[0] = distance;
    return answered(problem).solution.cost;
  };
  EXPECT_NEAR(cost_of(moved) - 1e5 * moved, furthest.solution.cost, tolerance(1e-8) * 1e5 * moved);
  const double by = 0.01;
  EXPECT_NEAR((cost_of(moved + by) - cost_of(moved - by)) / (2.0 * by), 1e5, tolerance(1e-3) * 1e5);
}

// Multipliers of the limits are large beside the gradient of effort: weights must not bring round-off into them.
TEST(UnusualGoals, within_limits_that_pull_harder_than_effort_are_proved) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/gait_at_least_transport_50.toml");
  problem.search.starts = 1;
  problem.search.seed = 4;
  const study::Answer answer = answered(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LT(answer.certificate.kkt, 5e-9);
}

// Two nodes show half a turn of a joint at most: rates of about a whole turn a step, or several, are above that.
TEST(UnusualGoals, with_limits_of_rates_beyond_any_motion_are_those_without) {
  maneuver::Problem problem = planar_chain();
  problem.goal->turn = Vector3d::Zero();
  problem.goal->move[0] = 0.5;
  const study::Answer free = answered(problem);
  for (const double turns : {0.98, 1.01, 2.02, 20.3}) {  // a step
    problem.limits.angular_velocity = turns * 2.0 * std::numbers::pi / problem.time_step();
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << turns << ": " << answer.solution.message;
    EXPECT_NEAR(answer.solution.cost / free.solution.cost, 1.0, 1e-9) << turns;
  }
}

// Without its time limit, which says nothing on slow machines.
maneuver::Problem kept_problem(const std::string& name) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/" + name + ".toml");
  problem.search.time_limit.reset();
  return problem;
}

// Motors of two axes: each may turn as fast as the whole joint may where the whole is limited, so that what both allow lies between
// the whole at as much and at √2 times as much. Searched one from the other, costs fall. A hinge has one motor: its limits are one.
TEST(UnusualGoals, within_rates_of_motors_lie_between_those_within_rates_of_joints) {
  const auto within = [](const char* name, const study::Answer* from, const auto& limit) {
    maneuver::Problem problem = kept_problem(name);
    problem.search.starts = 1;
    limit(problem.limits);
    const model::System system(problem.swimmer);
    search::SolveOptions options;
    options.refinement = false;
    if (from) options.first = search::first_motion(system, problem, from->solution);
    study::Answer answer = study::answer(system, problem, options);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << name << answer.solution.message;
    EXPECT_FALSE(answer.certificate.limits->reached.empty()) << name << ": nothing is tested";
    return answer;
  };
  const auto whole = [&](const char* name, double rate, const study::Answer* from = nullptr) {
    return within(name, from, [rate](maneuver::Limits& limits) { limits.angular_velocity = rate; });
  };
  const auto each = [&](const char* name, double rate, const study::Answer* from = nullptr) {
    return within(name, from, [rate](maneuver::Limits& limits) { limits.angular_velocity_component = rate; });
  };
  const study::Answer narrow = whole("universal_chain", 6.0), middle = each("universal_chain", 6.0, &narrow),
                      wide = whole("universal_chain", 6.0 * std::numbers::sqrt2, &middle);
  EXPECT_LT(middle.solution.cost, narrow.solution.cost);
  EXPECT_LT(wide.solution.cost, middle.solution.cost);
  EXPECT_NEAR(each("three_hinges", 5.0).solution.cost / whole("three_hinges", 5.0).solution.cost, 1.0, 1e-9);
}

// What digits leave of momenta over short steps is no leak, whatever the swimmer's size and units.
TEST(UnusualGoals, of_slow_small_swimmers_in_many_steps_are_proved) {
  for (const char* name : {"three_links_in_1000_steps", "links_of_two_centimetres"}) {
    const study::Answer answer = answered(kept_problem(name));
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << name << answer.solution.message;
    EXPECT_GT(answer.certificate.momentum_round_off, evidence::momentum_mark) << name;
    EXPECT_LT(answer.certificate.momentum_drift, answer.certificate.momentum_round_off) << name;
    study::Answer leaking = answer;
    leaking.solution.rotation[400][1] = leaking.solution.rotation[400][1] * lie::exp(Vector3d(0, 0, 1e-12));
    const maneuver::Problem problem = kept_problem(name);
    EXPECT_EQ(certificate::certify(model::System(problem.swimmer), problem, leaking.solution).verdict,
              certificate::Verdict::not_optimal)
        << name;
  }
}

TEST(UnusualGoals, of_light_arms_are_found_from_every_seed) {
  maneuver::Problem problem = kept_problem("two_arms_yaw");
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    problem.search.seed = seed;
    const study::Answer answer = answered_on_its_grid(problem);
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << seed << answer.solution.message;
  }
}

// Wide swings on the way of a swimmer that drifts lead searches astray, to whirls or nowhere.
TEST(UnusualGoals, of_a_swimmer_that_drifts_are_found_from_every_guess) {
  const maneuver::Problem problem = kept_problem("drifting_turn");
  const study::Answer answer = answered_on_its_grid(problem);
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_EQ(answer.solution.search.solved, problem.search.starts);
  EXPECT_EQ(answer.solution.search.minima.size(), 1U);
}

TEST(UnusualGoals, of_passive_joints_in_free_time_go_on_to_finer_steps) {
  const study::Answer answer = answered_on_its_grid(kept_problem("passive_tail_in_free_time"));
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LT(answer.solution.cost, -0.5);
}

TEST(UnusualGoals, of_a_gait_that_need_not_move_are_met_at_rest) {
  maneuver::Problem problem = planar_chain();
  problem.goal->rest = false;
  problem.goal->periodic = problem.start.free_shape = true;
  const study::Answer answer = answered(problem);
  EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.solution.cost, 0.0);
}

// Which conditions are independent is seen at a motion: a first guess that leads to none says nothing about it, nor does how far
// perturbations grow along one that is long and unstable.
TEST(UnusualGoals, have_the_same_independent_conditions_whatever_the_seed) {
  struct Case {
    const char* name;
    std::size_t rows;
    Eigen::Index shape;
  };
  for (const Case& expected : {Case{"chain_of_five_seed_3", 10, 6}, Case{"chain_of_five_turns", 15, 12}}) {
    maneuver::Problem problem = kept_problem(expected.name);
    const model::System system(problem.swimmer);
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      problem.search.seed = seed;
      const search::Reached reached(system, problem);
      EXPECT_EQ(reached.rows.size(), expected.rows) << expected.name << " seed " << seed;
      EXPECT_EQ(reached.coordinates.shape.cols(), expected.shape) << expected.name << " seed " << seed;
      EXPECT_EQ(reached.coordinates.pose.cols(), 6) << expected.name << " seed " << seed;
    }
  }
}

// A chain of universal joints whose servos stop at each axis: both solvers find the same motion within, and a looser limit costs
// less by its multiplier.
TEST(UnusualGoals, within_limits_about_each_axis_of_universal_joints_are_proved) {
  const auto within = [](double most) {
    maneuver::Problem problem = planar_chain();
    for (model::JointDescription& joint : problem.swimmer.joints) {
      joint.kind = model::JointKind::universal;
      joint.axes = {Vector3d(0, 0, 1), Vector3d(0, 1, 0)};
      joint.control_axes.reset();
    }
    problem.goal->turn = Vector3d(0.1, 0.0, 0.0);
    problem.goal->move = {0.2, std::nullopt, std::nullopt};
    problem.limits.angle["front"] = {{-most, most}, {-0.2, 0.2}};
    problem.limits.angle["back"] = {{-0.5, 0.9}, {-0.2, 0.2}};
    return problem;
  };
  study::Answer last;
  search::SolveOptions options;
  options.refinement = false;
  const auto answer_within = [&](double most) {
    const maneuver::Problem problem = within(most);
    const model::System system(problem.swimmer);
    if (options.first) options.first = search::first_motion(system, problem, last.solution);
    return study::answer(system, problem, options);
  };
  last = answer_within(0.2);
  options.first.emplace();  // from here on from that motion
  const study::Answer answer = answer_within(0.2);
  ASSERT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  std::array<bool, 2> held{};
  double worth = 0.0;  // of the limits about the first axis of the front joint, for each rad
  for (const maneuver::LimitMultiplier& own : answer.solution.limit_multipliers) {
    held[model::at(own.component)] = true;
    if (own.joint == 0 && own.component == 0)
      for (const double multiplier : own.multiplier) worth += multiplier * within(0.2).time_step();
  }
  EXPECT_TRUE(held[0] && held[1]);
  EXPECT_GT(worth, 0.0);
  constexpr double by = 1e-4;
  const double less = answer_within(0.2 - by).solution.cost, more = answer_within(0.2 + by).solution.cost;
  EXPECT_NEAR((less - more) / (2.0 * by), worth, 1e-4 * worth);
  last = answer;
  options.solver = search::Backend::ipopt;
  EXPECT_NEAR(answer_within(0.2).solution.cost, answer.solution.cost, tolerance(1e-7) * answer.solution.cost);
}

// Small strokes win by the square of their size and cost by it: twice as far costs twice as much. At rest nothing is lost but
// the goal, and the phase of a small gait hardly matters: neither may hold a search up.
TEST(UnusualGoals, of_the_smallest_strokes_cost_in_proportion_to_their_distance) {
  std::vector<double> cost;
  for (const double distance : {1e-2, 1e-3, 1e-4}) {
    maneuver::Problem problem = planar_chain();
    problem.steps = 100;
    problem.start.free_shape = problem.goal->periodic = true;
    problem.goal->rest = false;
    problem.goal->turn = Vector3d::Zero();
    problem.goal->move[0] = distance;
    for (const char* joint : {"front", "back"}) problem.limits.swing[joint] = 1.2;
    problem.search.starts = 4;
    const study::Answer answer = answered(problem);
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << distance << ": " << answer.solution.message;
    EXPECT_LE(answer.solution.solver.evaluations, 6000) << distance;
    cost.push_back(answer.solution.cost / distance);
  }
  EXPECT_NEAR(cost[1] / cost[0], 1.0, 0.02);
  EXPECT_NEAR(cost[2] / cost[1], 1.0, 2e-3);
}

// Small strokes answer to a goal's rows by the square of what they bend: multipliers are far above the cost there.
TEST(UnusualGoals, of_a_whole_pose_near_the_start_are_proved_minima) {
  maneuver::Problem problem = file::read_problem(LAMPREY_SOURCE_DIR "/examples/three_links.toml");
  problem.goal.emplace();
  problem.goal->move = {0.0012224901894711255, -0.020719475618523317, std::nullopt};
  problem.goal->rotation["middle"] = Vector3d(0.0, 0.0, -0.02994868489823914);
  problem.goal->rotation["head"] = Vector3d(0.0, 0.0, 0.2700513151017609);
  problem.goal->rotation["tail"] = Vector3d(0.0, 0.0, -0.20994868489823912);
  problem.steps = 200;
  problem.duration.value = 1.0;
  problem.search.starts = 2;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved) << answer.solution.message;
  EXPECT_LE(answer.certificate.kkt, 1e-9);
}

// A wheel on a satellite, of which as much is asked as whole turns of the wheel give: to and fro it gives nothing. Steps have
// these turns but for the square of their length.
TEST(UnusualGoals, that_whole_turns_reach_are_not_called_out_of_reach) {
  maneuver::Problem problem;
  const auto cylinder = [](const char* name, double inertia) {
    model::BodyDescription body;
    body.name = name;
    body.semi_axes = Vector3d(0.5, 0.5, 0.1);
    body.mass = 10.0;
    body.body_inertia = (inertia * Vector3d(0.6, 0.6, 1.0)).asDiagonal();
    return body;
  };
  problem.swimmer.bodies = {cylinder("bus", 10.0), cylinder("wheel", 0.8)};
  model::JointDescription joint;
  joint.name = joint.child = "wheel";
  joint.parent = "bus";
  joint.kind = model::JointKind::hinge;
  joint.axis = Vector3d(0, 0, 1);
  joint.parent_offset = joint.child_offset = Vector3d::Zero();
  problem.swimmer.joints = {joint};
  problem.start.rotation.assign(2, Vector3d::Zero());
  problem.start.angular_velocity.assign(2, Vector3d::Zero());
  problem.steps = 100;
  problem.duration.value = 10.0;
  problem.search.starts = 16;
  problem.goal = maneuver::Goal{};
  for (const int turns : {1, -1}) {
    problem.goal->turn = Vector3d(0, 0, 2.0 * M_PI * turns * 0.8 / 10.8);
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, {});
    EXPECT_NE(answer.solution.status, maneuver::Status::infeasible) << answer.solution.message;
    EXPECT_LT(answer.certificate.goal_error, 1e-2);
    EXPECT_NEAR(answer.solution.joint_angle.back()[0].x(), -2.0 * M_PI * turns, 1e-2);
  }
  problem.limits.angle["wheel"] = {{-3.0, 3.0}};
  const study::Answer none = study::answer(model::System(problem.swimmer), problem, {});
  EXPECT_EQ(none.solution.status, maneuver::Status::infeasible);
  EXPECT_NE(none.solution.message.find("cannot turn right round"), std::string::npos) << none.solution.message;
}

// A joint that turns at the start works from there on: the first half step counts from its own rate. By two solvers that share no
// formula, and by the certificate's.
TEST(UnusualGoals, work_of_joints_that_turn_at_the_start_counts_from_their_rates_there) {
  maneuver::Problem problem = flapping_row(2, model::JointKind::hinge);
  problem.steps = 4;
  problem.start.angular_velocity[0] = Vector3d(0, 0, 0.5);
  const model::System system(problem.swimmer);
  const integrator::State start = maneuver::start_without_momentum(system, problem.start);
  const Eigen::VectorXd velocity = integrator::velocity_of_state(system, start);
  problem.start.angular_velocity = mechanics::angular_velocities(system, start.rotation, velocity);
  problem.start.linear_velocity = velocity.tail<3>();
  problem.goal->rotation["b0"] = Vector3d(0.0, 0.0, -0.4);
  problem.goal->rotation["b1"] = std::nullopt;
  problem.cost_weights.work = 0.01;
  for (const search::Backend backend : {search::Backend::newton, search::Backend::ipopt}) {
    search::SolveOptions options;
    options.solver = backend;
    const study::Answer answer = study::answer(system, problem, options);
    ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
    EXPECT_LE(answer.certificate.costs->error, tolerance(1e-10));
  }
}

// Searches for little work that stall from afar arrive from the motion of least effort.
TEST(UnusualGoals, gaits_of_little_transport_with_a_passive_fin_are_found_by_way_of_effort) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/transport_of_a_tail.toml");
  problem.search.starts = 2;
  search::SolveOptions options;
  options.refinement = false;
  options.workers = 2;
  const study::Answer answer = study::answer(model::System(problem.swimmer), problem, options);
  ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
  EXPECT_LT(answer.solution.cost, 250.0);
}

// Each axis of a universal joint has a motor of its own, as two hinges with a small body between have: nothing is won back from
// one to the other.
TEST(UnusualGoals, little_work_of_a_universal_joint_is_that_of_two_hinges) {
  maneuver::Problem universal =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/work_of_a_universal_joint.toml");
  universal.steps = 50;
  universal.search.starts = 1;
  maneuver::Problem hinges = universal;
  model::BodyDescription between;
  between.name = "between";
  between.semi_axes.setConstant(0.005);
  hinges.swimmer.bodies.insert(hinges.swimmer.bodies.begin() + 1, between);
  hinges.start.rotation.assign(3, Vector3d::Zero());
  hinges.start.angular_velocity.assign(3, Vector3d::Zero());
  model::JointDescription& first = hinges.swimmer.joints[0];
  first.kind = model::JointKind::hinge;
  first.axes.reset();
  model::JointDescription second = first;
  first.name = first.child = between.name;
  first.child_offset.setZero();
  first.axis = Vector3d::UnitZ();
  second.parent = between.name;
  second.parent_offset.setZero();
  second.axis = Vector3d::UnitY();
  hinges.limits.angle = {{first.name, {{-1.2, 1.2}}}, {second.name, {{-1.2, 1.2}}}};
  hinges.swimmer.joints.push_back(second);
  std::vector<double> costs;
  for (const maneuver::Problem& problem : {universal, hinges}) {
    const study::Answer answer = answered(problem);
    ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
    costs.push_back(answer.solution.cost);
  }
  EXPECT_NEAR(costs[0], costs[1], tolerance(1e-4) * costs[1]);
}

// Work does not feel at which node a joint turns back: terms that do would drive the turn from node to node.
TEST(UnusualGoals, little_work_on_fine_steps_is_proved_where_joints_turn_back) {
  maneuver::Problem problem =
      file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/bench/problems/work_of_a_universal_joint.toml");
  problem.search.starts = 1;
  const study::Answer answer = answered(problem);
  ASSERT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
  EXPECT_EQ(answer.certificate.verdict, certificate::Verdict::proved);
  EXPECT_LE(answer.certificate.costs->signs, tolerance(1e-8));
}

// Where work is what costs, moments come in impulses at any steps: the answer says what makes them smooth.
TEST(UnusualGoals, answers_of_work_alone_on_coarse_steps_ask_for_smoother_moments) {
  maneuver::Problem problem = file::read_problem(std::string(LAMPREY_SOURCE_DIR) + "/examples/ellipses.toml");
  problem.steps = 50;
  problem.search.starts = 1;
  const auto message_with = [&](double work) {
    problem.cost_weights.work = work;
    const study::Answer answer = study::answer(model::System(problem.swimmer), problem, search::SolveOptions());
    EXPECT_EQ(answer.solution.status, maneuver::Status::optimal) << answer.solution.message;
    return answer.solution.message;
  };
  const std::string steps = "try [time] steps = ", smoother = "makes moments smoother";
  const std::string effort = message_with(0.0), impulses = message_with(10.0);
  EXPECT_NE(effort.find(steps), std::string::npos) << effort;
  EXPECT_EQ(effort.find(smoother), std::string::npos) << effort;
  EXPECT_NE(impulses.find(smoother), std::string::npos) << impulses;
  EXPECT_NE(effort.find("Servos that lead the joints along its angles end"), std::string::npos) << effort;
}

}  // namespace
}  // namespace lamprey::tests
