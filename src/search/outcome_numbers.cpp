#include "search/outcome_numbers.hpp"

namespace lamprey::search {

using optimizer::Iteration;
using optimizer::Outcome;

std::vector<double> numbers_of(const Outcome& outcome) {
  std::vector<double> numbers = {static_cast<double>(outcome.termination),
                                 outcome.objective,
                                 outcome.infeasibility,
                                 static_cast<double>(outcome.iterations),
                                 static_cast<double>(outcome.evaluations),
                                 static_cast<double>(outcome.history.size())};
  for (const Iteration& step : outcome.history)
    numbers.insert(numbers.end(), {static_cast<double>(step.iteration), step.objective, step.infeasibility,
                                   step.dual_infeasibility, step.goal_error, step.step, step.drift});
  numbers.push_back(static_cast<double>(outcome.reason.size()));
  numbers.insert(numbers.end(), outcome.reason.begin(), outcome.reason.end());
  numbers.push_back(static_cast<double>(outcome.point.size()));
  numbers.insert(numbers.end(), outcome.point.begin(), outcome.point.end());
  numbers.insert(numbers.end(), outcome.multipliers.begin(), outcome.multipliers.end());
  return numbers;
}

Outcome outcome_of(const std::vector<double>& numbers) {
  Outcome outcome;
  const double* next = numbers.data();
  outcome.termination = static_cast<optimizer::Termination>(static_cast<int>(*next++));
  outcome.objective = *next++;
  outcome.infeasibility = *next++;
  outcome.iterations = static_cast<int>(*next++);
  outcome.evaluations = static_cast<int>(*next++);
  const auto count = static_cast<std::size_t>(*next++);
  for (std::size_t n = 0; n < count; ++n, next += 7)
    outcome.history.push_back({static_cast<int>(next[0]), next[1], next[2], next[3], next[4], next[5], next[6]});
  outcome.reason.clear();
  const auto letters = static_cast<std::size_t>(*next++);
  for (std::size_t n = 0; n < letters; ++n) outcome.reason += static_cast<char>(*next++);
  const auto variables = static_cast<Eigen::Index>(*next++);
  outcome.point = Eigen::Map<const Eigen::VectorXd>(next, variables);
  next += variables;
  outcome.multipliers = Eigen::Map<const Eigen::VectorXd>(next, numbers.data() + numbers.size() - next);
  return outcome;
}

}  // namespace lamprey::search
