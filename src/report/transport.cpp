#include "report/transport.hpp"

#include <algorithm>

#include "report/joint_demands.hpp"

namespace lamprey::report {

namespace {

constexpr double same_place = 1e-9;  // of the swimmer's size: a displacement that is none
constexpr double some_way = 0.1;     // likewise: one that nobody has to ask for

// m, the largest semi-axis, as model::System::size.
double size_of(const result::ResolvedProblem& problem) {
  double size = 0.0;
  for (const result::ResolvedBody& body : problem.bodies)
    size = std::max(size, body.semi_axes.head(body.ellipse ? 2 : 3).maxCoeff());
  return size;
}

}  // namespace

bool distance_asked(const result::ResolvedProblem& problem) {
  const auto moves = [](const std::optional<double>& move) { return move && *move != 0.0; };
  return (problem.goal && std::any_of(problem.goal->move.begin(), problem.goal->move.end(), moves)) ||
         problem.cost_weights.transport > 0.0 || !problem.cost_weights.displacement.isZero(0.0);
}

bool goes_a_way(const result::Results& results) {
  const maneuver::Vectors& position = results.solution.position;
  if (position.empty()) return false;
  const double way = (position.back() - position.front()).norm(), size = size_of(results.problem);
  return way > (distance_asked(results.problem) ? same_place : some_way) * size;
}

std::optional<Transport> transport(const result::Results& results) {
  const std::optional<std::vector<JointDemand>> demands = joint_demands(results);
  if (!demands) return std::nullopt;
  const maneuver::Vectors& position = results.solution.position;
  Transport sum{0.0, (position.back() - position.front()).norm()};
  for (const JointDemand& demand : *demands) sum.work += demand.work;
  return sum;
}

}  // namespace lamprey::report
