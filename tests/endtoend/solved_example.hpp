// An example solved through the program, held to the marks of a proven answer and to a reference cost.
#pragma once

#include <ostream>

#include "program.hpp"
#include "result/solution_file.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {

using Values = std::vector<std::pair<std::string, std::string>>;

struct Example {
  std::string label;
  std::string name;
  std::vector<std::pair<std::string, std::string>> values;
  double cost;            // (N m)² s: at most this
  double cost_tolerance;  // relative, both ways; 0: only the bound above
  bool fine;              // full resolution: replay marks hold too
};

// Out-of-plane share of a motion that should stay in the plane of e_1 and e_2.
inline double out_of_plane(const maneuver::Solution& solution) {
  double largest = 0.0;
  for (std::size_t k = 0; k < solution.time.size(); ++k) {
    largest = std::max(largest, std::abs(solution.position[k][2]));
    for (const auto& R : solution.rotation[k])
      largest = std::max({largest, std::abs(R(2, 0)), std::abs(R(2, 1)), std::abs(R(0, 2)), std::abs(R(1, 2))});
  }
  return largest;
}

inline void expect_marks(const result::Results& results) {
  const certificate::Certificate& proof = *results.certificate;
  EXPECT_EQ(results.solution.status, maneuver::Status::optimal) << results.solution.message;
  EXPECT_LE(proof.goal_error, tolerance(1e-9));
  if (results.problem.goal->rest) {
    EXPECT_LE(proof.rest_error, tolerance(1e-9));
  }
  EXPECT_LE(proof.equation_residual, tolerance(1e-10));
  EXPECT_LE(proof.momentum_drift, tolerance(1e-11));
  EXPECT_LE(proof.rotation_drift, tolerance(1e-13));
  EXPECT_LE(proof.kkt, tolerance(1e-8));
}

inline void expect_solved(const Example& example) {
  const Folder folder;
  const ProgramRun run =
      lamprey(folder, "solve " + varied_example(folder, example.name, example.values) + " --out " + (folder / "run"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const result::Results results = result::read_solution(folder / "run");
  expect_marks(results);
  EXPECT_LE(results.solution.cost, example.cost);
  if (example.cost_tolerance > 0.0) {
    EXPECT_GE(results.solution.cost, example.cost - 2.0 * example.cost_tolerance * std::abs(example.cost));
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
inline Example close_to(std::string label, std::string name, std::vector<std::pair<std::string, std::string>> values,
                        double cost, double relative, bool fine = false) {
  return {std::move(label), std::move(name), std::move(values), cost + relative * std::abs(cost), relative, fine};
}

using Values = std::vector<std::pair<std::string, std::string>>;

inline void PrintTo(const Example& example, std::ostream* stream) { *stream << example.label; }

}  // namespace lamprey::tests
