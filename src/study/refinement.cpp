#include "study/refinement.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "integrator/scheme.hpp"

namespace lamprey::study {

namespace {

constexpr int least_steps = 20;       // of a grid that is halved
constexpr double round_off = 1e-12;   // of the cost: differences below are none
constexpr double near = 1e-2;         // of the cost: grids that differ by no more hold the same motion
constexpr double large_error = 0.01;  // of the cost

}  // namespace

int expected_order(const maneuver::Problem& problem) {
  const int rule = problem.cost_rule() == maneuver::CostRule::rectangle ? 1 : integrator::order(problem.scheme);
  return std::min(integrator::order(problem.scheme), rule);
}

certificate::Refinement refinement_of(const std::vector<certificate::GridCost>& grids, int steps, int expected_order) {
  certificate::Refinement result;
  result.grids = grids;
  for (const certificate::GridCost& grid : grids)
    if (grid.steps == 2LL * steps) result.cost_half_step = grid.cost;
  if (grids.size() < 3) return result;
  const double coarse = grids[0].cost - grids[1].cost, fine = grids[1].cost - grids[2].cost;
  const double noise = round_off * std::abs(grids[2].cost);
  if (std::abs(coarse) <= noise && std::abs(fine) <= noise) {  // the same on every grid: at rest
    result.cost_limit = grids[2].cost;
    result.cost_error = std::max(std::abs(coarse), std::abs(fine));
    return result;
  }
  const double order = std::log2(coarse / fine);
  // errors of odd order may cancel, as of `paper` in motions that run backwards alike: then the error bar is too wide
  const bool settled = order >= 0.5 * expected_order && order <= std::max(1.5 * expected_order, expected_order + 1.5);
  if (std::abs(fine) <= noise || !settled) return result;
  result.observed_order = order;
  result.cost_limit = grids[2].cost - fine / (std::exp2(expected_order) - 1.0);
  for (const certificate::GridCost& grid : grids)
    if (grid.steps == steps) result.cost_error = std::abs(grid.cost - result.cost_limit);
  return result;
}

certificate::Refinement refine_cost(const maneuver::Problem& problem, double cost, const CostOnGrid& cost_on_grid) {
  const int steps = problem.steps;
  const bool halved = steps % 2 == 0 && steps >= least_steps && problem.waypoints.empty();
  std::vector<certificate::GridCost> grids;
  const auto add = [&](int grid) {
    const std::optional<double> found = grid == steps ? cost : cost_on_grid(grid);
    if (found) grids.push_back({grid, *found});
    return found.has_value();
  };
  const bool begun = halved && add(steps / 2);
  add(steps);
  if (add(2 * steps) && !begun) add(4 * steps);
  return refinement_of(grids, steps, expected_order(problem));
}

std::string refinement_words(const certificate::Refinement& refinement) {
  std::ostringstream text;
  if (!std::isnan(refinement.cost_error)) {
    const double share = refinement.cost_error / std::abs(refinement.cost_limit);
    if (!(share > large_error)) return "";
    text << std::setprecision(2) << " The error of the cost, " << refinement.cost_error << ", is " << 100.0 * share
         << " % of it: more steps make it smaller.";
    return text.str();
  }
  if (refinement.grids.empty()) return "";
  text.precision(8);
  if (refinement.grids.size() < 3) {
    text << " Its cost has no error bar: from it searches on other grids, of half, of twice and of four times as many "
            "steps, do not all arrive.";
    return text.str();
  }
  const auto [least, most] = std::minmax_element(refinement.grids.begin(), refinement.grids.end(),
                                                 [](const auto& a, const auto& b) { return a.cost < b.cost; });
  const double spread = (most->cost - least->cost) / std::max(std::abs(least->cost), std::abs(most->cost));
  if (spread <= near)
    text << " Other grids have the cost to " << std::setprecision(2) << 100.0 * spread << std::setprecision(8) << " %:";
  else
    text << (refinement.grows() ? " The cost grows on finer grids:" : " The cost has not settled:");
  for (const certificate::GridCost& grid : refinement.grids)
    text << (grid.steps == refinement.grids.front().steps ? " " : ", ") << grid.cost << " with " << grid.steps
         << " steps";
  if (spread <= near)
    text << "; it changes too unevenly for an error bar.";
  else if (refinement.grows())
    text << "; the goal may be within reach of long steps alone, by their own error.";
  else
    text << "; more steps are needed, or the grids hold different motions.";
  return text.str();
}

}  // namespace lamprey::study
