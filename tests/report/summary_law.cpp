#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tuple>

#include "file/problem_file.hpp"
#include "lie/so3.hpp"
#include "report/cost_shares.hpp"
#include "report/joint_demands.hpp"
#include "report/momentum_lines.hpp"
#include "report/sample_results.hpp"
#include "report/summary.hpp"
#include "report/wording.hpp"
#include "task/tasks.hpp"

namespace lamprey {
namespace {

report::CertificateRow row(const result::Results& results, const std::string& name) {
  for (const auto& row : report::certificate_rows(*results.certificate, results.problem)) {
    if (row.name == name) return row;
  }
  throw std::out_of_range(name);
}

using Fault = void (*)(certificate::Certificate&);

struct MarkedRow {
  const char* name;
  Fault beyond, within;
};

TEST(CertificateRows, hold_within_their_marks_and_not_beyond) {
  using certificate::Certificate;
  const MarkedRow rows[] = {
      {"Goal error", [](Certificate& c) { c.goal_error = 1.1e-9; }, [](Certificate& c) { c.goal_error = 0.9e-9; }},
      {"Rest error", [](Certificate& c) { c.rest_error = 1.1e-9; }, [](Certificate& c) { c.rest_error = 0.9e-9; }},
      {"Momentum drift", [](Certificate& c) { c.momentum_drift = 1.1e-11; },
       [](Certificate& c) { c.momentum_drift = 0.9e-11; }},
      {"Momentum over all iterates", [](Certificate& c) { c.iterates_momentum = 1.1e-11; },
       [](Certificate& c) { c.iterates_momentum = 0.9e-11; }},
      {"First-order optimality (KKT)", [](Certificate& c) { c.kkt = 1.1e-8; }, [](Certificate& c) { c.kkt = 0.9e-8; }},
      {"Smallest curvature", [](Certificate& c) { c.second_order->positive = false; },
       [](Certificate& c) { c.second_order->positive = true; }},
      {"Replay, rotation", [](Certificate& c) { c.replay->rotation_error = 1.1e-3; },
       [](Certificate& c) { c.replay->rotation_error = 0.9e-3; }},
      {"Replay with feedback, rotation", [](Certificate& c) { c.replay->feedback_rotation_error = 1.1e-2; },
       [](Certificate& c) { c.replay->feedback_rotation_error = 0.9e-2; }},
  };
  for (const MarkedRow& marked : rows) {
    result::Results results = tests::sample_results(5);
    marked.beyond(*results.certificate);
    EXPECT_EQ(row(results, marked.name).holds, std::optional(false)) << marked.name;
    marked.within(*results.certificate);
    EXPECT_EQ(row(results, marked.name).holds, std::optional(true)) << marked.name;
  }
}

TEST(CertificateRows, mark_what_is_the_solvers_own_record) {
  const result::Results results = tests::sample_results(5);
  for (const char* name : {"Momentum over all iterates", "Cost at half the step", "Observed order", "Cost in the limit",
                           "Discretisation error of the cost"})
    EXPECT_TRUE(row(results, name).stored) << name;
  for (const char* name : {"Goal error", "Momentum drift", "Replay, rotation", "Unactuated moment"})
    EXPECT_FALSE(row(results, name).stored) << name;
}

TEST(CertificateRows, ask_no_rest_of_gaits) {
  result::Results results = tests::sample_results(5);
  results.problem.goal->periodic = true;
  EXPECT_NE(row(results, "Rest error").value, "not required") << "it is asked for";
  results.problem.goal->rest = false;
  EXPECT_EQ(row(results, "Rest error").value, "not required");
}

TEST(CertificateRows, hold_kkt_to_the_tolerance_of_the_problem) {
  result::Results results = tests::sample_results(5);
  results.certificate->kkt = 5e-7;
  EXPECT_EQ(row(results, "First-order optimality (KKT)").holds, std::optional(false));
  results.problem.tolerance = 1e-6;
  EXPECT_EQ(row(results, "First-order optimality (KKT)").holds, std::optional(true));
}

TEST(CertificateRows, give_no_mark_to_what_was_not_computed_or_not_asked_for) {
  result::Results results = tests::sample_results(5);
  results.certificate = certificate::Certificate{};
  for (const auto& empty : report::certificate_rows(*results.certificate, results.problem)) {
    EXPECT_EQ(empty.value, "not computed") << empty.name;
    EXPECT_FALSE(empty.holds.has_value()) << empty.name;
    EXPECT_FALSE(empty.meaning.empty()) << empty.name;
  }
  results = tests::sample_results(5);
  results.certificate->rest_error = 0.4;
  results.problem.goal->rest = false;
  EXPECT_FALSE(row(results, "Rest error").holds.has_value());
  EXPECT_EQ(row(results, "Rest error").mark, "");
}

TEST(Clearance, is_told_with_bodies_and_time_and_overlap_as_a_plain_fact) {
  result::Results results = tests::sample_results(5);
  EXPECT_EQ(row(results, "Clearance").value, "0.519 m: middle and front at 0.42 s");
  results.problem.limits.clearance = 0.5;
  EXPECT_EQ(row(results, "Clearance").value, "0.519 m: middle and front at 0.42 s");
  results.problem.limits.clearance = 0.6;
  EXPECT_EQ(row(results, "Clearance").value,
            "0.519 m: middle and front at 0.42 s, where the limit of 0.6 m holds at nodes alone");
  results.certificate->clearance = evidence::Clearance{-0.31, 0.42, 1, 2};
  const std::string overlap = "bodies pass through each other: front and rear by 0.31 m at 0.42 s";
  EXPECT_EQ(row(results, "Clearance").value, overlap + " (limits.clearance asks for 0.6 m, at nodes)");
  results.problem.limits.clearance.reset();
  EXPECT_EQ(row(results, "Clearance").value, overlap);
  EXPECT_FALSE(row(results, "Clearance").holds.has_value());
  const auto told = report::facts(results);
  EXPECT_NE(std::find(told.begin(), told.end(), std::pair<std::string, std::string>("Clearance", overlap)), told.end());
  results.certificate->clearance = evidence::Clearance{};
  EXPECT_EQ(row(results, "Clearance").value, "not computed");
}

TEST(CostShares, are_told_where_there_is_more_than_effort) {
  result::Results results = tests::sample_results(5);
  EXPECT_TRUE(report::cost_shares(results).empty());
  results.problem.time_weight = 7.0;
  results.solution.cost = 100.0;
  const double of_time = 7.0 * results.solution.time.back();
  using Shares = std::vector<std::pair<std::string, double>>;
  EXPECT_EQ(report::cost_shares(results), (Shares{{"effort", 100.0 - of_time}, {"time", of_time}}));
  results.problem.effort = 0.5;
  results.problem.cost_weights.work = 30.0;
  results.solution.cost_parts = maneuver::CostParts{.effort = 10.0, .work = 2.0, .power = 5.0};
  EXPECT_EQ(report::cost_shares(results), (Shares{{"effort", 5.0}, {"work", 60.0}, {"time", of_time}}));
  results.problem.cost_weights.displacement = {-3.0, 0.0, 0.0};
  const double moved = results.solution.position.back()[0] - results.solution.position.front()[0];
  EXPECT_EQ(report::cost_shares(results).back(), (std::pair<std::string, double>("displacement", 3.0 * moved)));
  const auto told = report::facts(results);
  EXPECT_NE(std::find_if(told.begin(), told.end(), [](const auto& row) { return row.first == "Shares of the cost"; }),
            told.end());
}

TEST(Verdict, calls_optimal_only_what_is) {
  using maneuver::Status;
  result::Results results = tests::sample_results(5);
  EXPECT_EQ(report::verdict(results).substr(0, 8), "Optimal:") << "of files without a verdict";
  results.certificate->verdict = certificate::Verdict::stationary;
  EXPECT_EQ(report::verdict(results).substr(0, 23), "Stationary, not proved:");
  results.certificate->verdict = certificate::Verdict::proved;
  EXPECT_EQ(report::verdict(results).substr(0, 21), "Proved local minimum:");
  for (const Status status :
       {Status::feasible, Status::infeasible, Status::stalled, Status::time_limit, Status::interrupted}) {
    results.solution.status = status;
    EXPECT_FALSE(report::succeeded(results));
    EXPECT_NE(report::verdict(results).substr(0, 7), "Optimal");
    EXPECT_EQ(report::verdict(results).find("local minimum"), std::string::npos);
  }
}

TEST(CertificateRows, tell_directions_of_descent_and_whether_axes_are_confined) {
  result::Results results = tests::sample_results(5);
  EXPECT_EQ(row(results, "Curvature, all axes free").value, "no axes are confined");
  results.certificate->all_axes = optimality::AllAxes{1e-12, {-246.0, false, 14}};
  EXPECT_EQ(row(results, "Curvature, all axes free").value, "−246 (14 descent directions)");
  EXPECT_FALSE(row(results, "Curvature, all axes free").holds.has_value());
}

TEST(Verdict, says_missed_when_the_goal_is_missed_and_in_which_unit) {
  result::Results results = tests::sample_results(5);
  results.problem.goal->move = {};
  EXPECT_NE(report::verdict(results).find("goal reached within 3.1×10⁻¹² rad"), std::string::npos)
      << report::verdict(results);
  results.problem.goal->turn.reset();
  results.problem.goal->move[0] = 2.0;
  EXPECT_NE(report::verdict(results).find("goal reached within 3.1×10⁻¹² m"), std::string::npos)
      << report::verdict(results);
  results.solution.status = maneuver::Status::infeasible;
  results.certificate->goal_error = 0.25;
  results.solution.position.back().x() += 0.25;
  EXPECT_NE(report::verdict(results).find("goal.move along e₁ missed by 0.25 m"), std::string::npos)
      << report::verdict(results);
}

// Of a goal that asks for places and attitudes the row that is off most has the word, as the certificate found it.
TEST(Verdict, names_the_row_of_the_goal_that_is_missed_most_and_its_unit_alone) {
  result::Results results = tests::sample_results(5);
  results.problem.goal->move[0] = 2.0;
  results.certificate->goal_error = 0.25;
  results.certificate->goal_missed = "the end attitude of front";
  EXPECT_NE(report::verdict(results).find("the end attitude of front missed by 0.25 rad,"), std::string::npos)
      << report::verdict(results);
  results.certificate->goal_missed = "goal.move along e₂";
  results.certificate->goal_missed_by_turn = false;
  EXPECT_NE(report::verdict(results).find("goal.move along e₂ missed by 0.25 m,"), std::string::npos)
      << report::verdict(results);
  results.certificate->goal_error = 3e-12;
  EXPECT_NE(report::verdict(results).find("goal reached within 3×10⁻¹² m,"), std::string::npos)
      << report::verdict(results);
  results.certificate->goal_missed.clear();  // as files do not tell it: seen from the motion
  results.solution.position.back() = results.solution.position.front();
  results.certificate->goal_error = 2.0;
  EXPECT_NE(report::verdict(results).find(" m,"), std::string::npos) << report::verdict(results);
  EXPECT_EQ(report::verdict(results).find("(rad, m)"), std::string::npos) << report::verdict(results);
}

TEST(Verdict, says_that_there_is_no_motion_and_nothing_of_its_cost) {
  result::Results results = tests::sample_results(5);
  const auto says = [&](const std::string& name) {
    const auto rows = report::facts(results);
    return std::any_of(rows.begin(), rows.end(), [&](const auto& entry) { return entry.first == name; });
  };
  EXPECT_TRUE(says("Cost"));
  EXPECT_FALSE(report::momentum_lines(results).empty());
  results.solution.status = maneuver::Status::stalled;
  results.certificate->equation_residual = 0.064;
  EXPECT_EQ(report::verdict(results),
            "Stalled before it was optimal: what is shown is no motion but the search’s last trial, whose steps "
            "do not "
            "follow from each other (by 0.064 of the momentum’s scale)");
  EXPECT_FALSE(says("Cost") || says("Clearance") || says("Work of the joints"));
  EXPECT_TRUE(report::momentum_lines(results).empty());
}

TEST(Facts, give_the_cost_of_transport_by_the_work_that_the_replay_sees_between_the_nodes) {
  result::Results results = tests::sample_results(5);
  results.problem.goal->periodic = true;
  const auto said = [&](const std::string& name) -> std::string {
    for (const auto& [key, value] : report::facts(results))
      if (key == name) return value;
    return "";
  };
  results.certificate->replay->work = std::nan("");
  const std::string at_nodes = said("Cost of transport");
  ASSERT_NE(at_nodes, "");
  results.certificate->replay->work = std::stod(said("Work of the joints"));
  EXPECT_EQ(said("Cost of transport"), at_nodes);
  results.certificate->replay->work *= 10.0;
  const std::string both = said("Cost of transport");
  EXPECT_NEAR(std::stod(both) / std::stod(at_nodes), 10.0, 1e-3) << both;
  EXPECT_NE(both.find("by the replay's work, " + at_nodes + " by the nodes'"), std::string::npos) << both;
}

TEST(Facts, tell_how_many_searches_arrived_and_name_the_solver_as_its_option_does) {
  result::Results results = tests::sample_results(5);
  const auto said = [&](const std::string& name) -> std::string {
    for (const auto& [key, value] : report::facts(results))
      if (key == name) return value;
    return "";
  };
  results.solution.solver.name = "lamprey newton";
  EXPECT_EQ(said("Solver"), "newton");
  EXPECT_EQ(said("First guesses"), "59 of 60 arrived, at 5 different minima");
  results.solution.search.hops = 4;
  EXPECT_EQ(said("First guesses"), "59 of 64 (60 random, 4 hops) arrived, at 5 different minima");
  EXPECT_NE(said("Work of the joints").find(" J (no regeneration)"), std::string::npos);
  EXPECT_NE(said("Displacement"), "");
}

TEST(Facts, tell_how_the_root_has_turned_where_the_goal_leaves_that_open) {
  result::Results results = tests::sample_results(5);
  const std::string root = results.problem.bodies.front().name;
  const auto told = [&] {
    for (const auto& [key, value] : report::facts(results))
      if (key == "Turn of " + root) return true;
    return false;
  };
  results.problem.goal->turn = Eigen::Vector3d::Zero();
  EXPECT_FALSE(told());
  results.problem.goal->rotation = {{root, std::nullopt}};
  EXPECT_TRUE(told());
  results.problem.goal->turn.reset();
  results.problem.goal->rotation = {{root, Eigen::Vector3d::Zero()}};
  EXPECT_FALSE(told());
  results.problem.goal->rotation = {};
  results.problem.goal->shape_of_start = true;
  EXPECT_TRUE(told());
}

// Of gaits and maneuvers alike, from the first attitude to the last; a half turn by the way round that was asked.
TEST(Facts, tell_the_turn_that_was_asked) {
  result::Results results = tests::sample_results(5);
  const std::string root = results.problem.bodies.front().name;
  const auto told = [&] {
    std::vector<std::string> turns;
    for (const auto& [key, value] : report::facts(results))
      if (key == "Turn of " + root) turns.push_back(value);
    EXPECT_LE(turns.size(), 1U);
    return turns.empty() ? "" : turns.front();
  };
  const Eigen::Matrix3d first = lie::exp({0.3, -0.2, 0.5});
  results.solution.rotation.front()[0] = first;
  for (const double angle : {0.25, -2.0, std::numbers::pi, -std::numbers::pi}) {
    const Eigen::Vector3d turn(0.0, 0.0, angle);
    results.solution.rotation.back()[0] = lie::exp(turn) * first;
    results.problem.goal->rotation = {};
    results.problem.goal->turn = turn;
    const std::string words = fmt::format("(0, 0, {}) rad, {}°", report::number(angle, 6),
                                          report::number(std::abs(angle) * 180.0 / std::numbers::pi, 5));
    for (const bool periodic : {false, true}) {
      results.problem.goal->periodic = periodic;
      EXPECT_EQ(told(), words);
    }
    results.problem.goal->turn = Eigen::Vector3d::Zero();
    EXPECT_EQ(told(), "") << "none was asked";
    results.problem.start = result::ResolvedStart{{first}, {}, {}, {}};
    results.problem.goal->rotation = {{root, lie::log(lie::exp(turn) * first)}};
    if (std::abs(angle) < 3.0) {
      EXPECT_EQ(told(), words);
    }
    results.problem.goal->rotation = {{root, lie::log(first)}};
    EXPECT_EQ(told(), "") << "its attitude was to stay";
  }
}

TEST(MomentumLines, tell_signs_of_motions_that_arrive_alone) {
  result::Results results = tests::sample_results(5);
  EXPECT_EQ(report::momentum_lines(results).size(), 3U);
  results.certificate->goal_error = 0.1;
  EXPECT_EQ(report::momentum_lines(results).size(), 1U);
}

TEST(MomentumLines, tell_what_the_fluid_carries_beside_the_bodies) {
  const std::vector<std::string> lines = report::momentum_lines(tests::sample_results(5));
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[1], "✓ mean linear momentum along e₁: bodies +3 kg m/s, with the move; fluid −3 kg m/s");
  EXPECT_EQ(lines[0].find("e-"), std::string::npos) << lines[0];
}

TEST(MomentumLines, take_no_sign_from_round_off) {
  result::Results results = tests::sample_results(5);
  results.solution.rotation.back() = results.solution.rotation.front();
  results.solution.position.back() = results.solution.position.front() + Eigen::Vector3d(1e-15, 0.0, 0.0);
  for (Eigen::Vector3d& momentum : results.solution.angular_momentum.bodies) momentum[0] = 1e-15;
  const std::vector<std::string> lines = report::momentum_lines(results);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[1], "· mean linear momentum of the bodies along e₁ is zero to round-off");
  EXPECT_EQ(lines[2], "· mean angular momentum of the bodies about e₁ is zero to round-off");
}

TEST(MomentumLines, take_no_sign_of_angular_momentum_from_the_error_of_steps) {
  result::Results results = tests::sample_results(6);
  auto& momenta = results.solution.angular_momentum.bodies;
  for (std::size_t k = 1; k + 1 < momenta.size(); ++k) momenta[k][0] = k % 2 == 0 ? 10.0 : -9.0;
  EXPECT_EQ(report::momentum_lines(results).back(),
            "· mean angular momentum of the bodies about e₁ is zero to what the steps leave of it");
}

TEST(Verdict, tells_of_costs_that_grow_on_finer_grids) {
  result::Results results = tests::sample_results(5);
  results.solution.status = maneuver::Status::optimal;
  results.certificate->verdict = certificate::Verdict::proved;
  results.certificate->refinement.emplace();
  results.certificate->refinement->grids = {{100, 1.0}, {200, 2.0}, {400, 4.0}};
  EXPECT_NE(report::verdict(results).find("at a cost that grows on finer steps"), std::string::npos);
  results.certificate->replay->rotation_error = 0.0;
  EXPECT_FALSE(report::succeeded(results));
  results.certificate->refinement->grids.back().cost = 2.1;
  EXPECT_EQ(report::verdict(results).find("grows"), std::string::npos);
  EXPECT_TRUE(report::succeeded(results));
}

// Bodies that end turned as they began have all moved as the root has: their mean momentum is mass × displacement / time, to the last
// digits, whatever steps leave of the momenta at nodes, and however small the move.
TEST(MomentumLines, take_the_mean_linear_momentum_from_where_bodies_went) {
  for (const double move : {2.0, 1e-6, -1e-6}) {
    result::Results results = tests::sample_results(5);
    results.problem.goal->move[0] = move;
    results.solution.rotation.back() = results.solution.rotation.front();
    results.solution.position.back()[0] = results.solution.position.front()[0] + move;
    auto& bodies = results.solution.linear_momentum.bodies;
    for (std::size_t k = 1; k < bodies.size(); ++k) bodies[k][0] = -move * 1e5;
    ASSERT_EQ(report::momentum_lines(results).size(), 3U);
    EXPECT_EQ(report::momentum_lines(results)[1],
              fmt::format("✓ mean linear momentum along e₁: bodies {}{} kg m/s, with the move; fluid {}{} kg m/s",
                          move > 0.0 ? "+" : "", report::number(1.5 * move, 3), move < 0.0 ? "+" : "",
                          report::number(-1.5 * move, 3)));
  }
}

// Bodies that end turned otherwise have moved by another way than the root: no law gives their momentum the move's sign.
TEST(MomentumLines, find_no_fault_with_signs_that_no_law_gives) {
  result::Results results = tests::sample_results(5);
  const Eigen::Matrix3d folded = lie::exp({0.0, 0.0, std::numbers::pi});
  auto &first = results.solution.rotation.front(), &last = results.solution.rotation.back();
  last = first;
  first[2] = folded;  // the arms go from in front of the root to behind: −11 m of a quarter kilogram each
  last[1] = folded;
  EXPECT_EQ(report::momentum_lines(results)[1],
            "· mean linear momentum along e₁: bodies −2.5 kg m/s, against the move; fluid +2.5 kg m/s");
}

// Joints at mass centres, a swimmer far from the origin: what is compared has a size all the same.
TEST(MomentumLines, hold_the_total_to_the_bodies_own) {
  result::Results results = tests::sample_results(5);
  const auto zero = [&] { return report::momentum_lines(results).front().starts_with("✓"); };
  for (result::ResolvedJoint& joint : results.problem.joints)
    joint.parent_offset = joint.child_offset = Eigen::Vector3d::Zero();
  EXPECT_TRUE(zero());
  for (Eigen::Vector3d& total : results.solution.angular_momentum.total) total.x() += 1e-5;
  EXPECT_FALSE(zero());
  for (Eigen::Vector3d& position : results.solution.position) position.x() += 1e6;
  EXPECT_TRUE(zero());
}

TEST(Wording, leaves_round_off_out_of_vectors) {
  EXPECT_EQ(report::vector({0.25, -6e-14, 1e-12}), "(0.25, 0, 10⁻¹²)");
  EXPECT_EQ(report::vector({0.0, 0.0, -2e-20}), "(0, 0, −2×10⁻²⁰)");
}

TEST(Wording, writes_all_costs_alike) {
  EXPECT_EQ(report::cost_number(243152.7), "243\u202f152.7");
  EXPECT_EQ(report::cost_number(13241.503), "13\u202f241.503");
  EXPECT_EQ(report::cost_number(-1234567.25), "−1\u202f234\u202f567.2");
  EXPECT_EQ(report::cost_number(230691.3, 5), "230\u202f691.3");
  EXPECT_EQ(report::cost_number(123456789012.0), "123\u202f456\u202f789\u202f012");
  EXPECT_EQ(report::cost_number(0.093349862), "0.093349862");
  EXPECT_EQ(report::cost_number(std::nan("")), "not computed");
}

TEST(Wording, writes_numbers_for_people) {
  EXPECT_EQ(report::number(0.0), "0");
  EXPECT_EQ(report::number(3.14159265, 3), "3.14");
  EXPECT_EQ(report::number(243152.7), "243152.7");
  EXPECT_EQ(report::number(-2.5), "−2.5");
  EXPECT_EQ(report::number(3.1e-12, 2), "3.1×10⁻¹²");
  EXPECT_EQ(report::number(-1e-9), "−10⁻⁹");
  EXPECT_EQ(report::number(1e-9), "10⁻⁹");
  EXPECT_EQ(report::number(1.2e10, 3), "1.2×10¹⁰");
  EXPECT_EQ(report::number(std::nan("")), "not computed");
  EXPECT_EQ(report::escaped("<a href=\"x\">&'\x01"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;\xEF\xBF\xBD");
}

// A hinge that turns at 0.5 rad/s under 3 N m for 2 s, a ball joint that is held 0.2 rad from its zero angle.
TEST(JointDemands, are_what_motors_must_give) {
  constexpr int steps = 8;
  result::Results results;
  results.problem = tests::sample_problem(steps);
  results.problem.time_step = 2.0 / steps;
  results.problem.joints[0].kind = model::JointKind::hinge;
  results.problem.joints[0].axis = Eigen::Vector3d::UnitZ();
  maneuver::Solution& solution = results.solution;
  for (int k = 0; k <= steps; ++k) {
    const double t = 2.0 * k / steps, angle = 0.5 * t - 0.3;
    solution.time.push_back(t);
    solution.position.emplace_back(0.0, 0.0, 0.0);
    solution.rotation.push_back({Eigen::Matrix3d::Identity(), lie::exp({0.0, 0.0, angle}), lie::exp({0.2, 0.0, 0.0})});
    solution.angular_velocity.push_back({Eigen::Vector3d::Zero(), {0.0, 0.0, 0.5}, Eigen::Vector3d::Zero()});
    solution.control.push_back({{0.0, 0.0, k == 3 ? -3.0 : 3.0}, {0.0, 4.0, 0.0}});
    solution.joint_angle.push_back({{angle, 0.0, 0.0}, {0.2, 0.0, 0.0}});
    if (k == steps) solution.joint_angle.back()[1].x() += 2.0 * M_PI;  // the same attitude, once round
  }
  const auto demands = report::joint_demands(results).value();
  ASSERT_EQ(demands.size(), 2U);
  EXPECT_EQ(demands[0].joint, "front");
  EXPECT_DOUBLE_EQ(demands[0].largest_moment, 3.0);
  EXPECT_DOUBLE_EQ(demands[0].largest_rate, 0.5);
  EXPECT_DOUBLE_EQ(demands[0].largest_power, 1.5);
  EXPECT_NEAR(demands[0].work, 3.0, 1e-14);
  ASSERT_EQ(demands[0].angles.size(), 1U);
  EXPECT_DOUBLE_EQ(demands[0].angles[0].first, -0.3);
  EXPECT_DOUBLE_EQ(demands[0].angles[0].second, 0.7);
  EXPECT_DOUBLE_EQ(demands[1].largest_moment, 4.0);
  EXPECT_EQ(demands[1].work, 0.0);
  for (int k = 0; k <= steps; ++k)  // turning back at once, at a node where its velocity is none
    solution.rotation[static_cast<std::size_t>(k)][1] = lie::exp({0.0, 0.0, 0.125 * std::abs(k - 4)});
  solution.angular_velocity[0][1] = {0.0, 0.0, -0.5};
  solution.angular_velocity[4][1].setZero();
  EXPECT_NEAR(report::joint_demands(results)->front().work, 3.0 - 0.5 * 3.0 * 0.5 * 0.25, 1e-14);
  EXPECT_NEAR(demands[1].angles[0].second, 0.2, 1e-14);
  results.solution.control_stages = {{{{0.0, 0.0, 7.0}, {0.0, 0.0, 0.0}}}};
  EXPECT_DOUBLE_EQ(report::joint_demands(results)->front().largest_moment, 7.0);
}

// Long steps of high order work as short ones of order 2 do: within them, not at their nodes alone.
TEST(JointDemands, of_long_steps_of_high_order_are_those_of_short_ones) {
  const auto work = [](maneuver::Scheme scheme, int steps) {
    file::ProblemFile file =
        file::read_problem_file(std::string(LAMPREY_SOURCE_DIR) + "/examples/translation_in_space.toml");
    task::MarchOptions options;
    options.scheme = scheme;
    options.steps = steps;
    options.duration = 0.5;
    options.control = [](double t) {
      return std::vector<Eigen::Vector3d>{{20.0 * std::cos(3.0 * t), 10.0, 30.0 * std::sin(5.0 * t)},
                                          {5.0, 8.0 * std::sin(2.0 * t), -20.0}};
    };
    double sum = 0.0;
    for (const auto& demand : report::joint_demands(task::march_task(file, options, "")).value()) sum += demand.work;
    return sum;
  };
  const double fine = work(maneuver::Scheme::trapezoid, 2000);
  for (const maneuver::Scheme scheme : {maneuver::Scheme::order4, maneuver::Scheme::order6}) {
    const double coarse = std::abs(work(scheme, 20) / fine - 1.0), finer = std::abs(work(scheme, 40) / fine - 1.0);
    EXPECT_LE(coarse, 2e-3);
    EXPECT_LE(finer, 0.3 * coarse + 1e-6) << "and converge";
  }
}

// Turned about its first axis under −1 N m, about its second, which that carries along, under 2 N m.
TEST(JointDemands, of_a_universal_joint_are_those_of_each_axis) {
  constexpr int steps = 40;
  result::Results results;
  results.problem = tests::sample_problem(steps);
  results.problem.time_step = 2.0 / steps;
  result::ResolvedJoint& joint = results.problem.joints[0];
  joint.kind = model::JointKind::universal;
  joint.axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  joint.control_axes = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  maneuver::Solution& solution = results.solution;
  const double first_rate = 0.3, second_rate = 0.7;
  for (int k = 0; k <= steps; ++k) {
    const double t = 2.0 * k / steps, first = first_rate * t, second = second_rate * t - 0.2;
    const Eigen::Matrix3d carried = lie::exp({first, 0.0, 0.0}), turned = lie::exp({0.0, second, 0.0});
    const Eigen::Vector3d axis = carried * Eigen::Vector3d::UnitY();
    solution.time.push_back(t);
    solution.position.emplace_back(0.0, 0.0, 0.0);
    solution.rotation.push_back({Eigen::Matrix3d::Identity(), carried * turned, Eigen::Matrix3d::Identity()});
    solution.angular_velocity.push_back({Eigen::Vector3d::Zero(),
                                         turned.transpose() * Eigen::Vector3d(first_rate, second_rate, 0.0),
                                         Eigen::Vector3d::Zero()});
    solution.control.push_back({-Eigen::Vector3d::UnitX() + 2.0 * axis, {0.0, 4.0, 0.0}});
    solution.joint_angle.push_back({{first, second, 0.0}, Eigen::Vector3d::Zero()});
  }
  for (const bool with_angles : {true, false}) {
    if (!with_angles) solution.joint_angle.clear();
    const auto demands = report::joint_demands(results).value();
    ASSERT_EQ(demands.size(), 3U);
    const double accuracy = with_angles ? 1e-13 : 1e-3;  // rates over steps from the rotations alone
    for (const auto& [n, moment, speed] : {std::tuple(0U, 1.0, first_rate), std::tuple(1U, 2.0, second_rate)}) {
      EXPECT_EQ(demands[n].joint, n == 0 ? "front 1" : "front 2");
      EXPECT_NEAR(demands[n].largest_moment, moment, 1e-13);
      EXPECT_NEAR(demands[n].largest_rate, speed, accuracy);
      EXPECT_NEAR(demands[n].largest_power, moment * speed, 2.0 * accuracy);
      EXPECT_NEAR(demands[n].work, 2.0 * moment * speed, 4.0 * accuracy);
      ASSERT_EQ(demands[n].angles.size(), with_angles ? 1U : 0U);
    }
    EXPECT_EQ(demands[2].joint, results.problem.joints[1].name);
  }
}

}  // namespace
}  // namespace lamprey
