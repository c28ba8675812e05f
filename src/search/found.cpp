#include "search/found.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "guess/guess.hpp"
#include "lie/so3.hpp"
#include "maneuver/goal_miss.hpp"
#include "maneuver/motion.hpp"

namespace lamprey::search {

namespace {

using maneuver::LimitMultiplier;
using maneuver::LimitRow;
using maneuver::Maneuver;
using maneuver::Solution;
using maneuver::Status;
using optimizer::Outcome;
using optimizer::Termination;

constexpr double goal_met = 1e-8;  // sum of what is missed
constexpr double nothing = 1e-15;  // of the largest multiplier

// What a row's multipliers are worth in the units of its limit, node by node, since rows may bend; densities belong to the time
// of the first guess.
Eigen::VectorXd prices(const model::System& system, const Maneuver& maneuver, const LimitRow& row,
                       const std::vector<mechanics::Rotations>& rotation, double time_step) {
  const bool density = row.time < 0.0 && !row.of_duration();
  const auto nodes = static_cast<Eigen::Index>(rotation.size());
  const Eigen::Vector3d nowhere = Eigen::Vector3d::Zero();
  const Eigen::VectorXd unmoved;
  Eigen::VectorXd price(nodes);
  for (Eigen::Index k = 0; k < nodes; ++k) {
    const auto node = static_cast<std::size_t>(k);
    const maneuver::LimitedNode at{rotation[node], rotation[k > 0 ? node - 1 : 0], nowhere, unmoved, time_step, 0.0};
    const double value = row.bends() ? maneuver::limit_value(system, row, at, 0.0) : 0.0;
    price[k] = maneuver::price_of_bound(row, time_step, value) * (density ? maneuver.time_step() / time_step : 1.0);
  }
  return price;
}

std::vector<LimitMultiplier> multipliers_of_limits(const model::System& system, const Maneuver& maneuver,
                                                   const std::vector<LimitRow>& limits, const Found& found,
                                                   const std::vector<mechanics::Rotations>& rotation,
                                                   double time_step) {
  std::vector<LimitMultiplier> result;
  if (found.limit_multipliers.value.size() == 0) return result;
  const double least = nothing * found.limit_multipliers.value.lpNorm<Eigen::Infinity>();
  for (std::size_t r = 0; r < limits.size(); ++r) {
    const auto values = found.limit_multipliers.value.row(static_cast<Eigen::Index>(r));
    if (values.lpNorm<Eigen::Infinity>() <= least) continue;
    const LimitRow& row = limits[r];
    LimitMultiplier own{row.key, row.joint, row.body, row.other_body, row.component, row.upper(), {}};
    const Eigen::VectorXd price = prices(system, maneuver, row, rotation, time_step);
    for (Eigen::Index k = 0; k < values.size(); ++k) own.multiplier.push_back(values[k] * price[k]);
    result.push_back(own);
  }
  return result;
}

// Whether a multiplier was read for a row; of several waypoints each has its own node.
bool belongs(const Maneuver& maneuver, const LimitRow& row, const LimitMultiplier& own) {
  if (own.key != row.key || own.joint != row.joint || own.body != row.body || own.other_body != row.other_body ||
      own.component != row.component || own.upper != row.upper() ||
      own.multiplier.size() != static_cast<std::size_t>(maneuver.steps) + 1)
    return false;
  if (row.time < 0.0) return true;
  return own.multiplier[static_cast<std::size_t>(std::lround(row.time / maneuver.duration * maneuver.steps))] != 0.0;
}

// Rows of as many entries as the matrix has columns.
void read_rows(const std::vector<std::vector<double>>& stored, Eigen::MatrixXd& values) {
  for (std::size_t j = 0; j < stored.size() && static_cast<Eigen::Index>(j) < values.rows(); ++j)
    if (static_cast<Eigen::Index>(stored[j].size()) == values.cols())
      values.row(static_cast<Eigen::Index>(j)) = Eigen::Map<const Eigen::RowVectorXd>(stored[j].data(), values.cols());
}

}  // namespace

Found staying(const System& system, const maneuver::Problem& problem, const Maneuver& maneuver,
              const std::string& reason) {
  Found still;
  still.outcome.termination = optimizer::Termination::converged;
  still.outcome.reason = reason;
  still.outcome.infeasibility = 0.0;
  still.path = guess::at_rest(system, maneuver, problem.scheme);
  if (problem.cost_weights.any())
    still.cost_parts = maneuver::CostParts{.time = maneuver.duration, .transport = std::nan("")};
  still.cost = maneuver.time_weight * maneuver.duration;
  still.duration = maneuver.duration;
  if (maneuver.free_duration) hold_in_least_time(system, problem, maneuver, still);
  return still;
}

void hold_in_least_time(const model::System& system, const maneuver::Problem& problem, const Maneuver& maneuver,
                        Found& found) {
  found.duration = problem.duration.min;
  found.cost = maneuver.time_weight * found.duration;
  if (found.cost_parts) found.cost_parts->time = found.duration;
  const std::vector<LimitRow> rows = maneuver::limit_rows(system, problem);
  Eigen::MatrixXd& multiplier = found.limit_multipliers.value;
  multiplier.setZero(static_cast<Eigen::Index>(rows.size()), maneuver.steps + 1);
  for (std::size_t r = 0; r < rows.size(); ++r)  // of the duration over its bound
    if (rows[r].kind == LimitRow::Kind::not_shorter)
      multiplier(static_cast<Eigen::Index>(r), maneuver.steps) = found.cost;
}

bool reaches_goal(const model::System& system, const maneuver::Problem& problem, const maneuver::NodePath& motion) {
  constexpr double beside = 1e-6;  // rad, units of length, that is none of an optimiser's
  maneuver::Solution end;
  end.rotation = motion.rotation;
  end.position = motion.position;
  const auto miss = maneuver::goal_miss(system, problem, end);
  return !miss || (miss->rotation <= beside && miss->position <= beside * system.length_unit());
}

bool any_converged(const std::vector<Found>& all) {
  return std::any_of(all.begin(), all.end(), [](const Found& found) { return found.converged(); });
}

void count_effort(const optimizer::Outcome& other, optimizer::Outcome& outcome) {
  outcome.iterations += other.iterations;
  outcome.evaluations += other.evaluations;
}

void append(std::vector<Found> more, std::vector<Found>& all) {
  std::move(more.begin(), more.end(), std::back_inserter(all));
}

StepTurn largest_turn(const std::vector<mechanics::Rotations>& rotation) {
  StepTurn largest;
  for (std::size_t k = 0; k + 1 < rotation.size(); ++k)
    for (std::size_t i = 0; i < rotation[k].size(); ++i) {
      const double angle = lie::rotation_angle(rotation[k][i].transpose() * rotation[k + 1][i]);
      if (angle > largest.angle) largest = {angle, i, k};
    }
  return largest;
}

Status status_of(const Outcome& outcome) {
  switch (outcome.termination) {
    case Termination::converged:
      return Status::optimal;
    case Termination::feasible:
      return Status::feasible;
    case Termination::infeasible:
      return Status::infeasible;
    case Termination::time_limit:
      return Status::time_limit;
    case Termination::interrupted:
      return Status::interrupted;
    case Termination::stalled:
      break;
  }
  return outcome.infeasibility < goal_met ? Status::feasible : Status::stalled;
}

Solution describe(const model::System& system, const Maneuver& maneuver, maneuver::Scheme scheme,
                  const std::vector<LimitRow>& limits, const Found& found) {
  Solution solution;
  const double duration = found.duration > 0.0 ? found.duration : maneuver.duration;
  const double time_step = duration / maneuver.steps;
  if (found.path.polynomial.empty()) {
    describe_motion(system, maneuver.lagrangian, time_step, found.path, solution);
    solution.cost = maneuver::cost_of(duration / maneuver.duration * maneuver.node_weight, solution.control) +
                    maneuver.time_weight * duration -
                    maneuver.cost_weights.displacement.dot(solution.position.back() - solution.position.front());
  } else {
    describe_composed_motion(system, scheme, time_step, found.path, solution);
    solution.cost = maneuver::cost_of_polynomials(maneuver.effort, time_step, found.path.polynomial) +
                    maneuver.time_weight * duration;
  }
  solution.limit_multipliers = multipliers_of_limits(system, maneuver, limits, found, solution.rotation, time_step);
  if (found.cost_parts) {
    solution.cost = found.cost;
    solution.cost_parts = found.cost_parts;
  }
  const shape::WorkMultipliers& work = found.work_multipliers;
  for (Eigen::Index d = 0; d < work.mean.rows() && work.weight > 0.0; ++d) {
    solution.work_multipliers.emplace_back(work.mean.row(d).begin(), work.mean.row(d).end());
    solution.work_change_multipliers.emplace_back(work.change.row(d).begin(), work.change.row(d).end());
  }
  solution.solver.held_joint_rate = found.joint_rate;
  solution.solver.limit_weight = {found.limit_multipliers.weight, found.limit_multipliers.largest_weight};
  if (work.largest_weight > 0.0) solution.solver.work_weight = {work.weight, work.largest_weight};
  solution.status = status_of(found.outcome);
  solution.message = found.outcome.reason;
  return solution;
}

Found found_in(const model::System& system, const Maneuver& maneuver, const std::vector<LimitRow>& limits,
               const Solution& solution) {
  Found found;
  found.path.rotation = solution.rotation;
  found.path.position = solution.position;
  for (std::size_t k = 0; k + 1 < solution.rotation.size(); ++k)
    maneuver::cayley_between(solution.rotation[k], solution.rotation[k + 1], found.path.cayley.emplace_back());
  found.outcome.termination = solution.status == Status::optimal ? Termination::converged : Termination::stalled;
  found.outcome.reason = solution.message;
  found.cost = solution.cost;
  found.duration = maneuver.free_duration && !solution.time.empty() ? solution.time.back() : maneuver.duration;
  const auto nodes = static_cast<Eigen::Index>(solution.rotation.size());
  found.limit_multipliers.value.setZero(static_cast<Eigen::Index>(limits.size()), nodes);
  for (std::size_t r = 0; r < limits.size(); ++r)
    for (const LimitMultiplier& own : solution.limit_multipliers) {
      if (!belongs(maneuver, limits[r], own)) continue;
      const Eigen::VectorXd price =
          prices(system, maneuver, limits[r], solution.rotation, found.duration / maneuver.steps);
      for (Eigen::Index k = 0; k < nodes; ++k) {
        const double multiplier = own.multiplier[static_cast<std::size_t>(k)];
        if (multiplier != 0.0 && price[k] > 0.0)
          found.limit_multipliers.value(static_cast<Eigen::Index>(r), k) = multiplier / price[k];
      }
      break;
    }
  found.limit_multipliers.weight = solution.solver.limit_weight.value;
  found.limit_multipliers.largest_weight = solution.solver.limit_weight.largest;
  if (solution.work_multipliers.size() != static_cast<std::size_t>(system.drive_count())) return found;
  found.work_multipliers.weight = solution.solver.work_weight.value;
  found.work_multipliers.largest_weight = solution.solver.work_weight.largest;
  found.work_multipliers.set_zero(system.drive_count(), nodes);
  read_rows(solution.work_multipliers, found.work_multipliers.mean);
  read_rows(solution.work_change_multipliers, found.work_multipliers.change);
  return found;
}

}  // namespace lamprey::search
