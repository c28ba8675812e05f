#include "report/momentum_lines.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "certificate/certificate.hpp"
#include "lie/so3.hpp"
#include "report/poses.hpp"
#include "report/summary.hpp"
#include "report/wording.hpp"

namespace lamprey::report {

namespace {

using maneuver::MomentumHistory;
using maneuver::Vectors;

constexpr double no_momentum = 1e-9;  // of the bodies' momentum, total momentum that is none

// Mean along e₁ by the trapezoid rule, over every node or every second one.
double mean_at_nodes(const Vectors& values, std::size_t stride) {
  double sum = 0.0;
  const std::size_t steps = values.size() - 1;
  for (std::size_t k = 0; k < steps; k += stride) {
    const std::size_t next = std::min(k + stride, steps);
    sum += 0.5 * static_cast<double>(next - k) * (values[k][0] + values[next][0]);
  }
  return sum / static_cast<double>(steps);
}

// Σ m_i x_i along e₁, kg m.
double first_moment(const result::Results& results, std::size_t k) {
  const std::vector<Eigen::Vector3d> centres = body_centres(results.problem, joint_order(results.problem),
                                                            results.solution.position[k], results.solution.rotation[k]);
  double sum = 0.0;
  for (std::size_t i = 0; i < centres.size(); ++i) sum += results.problem.bodies[i].mass * centres[i][0];
  return sum;
}

// Of the bodies' linear momentum along e₁, from where they went: momenta at nodes leave more of an error than tiny moves are worth.
double mean_linear(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  return (first_moment(results, solution.position.size() - 1) - first_moment(results, 0)) /
         (solution.time.back() - solution.time.front());
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

// Of a mean that is none beside what it is taken of.
std::string no_mean_line(const char* kind, const char* along, const char* to = "round-off") {
  return fmt::format("· mean {} momentum of the bodies {} e₁ is zero to {}", kind, along, to);
}

// Bodies that end turned as they began have all moved as the root has: the mean of their momentum has the sign of the move. Of others
// no law asks it.
std::string linear_line(double mean, double of_fluid, double asked) {
  return fmt::format("{} mean linear momentum along e₁: bodies {} kg m/s, {} the move; fluid {} kg m/s",
                     mean * asked > 0.0 ? "✓" : "·", with_sign(mean), sense_words(mean, asked), with_sign(of_fluid));
}

std::string linear_line_of(const result::Results& results) {
  constexpr double round_off = 1e-13;  // of all mass carried through the swimmer's reach
  double mass = 0.0;
  for (const result::ResolvedBody& body : results.problem.bodies) mass += body.mass;
  const double mean = mean_linear(results), time = results.solution.time.back() - results.solution.time.front();
  const double total = results.solution.linear_momentum.total.front()[0];
  return std::abs(mean) <= round_off * mass * reach_of(results) / time
             ? no_mean_line("linear", "along")
             : linear_line(mean, total - mean, *results.problem.goal->move[0]);
}

// Turns have the sign of the bodies' momentum in the paper's maneuver; no law asks it of all.
std::string angular_line(double mean, double of_fluid, double asked) {
  return fmt::format("{} mean angular momentum about e₁: bodies {} kg m²/s, {} the turn; fluid {} kg m²/s",
                     mean * asked > 0.0 ? "✓" : "·", with_sign(mean), sense_words(mean, asked), with_sign(of_fluid));
}

std::string angular_line_of(const MomentumHistory& momenta, double asked) {
  const double mean = mean_at_nodes(momenta.bodies, 1);
  const double error = std::abs(mean_at_nodes(momenta.bodies, 2) - mean) / 3.0;
  if (std::abs(mean) < no_momentum * largest(momenta.bodies)) return no_mean_line("angular", "about");
  return std::abs(mean) <= error ? no_mean_line("angular", "about", "what the steps leave of it")
                                 : angular_line(mean, mean_at_nodes(momenta.fluid, 1), asked);
}

// There the bodies' momentum is the total, and nothing is left to compare it with.
bool in_a_vacuum(const result::ResolvedProblem& problem) {
  return std::all_of(problem.bodies.begin(), problem.bodies.end(), [](const result::ResolvedBody& body) {
    return body.mass_matrix.isApprox(body.mass * Eigen::Matrix3d::Identity());
  });
}

}  // namespace

std::string asked_turn(const result::Results& results) {
  constexpr double round_off = 1e-12, half_a_turn = 1e-6;  // rad
  const auto& goal = results.problem.goal;
  const auto& rotation = results.solution.rotation;
  if (!goal || rotation.size() < 2) return "";
  Eigen::Matrix3d start = Eigen::Matrix3d::Identity();
  if (const auto& begin = results.problem.start; begin && !begin->rotation.empty()) start = begin->rotation.front();
  Eigen::Vector3d asked = goal->turn.value_or(Eigen::Vector3d(Eigen::Vector3d::Zero()));
  if (const auto own = goal->rotation.find(results.problem.bodies.front().name); own != goal->rotation.end())
    asked = own->second ? lie::log(lie::exp(*own->second) * start.transpose()) : Eigen::Vector3d::Zero();
  Eigen::Vector3d turn = lie::log(rotation.back().front() * rotation.front().front().transpose());
  if (!(asked.norm() > round_off && turn.norm() > round_off)) return "";
  if (turn.norm() > std::numbers::pi - half_a_turn && turn.dot(asked) < 0.0) turn = -turn;  // which is as far
  const double angle = turn.norm();
  turn = (turn.array().abs() < round_off).select(0.0, turn);
  return fmt::format("{} rad, {}°", vector(turn), number(angle * 180.0 / std::numbers::pi, 5));
}

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
  if (goal.move[0] && *goal.move[0] != 0.0) lines.push_back(linear_line_of(results));
  if (goal.turn && (*goal.turn)[0] != 0.0 && !drifts(results))  // momentum turns a swimmer either way
    lines.push_back(angular_line_of(solution.angular_momentum, (*goal.turn)[0]));
  return lines;
}

}  // namespace lamprey::report
