// Every example through the program: coarse always, at full resolution with LAMPREY_LONG=1. Reference costs: docs/theory chapter 5.
#include <gtest/gtest.h>

#include "file/solution_file.hpp"
#include "lie/so3.hpp"
#include "program.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

struct Example {
  std::string label;
  std::string name;
  std::vector<std::pair<std::string, std::string>> values;
  double cost;            // (N m)² s: at most this
  double cost_tolerance;  // relative, both ways; 0: only the bound above
  bool fine;              // full resolution: replay marks hold too
};

// Out-of-plane share of a motion that should stay in the plane of e_1 and e_2.
double out_of_plane(const maneuver::Solution& solution) {
  double largest = 0.0;
  for (std::size_t k = 0; k < solution.time.size(); ++k) {
    largest = std::max(largest, std::abs(solution.position[k][2]));
    for (const auto& R : solution.rotation[k])
      largest = std::max({largest, std::abs(R(2, 0)), std::abs(R(2, 1)), std::abs(R(0, 2)), std::abs(R(1, 2))});
  }
  return largest;
}

void expect_marks(const file::Results& results) {
  const certificate::Certificate& proof = *results.certificate;
  EXPECT_EQ(results.solution.status, maneuver::Status::optimal) << results.solution.message;
  EXPECT_LE(proof.goal_error, tolerance(1e-9));
  EXPECT_LE(proof.rest_error, tolerance(1e-9));
  EXPECT_LE(proof.equation_residual, tolerance(1e-10));
  EXPECT_LE(proof.momentum_drift, tolerance(1e-11));
  EXPECT_LE(proof.rotation_drift, tolerance(1e-13));
  EXPECT_LE(proof.kkt, tolerance(1e-8));
}

void expect_solved(const Example& example) {
  const Folder folder;
  const ProgramRun run = lamprey(folder, "solve " + varied_example(folder, example.name, example.values) + " --out " + (folder / "run"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const file::Results results = file::read_solution(folder / "run");
  expect_marks(results);
  EXPECT_LE(results.solution.cost, example.cost);
  if (example.cost_tolerance > 0.0) {
    EXPECT_GE(results.solution.cost, example.cost * (1.0 - 2.0 * example.cost_tolerance));
  }
  EXPECT_EQ(run.out.find("✗"), std::string::npos) << "a claim of the paper does not hold:\n" << run.out;
  if (results.problem.joints[0].control_axes.size() == 1) {
    EXPECT_LE(out_of_plane(results.solution), tolerance(1e-10));
  }
  if (example.fine) {
    EXPECT_LE(results.certificate->replay->rotation_error, tolerance(1e-3));
  }
  EXPECT_TRUE(std::filesystem::exists(folder / "run/trajectory.h5"));
  EXPECT_NE(text_of(folder / "run/report.html").find("<html"), std::string::npos);
  EXPECT_EQ(lamprey(folder, "verify " + (folder / "run")).exit_code, 0);
}

// Cost bounds are the reference value plus the tolerance, so that cost · (1 − 2 tolerance) is as far below it.
Example close_to(std::string label, std::string name, std::vector<std::pair<std::string, std::string>> values, double cost,
                 double relative, bool fine = false) {
  return {std::move(label), std::move(name), std::move(values), cost * (1.0 + relative), relative, fine};
}

using Values = std::vector<std::pair<std::string, std::string>>;

class CoarseExamples : public ::testing::TestWithParam<Example> {};
TEST_P(CoarseExamples, solves_and_is_proven) { expect_solved(GetParam()); }

const Values coarse = {{"steps", "100"}};
INSTANTIATE_TEST_SUITE_P(
    Solve, CoarseExamples,
    ::testing::Values(close_to("translation", "translation", coarse, 243080.02, 1e-6),
                      Example{"translation_in_space", "translation_in_space", {{"steps", "100"}, {"starts", "4"}}, 125000, 0, false},
                      Example{"rotation", "rotation", {{"steps", "100"}, {"starts", "4"}}, 15000, 0, false},
                      close_to("as_printed_translation", "as_printed/translation", coarse, 169753, 1e-5),
                      Example{"as_printed_rotation", "as_printed/rotation", {{"steps", "100"}, {"starts", "4"}}, 40000, 0, false},
                      close_to("paper_scheme_11_points", "paper_scheme/translation", {{"steps", "100"}, {"points", "11"}}, 248860, 5e-4),
                      close_to("paper_scheme_21_points", "paper_scheme/translation", coarse, 247835, 5e-4),
                      close_to("paper_scheme_41_points", "paper_scheme/translation", {{"steps", "100"}, {"points", "41"}}, 246764, 5e-4),
                      Example{"paper_scheme_rotation", "paper_scheme/rotation", {}, 17000, 0, false}),
    [](const auto& instance) { return instance.param.label; });

class FullExamples : public ::testing::TestWithParam<Example> {};
TEST_P(FullExamples, solves_and_is_proven) {
  if (!long_tests()) return;  // ./dev test-all runs these at length
  expect_solved(GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    Long, FullExamples,
    ::testing::Values(close_to("translation", "translation", {}, 243152.7, 1e-6, true),
                      Example{"translation_in_space", "translation_in_space", {}, 105000, 0, true},
                      Example{"rotation", "rotation", {}, 15000, 0, true},
                      Example{"as_printed_translation", "as_printed/translation", {}, 175000, 0, true},
                      Example{"as_printed_rotation", "as_printed/rotation", {}, 20000, 0, false},
                      close_to("paper_scheme_11_points", "paper_scheme/translation", {{"points", "11"}}, 244005, 5e-4),
                      close_to("paper_scheme_21_points", "paper_scheme/translation", {}, 243884, 5e-4),
                      close_to("paper_scheme_41_points", "paper_scheme/translation", {{"points", "41"}}, 243851, 5e-4)),
    [](const auto& instance) { return instance.param.label; });

TEST(Shooting, stays_at_the_answer_of_the_simultaneous_method) {
  const Folder folder;
  const std::string path = varied_example(folder, "paper_scheme/translation", {{"steps", "100"}, {"starts", "8\nmethod = \"shooting\""}});
  const ProgramRun run = lamprey(folder, "solve " + path + " --out " + (folder / "run"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const file::Results results = file::read_solution(folder / "run");
  expect_marks(results);
  EXPECT_NEAR(results.solution.cost, 247835, 5e-4 * 247835);
  EXPECT_NE(results.solution.solver.name.find("shooting"), std::string::npos);
}

TEST(Tumble, marches_free_with_its_momentum) {
  const Folder folder;
  const ProgramRun run = lamprey(folder, "simulate " + example("tumble") + " --steps 1000 --duration 1 --out " + (folder / "run"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const file::Results results = file::read_solution(folder / "run");
  EXPECT_EQ(results.solution.status, maneuver::Status::simulated);
  const auto& total = results.solution.angular_momentum.total;
  EXPECT_LE((total.back() - total.front()).norm(), tolerance(1e-12) * 200.0);
}

TEST(Tumble, follows_the_controls_of_a_solution) {
  const Folder folder;
  ASSERT_EQ(lamprey(folder, "solve " + varied_example(folder, "translation", coarse) + " --out " + (folder / "solved")).exit_code, 0);
  const ProgramRun run = lamprey(folder, "simulate " + (folder / "problem.toml") + " --controls " + (folder / "solved/solution.json") +
                                      " --out " + (folder / "marched"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const file::Results solved = file::read_solution(folder / "solved");
  const file::Results marched = file::read_solution(folder / "marched");
  EXPECT_LE((solved.solution.position.back() - marched.solution.position.back()).norm(), 1e-9);
  EXPECT_LE((solved.solution.rotation.back()[1] - marched.solution.rotation.back()[1]).norm(), 1e-9);
}

}  // namespace
}  // namespace lamprey::tests
