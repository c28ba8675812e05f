// Maneuvers: the transcription's functions, the certificate, and whole solves.
#include <benchmark/benchmark.h>

#include "certificate/certify.hpp"
#include "guess/guess.hpp"
#include "measured.hpp"
#include "search/solve.hpp"
#include "search/solver.hpp"
#include "swimmers.hpp"
#include "transcription/goal_rank.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::bench {

namespace {

using Eigen::VectorXd;
using maneuver::Problem;

// The rotation maneuver at N = 1000 and a point of it; programs keep what they know of a point, so there are two.
struct Programmed {
  Problem problem = rotation(1000);
  model::System system{problem.swimmer};
  maneuver::Maneuver maneuver = make_maneuver(system, problem, problem.steps);
  maneuver::NodePath guess = guess::random_guess(system, maneuver, 1);
  transcription::Transcription program{system, maneuver, transcription::stated_goal_rows(system, maneuver)};
  VectorXd point = program.pack(guess);
  VectorXd other = 1.000001 * point;
  VectorXd multiplier = VectorXd::Random(program.constraint_count());
  VectorXd values;
};

void constraints(benchmark::State& state) {
  Programmed p;
  p.values.resize(p.program.constraint_count());
  for (auto _ : state) {
    p.program.constraints(p.point, p.values);
    p.point.swap(p.other);
  }
}

void jacobian(benchmark::State& state) {
  Programmed p;
  for (auto _ : state) p.program.jacobian(p.point, p.values);
  state.counters["entries"] = static_cast<double>(p.values.size());
}

void hessian(benchmark::State& state) {
  Programmed p;
  for (auto _ : state) p.program.hessian(p.point, 1.0, p.multiplier, p.values);
  state.counters["entries"] = static_cast<double>(p.values.size());
}

void certify(benchmark::State& state, bool replay) {
  const Problem problem = rotation(1000);
  const model::System system(problem.swimmer);
  const maneuver::Solution solution = marched(system, problem);
  certificate::Options options;
  options.replay = replay;
  for (auto _ : state) benchmark::DoNotOptimize(certificate::certify(system, problem, solution, options).kkt);
}

// Search and all: from one random start on the coarse grid to full resolution.
void solve(benchmark::State& state, const Problem& problem) {
  const model::System system(problem.swimmer);
  for (auto _ : state) {
    const std::vector<maneuver::Solution> found = search::solve(system, problem, search::SolveOptions());
    if (found.front().status != maneuver::Status::optimal) return state.SkipWithError("not solved");
    state.counters["iterations"] = found.front().solver.iterations;
    state.counters["starts"] = found.front().search.starts;
    state.counters["cost"] = found.front().cost;
  }
}

// From an answer on, to a goal that has moved by a hundredth, and back, and so on.
void solve_again(benchmark::State& state, const Problem& problem) {
  const model::System system(problem.swimmer);
  search::Solver solver(system, problem, search::solve(system, problem, search::SolveOptions()).front());
  maneuver::Goal near = *problem.goal, far = near;
  if (far.move[0]) *far.move[0] *= 1.01;
  *far.turn *= 0.99;
  bool away = false;
  for (auto _ : state) {
    solver.set_goal((away = !away) ? far : near);
    if (solver.solve().termination != optimizer::Termination::converged) return state.SkipWithError("not solved");
  }
}

}  // namespace

void register_maneuvers() {
  using benchmark::kMillisecond;
  measured("constraints, N = 1000", kMillisecond, constraints);
  measured("Jacobian, N = 1000", kMillisecond, jacobian);
  measured("Hessian, N = 1000", kMillisecond, hessian);
  measured("certificate without replay, N = 1000", kMillisecond, certify, false);
  measured("certificate, N = 1000", kMillisecond, certify, true)->Iterations(1);
  measured("solve translation, plane, N = 100", kMillisecond, solve, translation(100))->Iterations(1);
  measured("solve translation, plane, N = 1000", kMillisecond, solve, translation(1000))->Iterations(1);
  measured("solve translation, space, N = 1000", kMillisecond, solve, translation(1000, false))->Iterations(1);
  measured("solve rotation, N = 100", kMillisecond, solve, rotation(100))->Iterations(1);
  measured("solve rotation, N = 1000", kMillisecond, solve, rotation(1000))->Iterations(1);
  for (const int steps : {100, 1000}) {
    const std::string N = ", N = " + std::to_string(steps);
    measured("re-solve translation, plane" + N, kMillisecond, solve_again, translation(steps));
    measured("re-solve translation, space" + N, kMillisecond, solve_again, translation(steps, false));
    measured("re-solve rotation" + N, kMillisecond, solve_again, rotation(steps));
  }
}

}  // namespace lamprey::bench
