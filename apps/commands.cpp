#include "commands.hpp"

#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <thread>

#include "certificate/certify.hpp"
#include "file/controls_file.hpp"
#include "file/followed_file.hpp"
#include "file/io_error.hpp"
#include "file/model_table.hpp"
#include "file/problem_file.hpp"
#include "file/resolve.hpp"
#include "file/solution_file.hpp"
#include "file/trajectory_file.hpp"
#include "file/words.hpp"
#include "interrupt.hpp"
#include "maneuver/control_path.hpp"
#include "maneuver/feedback.hpp"
#include "maneuver/simulate.hpp"
#include "maneuver/tracking.hpp"
#include "report/momentum_lines.hpp"
#include "report/report.hpp"
#include "report/summary.hpp"
#include "study/answer.hpp"

namespace lamprey::app {

namespace {

using file::Results;
using maneuver::Problem;
using maneuver::Status;

// The system of a problem file; what is wrong with it is told with its place in the file.
model::System build_system(const file::ProblemFile& problem_file) {
  try {
    return model::System(problem_file.problem.swimmer);
  } catch (const model::InputError& error) {
    throw file::located(error, problem_file);
  }
}

Results assemble(const file::ProblemFile& problem_file, const model::System& system, const std::string& command) {
  Results results;
  results.name = problem_file.problem.name;
  results.source = problem_file.problem.source;
  results.problem = file::resolve(system, problem_file.problem);
  results.provenance = file::provenance_here();
  results.provenance.command = command;
  results.provenance.problem_sha256 = problem_file.sha256;
  results.provenance.seed = problem_file.problem.search.seed;
  return results;
}

int exit_code(Status status) {
  switch (status) {
    case Status::optimal:
    case Status::simulated:
      return done;
    case Status::interrupted:
      return was_interrupted;
    default:
      return no_optimal_solution;
  }
}

void print_verdict(const Results& results, const std::string& folder) {
  fmt::print("{}\n  {}\n", results.name, report::verdict(results));
  for (const std::string& line : report::momentum_lines(results)) fmt::print("  {}\n", line);
  for (const auto& [name, value] : report::facts(results)) fmt::print("  {:<28} {}\n", name, value);
  fmt::print("  {:<28} {}/report.html\n", "report", folder);
}

void print_certificate(const certificate::Certificate& proof, const file::ResolvedProblem& problem) {
  for (const report::CertificateRow& row : report::certificate_rows(proof, problem))
    fmt::print("  {} {:<34} {:<22} {}\n", !row.holds ? " " : (*row.holds ? "✓" : "✗"), row.name, row.value, row.mark);
}

maneuver::ControlFunction controls_of(const file::ControlSamples& samples, const model::System& system) {
  std::vector<mechanics::Moments> moments;
  for (const auto& on_parent : samples.control) moments.push_back(maneuver::moments_at_zero_angle(system, on_parent));
  if (samples.source == file::ControlSource::stages)
    return maneuver::stage_polynomials(samples.time, moments, samples.stages);
  const int joints = system.joint_count();
  Eigen::MatrixXd values(3 * joints, static_cast<Eigen::Index>(samples.time.size()));
  for (std::size_t s = 0; s < samples.time.size(); ++s)
    for (int j = 0; j < joints; ++j)
      values.col(static_cast<Eigen::Index>(s)).segment<3>(3 * j) = moments[s][static_cast<std::size_t>(j)];
  const Eigen::VectorXd times =
      Eigen::Map<const Eigen::VectorXd>(samples.time.data(), static_cast<Eigen::Index>(samples.time.size()));
  const maneuver::ControlPath path = samples.source == file::ControlSource::spline
                                         ? maneuver::natural_spline_through_nodes(samples.points, times, values)
                                         : maneuver::ControlPath(samples.source == file::ControlSource::table
                                                                     ? maneuver::Interpolation::not_a_knot_cubic
                                                                     : maneuver::Interpolation::linear,
                                                                 times, values);
  return [path, joints](double t) {
    const Eigen::VectorXd u = path.value(t);
    mechanics::Moments at_time;
    for (int j = 0; j < joints; ++j) at_time.emplace_back(u.segment<3>(3 * j));
    return at_time;
  };
}

void override_march(const SimulateArguments& arguments, Problem& problem) {
  if (arguments.steps > 0) problem.steps = arguments.steps;
  if (arguments.duration > 0.0) problem.duration = {.free = false, .value = arguments.duration};
  if (arguments.scheme.empty()) return;
  for (const auto& entry : file::schemes)
    if (entry.text == arguments.scheme) {
      problem.scheme = entry.value;
      return;
    }
  throw model::InputError(
      "--scheme",
      "found \"" + arguments.scheme + "\"; allowed: paper, trapezoid, midpoint, order4, order6; choose one of them");
}

// A maneuver to follow, and the swimmer that it was made for.
struct Followed {
  Results results;
  model::System system;
  integrator::FeedbackLaw law;

  Followed(Results read, const std::string& folder)
      : results(std::move(read)),
        system(file::problem_of(results).swimmer),
        law(maneuver::feedback_law(
            system, results.solution,
            controls_of(file::read_controls(folder + "/solution.json", system.joint_count()), system))) {}
  Followed(const Followed&) = delete;
  Followed& operator=(const Followed&) = delete;
};

void perturb(const SimulateArguments& arguments, const model::System& system, const Followed* followed,
             Problem& problem) {
  if (arguments.perturb == 0.0) return;
  const int turns = system.velocity_count() - 3;
  problem.start =
      maneuver::turned_start(system, problem.start, arguments.perturb, arguments.seed,
                             followed ? maneuver::answered_turns(system, followed->results.solution.feedback)
                                      : Eigen::MatrixXd(Eigen::MatrixXd::Identity(turns, turns)));
}

// By the scheme or the reference integrator, under moments in time or under feedback.
maneuver::Solution march(const SimulateArguments& arguments, const model::System& system, const Problem& problem,
                         const Followed* followed) {
  maneuver::SimulateOptions options{arguments.adaptive, interrupted};
  maneuver::ControlFunction control = maneuver::no_control(system);
  if (!arguments.controls.empty())
    control = controls_of(file::read_controls(arguments.controls, system.joint_count()), system);
  if (followed) {
    control = [followed](double time) { return followed->law.planned(time); };
    options.feedback = [followed](double time, const integrator::ReferenceState& state) {
      return followed->law.moments(time, state);
    };
  }
  maneuver::Solution solution = arguments.reference ? maneuver::simulate_by_reference(system, problem, control, options)
                                                    : maneuver::simulate(system, problem, control, options);
  if (followed) {
    solution.tracking = maneuver::tracking_of(followed->law, solution);
    solution.tracking->maneuver = followed->results.name;
  }
  return solution;
}

}  // namespace

int solve(const SolveArguments& arguments) {
  const file::ProblemFile problem_file = file::read_problem_file(arguments.problem);
  file::require_supported(problem_file,
                          arguments.solver == "ipopt" ? file::Purpose::solve_with_ipopt : file::Purpose::solve);
  const model::System system = build_system(problem_file);
  study::SolveOptions options;
  options.workers = arguments.workers > 0 ? arguments.workers : static_cast<int>(std::thread::hardware_concurrency());
  if (arguments.solver == "newton") options.solver = study::Backend::newton;
  if (arguments.solver == "ipopt") options.solver = study::Backend::ipopt;
  options.refinement = arguments.refinement;
  options.progress = [](const std::string& line) { fmt::print(stderr, "lamprey: {}\n", line); };
  options.interrupted = interrupted;
  Results results = assemble(problem_file, system, arguments.command);
  try {
    study::Answer answer = study::answer(system, problem_file.problem, options);
    results.solution = std::move(answer.solution);
    results.certificate = answer.certificate;
    if (problem_file.problem.duration.free) {
      results.problem.duration = results.solution.time.back();
      results.problem.time_step = results.problem.duration / results.problem.steps;
    }
  } catch (const model::InputError& error) {
    throw file::located(error, problem_file);
  }
  file::write_files(arguments.out, {file::solution_file(results), file::trajectory_file(results),
                                    file::finished_file("report.html", report::report_html(results))});
  if (arguments.json) {
    fmt::print("{}", file::solution_text(results));
  } else {
    print_verdict(results, arguments.out);
  }
  return exit_code(results.solution.status);
}

int simulate(const SimulateArguments& arguments) {
  file::ProblemFile problem_file = file::read_problem_file(arguments.problem);
  override_march(arguments, problem_file.problem);
  file::require_supported(problem_file, file::Purpose::simulate);
  const model::System system = build_system(problem_file);
  problem_file.problem.goal.reset();  // marching seeks no goal
  std::unique_ptr<Followed> followed;
  if (!arguments.feedback.empty())
    followed = std::make_unique<Followed>(
        file::read_followed(arguments.feedback, system, problem_file.problem.duration.value), arguments.feedback);
  perturb(arguments, system, followed.get(), problem_file.problem);
  Results results = assemble(problem_file, system, arguments.command);
  results.solution = march(arguments, system, problem_file.problem, followed.get());
  if (results.solution.status == Status::stalled) {
    fmt::print(stderr, "lamprey: {}\n", results.solution.message);
    return numerical_failure;
  }
  if (results.solution.status == Status::interrupted) {  // the nodes reached are the result
    results.problem.steps = static_cast<int>(results.solution.time.size()) - 1;
    results.problem.duration = results.solution.time.back();
  }
  file::write_files(arguments.out, {file::solution_file(results), file::trajectory_file(results),
                                    file::finished_file("report.html", report::report_html(results))});
  print_verdict(results, arguments.out);
  if (results.solution.divided.steps > 0) fmt::print("  {}\n", results.solution.message);
  return exit_code(results.solution.status);
}

int check(const std::string& problem) {
  const file::ProblemFile problem_file = file::read_problem_file(problem);
  const model::System system = build_system(problem_file);
  fmt::print("{}", file::model_table(problem_file.problem, system));
  return done;
}

int verify(const std::string& folder) {
  Results results = file::read_solution(folder);
  const Problem problem = file::problem_of(results);
  const model::System system(problem.swimmer);
  certificate::Certificate proof = certificate::certify(system, problem, results.solution);
  if (results.certificate) proof.refinement = results.certificate->refinement;  // by solving: as stored
  const Status claimed = results.solution.status;
  if (problem.goal) study::judge(problem, proof, results.solution);
  fmt::print("{}\n  recomputed from {}/solution.json\n", results.name, folder);
  print_certificate(proof, results.problem);
  if (proof.verdict) fmt::print("  Verdict: {}.\n", file::word(*proof.verdict));
  const bool holds = claimed != Status::optimal || results.solution.status == Status::optimal;
  fmt::print("  {}\n",
             holds ? "The stored status holds." : "The stored status does not hold: " + results.solution.message);
  return holds ? exit_code(claimed) : no_optimal_solution;
}

int report(const std::vector<std::string>& folders) {
  const Results results = file::read_solution(folders.front());
  const bool compare = folders.size() == 2;
  const std::string name = compare ? "comparison.html" : "report.html";
  const std::string page =
      compare ? report::comparison_html(results, file::read_solution(folders[1])) : report::report_html(results);
  file::write_files(folders.front(), {file::finished_file(name, page),
                                      file::finished_file("snapshots.svg", report::snapshot_svg(results))});
  fmt::print("{}/{}\n", folders.front(), name);
  return done;
}

int inertia(const std::vector<double>& semi_axes, double density, bool json) {
  const Eigen::Vector3d axes(semi_axes[0], semi_axes[1], semi_axes[2]);
  fmt::print("{}", json ? file::inertia_json(axes, density) : file::inertia_table(axes, density));
  return done;
}

std::string version_line() {
  const file::Provenance here = file::provenance_here();
  return fmt::format("lamprey {} ({}, {})", here.version, here.build_type, here.compiler);
}

int explain_failure() noexcept {
  try {
    throw;
  } catch (const model::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return invalid_input;
  } catch (const file::IoError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return input_output;
  } catch (const std::exception& error) {
    fmt::print(stderr, "lamprey: internal error: {}\n", error.what());
    return internal_error;
  } catch (...) {
    fmt::print(stderr, "lamprey: internal error\n");
    return internal_error;
  }
}

}  // namespace lamprey::app
