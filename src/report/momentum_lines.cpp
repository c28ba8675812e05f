#include "report/momentum_lines.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "certificate/certificate.hpp"
#include "lie/so3.hpp"
#include "report/summary.hpp"
#include "report/wording.hpp"

namespace lamprey::report {

namespace {

using maneuver::MomentumHistory;
using maneuver::Vectors;

constexpr double no_momentum = 1e-9;  // of the bodies' momentum, total momentum that is none

// Mean over time of a component, by the trapezoid rule.
double mean_along_e1(const Vectors& values) {
  double sum = 0.0;
  for (std::size_t k = 1; k < values.size(); ++k) sum += 0.5 * (values[k - 1][0] + values[k][0]);
  return sum / static_cast<double>(values.size() - 1);
}

double largest(const Vectors& values) {
  double size = 0.0;
  for (const Eigen::Vector3d& v : values) size = std::max(size, v.lpNorm<Eigen::Infinity>());
  return size;
}

// m: how far mass is from where angular momentum is taken about: from mass centres, or of all from the world's origin.
double reach_of(const result::Results& results) {
  double reach = 0.0;
  for (const result::ResolvedBody& body : results.problem.bodies)
    reach =
        std::max(reach, std::sqrt(body.inertia_matrix.diagonal().maxCoeff() / body.mass_matrix.diagonal().maxCoeff()));
  for (const result::ResolvedJoint& joint : results.problem.joints)
    reach = std::max({reach, joint.parent_offset.norm(), joint.child_offset.norm()});
  return std::max(reach, largest(results.solution.position));
}

std::string with_sign(double value) { return (value > 0.0 ? "+" : "") + number(value, 3); }

// Total momentum over the bodies' own. Where these have one kind of momentum alone the other's total is compared with what that makes at
// the swimmer's reach. 0 where nothing moves.
double share_of_total(const result::Results& results) {
  const MomentumHistory &linear = results.solution.linear_momentum, &angular = results.solution.angular_momentum;
  const double reach = reach_of(results), along = std::max(largest(linear.bodies), largest(angular.bodies) / reach);
  return along > 0.0 ? std::max(largest(linear.total) / along, largest(angular.total) / (along * reach)) : 0.0;
}

std::string zero_line(double share, const std::optional<certificate::Certificate>& proof) {
  const bool drifts = proof && proof->momentum_drift > proof->momentum_allowed();
  const double allowed = std::max(no_momentum, proof ? proof->momentum_allowed() : 0.0);
  return fmt::format("{} total momentum is zero throughout: at most {} of the bodies' own",
                     share < allowed && !drifts ? "✓" : "✗", number(share, 2));
}

std::string sense_words(double mean, double asked) { return mean * asked > 0.0 ? "with" : "against"; }

// Of a mean that is none beside the largest.
std::string no_mean_line(const char* kind, const char* along) {
  return fmt::format("· mean {} momentum of the bodies {} e₁ is zero to round-off", kind, along);
}

// Bodies that end turned as they began have all moved as the root has: the mean of their momentum has the sign of the move. Of others
// no law asks it.
std::string linear_line(double mean, double of_fluid, double asked, bool by_law) {
  const char* mark = mean * asked > 0.0 ? "✓" : by_law ? "✗" : "·";
  return fmt::format("{} mean linear momentum along e₁: bodies {} kg m/s, {} the move; fluid {} kg m/s", mark,
                     with_sign(mean), sense_words(mean, asked), with_sign(of_fluid));
}

// Turns have the sign of the bodies' momentum in the paper's maneuver; no law asks it of all.
std::string angular_line(double mean, double of_fluid, double asked) {
  return fmt::format("{} mean angular momentum about e₁: bodies {} kg m²/s, {} the turn; fluid {} kg m²/s",
                     mean * asked > 0.0 ? "✓" : "·", with_sign(mean), sense_words(mean, asked), with_sign(of_fluid));
}

bool ends_turned_as_it_began(const maneuver::Solution& solution) {
  constexpr double same = 1e-6;  // rad
  const auto &first = solution.rotation.front(), &last = solution.rotation.back();
  for (std::size_t i = 0; i < first.size(); ++i)
    if (lie::rotation_angle(first[i].transpose() * last[i]) > same) return false;
  return true;
}

// There the bodies' momentum is the total, and nothing is left to compare it with.
bool in_a_vacuum(const result::ResolvedProblem& problem) {
  return std::all_of(problem.bodies.begin(), problem.bodies.end(), [](const result::ResolvedBody& body) {
    return body.mass_matrix.isApprox(body.mass * Eigen::Matrix3d::Identity());
  });
}

}  // namespace

bool drifts(const result::Results& results) { return share_of_total(results) > no_momentum; }

std::vector<std::string> momentum_lines(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  std::vector<std::string> lines;
  if (solution.time.size() < 2 || !results.problem.goal || without_motion(results)) return lines;
  const double moving = largest(solution.linear_momentum.bodies) + largest(solution.angular_momentum.bodies);
  const double start = solution.linear_momentum.bodies.front().norm() + solution.angular_momentum.bodies.front().norm();
  if (moving == 0.0 || in_a_vacuum(results.problem)) return lines;
  if (start < 1e-9 * moving) lines.push_back(zero_line(share_of_total(results), results.certificate));
  // signs of motions that go elsewhere say nothing
  if (!results.certificate || !(results.certificate->goal_error <= evidence::goal_mark)) return lines;
  const maneuver::Goal& goal = *results.problem.goal;
  const auto none = [](double mean, const Vectors& momenta) { return std::abs(mean) < no_momentum * largest(momenta); };
  if (goal.move[0] && *goal.move[0] != 0.0) {
    const double mean = mean_along_e1(solution.linear_momentum.bodies);
    lines.push_back(none(mean, solution.linear_momentum.bodies)
                        ? no_mean_line("linear", "along")
                        : linear_line(mean, mean_along_e1(solution.linear_momentum.fluid), *goal.move[0],
                                      ends_turned_as_it_began(solution)));
  }
  if (goal.turn && (*goal.turn)[0] != 0.0 && !drifts(results)) {  // momentum turns a swimmer either way
    const double mean = mean_along_e1(solution.angular_momentum.bodies);
    lines.push_back(none(mean, solution.angular_momentum.bodies)
                        ? no_mean_line("angular", "about")
                        : angular_line(mean, mean_along_e1(solution.angular_momentum.fluid), (*goal.turn)[0]));
  }
  return lines;
}

}  // namespace lamprey::report
