// Limits, keep-outs and waypoints in what reports say and draw.
#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "certificate/limit_words.hpp"
#include "document/text_table.hpp"
#include "evidence/limit_check.hpp"
#include "report/limit_facts.hpp"
#include "report/obstacles.hpp"
#include "report/page_data.hpp"
#include "report/sample_results.hpp"
#include "report/summary.hpp"
#include "report/transport.hpp"
#include "report/wording.hpp"
#include "result/resolve.hpp"
#include "task/task_words.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

json page_run(const result::Results& results) { return json::parse(report::page_data({&results}))["runs"][0]; }

std::string fact(const result::Results& results, const std::string& name) {
  for (const auto& [key, value] : report::facts(results))
    if (key == name) return value;
  return "";
}

// As the root, and the bodies that hang on it, would be without limits.
result::Results moving(int steps = 60) {
  result::Results results = tests::sample_results(steps);
  results.problem.start =
      result::ResolvedStart{results.solution.rotation.front(), results.solution.position.front(), Vector3d::Zero(), {}};
  return results;
}

const evidence::LimitReach& reach_of(const evidence::LimitCheck& check, const std::string& key) {
  return *std::find_if(check.reaches.begin(), check.reaches.end(), [&](const auto& one) { return one.key == key; });
}

// Every field of Limits in turn.
std::vector<maneuver::Limits> one_each() {
  std::vector<maneuver::Limits> all(13);
  all[0].torque = 7.25;
  all[1].joint_torque["front"] = 7.25;
  all[2].torque_component = 7.25;
  all[3].joint_torque_component["front"] = 7.25;
  all[4].angular_velocity = 7.25;
  all[5].joint_angular_velocity["front"] = 7.25;
  all[6].angular_velocity_component = 7.25;
  all[7].joint_angular_velocity_component["front"] = 7.25;
  all[8].swing["front"] = 7.25;
  all[9].twist["front"] = 7.25;
  all[10].angle["front"] = {{0.5, 7.25}};
  all[11].clearance = 7.25;
  all[12].spheres.push_back({Vector3d(1.0, 2.0, 3.0), 7.25});
  all.emplace_back().half_spaces.push_back({Vector3d(1.0, 7.25, 3.0), Vector3d::UnitZ()});
  return all;
}

TEST(LimitWords, tell_each_limit_once_with_its_number_and_unit) {
  for (const maneuver::Limits& limits : one_each()) {
    const auto lines = task::limit_lines(limits, document::short_number);
    ASSERT_EQ(lines.size(), 1U);
    EXPECT_NE(lines[0].find("7.25"), std::string::npos) << lines[0];
    EXPECT_TRUE(lines[0].find(" N m") != std::string::npos || lines[0].find(" rad") != std::string::npos ||
                lines[0].find(" m") != std::string::npos)
        << lines[0];
    result::Results results = moving();
    results.problem.limits = limits;
    const auto rows = report::problem_settings(results.problem);
    EXPECT_EQ(std::count_if(rows.begin(), rows.end(), [&](const auto& row) { return row.second == lines[0]; }), 1);
  }
  EXPECT_TRUE(task::limit_lines({}, document::short_number).empty());
}

TEST(LimitWords, name_the_fluid_the_free_duration_and_waypoints) {
  result::Results results = moving();
  results.problem.density = 998.2;
  results.problem.free_duration = true;
  results.problem.between = {0.25, 4.5};
  results.problem.waypoints.push_back({0.5, {std::nullopt, 0.2, std::nullopt}, {}, {}});
  std::string all;
  for (const auto& [name, value] : report::problem_settings(results.problem)) all += name + ": " + value + "\n";
  for (const char* words : {"998.2 kg/m³", "free between 0.25 and 4.5 s", "Waypoints: at 0.5 s: 0.2 m along e₂"})
    EXPECT_NE(all.find(words), std::string::npos) << words << " in " << all;
  results.problem.density = 0.0;
  EXPECT_EQ(report::problem_settings(results.problem).front().second, "none: a vacuum");
}

// A sphere that grows, and a face that comes nearer, take as much off the distance.
TEST(LimitReaches, are_distances_that_fall_as_obstacles_grow) {
  result::Results results = moving();
  auto& limits = results.problem.limits;
  limits.spheres.push_back({Vector3d(0.0, 60.0, 5.0), 2.0});
  limits.half_spaces.push_back({Vector3d(0.0, 0.0, -40.0), Vector3d(0.0, 0.3, 2.0)});
  const auto before = *report::limits_seen(results);
  limits.spheres[0].radius += 3.0;
  limits.half_spaces[0].point += 4.0 * limits.half_spaces[0].normal.normalized();
  const auto after = *report::limits_seen(results);
  for (const auto& [key, by] : {std::pair("limits.sphere", 3.0), std::pair("limits.half_space", 4.0)}) {
    EXPECT_GT(reach_of(after, key).margin, 0.0);
    EXPECT_NEAR(reach_of(before, key).margin - reach_of(after, key).margin, by, tests::tolerance(1e-9)) << key;
    EXPECT_FALSE(reach_of(after, key).reached());
  }
  EXPECT_EQ(after.violation, 0.0);
  EXPECT_EQ(fact(results, "Limits").substr(0, 4), "kept");
  EXPECT_NE(fact(results, "Limits").find(" m from the sphere"), std::string::npos) << fact(results, "Limits");
}

TEST(LimitReaches, count_the_time_at_a_limit_and_tell_what_is_broken) {
  result::Results results = moving();
  double largest = 0.0;
  for (const auto& moments : results.solution.control) largest = std::max(largest, moments[0].norm());
  results.problem.limits.joint_torque["front"] = 2.0 * largest;
  EXPECT_FALSE(report::limits_seen(results)->reaches.front().reached());
  EXPECT_FALSE(report::worst_broken(report::limits_seen(results)->reaches));
  results.problem.limits.joint_torque["front"] = largest;
  const auto touched = report::limits_seen(results)->reaches.front();
  EXPECT_TRUE(touched.reached());
  EXPECT_NEAR(touched.margin, 0.0, tests::tolerance(1e-9));
  EXPECT_LT(touched.share, 0.5);
  results.problem.limits.joint_torque["front"] = 0.5 * largest;
  const auto broken = report::worst_broken(report::limits_seen(results)->reaches);
  ASSERT_TRUE(broken);
  EXPECT_NEAR(broken->violation, 1.0, tests::tolerance(1e-9));
  EXPECT_EQ(fact(results, "Limits").rfind("limits.torque.front is broken by 1 times its bound", 0), 0U);
  EXPECT_EQ(certificate::violation_in_words("limits.torque", 272.0, 1.0),
            "limits.torque is broken by 270 times its bound at 1 s");
  results.problem.limits = {};
  EXPECT_EQ(fact(results, "Limits"), "");
}

// Pairs that are far apart are not looked at closely, and none that matters is left out.
TEST(LimitReaches, of_clearance_are_those_of_the_nearest_pair) {
  result::Results results = moving();
  for (result::ResolvedBody& body : results.problem.bodies) body.semi_axes *= 0.4;
  for (const double asked : {1e-3, 2.0, 6.0}) {
    results.problem.limits.clearance = asked;
    const maneuver::Problem problem = result::problem_of(results);
    const model::System system(problem.swimmer);
    const evidence::StoredMotion motion(system, problem, results.solution);
    double least = 1e300;
    for (const evidence::Bound& bound : evidence::bounds_of(motion))
      for (const double margin : evidence::margins(motion, bound))
        if (!std::isnan(margin)) least = std::min(least, margin);
    const auto check = evidence::check_limits(motion);
    EXPECT_EQ(reach_of(check, "limits.clearance").margin, least);
    EXPECT_EQ(check.violation, std::max(0.0, -least));
    EXPECT_EQ(reach_of(check, "limits.clearance").reached(), least <= 1e-3 * system.length_unit());
  }
}

// What a march looks like where nobody should overlook something.
TEST(MarchFaults, of_overlap_and_of_broken_limits_take_the_good_word_away) {
  result::Results results = tests::simulated_results(40);
  for (auto& velocities : results.solution.angular_velocity)
    for (Eigen::Vector3d& velocity : velocities) velocity.setZero();
  for (Eigen::Vector3d& velocity : results.solution.linear_velocity) velocity.setZero();
  for (result::ResolvedBody& body : results.problem.bodies) body.semi_axes *= 0.05;
  EXPECT_GT(report::march_clearance(results)->gap, 0.0);
  EXPECT_TRUE(report::succeeded(results));
  EXPECT_EQ(report::verdict(results), "Simulated");
  EXPECT_EQ(page_run(results)["good"], true);
  results.problem.limits.torque = 1e6;
  EXPECT_TRUE(report::succeeded(results));
  results.problem.limits.torque = 1.0;
  EXPECT_FALSE(report::succeeded(results));
  EXPECT_EQ(report::verdict(results), "Simulated, but limits.torque is broken");
  results.problem.limits = {};
  result::Results unworked = results;  // as if it had begun to move by itself
  for (std::size_t k = 20; k < unworked.solution.time.size(); ++k) unworked.solution.linear_velocity[k].x() = 1.0;
  EXPECT_FALSE(report::succeeded(unworked));
  EXPECT_NE(report::verdict(unworked).find("Simulated, but on steps too coarse to resolve it ("), std::string::npos)
      << report::verdict(unworked);
  for (result::ResolvedBody& body : results.problem.bodies) body.semi_axes *= 40.0;
  EXPECT_FALSE(report::succeeded(results));
  EXPECT_EQ(report::verdict(results), "Simulated, but bodies pass through each other");
  EXPECT_EQ(page_run(results)["good"], false);
}

TEST(CostOfTransport, is_told_where_a_distance_is_asked_for_or_gone) {
  result::Results results = moving();
  results.problem.goal->move = {};
  results.problem.goal->periodic = true;
  auto& position = results.solution.position;
  const auto goes = [&](double way) {
    for (Vector3d& x : position) x = position.front();
    position.back().x() += way;
    return report::goes_a_way(results);
  };
  const auto told = [&] { return !fact(results, "Cost of transport").empty(); };
  const double size = 8.0;  // m, the largest semi-axis
  EXPECT_TRUE(goes(0.11 * size) && told());
  EXPECT_FALSE(goes(0.09 * size) || told());
  results.problem.goal->move[1] = 0.0;  // nothing is asked for but to stay
  EXPECT_FALSE(goes(0.09 * size) || told());
  results.problem.goal->move[0] = 1e-3;
  EXPECT_TRUE(goes(1e-3) && told());
  results.problem.goal->periodic = false;
  EXPECT_TRUE(goes(1e-3) && told()) << "from rest to rest, too";
  results.problem.goal->periodic = true;
  EXPECT_FALSE(goes(0.0) || told());
  results.problem.goal->move = {};
  results.problem.cost_weights.transport = 1.0;
  EXPECT_TRUE(goes(1e-3));
  results.problem.cost_weights.transport = 0.0;
  results.problem.cost_weights.displacement = {0.0, 3.0, 0.0};
  EXPECT_TRUE(goes(1e-3));
}

TEST(PageObstacles, are_those_of_the_problem_and_waypoints_lie_where_they_are_asked_for) {
  result::Results results = moving();
  results.problem.limits.spheres.push_back({Vector3d(1.0, -2.0, 3.0), 0.5});
  results.problem.limits.half_spaces.push_back({Vector3d(0.0, 1.0, 0.0), Vector3d(0.0, 0.0, 4.0)});
  results.problem.waypoints.push_back({0.5, {0.25, std::nullopt, std::nullopt}, {}, {}});
  results.problem.waypoints.push_back({0.25, {}, Vector3d::UnitX(), {}});  // of attitudes alone
  const json obstacles = page_run(results)["obstacles"];
  EXPECT_EQ(obstacles["sphere"], json::parse(R"([{"centre": [1.0, -2.0, 3.0], "radius": 0.5}])"));
  EXPECT_EQ(obstacles["half_space"], json::parse(R"([{"point": [0.0, 1.0, 0.0], "normal": [0.0, 0.0, 1.0]}])"));
  ASSERT_EQ(obstacles["waypoint"].size(), 1U);
  const Vector3d there = results.solution.position[30];
  EXPECT_EQ(obstacles["waypoint"][0]["position"],
            json({results.solution.position[0].x() + 0.25, there.y(), there.z()}));
  EXPECT_EQ(page_run(moving())["obstacles"]["sphere"], json::array());
}

// Curves and the check of limits see the same: the largest value leaves the margin that the check finds.
TEST(PageLimitCurves, leave_the_margins_that_the_check_finds) {
  result::Results results = moving();
  auto& limits = results.problem.limits;
  limits.swing["front"] = 2.0;
  limits.twist["rear"] = 3.0;
  limits.torque = 900.0;
  limits.torque_component = 700.0;
  limits.angular_velocity = 80.0;
  const auto check = *report::limits_seen(results);
  const json run = page_run(results);
  const auto largest = [&](const char* kind, int joint, const char* label) {
    for (const json& curve : run["limit_curves"]) {
      if (curve["kind"] != kind || curve["joint"] != joint || curve.value("label", "") != label) continue;
      double most = 0.0;
      for (const json& value : curve["values"]) most = std::max(most, value.is_null() ? 0.0 : value.get<double>());
      return most;
    }
    return std::nan("");
  };
  const double close = tests::tolerance(1e-4);
  EXPECT_NEAR(2.0 - largest("angle", 0, "swing"), reach_of(check, "limits.swing.front").margin, close);
  EXPECT_NEAR(3.0 - largest("angle", 1, "|twist|"), reach_of(check, "limits.twist.rear").margin, close);
  EXPECT_NEAR(900.0 - std::max(largest("moment", 0, "|u|"), largest("moment", 1, "|u|")),
              reach_of(check, "limits.torque").margin, close);
  EXPECT_NEAR(80.0 - std::max(largest("rate", 0, "|rate|"), largest("rate", 1, "|rate|")),
              reach_of(check, "limits.angular_velocity").margin, close);
  int drawn_anyway = 0;
  for (const json& curve : run["limit_curves"])
    if (curve.contains("line")) {
      EXPECT_EQ(curve["bounds"], json({-700.0, 700.0}));
      EXPECT_FALSE(curve.contains("values"));
      ++drawn_anyway;
    }
  EXPECT_EQ(drawn_anyway, 6) << "three components of two joints";
  EXPECT_EQ(page_run(moving())["limit_curves"], json::array());
}

// The moments of motors, along axes that are orthogonal, are as large together as the moment that they make.
TEST(PageMoments, of_motors_make_the_moment_on_the_parent) {
  result::Results results = moving(20);
  result::ResolvedJoint& joint = results.problem.joints[0];
  joint.kind = model::JointKind::universal;
  joint.axes = {Vector3d::UnitX(), Vector3d::UnitY()};
  joint.control_axes = {Vector3d::UnitX(), Vector3d::UnitY()};
  for (std::size_t k = 0; k <= 20; ++k) {
    const double first = 0.05 * static_cast<double>(k), second = 0.3 - first;
    const Eigen::Matrix3d& root = results.solution.rotation[k][0];
    results.solution.rotation[k][1] = root * lie::exp({first, 0.0, 0.0}) * lie::exp({0.0, second, 0.0});
    results.solution.control[k][0] = -3.0 * Vector3d::UnitX() + 2.0 * (lie::exp({first, 0.0, 0.0}) * Vector3d::UnitY());
  }
  const json moment = page_run(results)["frames"]["joint_moment"];
  for (std::size_t k = 0; k <= 20; ++k) {
    EXPECT_NEAR(moment[6 * k].get<double>(), -3.0, tests::tolerance(1e-6));
    EXPECT_NEAR(moment[6 * k + 1].get<double>(), 2.0, tests::tolerance(1e-6));
    EXPECT_EQ(moment[6 * k + 2].get<double>(), 0.0);
  }
}

// On paper: the piece of line in a box ends on its edge, and its points lie on the face at that depth.
TEST(HalfSpacesOnPaper, are_where_their_faces_are) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto vector = [&] { return Vector3d(normal(random), normal(random), normal(random)); };
  int drawn = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const maneuver::KeepOutHalfSpace half{vector(), vector()};
    const Vector3d at = vector();
    for (const report::View& view : {report::top_view(), report::side_view(), report::back_view()}) {
      const auto line = report::cut(half, view, at);
      if (!line) continue;
      const Eigen::Vector2d low(-2.0, -1.5), high(1.0, 2.5);
      const auto ends = report::line_in_box(*line, low, high);
      if (!ends) continue;
      for (const Eigen::Vector2d& end : *ends) {
        const Vector3d there = at + view.transpose() * (end - view * at);
        EXPECT_NEAR(half.normal.normalized().dot(there - half.point), 0.0, tests::tolerance(1e-12));
        const double inside = std::min((end - low).minCoeff(), (high - end).minCoeff());
        EXPECT_NEAR(inside, 0.0, tests::tolerance(1e-12));
        const Vector3d forbidden = there - 0.1 * (view.transpose() * line->normal);
        EXPECT_LT(half.normal.dot(forbidden - half.point), 0.0) << "its normal leads out";
      }
      ++drawn;
    }
  }
  EXPECT_GT(drawn, 100);
  EXPECT_FALSE(report::cut({Vector3d::Zero(), Vector3d::UnitZ()}, report::top_view(), Vector3d::Zero()))
      << "a floor from above";
}

}  // namespace
}  // namespace lamprey
