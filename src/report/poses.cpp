#include "report/poses.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace lamprey::report {
namespace {

void ensure_size(const char* name, std::size_t found, std::size_t wanted) {
  if (found != wanted) {
    throw std::invalid_argument("report: " + std::string(name) + " has " + std::to_string(found) + " entries, " +
                                std::to_string(wanted) + " are needed");
  }
}

template <class Rows>
void ensure_rows(const char* name, const Rows& rows, std::size_t count, std::size_t width) {
  ensure_size(name, rows.size(), count);
  for (const auto& row : rows) ensure_size(name, row.size(), width);
}

}  // namespace

std::vector<int> joint_order(const result::ResolvedProblem& problem) {
  std::vector<int> order;
  std::vector<bool> placed(problem.bodies.size(), false);
  std::vector<std::vector<int>> joints_below(problem.bodies.size());
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    joints_below.at(static_cast<std::size_t>(problem.joints[j].parent)).push_back(static_cast<int>(j));
  }
  std::vector<int> waiting = {0};
  if (!placed.empty()) placed[0] = true;
  for (std::size_t next = 0; next < waiting.size(); ++next) {
    for (const int j : joints_below.at(static_cast<std::size_t>(waiting[next]))) {
      const int child = problem.joints[static_cast<std::size_t>(j)].child;
      if (placed.at(static_cast<std::size_t>(child))) throw std::invalid_argument("report: a body hangs on two joints");
      placed[static_cast<std::size_t>(child)] = true;
      order.push_back(j);
      waiting.push_back(child);
    }
  }
  ensure_size("the tree of joints", order.size() + 1, problem.bodies.size());
  return order;
}

std::vector<Eigen::Vector3d> body_centres(const result::ResolvedProblem& problem, const std::vector<int>& order,
                                          const Eigen::Vector3d& root, const std::vector<Eigen::Matrix3d>& rotation) {
  std::vector<Eigen::Vector3d> centres(problem.bodies.size(), root);
  for (const int j : order) {
    const result::ResolvedJoint& joint = problem.joints[static_cast<std::size_t>(j)];
    const auto parent = static_cast<std::size_t>(joint.parent), child = static_cast<std::size_t>(joint.child);
    centres[child] = centres[parent] + rotation[parent] * joint.parent_offset - rotation[child] * joint.child_offset;
  }
  return centres;
}

bool planar(const result::Results& results) {
  constexpr double round_off = 1e-9;  // of turns and of the largest semi-axis
  const maneuver::Solution& solution = results.solution;
  if (solution.rotation.size() != solution.position.size()) return false;
  double size = 0.0;
  for (const result::ResolvedBody& body : results.problem.bodies) size = std::max(size, body.semi_axes.maxCoeff());
  for (std::size_t k = 1; k < solution.position.size(); ++k) {
    if (std::abs(solution.position[k].z() - solution.position[0].z()) > round_off * size) return false;
    for (std::size_t i = 0; i < solution.rotation[k].size(); ++i) {
      const Eigen::Matrix3d turn = solution.rotation[k][i] * solution.rotation[0][i].transpose();
      if ((turn.col(2) - Eigen::Vector3d::UnitZ()).norm() > round_off) return false;
    }
  }
  return true;
}

void ensure_shapes(const result::Results& results) {
  const maneuver::Solution& s = results.solution;
  const std::size_t count = s.time.size(), bodies = results.problem.bodies.size(),
                    joints = results.problem.joints.size();
  if (count == 0 || bodies == 0) throw std::invalid_argument("report: there is no motion to show");
  ensure_size("position", s.position.size(), count);
  ensure_rows("rotation", s.rotation, count, bodies);
  ensure_rows("control", s.control, count, joints);
  if (!s.joint_angle.empty()) ensure_rows("joint_angle", s.joint_angle, count, joints);
  ensure_size("velocity.linear", s.linear_velocity.size(), count);
  ensure_rows("velocity.angular", s.angular_velocity, count, bodies);
  for (const maneuver::MomentumHistory* momentum : {&s.linear_momentum, &s.angular_momentum}) {
    ensure_size("momentum.bodies", momentum->bodies.size(), count);
    ensure_size("momentum.fluid", momentum->fluid.size(), count);
    ensure_size("momentum.total", momentum->total.size(), count);
  }
}

}  // namespace lamprey::report
