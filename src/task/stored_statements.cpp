#include "task/stored_statements.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "certificate/certificate.hpp"
#include "evidence/clearance.hpp"
#include "evidence/limit_check.hpp"
#include "fluid/ellipse.hpp"
#include "fluid/ellipsoid.hpp"
#include "lie/so3.hpp"
#include "maneuver/feedback.hpp"
#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "task/problem_difference.hpp"

namespace lamprey::task {

namespace {

using evidence::Clearance;
using nlohmann::json;
using result::Results;

using Claims = std::vector<certificate::FalseClaim>;

// Where the problem's own times differ from each other or from the nodes'.
void add_false_times(const Results& stored, Claims& claims) {
  const result::ResolvedProblem& problem = stored.problem;
  const std::vector<double>& time = stored.solution.time;
  const auto claim = [&](const char* field, double told, double is) {
    if (!(std::abs(told - is) <= evidence::time_mark * std::abs(is))) claims.push_back({field, told, is});
  };
  if (problem.steps == 0) return;
  if (problem.free_duration && time.size() > 1) claim("problem.duration", problem.duration, time.back());
  claim("problem.time_step", problem.time_step, problem.duration / problem.steps);
}

// [2 velocity_count] what a column of gains is by in N m: turns as they are, ways by the swimmer's unit of length, rates by the duration.
Eigen::VectorXd unit_of_columns(const evidence::StoredMotion& motion) {
  const Eigen::Index half = motion.system.velocity_count();
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(2 * half);
  unit.segment(half - 3, 3).setConstant(motion.system.length_unit());
  unit.tail(half) = unit.head(half) / (motion.time_step * motion.steps);
  return unit;
}

// Gains follow from problem and motion: where one is another than these give, by more than round-off along an unstable motion, a
// vehicle would follow somebody else's.
void add_false_gains(const Results& stored, const evidence::StoredMotion& motion, Claims& claims) {
  constexpr double other = 1e-3;   // of the column's largest gain at the node
  constexpr double beside = 1e-6;  // of the largest one of all columns, in N m by what they are by
  const std::vector<Eigen::MatrixXd>& told = stored.solution.feedback.gain;
  if (told.empty()) return;
  maneuver::Feedback feedback;
  try {
    feedback = maneuver::design_feedback(motion.system, motion.problem, stored.solution);
  } catch (const std::domain_error&) {  // there are none for such a motion
  }
  const std::vector<Eigen::MatrixXd>& found = feedback.gain;
  const Eigen::VectorXd unit = unit_of_columns(motion);
  if (found.size() != told.size()) {
    claims.push_back({"feedback.gain", static_cast<double>(told.size()), static_cast<double>(found.size())});
    return;
  }
  for (std::size_t m = 0; m < told.size(); ++m) {
    const double at = stored.solution.feedback.time[m];
    if (!(std::abs(at - feedback.time[m]) <= evidence::time_mark * stored.solution.time.back())) {
      claims.push_back({fmt::format("feedback.time[{}]", m), at, feedback.time[m]});
      return;
    }
    Eigen::Index row = 0, column = 0;
    const Eigen::MatrixXd is = found[m] * unit.asDiagonal(), off = (told[m] - found[m]) * unit.asDiagonal();
    const Eigen::RowVectorXd allowed =
        (other * is.cwiseAbs().colwise().maxCoeff()).cwiseMax(beside * is.cwiseAbs().maxCoeff());
    if ((off.cwiseAbs().rowwise() - allowed).maxCoeff(&row, &column) <= 0.0) continue;
    claims.push_back(
        {fmt::format("feedback.gain[{}][{}][{}]", m, row, column), told[m](row, column), found[m](row, column)});
    return;
  }
}

// Where joints have turned otherwise than the bodies did from node to node, by whole turns that no rotation shows.
void add_false_turns(const Results& stored, const evidence::StoredMotion& motion, Claims& claims) {
  constexpr double same = 1e-3;  // rad: what is less than a turn is looked at with the velocities
  const auto& told = stored.solution.joint_angle;
  const auto joints = static_cast<std::size_t>(motion.system.joint_count());
  for (std::size_t j = 0; j < joints; ++j) {
    const model::Joint& joint = motion.system.joint(static_cast<int>(j));
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < told.size() && k < stored.solution.rotation.size(); ++k) {
      if (told[k].size() != joints) return;
      turn = mechanics::turn_from_zero(joint, mechanics::child_to_parent(stored.solution.rotation[k], joint), turn);
      Eigen::Index axis = 0;
      if ((told[k][j] - turn).cwiseAbs().maxCoeff(&axis) <= same) continue;
      claims.push_back({fmt::format("joint_angle[{}][{}][{}]", k, j, axis), told[k][j][axis], turn[axis]});
      return;
    }
  }
}

// A problem restates what follows from it, such as the axes of a hinge's moment. Times are looked at by themselves.
void add_false_restatements(const Results& stored, const model::System& system, const maneuver::Problem& problem,
                            Claims& claims) {
  constexpr double same = 1e-9;  // of a number, or of 1
  if (!stored.problem.start || stored.problem.steps == 0)
    return;  // of an early version, which tells less; or of one node
  const json told = json::parse(result::problem_text(stored.problem)).flatten();
  const json is = json::parse(result::problem_text(result::resolve(system, problem))).flatten();
  for (const auto& [pointer, value] : told.items()) {
    if (!value.is_number() || pointer == "/duration" || pointer == "/time_step") continue;
    const double number = value;
    const double settled =
        is.contains(pointer) && is[pointer].is_number() ? is[pointer].get<double>() : evidence::unset;
    if (std::abs(number - settled) <= same * std::max(1.0, std::abs(settled))) continue;
    claims.push_back({"problem." + path_in_words(pointer), number, settled});
    return;
  }
}

fluid::EllipsoidInertia in_unit_density(const result::ResolvedBody& body) {
  return body.ellipse ? fluid::ellipse_inertia(body.semi_axes.head<2>(), 1.0)
                      : fluid::ellipsoid_inertia(body.semi_axes, 1.0);
}

// Whether what a body's matrices add to the body alone is what its semi-axes add in fluid of a density.
bool follows_from(double density, const result::ResolvedBody& body) {
  constexpr double same = 1e-9;  // of the matrix
  const fluid::EllipsoidInertia added = in_unit_density(body);
  const auto is = [](const Eigen::Matrix3d& told, const Eigen::Matrix3d& found) {
    return (told - found).norm() <= same * told.norm();
  };
  return body.coupling_matrix.isZero(0.0) &&
         is(body.mass_matrix,
            body.mass * Eigen::Matrix3d::Identity() + Eigen::Matrix3d((density * added.added_mass).asDiagonal())) &&
         is(body.inertia_matrix, body.body_inertia + Eigen::Matrix3d((density * added.added_inertia).asDiagonal()));
}

// Files do not tell which matrices were given. But where those of all bodies are what their semi-axes make of them in fluid of one
// density, to the last digits, nobody gave them, and that is the fluid's.
void add_false_density(const result::ResolvedProblem& problem, Claims& claims) {
  if (!(problem.density.value_or(0.0) > 0.0) || problem.bodies.empty()) return;
  const auto fits = [&](double density) {
    return std::all_of(problem.bodies.begin(), problem.bodies.end(),
                       [&](const result::ResolvedBody& body) { return follows_from(density, body); });
  };
  if (fits(*problem.density)) return;
  const result::ResolvedBody& body = problem.bodies.front();
  Eigen::Index axis = 0;
  const double added = in_unit_density(body).added_mass.maxCoeff(&axis);
  const double density = (body.mass_matrix(axis, axis) - body.mass) / added;
  if (density > 0.0 && fits(density))
    claims.push_back({"problem.density", *problem.density, density, "while the matrices of all bodies are of another"});
}

// Multipliers tell what a limit is worth: where it asks for nothing that is nothing.
void add_idle_pulls(const evidence::StoredMotion& motion, Claims& claims) {
  if (const std::optional<evidence::IdlePull> idle = evidence::idle_pull(motion))
    claims.push_back(
        {fmt::format("limit_multipliers[{}].multiplier[{}]", idle->record, idle->node), idle->multiplier, 0.0});
}

// Of limits that are broken alike a file may name any.
void add_false_limit(const Results& stored, const Results& found, const evidence::StoredMotion& motion,
                     Claims& claims) {
  constexpr double same = 1e-9;  // of their units
  if (!stored.certificate || !stored.certificate->limits || !found.certificate->limits) return;
  const evidence::LimitsKept &told = *stored.certificate->limits, &is = *found.certificate->limits;
  if (told.key.empty() || std::isnan(told.violation) || (told.key == is.key && told.time == is.time)) return;
  if (evidence::violation_at(motion, told.key, told.time) >= told.violation - same) return;
  if (told.key != is.key)
    claims.push_back({"limits.key", told.violation, evidence::unset});
  else
    claims.push_back({"limits.time", told.time, is.time});
}

// Of equal gaps a file may name any.
void add_false_place(const Results& stored, const Results& found, const evidence::StoredMotion& motion,
                     Claims& claims) {
  constexpr double same = 1e-6;  // of the swimmer's unit of length, or of the gap
  if (!stored.certificate || !stored.certificate->clearance || !found.certificate->clearance) return;
  const Clearance &told = *stored.certificate->clearance, &is = *found.certificate->clearance;
  if (std::isnan(told.gap) || (told.time == is.time && told.first == is.first && told.second == is.second)) return;
  double gap = evidence::unset;
  if (told.first >= 0 && told.second >= 0 && told.first != told.second) gap = evidence::gap_at(motion, told);
  if (std::abs(gap - told.gap) <= same * std::max(motion.system.length_unit(), std::abs(told.gap))) return;
  if (told.first != is.first)
    claims.push_back({"clearance.bodies[0]", static_cast<double>(told.first), static_cast<double>(is.first)});
  else if (told.second != is.second)
    claims.push_back({"clearance.bodies[1]", static_cast<double>(told.second), static_cast<double>(is.second)});
  else
    claims.push_back({"clearance.time", told.time, is.time});
}

// What no file shows again must not contradict the rest: minima by rising cost, none for nothing unless displacement wins, what was
// set aside cheaper than the answer, other grids of half, twice and four times the steps.
void add_contradictions(const Results& stored, Claims& claims) {
  const maneuver::SearchRecord& search = stored.solution.search;
  double least = stored.problem.cost_weights.of_displacement() ? -std::numeric_limits<double>::infinity() : 0.0;
  for (std::size_t n = 0; n < search.minima.size(); ++n) {
    const double cost = search.minima[n].cost;
    const bool for_nothing = n == 0 && cost == 0.0 && least == 0.0 && stored.solution.cost > 0.0;
    if (cost < least || for_nothing)
      claims.push_back({fmt::format("search.minima[{}].cost", n), cost, n == 0 ? stored.solution.cost : least,
                        n == 0 ? "though the answer costs something" : "less than the one before it"});
    if (cost > least) least = cost;
  }
  if (search.set_aside && !(search.set_aside->cost < stored.solution.cost))
    claims.push_back(
        {"search.set_aside.cost", search.set_aside->cost, stored.solution.cost, "no less than the answer"});
  const bool of_moments_alone = !stored.problem.cost_weights.any() || !integrator::single_step(stored.problem.scheme) ||
                                stored.solution.status == maneuver::Status::simulated;
  if (stored.solution.cost_parts && of_moments_alone)
    claims.push_back({"cost_parts", stored.solution.cost_parts->effort, evidence::unset});
  if (!stored.certificate || !stored.certificate->refinement) return;
  const auto& grids = stored.certificate->refinement->grids;
  const int steps = stored.problem.steps;
  for (std::size_t g = 0; g < grids.size(); ++g)
    if (grids[g].steps != steps / 2 && grids[g].steps != steps && grids[g].steps != 2 * steps &&
        grids[g].steps != 4 * steps)
      claims.push_back({fmt::format("refinement.grids[{}].steps", g), static_cast<double>(grids[g].steps),
                        static_cast<double>(steps), "neither half, twice nor four times the answer's"});
}

}  // namespace

std::vector<certificate::FalseClaim> false_statements(const Results& stored, const Results& found, bool with_gains) {
  const maneuver::Problem problem = result::problem_of(stored);
  const model::System system(problem.swimmer);
  Claims claims;
  add_false_restatements(stored, system, problem, claims);
  add_false_density(stored.problem, claims);
  add_false_times(stored, claims);
  add_contradictions(stored, claims);
  if (stored.solution.time.size() < 2) return claims;
  const evidence::StoredMotion motion(system, problem, stored.solution);
  add_false_turns(stored, motion, claims);
  add_false_place(stored, found, motion, claims);
  add_idle_pulls(motion, claims);
  add_false_limit(stored, found, motion, claims);
  if (with_gains) add_false_gains(stored, motion, claims);
  return claims;
}

}  // namespace lamprey::task
