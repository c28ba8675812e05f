#include "study/answer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <tuple>

#include "certificate/certify.hpp"
#include "certificate/limit_words.hpp"
#include "integrator/scheme.hpp"
#include "study/answer_parts.hpp"
#include "study/enough_time.hpp"
#include "study/found.hpp"
#include "study/plain_words.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using certificate::complementarity_mark;
using certificate::goal_mark;
using certificate::limit_mark;
using certificate::rest_mark;
using certificate::violation_in_words;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Status;

constexpr int few_steps = 50;
constexpr double half_turn_mark = 1e-4;     // rad
constexpr double loosest_tolerance = 1e-4;  // of stationarity, that is worth proposing
constexpr double cheaper_share = 1e-6;      // of the cost, by which a motion is cheaper
constexpr double nearly_there = 1e-3;       // rad or swimmer's sizes, of a goal
constexpr double other_units = 1e3;         // times a bound on moments, by which motions of these sizes hardly break it
constexpr int few_arrived = 3;              // first guesses for each that arrived, from which on minima may be missing
constexpr double small_motion = 1e-2;  // displacement over the largest distance of joints from parents' mass centres

// What shows that files do not tell of the problem's own motion; empty when nothing does.
std::string foreign(const Certificate& proof) {
  if (!proof.refusal.empty()) return "the files ask what no problem file may (" + proof.refusal + ")";
  if (!(proof.equation_residual <= proof.equation_allowed())) return "";  // the motion is none
  if (!(proof.rotation_drift <= certificate::rotation_mark))
    return "rotations are none: |RᵀR − I| is " + number(proof.rotation_drift);
  if (std::isnan(proof.start_error)) return "the files do not tell the start that was asked for";
  if (!(proof.start_error <= certificate::start_mark))
    return "the motion begins " + number(proof.start_error) + " (rad or m) beside the problem's start";
  if (!(proof.time_error <= certificate::time_mark))
    return "the nodes' times differ by " + number(proof.time_error) + " of the duration from its equal steps";
  if (!(proof.control_error <= certificate::control_mark))
    return number(proof.control_error) + " of the moments is outside what the joints or the control's kind can exert";
  if (!(proof.momentum_drift <= proof.momentum_allowed()))
    return "total momentum changes by " + number(proof.momentum_drift) + " of its scale";
  if (!(proof.velocity_error <= certificate::velocity_mark))
    return "stored velocities, momenta or joint angles are off by " + number(proof.velocity_error) + " of the largest";
  if (!(proof.cost_error <= certificate::cost_mark))
    return "the stored cost is off by " + number(proof.cost_error) + " of the one recomputed";
  return "";
}

// Whether stages of a scheme above order 2 do not follow from the moments.
bool too_long_for_stages(const Problem& problem, const Certificate& proof) {
  return std::isnan(proof.equation_residual) && !integrator::single_step(problem.scheme);
}

// What keeps the answer from being feasible; empty when nothing does.
std::string unmet(const Problem& problem, const Certificate& proof) {
  if (too_long_for_stages(problem, proof))
    return "no march under the moments, in steps of " + number(problem.time_step(), 3) +
           " s with several stages each, arrives at a motion whose equations can be checked";
  if (std::isnan(proof.equation_residual)) return "there is no motion whose equations can be checked";
  if (!(proof.equation_residual <= proof.equation_allowed()))
    return "no motion was found that obeys the mechanics and meets the goal (discrete equations off by " +
           number(proof.equation_residual) + " of the momentum's scale, goal by " + number(proof.goal_error) +
           " rad or m)";
  if (!(proof.goal_error <= goal_mark)) return "the goal is missed by " + number(proof.goal_error) + " (rad or m)";
  if (proof.limits && !(proof.limits->violation <= limit_mark))
    return violation_in_words(proof.limits->key, proof.limits->violation, proof.limits->time);
  if (problem.goal && problem.goal->rest && !(proof.rest_error <= rest_mark))
    return "the end is not at rest: momentum " + number(proof.rest_error) + " of its scale is left";
  return "";
}

// What keeps a feasible answer from being optimal.
std::string unsettled(const Problem& problem, const Certificate& proof) {
  if (!(proof.kkt <= problem.search.tolerance))
    return "the cost is stationary to " + number(proof.kkt, 3) + " only, not to " + number(problem.search.tolerance);
  if (proof.limits && !(proof.limits->complementarity <= complementarity_mark))
    return "limits pull where they are not reached: by " + number(proof.limits->complementarity) +
           " of the cost over the duration, allowed " + number(complementarity_mark);
  if (proof.limits && !(proof.limits->negative <= complementarity_mark))
    return "limits push the wrong way: by " + number(proof.limits->negative) + " of the largest multiplier, allowed " +
           number(complementarity_mark);
  return "the work's multipliers do not fit the signs of the powers: by " + number(proof.costs->signs) +
         " of their joint's largest, allowed " + number(complementarity_mark);
}

// A spring's moment is along the joint's turn and jumps where that is half a turn: a search can end there, stationary on
// neither side. Empty where no sprung joint stands there.
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

// By schemes whose steps are one.
StepTurn turn_of_steps(const Problem& problem, const Solution& solution) {
  return integrator::single_step(problem.scheme) ? largest_turn(solution.rotation) : StepTurn();
}

// Beyond a quarter turn momentum falls as the turn grows, and half a turn carries none. Empty where no turn is near that.
std::string far_turn(const Problem& problem, const Solution& solution) {
  const StepTurn turn = turn_of_steps(problem, solution);
  if (turn.angle < nearly_quarter_turn) return "";
  return " " + problem.swimmer.bodies[turn.body].name + " turns by " + number(turn.angle, 3) + " rad in one step, at " +
         number(solution.time[turn.step], 3) +
         " s, and a quarter turn is the most that a step can show: time.steps = " + std::to_string(problem.steps) +
         " may be too few; a limits.angular_velocity keeps motions from such turns.";
}

// Small gaits move by the square of their size and work by it too, so that a search for the least work per distance may fade
// towards rest, whether the smallest gaits are the cheapest or not. Empty where it did not.
std::string fading(const Problem& problem, const Solution& solution) {
  if (problem.cost_weights.transport == 0.0 || !problem.goal || problem.goal->distance()) return "";
  if (solution.position.empty()) return "";
  const double moved = (solution.position.back() - solution.position.front()).norm();
  if (moved > small_motion * model::System(problem.swimmer).size()) return "";
  return " The motion shrank to a displacement of " + number(moved, 3) +
         " m, and next to rest work per distance is the ratio of two numbers that vanish.";
}

// A power of ten, or twice or five times one, that is not below the value.
double rounded_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= value) return digit * power;
  return 10.0 * power;
}

// What to try where a motion meets all that is asked but is not optimal.
std::string advice_where_met(const Problem& problem, const Certificate& proof, const Solution& solution) {
  std::string words = "try ";
  const std::string finer = "[time] steps = " + std::to_string(2 * problem.steps);
  if (const std::optional<double> held = solution.solver.held_joint_rate)
    return words + "limits.angular_velocity = " + number(*held, 6) + ", or " +
           (solution.status == Status::time_limit ? "a longer search.time_limit" : finer);
  if (!far_turn(problem, solution).empty()) words += finer + ", ";
  words += problem.search.starts == 1 ? "[search] starts = 8, another seed" : "more starts, another seed";
  if (proof.kkt > problem.search.tolerance && proof.kkt <= loosest_tolerance)
    words += "; where so much is enough, [search] tolerance = " + number(rounded_up(proof.kkt)) + " accepts it";
  return words;
}

// Keys of limits that more time makes easier to keep, "a, b or c"; empty where there are none.
std::string limits_on_haste(const maneuver::Limits& limits) {
  std::vector<std::string> keys;
  const auto add = [&](const char* quantity, const std::optional<double>& all, const auto& by_joint) {
    if (all) keys.push_back(std::string("limits.") + quantity);
    for (const auto& [joint, bound] : by_joint) keys.push_back(std::string("limits.") + quantity + "." + joint);
  };
  add("torque", limits.torque, limits.joint_torque);
  add("torque_component", limits.torque_component, limits.joint_torque_component);
  add("angular_velocity", limits.angular_velocity, limits.joint_angular_velocity);
  std::string words;
  for (std::size_t n = 0; n < keys.size(); ++n) words += (n == 0 ? "" : n + 1 < keys.size() ? ", " : " or ") + keys[n];
  return words;
}

// In what time the motion that was found would do, where it nearly meets the goal; in brackets after a blank.
std::string time_for_motion(const Problem& problem, const Certificate& proof, const Solution& solution) {
  const model::System system(problem.swimmer);
  if (!(proof.goal_error <= nearly_there * std::min(1.0, system.size()))) return "";
  const std::optional<double> seconds = enough_time(system, problem, solution);
  return seconds ? " (in " + number(*seconds, 3) + " s the motors are up to this motion)" : "";
}

// What to try, what bears on this answer first.
std::string advice(const Problem& problem, const Certificate& proof, const Solution& solution) {
  if (problem.search.method == maneuver::SearchMethod::shooting) return "set method = \"simultaneous\"";
  const bool resolved = unmet(problem, proof).empty() && fading(problem, solution).empty();
  if (resolved) return advice_where_met(problem, proof, solution);
  std::string words = "try ";
  if (solution.status == Status::time_limit) {  // tells nothing of what is asked
    words += "a longer search.time_limit";
    if (problem.steps > few_steps)
      words += ", or fewer time.steps, whose answer lamprey solve --first begins with on as many as these";
    if (problem.duration.free && !solution.time.empty() &&
        solution.time.back() > problem.duration.max * (1.0 + limit_mark))
      words += ", or a larger time.max";
    return words;
  }
  if (!fading(problem, solution).empty()) {
    const auto& move = problem.goal->move;
    const bool partly = std::any_of(move.begin(), move.end(), [](const auto& along) { return along.has_value(); });
    words += partly ? "a goal.move along all axes, which gives the distance, " : "a distance (goal.move), ";
  }
  if (too_long_for_stages(problem, proof) && problem.swimmer.compliant())
    words += "[integrator] scheme = \"midpoint\" (springs and dampers of light bodies ask for short stages), ";
  if (!far_turn(problem, solution).empty() || too_long_for_stages(problem, proof))
    words += "[time] steps = " + std::to_string(2 * problem.steps) + ", ";
  const bool broken = proof.limits && !(proof.limits->violation <= limit_mark);
  if (broken && proof.limits->key.starts_with("limits.")) words += "a looser " + proof.limits->key + ", ";
  if (broken && proof.limits->key.starts_with("limits.torque") && proof.limits->violation > other_units)
    words += "other units (its N m, lengths' m, the density's kg/m³, the time's s), ";
  const std::string hurried = limits_on_haste(problem.limits);
  const bool gait = problem.goal && problem.goal->periodic;
  if (!hurried.empty())
    words += (problem.duration.free ? "a larger time.max" : "a longer time.duration") +
             time_for_motion(problem, proof, solution) + ", ";
  if (broken && proof.limits->key == "time.max" && !hurried.empty()) words += "a looser " + hurried + ", ";
  if (!problem.waypoints.empty()) words += "waypoints farther apart in time, or fewer, ";
  if (broken && !gait) words += "a share of the way (what takes many strokes is a gait, goal.periodic, repeated), ";
  if (problem.search.starts == 1) return words + "[search] starts = 8, another seed, or a nearer goal";
  return words + "more starts, another seed, or a nearer goal; check that control_axes can reach it";
}

// What is particular about where a search ended.
std::string where_it_ended(const Problem& problem, const Solution& solution) {
  return far_turn(problem, solution) + spring_at_its_jump(problem, solution) + fading(problem, solution);
}

// What second derivatives say, as sentences.
std::string curvature_words(const Problem& problem, const Certificate& proof) {
  const auto saddle = [](const certificate::SecondOrder& second) {
    return second.negative_eigenvalues && *second.negative_eigenvalues > 0;
  };
  const auto directions = [](const certificate::SecondOrder& second) {
    return std::to_string(*second.negative_eigenvalues) +
           (*second.negative_eigenvalues == 1 ? " direction lowers" : " directions lower") + " the cost";
  };
  std::string words;
  if (!proof.second_order)
    words = std::string(" Whether it is a minimum cannot be told: ") +
            (problem.cost_weights.any() ? "where powers vanish second derivatives may differ from side to side."
                                        : "its second derivatives may be lost in round-off.");
  else if (proof.second_order->positive)
    words = proof.kkt <= certificate::proof_mark
                ? words_of_minimum(proof)
                : " Not proved a minimum: its conditions hold to " + number(proof.kkt) + " only, and a proof takes " +
                      number(certificate::proof_mark) + ".";
  else if (saddle(*proof.second_order))
    words = " A saddle: " + directions(*proof.second_order) +
            "; another number of time.steps, more starts or another seed may lead to a minimum.";
  else
    words = " Not proved a minimum: smallest curvature " + number(proof.second_order->smallest_eigenvalue, 3) + ".";
  const bool flat = proof.second_order && !proof.second_order->positive &&
                    std::abs(proof.second_order->smallest_eigenvalue) < certificate::curvature_mark;
  if (flat && problem.goal->periodic && problem.start.free_shape)
    words += " Where nothing ties a gait to its start it may begin anywhere along itself, which costs the same.";
  if (proof.all_axes && saddle(proof.all_axes->second_order))
    words += " With control_axes set aside it is a saddle: " + directions(proof.all_axes->second_order) + ".";
  return words;
}

// What shows that the steps are too coarse for the motion: far turns, or an independent integrator that does not stay with
// it between restarts. Empty where neither does.
std::string unresolved(const Problem& problem, const Answer& answer) {
  const double turn = turn_of_steps(problem, answer.solution).angle;
  if (turn > 0.5 * std::numbers::pi) return "a body turns by " + number(turn, 3) + " rad in one of its steps";
  const auto& replay = answer.certificate.replay;
  if (!replay || std::isnan(replay->rotation_error)) return "it was not replayed";
  if (!(replay->rotation_error <= certificate::replay_mark))
    return "its replay misses by " + number(replay->rotation_error) + " rad";
  return "";
}

// Moments that come and go within a step do work that its nodes do not see. Empty where both agree.
std::string unseen_work(const Answer& answer) {
  const auto& parts = answer.solution.cost_parts;
  const auto& replay = answer.certificate.replay;
  if (!parts || !replay || !replay->works_otherwise(parts->work)) return "";
  return " By its replay the joints do " + number(replay->work, 3) + " J of work, by the nodes that the cost counts " +
         number(parts->work, 3) +
         " J: moments change faster than these steps show, and costs of work, power and transport are not what they "
         "seem. More weight on cost.effort, or one on cost.smoothness, makes moments smoother.";
}

// How many times as many steps would resolve a motion, by the order at which what its replay misses falls.
int more_steps(const Problem& problem, const Answer& answer) {
  constexpr int least = 2, most = 16;  // beyond, errors say little of how they fall
  const auto& replay = answer.certificate.replay;
  if (!replay || !(replay->rotation_error > certificate::replay_mark)) return least;
  const double times =
      std::pow(replay->rotation_error / certificate::replay_mark, 1.0 / integrator::order(problem.scheme));
  return std::clamp(static_cast<int>(std::ceil(std::min<double>(times, most))), least, most);
}

// The effort's weight at which it would be as much as all else that this motion costs.
std::string effort_to_match(const Problem& problem, const Solution& solution) {
  const double smoothed = problem.effort * solution.cost_parts->effort;
  const double weight = (solution.cost - smoothed) / solution.cost_parts->effort;
  return weight > problem.effort && std::isfinite(weight) ? " (" + number(rounded_up(weight)) + ")" : "";
}

// Whether what is paid is mostly work: it is least in impulses, which finer steps only make shorter.
bool mostly_work(const Problem& problem, const Solution& solution) {
  constexpr double mostly = 0.5;
  if (!solution.cost_parts || !(problem.cost_weights.work > 0.0 || problem.cost_weights.transport > 0.0)) return false;
  const double smoothed =
      problem.effort * solution.cost_parts->effort + problem.cost_weights.smoothness * solution.cost_parts->smoothness;
  return smoothed < mostly * solution.cost;
}

// What of an optimal answer more steps would mend, as a sentence. Empty where its replays keep to their marks.
std::string coarseness(const Problem& problem, const Answer& answer) {
  std::string missed = unresolved(problem, answer);
  const auto& replay = answer.certificate.replay;
  const bool lost = replay && replay->feedback_rotation_error > certificate::feedback_mark;
  if (missed.empty() && lost && problem.limits.of_moments())
    return " Its feedback, held to the limits of torque, ends " + number(replay->feedback_rotation_error) +
           " rad beside it: a plan with smaller limits leaves motors a reserve.";
  if (missed.empty() && lost)
    missed = "its replay with feedback ends " + number(replay->feedback_rotation_error) + " rad beside it";
  if (missed.empty()) return "";
  const std::string mend =
      "try [time] steps = " + std::to_string(problem.steps * more_steps(problem, answer)) + " or more";
  return " These steps do not resolve the motion: " + missed + "; " +
         (mostly_work(problem, answer.solution) && unseen_work(answer).empty()
              ? "work is least in impulses, which finer steps only make shorter: more weight on cost.effort" +
                    effort_to_match(problem, answer.solution) +
                    ", or one on cost.smoothness, makes moments smoother; or " + mend
              : mend) +
         (!replay || std::isnan(replay->servo_rotation_error)
              ? "."
              : ". Servos that lead the joints along its angles end " + number(replay->servo_rotation_error) +
                    " rad and " + number(replay->servo_position_error) + " m beside the goal" +
                    (problem.limits.of_moments() ? ", by whatever moments that takes." : "."));
}

// Answers in order of worth: proven first, then those that meet what is asked, then motions at all, then resolved, then cheap.
std::tuple<bool, bool, bool, bool, double> rank(const Problem& problem, const Answer& answer) {
  const Certificate& proof = answer.certificate;
  return {answer.solution.status != Status::optimal, !unmet(problem, proof).empty(),
          !(proof.equation_residual <= proof.equation_allowed()), !unresolved(problem, answer).empty(),
          answer.solution.cost};
}

// A candidate of the search, by its number.
struct Certified {
  std::size_t candidate;
  Answer answer;
};

// Why motions that cost less than the answer are not the answer.
std::string cheaper_ones(const Problem& problem, const std::vector<Certified>& found, const Solution& best) {
  std::string words;
  for (const auto& [candidate, other] : found) {
    if (!(other.solution.cost < best.cost - cheaper_share * std::abs(best.cost))) continue;
    const std::string cheaper = " A cheaper motion (cost " + number(other.solution.cost, 6) + ") ";
    const std::string coarse = unresolved(problem, other);
    if (other.solution.status == Status::optimal && !coarse.empty())
      words += cheaper + "was set aside: " + coarse + ", so these steps are too coarse for it.";
    if (other.solution.status == Status::feasible && best.status == Status::optimal &&
        unmet(problem, other.certificate).empty())
      words += cheaper + "meets all that is asked, too, but " + unsettled(problem, other.certificate) + ".";
  }
  return words;
}

// Where few first guesses arrived, as a sentence.
std::string few_arrivals(const Solution& solution) {
  const auto& search = solution.search;
  const int tried = search.starts + search.hops;
  if (tried < few_arrived || few_arrived * search.solved > tried) return "";
  return " Of " + std::to_string(tried) + " searches " + std::to_string(search.solved) +
         " arrived: more starts or another seed may find a cheaper one.";
}

// Adds what was found out to the answer and its message.
void add_to(Answer& best, const Problem& problem, const Completion& found_out) {
  std::string& message = best.solution.message;
  if (found_out.curved) {
    best.certificate = *found_out.curved;
    message += curvature_words(problem, best.certificate);
  }
  const Followed& followed = found_out.followed;
  best.solution.feedback = followed.feedback;
  best.certificate.replay = followed.replay;
  if (!followed.refused.empty()) message += " It comes without feedback: " + followed.refused + ".";
  best.certificate.refinement = found_out.refinement;
  if (found_out.refinement) message += refinement_words(*found_out.refinement);
}

}  // namespace

std::string fault(const Problem& problem, const Certificate& proof) {
  if (const std::string other = foreign(proof); !other.empty()) return other;
  if (const std::string missing = unmet(problem, proof); !missing.empty()) return missing;
  return certificate::stationary(problem, proof) ? "" : unsettled(problem, proof);
}

void judge(const Problem& problem, const Certificate& proof, Solution& solution) {
  std::string missing = unmet(problem, proof);
  const double duration = solution.time.empty() ? 0.0 : solution.time.back() - solution.time.front();
  const bool above = duration > problem.duration.max * (1.0 + limit_mark);
  const bool below = duration < problem.duration.min * (1.0 - limit_mark);
  const bool said_so = proof.limits && proof.limits->key.starts_with("time.") && missing.starts_with("time.");
  if (!missing.empty() && !said_so && problem.duration.free && !solution.time.empty() && (above || below))
    missing += ", in " + number(duration, 3) + " s, beyond " + (above ? "time.max" : "time.min");
  const std::string other = foreign(proof);
  const bool said = !solution.message.empty() && solution.message != "converged";
  const std::string stopped = said ? " The optimiser stopped: " + solution.message + "." : "";
  const bool cut_short = solution.status == Status::interrupted || solution.status == Status::time_limit;
  if (!other.empty()) {
    if (!cut_short) solution.status = Status::stalled;
    solution.message = "No answer to this problem: " + other + "." + stopped;
  } else if (missing.empty() && certificate::stationary(problem, proof)) {
    solution.status = Status::optimal;
    solution.message = words_of_goal(proof) + far_turn(problem, solution);
  } else if (missing.empty()) {
    if (!cut_short) solution.status = Status::feasible;
    solution.message = "The goal is met, but " + unsettled(problem, proof) + "." + stopped +
                       where_it_ended(problem, solution) + " To mend it: " + advice(problem, proof, solution) + ".";
  } else {
    const bool beyond_moments = solution.status == Status::optimal && !(proof.goal_error <= goal_mark);
    if (!cut_short && solution.status != Status::infeasible)
      solution.status = beyond_moments ? Status::infeasible : Status::stalled;
    if (beyond_moments) {
      solution.message = "Out of reach: " + missing +
                         ", and no moment of these joints changes that. What may help: other control_axes or joints, "
                         "or a goal that leaves this free.";
      return;
    }
    solution.message = "Not solved: " + missing + "." + stopped + where_it_ended(problem, solution) +
                       " What may help: " + advice(problem, proof, solution) + ".";
  }
}

void judge_march(const Certificate& proof, Solution& solution) {
  const auto beyond = [](double error, double mark) { return error > mark; };  // NaN: not computed
  std::string missing;
  if (beyond(proof.equation_residual, proof.equation_allowed()))
    missing = "the discrete equations are off by " + number(proof.equation_residual) + " of the momentum's scale";
  else if (beyond(proof.momentum_drift, proof.momentum_allowed()))
    missing = "total momentum changes by " + number(proof.momentum_drift) + " of its scale";
  else if (beyond(proof.rotation_drift, certificate::rotation_mark))
    missing = "rotations are none: |RᵀR − I| is " + number(proof.rotation_drift);
  else if (beyond(proof.start_error, certificate::start_mark))
    missing = "it begins " + number(proof.start_error) + " (rad or m) beside its start";
  else if (beyond(proof.velocity_error, certificate::velocity_mark))
    missing =
        "stored velocities, momenta or joint angles are off by " + number(proof.velocity_error) + " of the largest";
  else if (beyond(proof.time_error, certificate::time_mark))
    missing = "the nodes' times differ by " + number(proof.time_error) + " of the duration from equal steps";
  else if (std::isfinite(solution.cost))
    missing = "a march has no cost, and one is stored";
  if (missing.empty()) return;
  solution.status = Status::stalled;
  solution.message = "No march: " + missing + ".";
}

Answer answer(const model::System& system, const Problem& problem, const SolveOptions& options) {
  Parts parts(problem, options);
  std::vector<std::optional<Certificate>> proofs;
  bool proven = false, met = false;  // whether a candidate is
  SolveOptions certified = options;
  certified.accept = [&](Solution& solution) {
    // without a certificate an answer is worth little: time or not, the first candidate has one, and so have others that
    // may be proven where none is yet, or keep what is asked where none does
    const bool needed = proofs.empty() || (!proven && solution.status == Status::optimal) ||
                        (!met && solution.status == Status::feasible);
    proofs.emplace_back();
    if (!needed && !parts.begins(Part::other_candidate)) return false;
    parts.progress("certifying");
    Certificate& proof = proofs.back().emplace(first_certificate(system, problem, solution, options.workers, parts));
    judge(problem, proof, solution);
    if (solution.status != Status::optimal)
      parts.progress("candidate of cost " + number(solution.cost, 8) + ": " + solution.message);
    proven = proven || solution.status == Status::optimal;
    met = met || proven || solution.status == Status::feasible;
    return solution.status == Status::optimal && unresolved(problem, {solution, proof}).empty();
  };
  const Candidates candidates = find_candidates(system, problem, certified);
  if (!candidates.out_of_reach.empty()) {
    Answer none{candidates.solution.front(), {}};
    none.certificate = first_certificate(system, problem, none.solution, options.workers, parts);
    none.solution.message = "Out of reach: " + candidates.out_of_reach + ".";
    none.solution.solver.total_wall_seconds = parts.seconds();
    return none;
  }
  std::vector<Certified> found;
  for (std::size_t n = 0; n < candidates.solution.size(); ++n)
    if (proofs[n]) found.push_back({n, {candidates.solution[n], *proofs[n]}});
  const auto chosen = std::min_element(found.begin(), found.end(), [&](const Certified& a, const Certified& b) {
    return rank(problem, a.answer) < rank(problem, b.answer);
  });
  Answer best = chosen->answer;
  const bool optimal = best.solution.status == Status::optimal;
  if (optimal) {
    CostOnGrid cost_on_grid;
    if (candidates.cost_on_grid)
      cost_on_grid = [&](int steps) {
        parts.progress("on a grid of " + std::to_string(steps) + " steps");
        return candidates.cost_on_grid(chosen->candidate, steps);
      };
    add_to(best, problem, complete(system, problem, best, cost_on_grid, options.workers, parts));
  }
  best.solution.message += cheaper_ones(problem, found, best.solution);
  if (optimal) best.solution.message += coarseness(problem, best) + unseen_work(best) + few_arrivals(best.solution);
  parts.tell(candidates.unsearched, best.solution);
  best.solution.solver.total_wall_seconds = parts.seconds();
  return best;
}

}  // namespace lamprey::study
