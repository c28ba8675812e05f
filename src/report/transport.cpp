#include "report/transport.hpp"

#include "report/joint_demands.hpp"

namespace lamprey::report {

std::optional<Transport> transport(const file::Results& results) {
  const std::optional<std::vector<JointDemand>> demands = joint_demands(results);
  if (!demands) return std::nullopt;
  const maneuver::Vectors& position = results.solution.position;
  Transport sum{0.0, (position.back() - position.front()).norm()};
  for (const JointDemand& demand : *demands) sum.work += demand.work;
  return sum;
}

}  // namespace lamprey::report
