#include "commands.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <thread>

#include "certificate/claims.hpp"
#include "document/io_error.hpp"
#include "document/text_table.hpp"
#include "file/problem_file.hpp"
#include "file/words.hpp"
#include "interrupt.hpp"
#include "report/momentum_lines.hpp"
#include "report/report.hpp"
#include "report/summary.hpp"
#include "report/wording.hpp"
#include "result/controls_file.hpp"
#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "result/table_files.hpp"
#include "result/trajectory_file.hpp"
#include "task/choices.hpp"
#include "task/finer_steps.hpp"
#include "task/model_remarks.hpp"
#include "task/model_table.hpp"
#include "task/tasks.hpp"

namespace lamprey::app {

namespace {

using maneuver::Status;
using result::Results;

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

// A fact on one line, or, where that is long, a line for each of its parts.
void print_fact(const std::string& name, const std::string& value) {
  constexpr std::size_t long_value = 110;  // bytes
  std::string lines = value;
  if (value.size() > long_value)
    for (std::size_t at = lines.find("; "); at != std::string::npos; at = lines.find("; ", at + 1))
      lines.replace(at, 2, ";\n" + std::string(31, ' '));
  fmt::print("  {:<28} {}\n", name, lines);
}

// In blocks: one for each paragraph, and what to try as a list.
void print_remarks(const report::Remarks& remarks) {
  const bool blocks = !remarks.remedies.empty();
  for (const std::string& words : remarks.paragraphs) fmt::print("{}{}", blocks ? "\n" : "", document::wrapped(words));
  if (!blocks) return;
  fmt::print("\n  Try:\n");
  for (const std::string& remedy : remarks.remedies) fmt::print("{}", document::wrapped(remedy, "    - "));
  fmt::print("\n");
}

void print_verdict(const Results& results, const std::string& folder) {
  fmt::print("{}\n  {}\n", results.name, report::verdict(results));
  if (results.solution.status != Status::simulated) print_remarks(report::remarks(results));
  for (const std::string& line : report::momentum_lines(results)) fmt::print("  {}\n", line);
  for (const auto& [name, value] : report::facts(results)) print_fact(name, value);
  const std::string here = folder.empty() ? "." : folder;
  fmt::print("  {:<28} {}/report.html\n", "report", here);
  for (std::size_t n = 0; n < results.others.size(); ++n)
    fmt::print("  {:<28} {}/{}/report.html: cost {}, {}, {} steps\n", n == 0 ? "other minima" : "", here,
               report::folder_of_other(n), report::cost_number(results.others[n].solution.cost),
               file::word(*results.others[n].certificate->verdict), results.others[n].problem.steps);
}

// What is seldom meant, before time is spent on it.
void tell_remarks(const file::ProblemFile& problem_file) {
  for (const std::string& remark : task::model_remarks(problem_file, task::system_of(problem_file)))
    fmt::print(stderr, "lamprey: {}\n", remark);
}

void print_certificate(const certificate::Certificate& proof, const result::ResolvedProblem& problem) {
  for (const report::CertificateRow& row : report::certificate_rows(proof, problem)) {
    if (!problem.goal && row.value == report::number(evidence::unset)) continue;  // a march is asked for less
    fmt::print("  {} {:<43} {:<22} {}{}\n", !row.holds ? " " : (*row.holds ? "✓" : "✗"), row.name, row.value, row.mark,
               !row.stored        ? ""
               : row.mark.empty() ? "(stored by the solver)"
                                  : " (stored by the solver)");
  }
}

// Says where a cubic swings beyond its rows. Tables that lamprey export wrote say themselves how they run.
void choose_interpolation(const std::string& asked, result::ControlSamples& samples) {
  constexpr double worth_telling = 1.1;
  if (samples.source != result::ControlSource::table && samples.source != result::ControlSource::lines) {
    if (!asked.empty())
      throw model::InputError("--interpolation",
                              "found moments of a solution, which run between their nodes as they were found; allowed: "
                              "with a CSV table; leave it out");
    return;
  }
  if (!asked.empty()) samples.source = asked == "linear" ? result::ControlSource::lines : result::ControlSource::table;
  if (samples.source == result::ControlSource::lines) return;
  const result::Reach reach = result::reach_of_table(samples);
  if (asked.empty() && reach.between > worth_telling * reach.rows)
    fmt::print(stderr,
               "lamprey: the cubic through the rows of moments reaches {} N m between them, the rows {} N m at most; "
               "--interpolation linear keeps to them\n",
               report::number(reach.between, 3), report::number(reach.rows, 3));
}

}  // namespace

int solve(const SolveArguments& arguments) {
  file::ProblemFile problem_file = file::read_problem_file(arguments.problem);
  maneuver::Search& search = problem_file.problem.search;
  if (arguments.starts > 0) search.starts = arguments.starts;
  if (arguments.keep > 0) search.keep = arguments.keep;
  if (arguments.seed) search.seed = *arguments.seed;
  if (arguments.time_limit) search.time_limit = arguments.time_limit;
  search::SolveOptions options;
  options.workers = arguments.workers > 0 ? arguments.workers : static_cast<int>(std::thread::hardware_concurrency());
  if (!arguments.solver.empty()) options.solver = task::backend_named("--solver", arguments.solver);
  options.refinement = arguments.refinement;
  options.progress = [](const std::string& line) { fmt::print(stderr, "lamprey: {}\n", line); };
  watch_for_interrupts(2);
  options.interrupted = interrupted;
  options.hurried = interrupted_again;
  std::optional<task::EarlierMotion> first;
  if (!arguments.first.empty()) first = {result::read_solution(arguments.first), arguments.first + "/solution.json"};
  document::require_writable(arguments.out);  // before the work, not after it
  tell_remarks(problem_file);
  const auto task = arguments.resolve ? task::resolve_task : task::solve_task;
  const Results results = task(problem_file, options, arguments.command, first);
  report::write_results(arguments.out, results);
  if (arguments.json) {
    fmt::print("{}", result::solution_text(results));
  } else {
    print_verdict(results, arguments.out);
  }
  return exit_code(results.solution.status);
}

int simulate(const SimulateArguments& arguments) {
  const file::ProblemFile problem_file = file::read_problem_file(arguments.problem);
  task::MarchOptions options{.steps = arguments.steps,
                             .duration = arguments.duration,
                             .cycles = arguments.cycles,
                             .adaptive = arguments.adaptive,
                             .reference = arguments.reference,
                             .perturb = arguments.perturb,
                             .perturb_inertia = arguments.perturb_inertia,
                             .seed = arguments.seed};
  if (!arguments.scheme.empty()) options.scheme = task::scheme_named("--scheme", arguments.scheme);
  watch_for_interrupts(1);
  options.interrupted = interrupted;
  if (!arguments.controls.empty()) {
    options.controls_path = arguments.controls;
    options.controls = result::read_controls(arguments.controls, problem_file.problem.swimmer.joints);
    if (!options.controls->remark.empty()) fmt::print(stderr, "lamprey: {}\n", options.controls->remark);
    choose_interpolation(arguments.interpolation, *options.controls);
  }
  if (!arguments.angles.empty()) {
    options.angles_path = arguments.angles;
    options.angles = result::read_angles(arguments.angles, problem_file.problem.swimmer.joints);
    if (!options.angles->remark.empty()) fmt::print(stderr, "lamprey: {}\n", options.angles->remark);
  }
  if (!arguments.feedback.empty()) {
    options.followed = result::read_solution(arguments.feedback);
    options.followed_path = arguments.feedback + "/solution.json";
    options.followed_from = arguments.feedback_from;
  }
  document::require_writable(arguments.out);
  tell_remarks(problem_file);
  const Results results = task::march_task(problem_file, options, arguments.command);
  const bool ended_early = results.solution.status == Status::stalled;
  if (results.solution.status == Status::interrupted && results.solution.time.size() > 1)
    fmt::print(stderr, "lamprey: interrupted: {} steps are written to {}; interrupt again to leave them\n",
               results.solution.time.size() - 1, arguments.out);
  if (!ended_early || results.solution.time.size() > 1) report::write_results(arguments.out, results);
  if (ended_early) {
    fmt::print(stderr, "lamprey: {}\n", results.solution.message);
    if (results.solution.time.size() > 1)
      fmt::print(stderr, "lamprey: what it came to, up to {} s, is in {}\n",
                 report::number(results.solution.time.back()), arguments.out);
    return numerical_failure;
  }
  print_verdict(results, arguments.out);
  fmt::print("{}", document::wrapped(results.solution.message));
  return exit_code(results.solution.status);
}

int check(const std::string& problem) {
  fmt::print("{}", task::check_task(file::read_problem_file(problem)));
  return done;
}

std::string found_or_nothing(double value) { return std::isnan(value) ? "not found" : report::number(value, 3); }

std::string verdict_word(const std::optional<certificate::Verdict>& verdict) {
  return verdict ? "\"" + std::string(file::word(*verdict)) + "\"" : "not found";
}

// Which rows fail their marks, beside a verdict that does not depend on them.
std::string failed_rows(const certificate::Certificate& proof, const result::ResolvedProblem& problem) {
  std::string names;
  for (const report::CertificateRow& row : report::certificate_rows(proof, problem))
    if (row.holds && !*row.holds) names += (names.empty() ? "" : "; ") + row.name;
  return names;
}

std::string claimed_in_words(const certificate::FalseClaim& claim, double value) {
  if (claim.field.ends_with(".positive")) return std::isnan(value) ? "not found" : value > 0.0 ? "true" : "false";
  return found_or_nothing(value);
}

void print_status(const task::Verification& is) {
  const std::string_view status = file::word(is.stored.solution.status);
  if (!is.promises())
    fmt::print("  The stored status, {}, promises nothing.\n", status);
  else if (is.status_holds && is.stored.solution.status == Status::simulated &&
           std::isnan(is.found.certificate->equation_residual))
    fmt::print(
        "  The stored status, {}, is not refuted: the files do not hold all that the steps of such a march are made "
        "of{}.\n",
        status,
        is.found.certificate->beyond_moments <= 1.0 ? ", but none leads farther than moments like its own could" : "");
  else if (is.status_holds)
    fmt::print("  The stored status, {}, holds.\n", status);
  else
    fmt::print("  The stored status, {}, does not hold: {}{}\n", status, is.fault, is.fault.ends_with('.') ? "" : ".");
}

// Those of which nothing is found in one sentence.
void print_false_claims(const task::Verification& is) {
  std::vector<std::string> unfounded;
  for (const certificate::FalseClaim& claim : is.claims) {
    if (!claim.contradiction.empty()) {
      fmt::print("  What is stored contradicts itself: {} is {}, {} ({}).\n", claim.field,
                 report::number(claim.stored, 6), claim.contradiction, report::number(claim.found, 6));
      continue;
    }
    const bool verdict = claim.field == "verdict";
    if (!verdict && std::isnan(claim.found)) {
      unfounded.push_back(claim.field);
      continue;
    }
    fmt::print("  The stored certificate does not hold: {} is {}, it says {}.\n", claim.field,
               verdict ? verdict_word(is.found.certificate->verdict) : claimed_in_words(claim, claim.found),
               verdict ? verdict_word(is.stored.certificate->verdict) : claimed_in_words(claim, claim.stored));
  }
  if (!unfounded.empty())
    fmt::print("{}", document::wrapped(fmt::format("The stored certificate does not hold: of {} nothing is found.",
                                                   fmt::join(unfounded, ", "))));
}

int verify(const VerifyArguments& arguments) {
  std::optional<file::ProblemFile> asked;
  if (!arguments.problem.empty()) asked = file::read_problem_file(arguments.problem);
  const task::Verification is = task::verify_task(arguments.folder, asked);
  const certificate::Certificate& proof = *is.found.certificate;
  fmt::print("{}\n  recomputed from {}/solution.json\n", document::printable(is.found.name), arguments.folder);
  print_certificate(proof, is.found.problem);
  const std::string failed = failed_rows(proof, is.found.problem);
  if (proof.verdict)
    fmt::print("  Verdict: {}{}.\n", file::word(*proof.verdict),
               failed.empty() || *proof.verdict == certificate::Verdict::not_optimal
                   ? ""
                   : ", but beyond the mark: " + failed);
  print_status(is);
  print_false_claims(is);
  if (!is.trajectory_difference.empty())
    fmt::print("  {}/trajectory.h5 does not hold what solution.json does: {}.\n", arguments.folder,
               is.trajectory_difference);
  for (const std::string& difference : is.problem_differences)
    fmt::print("  Another problem than that of {}: {}.\n", arguments.problem, difference);
  if (asked && is.problem_differences.empty() && is.march_differences.empty())
    fmt::print("  The problem is that of {}.\n", arguments.problem);
  else if (asked && is.problem_differences.empty())
    fmt::print("  The swimmer is that of {}; it was marched with another {}.\n", arguments.problem,
               fmt::join(is.march_differences, ", another "));
  if (!is.holds()) return no_optimal_solution;
  const Status stored = is.stored.solution.status;
  return exit_code(stored == Status::interrupted ? Status::time_limit : stored);  // nobody interrupted this check
}

int report(const std::vector<std::string>& folders) {
  const Results results = result::read_solution(folders.front());
  const bool compare = folders.size() == 2;
  const std::string name = compare ? "comparison.html" : "report.html";
  const std::string page =
      compare ? report::comparison_html(results, result::read_solution(folders[1])) : report::report_html(results);
  document::write_files(folders.front(), {document::finished_file(name, page),
                                          document::finished_file("snapshots.svg", report::snapshot_svg(results))});
  fmt::print("{}/{}\n", folders.front(), name);
  return done;
}

int export_tables(const std::string& folder) {
  const Results results = result::read_solution(folder);
  const std::string path = folder + "/solution.json";
  std::vector<document::PendingFile> tables = {result::angles_table(results, path)};
  const std::optional<document::PendingFile> moments = result::moments_table(results, path);
  if (moments) tables.push_back(*moments);
  document::write_files(folder, tables);
  fmt::print("{}/angles.csv\n", folder);
  if (moments) fmt::print("{}/moments.csv\n", folder);
  if (!moments)
    fmt::print(stderr,
               "lamprey: no moments.csv: above order 2 moments are polynomials over the stages of each step, "
               "control_stages of solution.json\n");
  return done;
}

int inertia(const std::vector<double>& semi_axes, double density, bool json) {
  if (semi_axes.size() > 3)
    throw model::InputError("--semi-axes", fmt::format("found {} numbers; allowed: three of an ellipsoid, or two of an "
                                                       "ellipse in the plane; leave some out",
                                                       semi_axes.size()));
  const Eigen::VectorXd axes =
      Eigen::Map<const Eigen::VectorXd>(semi_axes.data(), static_cast<Eigen::Index>(semi_axes.size()));
  fmt::print("{}", json ? task::inertia_json(axes, density) : task::inertia_table(axes, density));
  return done;
}

std::string version_line() {
  const result::Provenance here = result::provenance_here();
  return fmt::format("lamprey {} ({}, {})", here.version, here.build_type, here.compiler);
}

void finish_output() {
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw document::IoError("standard output", fmt::format("cannot be written: {}", std::strerror(errno)));
}

int explain_failure() noexcept {
  try {
    throw;
  } catch (const model::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return invalid_input;
  } catch (const document::IoError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return input_output;
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) {  // what fmt then throws
      fmt::print(stderr, "standard output: cannot be written: {}\n", std::strerror(errno));
      return input_output;
    }
    fmt::print(stderr, "lamprey: internal error: {}\n", error.what());
    return internal_error;
  } catch (...) {
    fmt::print(stderr, "lamprey: internal error\n");
    return internal_error;
  }
}

}  // namespace lamprey::app
