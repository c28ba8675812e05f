#include "report/summary.hpp"
#include "report/cost_shares.hpp"
#include "report/limit_facts.hpp"
#include "report/momentum_lines.hpp"
#include "report/transport.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "certificate/limit_words.hpp"
#include "evidence/clearance.hpp"
#include "evidence/goal_check.hpp"
#include "evidence/limit_check.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"
#include "maneuver/energy_balance.hpp"
#include "maneuver/maneuver.hpp"
#include "model/world_axes.hpp"
#include "report/wording.hpp"
#include "result/resolve.hpp"
#include "study/plain_words.hpp"
#include "task/model_table.hpp"
#include "task/task_words.hpp"

namespace lamprey::report {
namespace {

std::string minima_in_words(std::size_t count) {
  return count == 1 ? "1 minimum" : fmt::format("{} different minima", count);
}

// Where two solvers searched: who found the minima.
std::string by_solvers(const maneuver::SearchRecord& search) {
  int newton = 0, ipopt = 0, both = 0;
  for (const maneuver::Minimum& minimum : search.minima) {
    if (!minimum.by_ipopt) return "";
    ++(*minimum.by_ipopt == 0 ? newton : *minimum.by_ipopt == minimum.count ? ipopt : both);
  }
  return search.minima.empty()
             ? ""
             : fmt::format(": {} of both solvers, {} of newton alone, {} of ipopt alone", both, newton, ipopt);
}

using certificate::Certificate;
using maneuver::Status;

const char* scheme_name(maneuver::Scheme scheme) {
  switch (scheme) {
    case maneuver::Scheme::paper:
      return "paper (order 1)";
    case maneuver::Scheme::trapezoid:
      return "trapezoid (order 2)";
    case maneuver::Scheme::midpoint:
      return "midpoint (order 2)";
    case maneuver::Scheme::order4:
      return "order4 (order 4)";
    case maneuver::Scheme::order6:
      return "order6 (order 6)";
  }
  return "unknown";
}

const char* status_words(Status status) {
  switch (status) {
    case Status::optimal:
      return "Optimal";
    case Status::simulated:
      return "Simulated";
    case Status::feasible:
      return "Feasible, not proven optimal";
    case Status::infeasible:
      return "Infeasible";
    case Status::stalled:
      return "Stalled before it was optimal";
    case Status::time_limit:
      return "Stopped by the time limit";
    case Status::interrupted:
      return "Interrupted: the best point so far";
  }
  return "Unknown status";
}

// The row of the goal whose end is farthest from what it asks, and its unit. Files do not tell which one that is.
struct FarthestRow {
  std::string words;
  const char* unit;
};

FarthestRow farthest_row(const result::Results& results) {
  const auto unit = [](bool turn) { return turn ? "rad" : "m"; };
  const Certificate& proof = *results.certificate;
  if (!proof.goal_missed.empty()) return {proof.goal_missed, unit(proof.goal_missed_by_turn)};
  const maneuver::Solution& solution = results.solution;
  if (results.problem.goal && !solution.time.empty() && solution.rotation.size() == solution.time.size()) {
    const maneuver::Problem problem = result::problem_of(results);
    const model::System system(problem.swimmer);
    const evidence::GoalMiss miss = evidence::largest_miss(evidence::StoredMotion(system, problem, solution));
    if (!miss.condition.empty()) return {miss.condition, unit(miss.is_turn)};
  }
  const auto& goal = results.problem.goal;  // met to the last digit
  const bool moves =
      goal && std::any_of(goal->move.begin(), goal->move.end(), [](const auto& along) { return along.has_value(); });
  return {"goal", unit(!moves)};
}

std::string goal_words(const maneuver::Goal& goal) {
  std::vector<std::string> parts;
  for (std::size_t axis = 0; axis < model::world_axes.size(); ++axis) {
    if (goal.move[axis])
      parts.push_back(fmt::format("move {} m along {}", number(*goal.move[axis]), model::world_axes[axis]));
  }
  if (goal.turn)
    parts.push_back(fmt::format("turn {} by {} rad",
                                goal.periodic        ? "the root"
                                : goal.angle.empty() ? "every body"
                                                     : "every body not below the joints that follow",
                                vector(*goal.turn)));
  for (const auto& [body, rotation] : goal.rotation) {
    parts.push_back(rotation ? fmt::format("{} ends at {} rad", body, vector(*rotation)) : body + " turns freely");
  }
  for (const std::string& line : task::joint_end_lines(goal, [](double value) { return number(value); }))
    parts.push_back(line);
  if (goal.periodic) parts.emplace_back("shape and its velocity repeat");
  parts.emplace_back(goal.rest ? "end at rest" : goal.joints_rest ? "joints end at rest" : "end velocities free");
  return fmt::format("{}", fmt::join(parts, "; "));
}

void append_tracking(const maneuver::Tracking& tracking, std::vector<std::pair<std::string, std::string>>& rows) {
  const auto off = [](double rotation, double position) {
    return fmt::format("{} rad, {} m", number(rotation, 3), number(position, 3));
  };
  rows.emplace_back("Follows", tracking.maneuver);
  rows.emplace_back("Off the plan at the end", off(tracking.rotation_error, tracking.position_error));
  rows.emplace_back("Off the plan at most", off(tracking.largest_rotation_error, tracking.largest_position_error));
  rows.emplace_back("Largest correction", number(tracking.largest_correction, 3) + " N m");
  if (tracking.cut_share > 0.0)
    rows.emplace_back("Limits of torque", fmt::format("cut moments at {:.1f} % of times", 100.0 * tracking.cut_share));
  if (tracking.lost())
    rows.emplace_back("Feedback", tracking.cut_first()
                                      ? "has lost the plan: motors are at their limits of torque"
                                      : "has lost the plan: start, swimmer or scheme differ from it by more than gains "
                                        "answer");
}

}  // namespace

namespace {

// Whether the nodes, which the cost looks at, see other work than the joints do.
bool works_otherwise(const result::Results& results) {
  const auto& proof = results.certificate;
  return proof && proof->replay && results.solution.cost_parts &&
         proof->replay->works_otherwise(results.solution.cost_parts->work);
}

}  // namespace

bool succeeded(const result::Results& results) {
  if (results.solution.status == Status::simulated) return march_faults(results).empty();
  if (results.solution.status != Status::optimal) return false;
  if (!results.certificate) return true;
  const Certificate& proof = *results.certificate;
  const bool proved = !proof.verdict || *proof.verdict == certificate::Verdict::proved;
  const bool unresolved = proof.replay && proof.replay->misses();
  const bool grows = proof.refinement && proof.refinement->grows();
  return proved && !unresolved && !grows && !works_otherwise(results);
}

bool without_motion(const result::Results& results) {
  return results.solution.status != Status::simulated && results.certificate &&
         results.certificate->equation_residual > results.certificate->equation_allowed();
}

namespace {

// J, of the joints by the replay where the nodes show other: moments that come and go within a step.
std::optional<double> work_by_replay(const std::optional<Certificate>& proof, double at_nodes) {
  if (!proof || !proof->replay || !proof->replay->works_otherwise(at_nodes)) return std::nullopt;
  return proof->replay->work;
}

std::string work_words(double at_nodes, std::optional<double> by_replay) {
  const std::string words = cost_number(at_nodes, 5) + " J";
  if (!by_replay) return words + " (no regeneration)";
  return fmt::format("{} by the nodes, {} J by the replay, which sees between them (no regeneration)", words,
                     cost_number(*by_replay, 5));
}

std::string transport_words(const Transport& moved, std::optional<double> by_replay) {
  const std::string at_nodes = cost_number(moved.work / moved.distance, 5) + " J/m";
  if (!by_replay) return at_nodes;
  return fmt::format("{} J/m by the replay's work, {} by the nodes'", cost_number(*by_replay / moved.distance, 5),
                     at_nodes);
}

// With the work as the cost counts it, where it does.
std::optional<Transport> transport_as_weighed(const result::Results& results) {
  std::optional<Transport> moved = transport(results);
  const maneuver::CostWeights& weights = results.problem.cost_weights;
  const auto& parts = results.solution.cost_parts;
  if (moved && parts && weights.work + weights.transport > 0.0) moved->work = parts->work;
  return moved;
}

// Whether the goal leaves open how the root ends turned.
bool turns_freely(const result::ResolvedProblem& problem) {
  const auto own = problem.goal->rotation.find(problem.bodies.front().name);
  return own == problem.goal->rotation.end() ? !problem.goal->turn : !own->second;
}

// How the root has turned: with all turns where it does about one axis, else from its first attitude to its last.
std::string turn_words(const maneuver::Solution& solution) {
  constexpr double off_axis = 1e-6;    // of the turns
  constexpr double round_off = 1e-12;  // rad
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), largest = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> turns;
  for (std::size_t k = 1; k < solution.rotation.size(); ++k)
    turns.push_back(lie::log(solution.rotation[k][0] * solution.rotation[k - 1][0].transpose()));
  double all = 0.0;
  for (const Eigen::Vector3d& turn : turns) {
    all += turn.norm();
    if (turn.norm() > largest.norm()) largest = turn;
    sum += turn;
  }
  const Eigen::Vector3d axis = largest.stableNormalized();
  const bool one_axis = std::all_of(turns.begin(), turns.end(), [&](const Eigen::Vector3d& turn) {
    return (turn - axis * axis.dot(turn)).norm() <= off_axis * largest.norm();
  });
  if (one_axis) return vector(sum.norm() <= off_axis * all ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : sum) + " rad";
  const Eigen::Vector3d turn = lie::log(solution.rotation.back()[0] * solution.rotation.front()[0].transpose());
  return vector((turn.array().abs() < round_off).select(0.0, turn)) + " rad, less than half a turn";
}

// Of so much as the swimmer's size allows to tell from round-off.
std::string way_words(const maneuver::Solution& solution, const result::ResolvedProblem& problem) {
  constexpr double round_off = 1e-12;  // of the largest semi-axis
  double size = 0.0;
  for (const result::ResolvedBody& body : problem.bodies) size = std::max(size, body.semi_axes.maxCoeff());
  const Eigen::Vector3d way = solution.position.back() - solution.position.front();
  return vector((way.array().abs() < round_off * size).select(0.0, way)) + " m";
}

// Where a march went, and what became of its energy.
void append_march(const result::Results& results, std::vector<std::pair<std::string, std::string>>& rows) {
  const maneuver::Solution& solution = results.solution;
  const std::size_t nodes = solution.time.size();
  if (nodes < 2 || solution.angular_velocity.size() != nodes || solution.linear_velocity.size() != nodes) return;
  rows.emplace_back("Displacement", way_words(solution, results.problem));
  rows.emplace_back("Turn of " + results.problem.bodies.front().name, turn_words(solution));
  const maneuver::Problem problem = result::problem_of(results);
  const model::System system(problem.swimmer);
  if (const auto gap = march_clearance(results)) rows.emplace_back("Clearance", clearance_words(*gap, results.problem));
  for (const auto& row : limit_facts(results)) rows.push_back(row);
  if (const auto energy = maneuver::energy_balance(system, solution))
    rows.emplace_back("Energy",
                      fmt::format("{} J at the start, {} J at the end, between {} and {} J", number(energy->first),
                                  number(energy->last), number(energy->least), number(energy->most)));
  if (const std::optional<Transport> moved = transport(results); moved && moved->work > 0.0) {
    rows.emplace_back("Work of the joints", work_words(moved->work, std::nullopt));
    if (goes_a_way(results) && !maneuver::has_momentum(system, problem.start))
      rows.emplace_back("Cost of transport", transport_words(*moved, std::nullopt));
  }
}

}  // namespace

std::string verdict(const result::Results& results) {
  std::string words = status_words(results.solution.status);
  if (results.solution.status == Status::optimal && results.certificate && results.certificate->verdict) {
    words = file::word(*results.certificate->verdict);
    words[0] = static_cast<char>(std::toupper(words[0]));
  }
  if (results.solution.status == Status::simulated) {
    const std::vector<std::string> faults = march_faults(results);
    return faults.empty() ? words : fmt::format("{}, but {}", words, fmt::join(faults, " and "));
  }
  if (!results.certificate) return words;
  const Certificate& proof = *results.certificate;
  if (results.solution.status == Status::optimal && proof.replay && proof.replay->misses())
    words += std::isnan(proof.replay->rotation_error)
                 ? std::string(", on steps too coarse to resolve it (its replay breaks off)")
             : proof.replay->misses_by_place()
                 ? fmt::format(", on steps too coarse to resolve it (replay off by {} m)",
                               number(proof.replay->position_error, 2))
                 : fmt::format(", on steps too coarse to resolve it (replay off by {} rad)",
                               number(proof.replay->rotation_error, 2));
  if (results.solution.status == Status::optimal && proof.refinement && proof.refinement->grows())
    words += ", at a cost that grows on finer steps";
  if (const auto& aside = results.solution.search.set_aside; aside && results.solution.status == Status::optimal)
    words += fmt::format(", dearer than a motion of cost {} that takes {} steps", cost_number(aside->cost),
                         aside->steps ? std::to_string(*aside->steps) : "more");
  const auto& parts_of_cost = results.solution.cost_parts;
  if (results.solution.status == Status::optimal && works_otherwise(results))
    words += fmt::format(", of a cost whose nodes see {} J of work where the joints do {} J",
                         number(parts_of_cost->work, 4), number(proof.replay->work, 4));
  if (without_motion(results))
    return fmt::format(
        "{}: what is shown is no motion but the search’s last trial, whose steps do not follow from "
        "each other (by {} of the momentum’s scale)",
        words, number(proof.equation_residual, 2));
  std::vector<std::string> parts;
  const bool missed = proof.goal_error > evidence::goal_mark;
  if (!std::isnan(proof.goal_error)) {
    const FarthestRow row = farthest_row(results);
    parts.push_back(fmt::format("{} {} {}", missed ? row.words + " missed by" : "goal reached within",
                                number(proof.goal_error, 2), row.unit));
  }
  if (results.solution.status == Status::infeasible) {  // what else holds of it helps nobody
    if (proof.limits && proof.limits->violation > evidence::limit_mark)
      return words + ": " +
             certificate::violation_in_words(proof.limits->key, proof.limits->violation, proof.limits->time);
    return parts.empty() ? words : words + ": " + parts.front();
  }
  const bool rests = results.problem.goal && results.problem.goal->stills_joints();
  if (rests && !std::isnan(proof.rest_error))
    parts.push_back(fmt::format("rest{} within {}", results.problem.goal->joints_rest ? " of the joints" : "",
                                number(proof.rest_error, 2)));
  if (proof.limits && proof.limits->violation > evidence::limit_mark)
    parts.push_back(certificate::violation_in_words(proof.limits->key, proof.limits->violation, proof.limits->time));
  if (!std::isnan(proof.kkt)) parts.push_back(fmt::format("optimality conditions within {}", number(proof.kkt, 2)));
  if (proof.second_order && proof.second_order->lost())
    parts.emplace_back("curvature lost in round-off");
  else if (proof.second_order && proof.second_order->held())
    parts.emplace_back("limits leave no direction open");
  else if (proof.second_order)
    parts.push_back(fmt::format("smallest curvature {}", number(proof.second_order->smallest_eigenvalue, 2)));
  return parts.empty() ? words : fmt::format("{}: {}", words, fmt::join(parts, ", "));
}

namespace {

// Whether the verdict has said it: that this row of the goal is missed, and nothing more.
bool in_headline(const std::string& missed, const result::Results& results) {
  if (!results.certificate || !(results.certificate->goal_error > evidence::goal_mark) || without_motion(results))
    return false;
  return missed.starts_with(fmt::format("Not solved: {} is missed by", farthest_row(results).words)) &&
         missed.find(',') == std::string::npos;
}

}  // namespace

Remarks remarks(const result::Results& results) {
  const maneuver::Failure& failure = results.failure;
  const std::string& message = results.solution.message;
  const std::string begin = failure.text();
  Remarks remarks;
  const auto add = [&](std::string words) {
    words.erase(0, words.find_first_not_of(' '));
    if (!words.empty()) remarks.paragraphs.push_back(std::move(words));
  };
  if (!failure.any() || !message.starts_with(begin)) {
    add(results.certificate ? study::beyond_numbers(results.solution, *results.certificate) : message);
    return remarks;
  }
  if (!in_headline(failure.missed, results)) add(failure.missed);
  for (const std::string& words : {failure.cause, message.substr(begin.size())}) add(words);
  remarks.remedies = failure.remedies;
  return remarks;
}

namespace {

// How many of all searches arrived, and where.
std::string arrivals_words(const maneuver::SearchRecord& search) {
  std::string kinds;
  if (search.strokes > 0) kinds += fmt::format(", {} of many strokes", search.strokes);
  if (search.hops > 0) kinds += fmt::format(", {} hops", search.hops);
  if (!kinds.empty()) kinds = fmt::format(" ({} random{})", search.starts - search.strokes, kinds);
  const std::string arrived = fmt::format("{} of {}{} arrived", search.solved, search.starts + search.hops, kinds);
  if (search.minima.empty()) return arrived;
  return fmt::format("{}, at {}{}", arrived, minima_in_words(search.minima.size()), by_solvers(search));
}

// As --solver names it.
std::string solver_words(const std::string& name) {
  constexpr std::string_view own = "lamprey ";
  return name.starts_with(own) ? name.substr(own.size()) : name;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> facts(const result::Results& results) {
  const result::ResolvedProblem& problem = results.problem;
  const maneuver::Solution& solution = results.solution;
  const bool sought = solution.status != Status::simulated, moves = !without_motion(results);
  std::vector<std::pair<std::string, std::string>> rows;
  if (sought && moves && !std::isnan(solution.cost))
    rows.emplace_back("Cost", cost_number(solution.cost) + " (N m)² s");
  if (const auto shares = cost_shares(results); sought && moves && !std::isnan(solution.cost) && !shares.empty()) {
    std::vector<std::string> words;
    for (const auto& [term, share] : shares) words.push_back(term + " " + cost_number(share));
    rows.emplace_back("Shares of the cost", fmt::format("{} (N m)² s", fmt::join(words, ", ")));
  }
  if (moves && results.certificate && results.certificate->clearance)
    rows.emplace_back("Clearance", clearance_words(*results.certificate->clearance, problem));
  if (sought && moves)
    for (const auto& row : limit_facts(results)) rows.push_back(row);
  if (const std::optional<Transport> moved = transport_as_weighed(results); sought && moves && moved) {
    const std::optional<double> by_replay = work_by_replay(results.certificate, moved->work);
    rows.emplace_back("Work of the joints", work_words(moved->work, by_replay));
    if (problem.goal) rows.emplace_back("Displacement", way_words(solution, problem));
    if (problem.goal && turns_freely(problem) && solution.rotation.size() > 1)
      rows.emplace_back("Turn of " + problem.bodies.front().name, turn_words(solution));
    if (const auto turn = asked_turn(results); !turn.empty())
      rows.emplace_back("Turn of " + problem.bodies[0].name, turn);
    if (problem.goal && goes_a_way(results) && (problem.goal->periodic || distance_asked(problem)) && !drifts(results))
      rows.emplace_back("Cost of transport", transport_words(*moved, by_replay));
  }
  if (!sought) append_march(results, rows);
  if (!problem.bodies.empty() && problem.bodies.front().ellipse)
    rows.emplace_back("Depth", "one metre of ellipses in the plane: masses, moments, energies and costs");
  rows.emplace_back("Duration", number(problem.duration) + " s");
  rows.emplace_back("Steps", fmt::format("{} of {} s", problem.steps, number(problem.time_step)));
  rows.emplace_back("Scheme", solution.marched_by.empty() ? scheme_name(problem.scheme) : solution.marched_by);
  if (solution.tracking) append_tracking(*solution.tracking, rows);
  if (sought && !solution.solver.name.empty()) rows.emplace_back("Solver", solver_words(solution.solver.name));
  if (const maneuver::SearchRecord& search = solution.search; sought && search.starts > 1)
    rows.emplace_back("First guesses", arrivals_words(search));
  if (sought && solution.solver.iterations > 0) {
    rows.emplace_back("Iterations",
                      fmt::format("{}, {} evaluations", solution.solver.iterations, solution.solver.evaluations));
  }
  if (sought && solution.solver.wall_seconds > 0.0) {
    const double all = solution.solver.total_wall_seconds;
    rows.emplace_back("Time taken",
                      fmt::format("{} s{}, {} build", number(solution.solver.wall_seconds, 3),
                                  all > 0.0 ? fmt::format(" by the search, {} s in all", number(all, 3)) : "",
                                  results.provenance.build_type));
  }
  if (!results.provenance.machine.empty()) rows.emplace_back("Machine", results.provenance.machine);
  return rows;
}

namespace {

void append_lines(const std::string& name, const std::vector<std::string>& lines,
                  std::vector<std::pair<std::string, std::string>>& rows) {
  for (std::size_t n = 0; n < lines.size(); ++n) rows.emplace_back(n == 0 ? name : "", lines[n]);
}

std::string fluid_words(double density) {
  return density > 0.0 ? fmt::format("perfect, of density {} kg/m³", number(density)) : "none: a vacuum";
}

}  // namespace

std::vector<std::pair<std::string, std::string>> problem_settings(const result::ResolvedProblem& problem) {
  std::vector<std::pair<std::string, std::string>> rows;
  if (problem.density) rows.emplace_back("Fluid", fluid_words(*problem.density));
  if (problem.goal) rows.emplace_back("Goal", goal_words(*problem.goal));
  rows.emplace_back("Duration",
                    number(problem.duration) + " s" +
                        (problem.free_duration ? fmt::format(", free between {} and {} s", number(problem.between[0]),
                                                             number(problem.between[1]))
                                               : ""));
  rows.emplace_back("Time step", fmt::format("{} s, {} steps", number(problem.time_step), problem.steps));
  rows.emplace_back("Scheme", scheme_name(problem.scheme));
  rows.emplace_back("Control", problem.control == maneuver::ControlKind::spline
                                   ? fmt::format("natural cubic spline through {} points", problem.points)
                                   : std::string("one value at each node"));
  if (problem.goal) {
    const bool trapezoid = problem.cost_rule == maneuver::CostRule::trapezoid;
    rows.emplace_back("Cost", task::cost_words(problem.effort, problem.time_weight, problem.cost_weights) +
                                  (trapezoid ? ", effort by the trapezoid rule"
                                             : ", effort by the rectangle rule, every node of weight h"));
  }
  const auto digits = [](double value) { return number(value); };
  append_lines("Limits", task::limit_lines(problem.limits, digits), rows);
  append_lines("Waypoints", task::waypoint_lines(problem.waypoints, problem.free_shape, digits), rows);
  return rows;
}

std::vector<std::pair<std::string, std::string>> provenance_rows(const result::Provenance& provenance) {
  return {{"Version", provenance.version},          {"Build type", provenance.build_type},
          {"Compiler", provenance.compiler},        {"Machine", provenance.machine},
          {"Command", provenance.command},          {"SHA-256 of the problem file", provenance.problem_sha256},
          {"Seed", std::to_string(provenance.seed)}};
}

const char* joint_kind_name(model::JointKind kind) {
  switch (kind) {
    case model::JointKind::ball:
      return "ball";
    case model::JointKind::universal:
      return "universal";
    case model::JointKind::hinge:
      return "hinge";
    case model::JointKind::fixed:
      return "fixed";
  }
  return "unknown";
}

}  // namespace lamprey::report
