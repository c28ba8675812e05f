#include "report/limit_facts.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "certificate/limit_words.hpp"
#include "evidence/clearance.hpp"
#include "model/system.hpp"
#include "report/wording.hpp"
#include "result/resolve.hpp"
#include "task/march_remarks.hpp"

namespace lamprey::report {

namespace {

using evidence::LimitReach;
using Kind = evidence::Bound::Kind;

constexpr std::size_t most_named = 6;                // limits that are reached, one by one
constexpr std::size_t most_bodies_placed = 100'000;  // at all nodes, between which a summary looks for overlaps

bool has_motion(const maneuver::Solution& solution) {
  const std::size_t nodes = solution.time.size();
  return nodes > 1 && solution.rotation.size() == nodes && solution.position.size() == nodes &&
         solution.angular_velocity.size() == nodes;
}

bool broken(const LimitReach& reach) { return !(reach.violation <= evidence::limit_mark); }

bool of_length(const LimitReach& reach) {
  return reach.kind == Kind::sphere || reach.kind == Kind::half_space || reach.kind == Kind::clearance;
}

// m; round-off is none.
std::string length(double metres) { return number(std::abs(metres) <= evidence::limit_mark ? 0.0 : metres, 3) + " m"; }

std::string percent(double share) {
  return fmt::format("{} % of the time", share > 0.1 ? fmt::format("{:.0f}", 100.0 * share) : number(100.0 * share, 2));
}

std::string time_words(const LimitReach& reach) { return number(reach.time, 4) + " s"; }

// "the sphere", or, of several, "sphere[1]" as messages name them.
std::string obstacle(const std::vector<LimitReach>& reaches, const LimitReach& reach) {
  const bool sphere = reach.kind == Kind::sphere;
  const auto alike =
      std::count_if(reaches.begin(), reaches.end(), [&](const LimitReach& other) { return other.kind == reach.kind; });
  if (alike == 1) return sphere ? "the sphere" : "the half-space";
  return fmt::format("{}[{}]", sphere ? "sphere" : "half_space", reach.which);
}

std::string length_words(const std::vector<LimitReach>& reaches, const LimitReach& reach) {
  const std::string there = reach.reached() ? fmt::format(", there over {}", percent(reach.share)) : "";
  if (reach.kind == Kind::clearance) {
    const double gap = reach.bound + reach.margin;
    return fmt::format("bodies {} at {} ({} asked for){}",
                       gap < 0.0 ? "overlap by " + length(-gap) : length(gap) + " apart", time_words(reach),
                       length(reach.bound), there);
  }
  const std::string name = obstacle(reaches, reach);
  if (std::abs(reach.margin) <= evidence::limit_mark)
    return fmt::format("touches {} at {}{}", name, time_words(reach), there);
  return fmt::format("{} {} {} at {}{}", length(std::abs(reach.margin)), broken(reach) ? "within" : "from", name,
                     time_words(reach), there);
}

// Of a limit that is not reached: how much of it is used.
std::string used_words(const LimitReach& reach) {
  const auto of_bound = [&](const char* what, const char* unit) {
    return fmt::format("{} up to {} of {} {}", what, number(reach.bound - reach.margin, 3), number(reach.bound, 3),
                       unit);
  };
  switch (reach.kind) {
    case Kind::torque:
      return of_bound("moments", "N m");
    case Kind::torque_component:
      return of_bound("components of moments", "N m");
    case Kind::swing:
      return of_bound("swing", "rad");
    case Kind::twist:
      return of_bound("twist", "rad");
    case Kind::angular_velocity:
      return of_bound("joints’ rates", "rad/s");
    case Kind::angle_rate:
      return of_bound("rates of angles", "rad/s");
    case Kind::angle:
      return fmt::format("angles {} rad or more from their bounds", number(reach.margin, 3));
    case Kind::duration:
      return fmt::format("duration {} s from {}", number(reach.margin, 3), reach.key);
    default:
      return "";
  }
}

std::string reached_words(const std::vector<LimitReach>& reached) {
  std::vector<std::string> names;
  for (const LimitReach& reach : reached) {
    if (names.size() == most_named) break;
    names.push_back(reach.kind == Kind::duration ? reach.key
                                                 : fmt::format("{} over {}", reach.key, percent(reach.share)));
  }
  if (reached.size() > most_named) names.push_back(fmt::format("{} more", reached.size() - most_named));
  return fmt::format("{} {}", std::any_of(reached.begin(), reached.end(), broken) ? "at or beyond" : "at",
                     fmt::join(names, ", "));
}

}  // namespace

std::optional<evidence::LimitCheck> limits_seen(const result::Results& results) {
  const result::ResolvedProblem& asked = results.problem;
  const bool limits = asked.limits.any() || asked.free_duration || !asked.waypoints.empty();
  if (!limits || !has_motion(results.solution)) return std::nullopt;
  const maneuver::Problem problem = result::problem_of(results);
  const model::System system(problem.swimmer);
  return evidence::check_limits(evidence::StoredMotion(system, problem, results.solution));
}

std::optional<LimitReach> worst_broken(const std::vector<LimitReach>& reaches) {
  std::optional<LimitReach> worst;
  for (const LimitReach& reach : reaches)
    if (broken(reach) && (!worst || reach.violation > worst->violation)) worst = reach;
  return worst;
}

std::string reaches_in_words(const std::vector<LimitReach>& reaches) {
  std::vector<LimitReach> reached;
  std::vector<std::string> parts;
  for (const LimitReach& reach : reaches)
    if (reach.reached() && !of_length(reach)) reached.push_back(reach);
  if (!reached.empty()) parts.push_back(reached_words(reached));
  for (const LimitReach& reach : reaches)
    if (of_length(reach)) parts.push_back(length_words(reaches, reach));
  std::set<Kind> told;
  for (const LimitReach& reach : reaches) {
    if (of_length(reach) || reach.reached() || !told.insert(reach.kind).second) continue;
    LimitReach tightest = reach;
    for (const LimitReach& other : reaches)
      if (other.kind == reach.kind && !other.reached() && other.violation > tightest.violation) tightest = other;
    const bool others =
        reach.kind != Kind::duration &&
        std::any_of(reached.begin(), reached.end(), [&](const LimitReach& other) { return other.kind == reach.kind; });
    parts.push_back((others ? "other " : "") + used_words(tightest));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

std::vector<std::pair<std::string, std::string>> limit_facts(const result::Results& results) {
  std::vector<std::pair<std::string, std::string>> rows;
  const std::optional<evidence::LimitCheck> check = limits_seen(results);
  if (!check) return rows;
  if (const std::string near = reaches_in_words(check->reaches); !near.empty()) {
    const std::optional<LimitReach> worst = worst_broken(check->reaches);
    const bool marched = results.solution.status == maneuver::Status::simulated;
    rows.emplace_back("Limits", !worst ? "kept; " + near
                                       : certificate::violation_in_words(worst->key, worst->violation, worst->time) +
                                             (marched ? ": a march does not keep limits; " : "; ") + near);
  }
  if (!results.problem.waypoints.empty())
    rows.emplace_back(
        "Waypoints", fmt::format("{} {} rad or m", check->missed > evidence::limit_mark ? "missed by" : "passed within",
                                 number(check->missed, 2)));
  return rows;
}

std::optional<evidence::Clearance> march_clearance(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  if (!has_motion(solution) || solution.time.size() * results.problem.bodies.size() > most_bodies_placed)
    return std::nullopt;
  const maneuver::Problem problem = result::problem_of(results);
  const model::System system(problem.swimmer);
  return evidence::clearance(evidence::StoredMotion(system, problem, solution));
}

std::vector<std::string> march_faults(const result::Results& results) {
  std::vector<std::string> faults;
  if (const auto gap = march_clearance(results); gap && gap->gap < 0.0)
    faults.emplace_back("bodies pass through each other");
  if (const auto check = limits_seen(results))
    if (const auto worst = worst_broken(check->reaches)) {
      const auto others = std::count_if(check->reaches.begin(), check->reaches.end(), broken) - 1;
      faults.push_back(others == 0 ? worst->key + " is broken"
                                   : fmt::format("{} limits are broken, {} most", others + 1, worst->key));
    }
  if (results.solution.tracking && results.solution.tracking->lost()) faults.emplace_back("feedback has lost the plan");
  const model::System system(result::problem_of(results).swimmer);
  if (const auto energy = task::energy_out_of_balance(system, results))
    faults.push_back(
        fmt::format("on steps too coarse to resolve it ({} J that no moment has worked)", number(energy->unworked, 2)));
  return faults;
}

}  // namespace lamprey::report
