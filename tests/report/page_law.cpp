// The page as a stranger's parser reads it: it loads nothing, carries what its policy allows, and keeps names as text.
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "model/input_error.hpp"
#include "report/page_data.hpp"
#include "report/report.hpp"
#include "report/sample_results.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

using nlohmann::json;

json read_page(const std::string& html) {
  const auto path = std::filesystem::temp_directory_path() / ("lamprey_page_" + std::to_string(getpid()) + ".html");
  std::ofstream(path, std::ios::binary) << html;
  const std::string python = std::filesystem::exists("/usr/bin/python3") ? "/usr/bin/python3" : "python3";
  const std::string command = python + " " LAMPREY_SOURCE_DIR "/tests/report/check_page.py " + path.string();
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  char buffer[4096];
  while (std::size_t count = fread(buffer, 1, sizeof buffer, pipe.get())) text.append(buffer, count);
  std::filesystem::remove(path);
  return json::parse(text);
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("nothing to replace: " + from);
  return text.replace(at, from.size(), to);
}

std::set<std::string> names(const json& pairs) {
  std::set<std::string> found;
  for (const json& pair : pairs) found.insert(pair.at(0).get<std::string>());
  return found;
}

TEST(PageData, joints_show_their_axes_springs_and_dampers) {
  result::Results results = tests::simulated_results(10);
  results.problem.joints[0].kind = model::JointKind::hinge;
  results.problem.joints[0].axis = Eigen::Vector3d(0.0, 0.0, 1.0);
  results.problem.joints[0].stiffness = 2.5;
  const json rows = json::parse(report::page_data({&results}))["runs"][0]["problem"]["joint_rows"];
  EXPECT_EQ(rows[0][1], "hinge (0, 0, 1)");
  EXPECT_EQ(rows[0][7], "2.5");
  EXPECT_EQ(rows[0][8], "none");
  EXPECT_EQ(rows[1][1], "ball");
}

TEST(Page, loads_nothing_and_its_policy_names_exactly_its_own_script_and_style) {
  const std::string one = report::report_html(tests::sample_results(50));
  const std::string two = report::comparison_html(tests::sample_results(50), tests::sample_results(20));
  for (const std::string& html : {one, two}) {
    const json page = read_page(html);
    EXPECT_EQ(page["problems"], json::array());
    for (const char* forbidden :
         {"src=\"http", "src=http", "href=\"http", "href=http", "url(http", "url(\"http", "@import"}) {
      EXPECT_EQ(html.find(forbidden), std::string::npos) << forbidden;
    }
  }
}

TEST(Page, that_was_tampered_with_is_found_out) {
  const std::string html = report::report_html(tests::sample_results(20));
  EXPECT_NE(read_page(replaced(html, "</main>", "<img src=\"x\"></main>"))["problems"], json::array());
  EXPECT_NE(read_page(replaced(html, "</script>\n</body>", " </script>\n</body>"))["problems"], json::array());
  EXPECT_NE(read_page(replaced(html, "</style>", " </style>"))["problems"], json::array());
  EXPECT_NE(read_page(replaced(html, "default-src 'none'", "default-src *"))["problems"], json::array());
}

TEST(Page, keeps_hostile_names_as_text) {
  const std::string hostile = "</script><script>alert(1)</script><!-- %DATA% %SNAPSHOTS% </title> & \"'\\ é";
  result::Results results = tests::sample_results(20);
  results.name = results.source = results.solution.message = results.problem.bodies[1].name = hostile;
  results.problem.joints[0].name = results.provenance.command = results.solution.solver.name = hostile;
  const json page = read_page(report::report_html(results));
  EXPECT_EQ(page["problems"], json::array());
  EXPECT_EQ(page["title"], hostile);
  const json& run = page["data"]["runs"][0];
  EXPECT_EQ(run["name"], hostile);
  EXPECT_EQ(run["paragraphs"], json::array({hostile}));
  EXPECT_EQ(run["bodies"][1]["name"], hostile);
  EXPECT_EQ(run["joints"][0]["name"], hostile);
  EXPECT_EQ(report::snapshot_svg(results).find("<script"), std::string::npos);
}

TEST(Page, replaces_bytes_that_are_not_utf8_instead_of_failing) {
  result::Results results = tests::sample_results(20);
  results.solution.message = "broken \xC3( byte";
  EXPECT_EQ(read_page(report::report_html(results))["data"]["runs"][0]["paragraphs"][0], "broken \uFFFD( byte");
}

TEST(Page, of_a_simulation_leaves_out_what_has_no_meaning) {
  const json solved = read_page(report::report_html(tests::sample_results(20)))["data"]["runs"][0];
  const json simulated = read_page(report::report_html(tests::simulated_results(20)))["data"]["runs"][0];
  for (const char* key : {"certificate", "search", "minima", "history"}) {
    EXPECT_TRUE(solved.contains(key)) << key;
    EXPECT_FALSE(simulated.contains(key)) << key;
  }
  for (const char* fact : {"Cost", "Solver", "Time taken"}) {
    EXPECT_TRUE(names(solved["figures"]).contains(fact) || names(solved["details"]).contains(fact)) << fact;
    EXPECT_FALSE(names(simulated["figures"]).contains(fact) || names(simulated["details"]).contains(fact)) << fact;
  }
}

// What people came for first, the proof before the pictures, the rest behind a closed heading.
TEST(Page, shows_six_figures_the_motion_and_the_certificate_before_all_else) {
  result::Results results = tests::sample_results(20);
  results.problem.goal->periodic = true;
  const std::string html = report::report_html(results);
  const json run = read_page(html)["data"]["runs"][0];
  EXPECT_EQ(names(run["figures"]), (std::set<std::string>{"Cost", "Displacement", "Duration", "Work of the joints",
                                                          "Cost of transport", "Clearance"}));
  EXPECT_TRUE(names(run["details"]).contains("Machine"));
  std::size_t at = 0;
  for (const char* id : {"verdict", "motion", "certificate", "shapes", "snapshots", "curves"}) {
    const std::size_t next = html.find("id=\"" + std::string(id) + "\"", at);
    ASSERT_NE(next, std::string::npos) << id;
    at = next;
  }
}

TEST(Page, warns_where_bodies_pass_through_each_other_alone) {
  result::Results results = tests::sample_results(20);
  const auto run = [&] { return json::parse(report::page_data({&results}))["runs"][0]; };
  EXPECT_EQ(run()["warning"], "");
  results.certificate->clearance = evidence::Clearance{-0.31, 0.42, 1, 2};
  EXPECT_EQ(run()["warning"],
            "Bodies pass through each other: front and rear by 0.31 m at 0.42 s. Nothing keeps them apart: set "
            "limits.clearance.");
  const json figures = run()["figures"];
  EXPECT_NE(std::find(figures.begin(), figures.end(), json::array({"Clearance", "−0.31 m at 0.42 s"})), figures.end());
}

TEST(Page, leaves_out_the_view_from_behind_of_planar_motions) {
  result::Results results = tests::sample_results(20);
  EXPECT_NE(report::report_html(results).find("From behind"), std::string::npos);
  for (std::size_t k = 0; k < results.solution.time.size(); ++k) {
    results.solution.position[k].z() = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
      results.solution.rotation[k][i] = lie::exp({0.0, 0.0, 0.1 * static_cast<double>(k * i)});
  }
  const std::string html = report::report_html(results);
  EXPECT_EQ(html.find("From behind"), std::string::npos);
  EXPECT_EQ(read_page(html)["data"]["runs"][0]["planar"], true);
  results.solution.rotation[7][1] = lie::exp({1e-3, 0.0, 0.0}) * results.solution.rotation[7][1];
  EXPECT_NE(report::report_html(results).find("From behind"), std::string::npos);
}

TEST(Page, is_the_same_bytes_on_a_second_run) {
  EXPECT_EQ(report::report_html(tests::sample_results(30)), report::report_html(tests::sample_results(30)));
}

TEST(Page, stays_small_for_a_thousand_and_for_a_hundred_thousand_steps) {
  for (const int steps : {1000, 100000}) {
    EXPECT_LT(report::report_html(tests::sample_results(steps)).size(), 2'500'000u) << steps;
  }
}

TEST(PageData, holds_the_stored_motion_to_seven_digits) {
  const result::Results results = tests::sample_results(60);
  const json frames = json::parse(report::page_data({&results}))["runs"][0]["frames"];
  const double tolerance = tests::tolerance(1e-6);
  for (std::size_t k = 0; k <= 60; ++k) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto row = static_cast<Eigen::Index>(axis);
      const double moment = results.solution.control[k][1][row];
      EXPECT_NEAR(frames["position"][3 * k + axis].get<double>(), results.solution.position[k][row], tolerance);
      EXPECT_NEAR(frames["joint_moment"][6 * k + 3 + axis].get<double>(), moment, tolerance * (1.0 + std::abs(moment)));
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const auto q = [&](std::size_t part) { return frames["rotation"][4 * (3 * k + i) + part].get<double>(); };
      const Eigen::Matrix3d R = lie::rotation_of_quaternion({q(3), q(0), q(1), q(2)});
      EXPECT_LE((R - results.solution.rotation[k][i]).norm(), tolerance) << "node " << k << " body " << i;
    }
  }
}

TEST(PageData, draws_first_and_last_node_in_order_and_within_the_budget) {
  for (const std::size_t nodes : {1u, 2u, 50u, 1001u, 2001u, 2002u, 100001u}) {
    for (const std::size_t numbers : {10u, 60u, 3000u}) {
      const auto drawn = report::drawn_nodes(nodes, numbers);
      ASSERT_FALSE(drawn.empty());
      EXPECT_EQ(drawn.front(), 0u);
      EXPECT_EQ(drawn.back(), nodes - 1);
      EXPECT_LE(drawn.size(), 2001u);
      EXPECT_LE(drawn.size() * numbers, std::max<std::size_t>(150000, 21 * numbers));
      for (std::size_t k = 1; k < drawn.size(); ++k) EXPECT_LT(drawn[k - 1], drawn[k]);
    }
  }
}

TEST(Report, refuses_results_whose_arrays_do_not_fit) {
  result::Results short_control = tests::sample_results(10), two_parents = tests::sample_results(10);
  short_control.solution.control.pop_back();
  EXPECT_THROW(report::report_html(short_control), std::invalid_argument);
  two_parents.problem.joints[1].child = 1;
  EXPECT_THROW(report::report_html(two_parents), std::invalid_argument);
  result::Results lonely = tests::sample_results(10);
  lonely.problem.joints.clear();
  EXPECT_THROW(report::comparison_html(tests::sample_results(10), lonely), model::InputError);
}

}  // namespace
}  // namespace lamprey
