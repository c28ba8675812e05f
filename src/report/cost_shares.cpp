#include "report/cost_shares.hpp"

namespace lamprey::report {

std::vector<std::pair<std::string, double>> cost_shares(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  const maneuver::CostWeights& weights = results.problem.cost_weights;
  std::vector<std::pair<std::string, double>> shares;
  if (solution.time.empty() || solution.position.empty()) return shares;
  const auto add = [&](const char* term, double weight, double part) {
    if (weight != 0.0) shares.emplace_back(term, weight * part);
  };
  const double time = solution.time.back();
  const double won = weights.displacement.dot(solution.position.back() - solution.position.front());
  if (const auto& parts = solution.cost_parts) {
    add("effort", results.problem.effort, parts->effort);
    add("work", weights.work, parts->work);
    add("power", weights.power, parts->power);
    add("smoothness", weights.smoothness, parts->smoothness);
    add("angular velocity", weights.angular_velocity, parts->angular_velocity);
    add("transport", weights.transport, parts->transport);
  } else {
    shares.emplace_back("effort", solution.cost - results.problem.time_weight * time + won);
  }
  add("time", results.problem.time_weight, time);
  if (weights.of_displacement()) shares.emplace_back("displacement", -won);
  if (shares.size() < 2) shares.clear();
  return shares;
}

}  // namespace lamprey::report
