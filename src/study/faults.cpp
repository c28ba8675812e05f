#include "study/faults.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "certificate/limit_words.hpp"
#include "certificate/verdict.hpp"
#include "integrator/scheme.hpp"
#include "lie/so3.hpp"
#include "mechanics/tree_motion.hpp"
#include "search/found.hpp"
#include "study/plain_words.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using certificate::violation_in_words;
using evidence::complementarity_mark;
using evidence::goal_mark;
using evidence::limit_mark;
using evidence::rest_mark;
using evidence::sign_mark;
using maneuver::Problem;
using maneuver::Solution;

constexpr double half_turn_mark = 1e-4;  // rad
constexpr double small_motion = 1e-2;    // displacement over the largest distance of joints from parents' mass centres

// By schemes whose steps are one.
search::StepTurn turn_of_steps(const Problem& problem, const Solution& solution) {
  return integrator::single_step(problem.scheme) ? search::largest_turn(solution.rotation) : search::StepTurn();
}

}  // namespace

std::string foreign(const Certificate& proof) {
  if (!proof.refusal.empty()) return "the files ask what no problem file may (" + proof.refusal + ")";
  if (!(proof.equation_residual <= proof.equation_allowed())) return "";  // the motion is none
  if (!(proof.rotation_drift <= evidence::rotation_mark))
    return "rotations are none: |RᵀR − I| is " + number(proof.rotation_drift);
  if (std::isnan(proof.start_error)) return "the files do not tell the start that was asked for";
  if (!(proof.start_error <= evidence::start_mark))
    return "the motion begins " + number(proof.start_error) + " (rad or m) beside the problem's start";
  if (!(proof.time_error <= evidence::time_mark))
    return "the nodes' times differ by " + number(proof.time_error) + " of the duration from its equal steps";
  if (!(proof.control_error <= evidence::control_mark))
    return number(proof.control_error) + " of the moments is outside what the joints or the control's kind can exert";
  if (!(proof.momentum_drift <= proof.momentum_allowed()))
    return "total momentum changes by " + number(proof.momentum_drift) + " of its scale";
  if (!(proof.velocity_error <= evidence::velocity_mark))
    return "stored velocities, momenta or joint angles are off by " + number(proof.velocity_error) + " of the largest";
  if (!(proof.cost_error <= evidence::cost_mark))
    return "the stored cost is off by " + number(proof.cost_error) + " of the one recomputed";
  return "";
}

bool too_long_for_stages(const Problem& problem, const Certificate& proof) {
  return std::isnan(proof.equation_residual) && !integrator::single_step(problem.scheme);
}

std::string unmet(const Problem& problem, const Certificate& proof) {
  if (too_long_for_stages(problem, proof))
    return "no march under the moments, in steps of " + number(problem.time_step(), 3) +
           " s with several stages each, arrives at a motion whose equations can be checked";
  if (std::isnan(proof.equation_residual)) return "there is no motion whose equations can be checked";
  if (!(proof.equation_residual <= proof.equation_allowed()))
    return "no motion was found that obeys the mechanics and meets the goal (discrete equations off by " +
           number(proof.equation_residual) + " of the momentum's scale, goal by " + number(proof.goal_error) +
           " rad or m)";
  if (!(proof.goal_error <= goal_mark) && proof.goal_missed.empty())
    return "the goal is missed by " + number(proof.goal_error) + " (rad or m)";
  if (!(proof.goal_error <= goal_mark))
    return proof.goal_missed + " is missed by " + number(proof.goal_error) +
           (proof.goal_missed_by_turn ? " rad" : " m");
  if (proof.limits && !(proof.limits->violation <= limit_mark))
    return violation_in_words(proof.limits->key, proof.limits->violation, proof.limits->time);
  if (problem.goal && problem.goal->joints_rest && !(proof.rest_error <= rest_mark))
    return "the joints do not end at rest: momenta are " + number(proof.rest_error) +
           " of their scale off those of a whole that moves as one";
  if (problem.goal && problem.goal->rest && !(proof.rest_error <= rest_mark))
    return "the end is not at rest: momentum " + number(proof.rest_error) + " of its scale is left";
  return "";
}

double missed_by(const Problem& problem, const Certificate& proof) {
  constexpr double unknown = std::numeric_limits<double>::infinity();
  const auto beyond = [](double error, double mark) {
    return std::isnan(error) ? unknown : (error <= mark ? 0.0 : error);
  };
  double most = beyond(proof.goal_error, goal_mark);
  if (proof.limits) most = std::max(most, beyond(proof.limits->violation, limit_mark));
  if (problem.goal && problem.goal->stills_joints()) most = std::max(most, beyond(proof.rest_error, rest_mark));
  return std::isnan(proof.equation_residual) ? unknown : most;
}

std::string unsettled(const Problem& problem, const Certificate& proof) {
  if (const double allowed = proof.kkt_allowed(problem.search.tolerance); !(proof.kkt <= allowed))
    return "the cost is stationary to " + number(proof.kkt, 3) + " only, not to " + number(allowed);
  if (proof.limits && !(proof.limits->complementarity <= complementarity_mark))
    return "limits pull where they are not reached: by " + number(proof.limits->complementarity) +
           " of the cost over the duration, allowed " + number(complementarity_mark);
  if (proof.limits && !(proof.limits->negative <= sign_mark))
    return "limits push the wrong way: by " + number(proof.limits->negative) + " of the largest multiplier, allowed " +
           number(sign_mark);
  return "the work's multipliers do not fit the signs of the powers: by " + number(proof.costs->signs) +
         " of their joint's largest, allowed " + number(sign_mark);
}

std::string fault(const Problem& problem, const Certificate& proof) {
  if (const std::string other = foreign(proof); !other.empty()) return other;
  if (const std::string missing = unmet(problem, proof); !missing.empty()) return missing;
  return certificate::stationary(problem, proof) ? "" : unsettled(problem, proof);
}

std::string spring_at_its_jump(const Problem& problem, const Solution& solution) {
  const auto body = [&](const std::string& name) {
    const auto& bodies = problem.swimmer.bodies;
    return static_cast<std::size_t>(
        std::find_if(bodies.begin(), bodies.end(), [&](const auto& each) { return each.name == name; }) -
        bodies.begin());
  };
  for (const model::JointDescription& joint : problem.swimmer.joints) {
    if (joint.stiffness == 0.0 || joint.kind == model::JointKind::universal) continue;
    const std::size_t parent = body(joint.parent), child = body(joint.child);
    const Eigen::Matrix3d zero = lie::exp(joint.reference_rotation);
    for (std::size_t k = 0; k < solution.rotation.size(); ++k) {
      const auto& R = solution.rotation[k];
      if (lie::rotation_angle(zero.transpose() * R[parent].transpose() * R[child]) < std::numbers::pi - half_turn_mark)
        continue;
      return " At " + number(solution.time[k], 3) + " s joint " + joint.name +
             " stands at half a turn, where its spring's moment jumps: a limit below it (limits.swing or limits.angle) "
             "keeps clear of that.";
    }
  }
  return "";
}

std::string far_turn(const Problem& problem, const Solution& solution) {
  const search::StepTurn turn = turn_of_steps(problem, solution);
  if (turn.angle < search::nearly_quarter_turn) return "";
  return " " + problem.swimmer.bodies[turn.body].name + " turns by " + number(turn.angle, 3) + " rad in one step, at " +
         number(solution.time[turn.step], 3) +
         " s, and a quarter turn is the most that a step can show: time.steps = " + std::to_string(problem.steps) +
         " may be too few" +
         (problem.limits.of_rates() ? " for what limits.angular_velocity leaves."
                                    : "; a limits.angular_velocity keeps motions from such turns.");
}

std::string ways_of_joints(const Problem& problem, const Solution& solution) {
  constexpr double same = 1e-3;  // rad
  if (!problem.goal || problem.goal->angle.empty() || solution.rotation.empty()) return "";
  const model::System system(problem.swimmer);
  std::string text;
  for (const model::Joint& joint : system.joints()) {
    const auto asked = problem.goal->angle.find(joint.name);
    if (asked == problem.goal->angle.end() || joint.free()) continue;
    Eigen::Vector3d turn = Eigen::Vector3d::Zero();
    for (const auto& R : solution.rotation)
      turn = mechanics::turn_from_zero(joint, mechanics::child_to_parent(R, joint), turn);
    const Eigen::Vector3d off = turn - maneuver::about_axes(asked->second);
    if (off.unaryExpr([](double by) { return std::remainder(by, 2.0 * std::numbers::pi); }).cwiseAbs().maxCoeff() >
        same)
      continue;
    for (std::size_t axis = 0; axis < asked->second.size(); ++axis) {
      const double end = turn[static_cast<Eigen::Index>(axis)], aim = asked->second[axis];
      if (std::abs(end - aim) <= same) continue;
      const char* about = asked->second.size() == 1 ? ""
                          : axis == 0               ? " about its first axis"
                                                    : " about its second axis";
      text += " Joint " + joint.name + " ends at " + number(end, 4) + " rad" + about + ", not at " + number(aim, 4) +
              ": whole turns lead to the same attitude.";
    }
  }
  return text;
}

std::string way_round(const Problem& problem, const Solution& solution) {
  constexpr double same = 1e-3;  // rad
  if (!problem.goal || !problem.goal->turn || solution.rotation.size() < 2) return "";
  const double asked = problem.goal->turn->norm();
  if (asked == 0.0) return "";
  Eigen::Vector3d turned = Eigen::Vector3d::Zero();  // world frame
  for (std::size_t k = 0; k + 1 < solution.rotation.size(); ++k) {
    const Eigen::Matrix3d& R = solution.rotation[k][0];
    turned += R * lie::log(Eigen::Matrix3d(R.transpose() * solution.rotation[k + 1][0]));
  }
  const Eigen::Vector3d axis = *problem.goal->turn / asked;
  const double about = turned.dot(axis), whole = std::round((about - asked) / (2.0 * std::numbers::pi));
  const bool keeps_axis = (turned - (asked + 2.0 * std::numbers::pi * whole) * axis).norm() <= same;
  if (whole == 0.0 || !keeps_axis) return "";
  return " On its way " + problem.swimmer.bodies.front().name + " turns by " + number(about, 4) + " rad, not by " +
         number(asked, 4) + ": whole turns lead to the same attitude.";
}

std::string fading(const Problem& problem, const Solution& solution) {
  if (problem.cost_weights.transport == 0.0 || !problem.goal || problem.goal->distance()) return "";
  if (solution.position.empty()) return "";
  const double moved = (solution.position.back() - solution.position.front()).norm();
  if (moved > small_motion * model::System(problem.swimmer).size()) return "";
  return " The motion shrank to a displacement of " + number(moved, 3) +
         " m, and next to rest work per distance is the ratio of two numbers that vanish.";
}

std::string unresolved(const Problem& problem, const Solution& solution, const Certificate& proof) {
  const double turn = turn_of_steps(problem, solution).angle;
  if (turn > 0.5 * std::numbers::pi) return "a body turns by " + number(turn, 3) + " rad in one of its steps";
  const auto& replay = proof.replay;
  if (!replay || !replay->misses()) return "";
  if (std::isnan(replay->rotation_error)) return "its replay breaks off";
  if (replay->misses_by_place())
    return "its replay misses by " + number(replay->position_error, 3) + " m, where " +
           number(replay->position_mark / certificate::asked_share, 3) + " m are asked for";
  return "its replay misses by " + number(replay->rotation_error, 3) + " rad";
}

}  // namespace lamprey::study
