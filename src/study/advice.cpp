#include "study/advice.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "certificate/verdict.hpp"
#include "guess/whole_turns.hpp"
#include "integrator/scheme.hpp"
#include "lie/so3.hpp"
#include "maneuver/motion.hpp"
#include "mechanics/connection.hpp"
#include "search/method.hpp"
#include "study/enough_time.hpp"
#include "study/faults.hpp"
#include "study/plain_words.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using evidence::limit_mark;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Status;

constexpr int few_steps = 50, fewest_steps = 12;
constexpr double most_steps_proposed = 1e5;  // to be solved on unasked
constexpr double enough_digits = 1.0005;     // so that four digits of a time are enough of it
constexpr double loosest_tolerance = 1e-4;   // of stationarity, that is worth proposing
constexpr double nearly_there = 1e-3;        // rad or swimmer's sizes, of a goal
constexpr double roughly_there = 1.0;        // the same, of a motion like one that is asked for
constexpr double far_away = 1e3;             // swimmer's sizes
constexpr double some_more = 1.05;           // times what a motion like the one found takes, rounded down as it may be
constexpr double other_units = 1e3;  // times a bound on moments, by which motions of these sizes hardly break it

// A power of ten, or twice or five times one, that is not below the value.
double rounded_up(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  for (const double digit : {1.0, 2.0, 5.0})
    if (digit * power >= value) return digit * power;
  return 10.0 * power;
}

// Whether a body turns, where it is fastest, so fast that it would go round many times in the duration.
bool whirls(const Problem& problem, const Solution& solution) {
  constexpr double many = 5.0;
  if (problem.cost_weights.angular_velocity > 0.0 || solution.time.size() < 2) return false;
  double fastest = 0.0;
  for (const auto& node : solution.angular_velocity)
    for (const Eigen::Vector3d& own : node) fastest = std::max(fastest, own.norm());
  return fastest * (solution.time.back() - solution.time.front()) > many * 2.0 * std::numbers::pi;
}

// The weight of cost.angular_velocity at which turning costs as much as moments do on this motion, "cost.angular_velocity = 1e-05".
std::string words_on_calming(const Problem& problem, const Solution& solution) {
  const model::System system(problem.swimmer);
  const double h = problem.duration.free ? solution.time[1] - solution.time[0] : problem.time_step();
  double turning = 0.0;  // 1/s, ∫ ½ Σ |ω|² dt of the joints
  for (std::size_t k = 0; k + 1 < solution.rotation.size(); ++k)
    for (const model::Joint& joint : system.joints()) {
      const double angle = lie::rotation_angle(mechanics::child_to_parent(solution.rotation[k], joint).transpose() *
                                               mechanics::child_to_parent(solution.rotation[k + 1], joint));
      turning += 0.5 * angle * angle / h;
    }
  const int steps = static_cast<int>(solution.rotation.size()) - 1;
  const double moments =
      maneuver::cost_of(maneuver::node_weights(problem.cost_rule(), problem.effort, h, steps), solution.control);
  const double weight = moments / turning;
  return weight > 0.0 && std::isfinite(weight) ? "cost.angular_velocity = " + number(rounded_up(weight))
                                               : "a little cost.angular_velocity";
}

// What to try where a motion meets all that is asked but is not optimal.
Remedies advice_where_met(const Problem& problem, const Certificate& proof, const Solution& solution) {
  Remedies words;
  const bool rounded = problem.cost_weights.smoothness > 0.0 && proof.kkt_round_off >= optimality::proof_mark;
  if (rounded)
    words.emplace_back(
        "fewer time.steps (where smoothness costs, what digits leave of the moments grows with their fourth power)");
  const std::string finer = "[time] steps = " + std::to_string(2 * problem.steps);
  if (const std::optional<double> held = solution.solver.held_joint_rate) {
    if (whirls(problem, solution)) {
      words.push_back("a limits.angular_velocity that motors can do (at " + number(*held, 3) +
                      " rad/s steps cease to show turns)");
      words.push_back(words_on_calming(problem, solution));
    } else {
      words.push_back("limits.angular_velocity = " + number(*held, 6));
    }
    words.push_back(solution.status == Status::time_limit ? "a longer search.time_limit" : finer);
    return words;
  }
  if (solution.status == Status::time_limit) words.emplace_back("a longer search.time_limit");
  if (!far_turn(problem, solution).empty()) words.push_back(finer);
  if (whirls(problem, solution))
    words.push_back(words_on_calming(problem, solution) + ", which calms bodies that whirl");
  const bool sharp = problem.cost_weights.work > 0.0 || problem.cost_weights.transport > 0.0;
  if (sharp)
    words.push_back(std::string(problem.cost_weights.smoothness > 0.0 ? "more" : "a little") +
                    " cost.smoothness, which rounds what work leaves sharp");
  words.emplace_back(problem.search.starts == 1 ? "[search] starts = 8" : "more starts");
  words.emplace_back("another seed");
  if (const std::string looser = words_on_tolerance(problem, proof); !looser.empty())
    words.back() += "; where so much is enough, " + looser;
  return words;
}

// Whether the goal asks for more than a place that rest would not meet.
bool asks_beside_place(const Problem& problem) {
  const auto& move = problem.goal->move;
  if (std::none_of(move.begin(), move.end(), [](const auto& along) { return along.has_value(); })) return false;
  Problem placeless = problem;
  placeless.goal->move = {};
  const model::System system(problem.swimmer);
  return !guess::rest_meets_goal(system, placeless, maneuver::make_maneuver(system, placeless, problem.steps));
}

// Positions end at their last digit, which far from the world's origin is a velocity from step to step.
std::string advice_far_away(const Problem& problem) {
  const double away = problem.start.position.norm();
  if (!(away > far_away * model::System(problem.swimmer).size())) return "";
  return "a [start] position nearer to the world's origin (" + number(away, 3) +
         " m away the last digits of positions are " + number(away * std::numeric_limits<double>::epsilon(), 2) + " m)";
}

// In what time momentum alone takes the root nearest to where the goal asks for it, where that is not about the one that is given.
std::string time_of_drift(const Problem& problem, const Eigen::Vector3d& velocity) {
  constexpr double alike = 0.1;
  Eigen::Vector3d asked = Eigen::Vector3d::Zero(), along = Eigen::Vector3d::Zero();
  for (std::size_t c = 0; c < 3; ++c)
    if (const auto& move = problem.goal->move[c]) {
      asked[static_cast<Eigen::Index>(c)] = *move;
      along[static_cast<Eigen::Index>(c)] = velocity[static_cast<Eigen::Index>(c)];
    }
  const double seconds = asked.dot(along) / along.squaredNorm();
  if (problem.duration.free || !(seconds > 0.0) || !std::isfinite(seconds)) return "";
  if (std::abs(seconds / problem.duration.value - 1.0) <= alike) return "";
  return "a time.duration nearer to the " + number(seconds, 3) + " s in which its momentum alone takes it there";
}

// Where a place is missed, or not reached in the time that there may be, and total momentum takes the whole elsewhere: as far as it
// would go as one.
std::string advice_on_drift(const Problem& problem, const Certificate& proof, const Solution& solution) {
  if (!problem.goal || solution.position.empty()) return "";
  const model::System system(problem.swimmer);
  const integrator::State start = maneuver::start_state(system, problem.start);
  if (!maneuver::has_momentum(system, start)) return "";
  double missed = 0.0;
  bool asked = false;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto along = static_cast<Eigen::Index>(c);
    asked = asked || problem.goal->move[c];
    if (const auto& move = problem.goal->move[c])
      missed = std::max(missed, std::abs(solution.position.back()[along] - start.position[along] - *move));
  }
  const bool out_of_time =
      asked && proof.limits && proof.limits->key.starts_with("time.") && !(proof.limits->violation <= limit_mark);
  const bool missed_place = missed > evidence::goal_mark || out_of_time;
  const bool broken = proof.limits && !(proof.limits->violation <= limit_mark);
  if (!missed_place && !(asked && broken)) return "";
  const auto total = mechanics::spatial_momentum(system, start.rotation, start.position, start.momentum);
  const mechanics::Vectors still(static_cast<std::size_t>(system.joint_count()), Eigen::Vector3d::Zero());
  const Eigen::Vector3d velocity =
      mechanics::velocity_of_rates(system, start.rotation, start.position, still, total).tail<3>();
  if (!missed_place) return time_of_drift(problem, velocity);
  const Eigen::Vector3d way = (problem.duration.free ? 1.0 : problem.duration.value) * velocity;
  return "a goal.move nearer to where its momentum takes it, which moments cannot change (stiff it would go (" +
         number(way[0], 3) + ", " + number(way[1], 3) + ", " + number(way[2], 3) + ") m in " +
         (problem.duration.free ? "each second" : "this time") + " as it begins)";
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
  add("angular_velocity_component", limits.angular_velocity_component, limits.joint_angular_velocity_component);
  std::string words;
  for (std::size_t n = 0; n < keys.size(); ++n) words += (n == 0 ? "" : n + 1 < keys.size() ? ", " : " or ") + keys[n];
  return words;
}

// In what time the motion that was found would do, where it meets the goal nearly or roughly; in brackets after a blank.
std::string time_for_motion(const Problem& problem, const Certificate& proof, const Solution& solution) {
  const model::System system(problem.swimmer);
  const double unit = std::min(1.0, system.size());
  if (!(proof.goal_error <= roughly_there * unit)) return "";
  const bool nearly = proof.goal_error <= nearly_there * unit;
  const std::optional<double> seconds = enough_time(system, problem, solution, !nearly);
  if (!seconds) return "";
  return nearly ? " (in " + number(*seconds * enough_digits, 4) + " s the motors are up to this motion)"
                : " (a motion like this one takes these motors some " + number(some_more * *seconds, 2) + " s)";
}

// Whether the time that may be is nearly all used.
bool near_the_most(const Problem& problem, const Solution& solution) {
  constexpr double nearly = 0.9;
  return !problem.duration.free || solution.time.empty() || solution.time.back() >= nearly * problem.duration.max;
}

// Where motors are too weak or too slow for the time that there is.
std::string more_time(const Problem& problem, const Certificate& proof, const Solution& solution) {
  return (problem.duration.free ? "a larger time.max" : "a longer time.duration") +
         time_for_motion(problem, proof, solution);
}

// How many times as many steps would resolve a motion, by the order at which what its replay misses falls.
int more_steps(const Problem& problem, const Certificate& proof) {
  constexpr int least = 2, most = 16;  // beyond, errors say little of how they fall
  const auto& replay = proof.replay;
  if (!replay || !(replay->excess() > 1.0)) return least;
  const double times = std::pow(replay->excess(), 1.0 / integrator::order(problem.scheme));
  return std::clamp(static_cast<int>(std::ceil(std::min<double>(times, most))), least, most);
}

// The effort's weight at which it would be as much as all else that this motion costs.
std::string effort_to_match(const Problem& problem, const Solution& solution) {
  const double smoothed = problem.effort * solution.cost_parts->effort;
  const double weight = (solution.cost - smoothed) / solution.cost_parts->effort;
  return weight > problem.effort && std::isfinite(weight) ? " (" + number(rounded_up(weight)) + ")" : "";
}

// Whether steps may be too long to show what is sought.
bool has_long_steps(const Problem& problem, const Certificate& proof, const Solution& solution) {
  return !far_turn(problem, solution).empty() || too_long_for_stages(problem, proof);
}

// Whether what is paid is mostly work: it is least in impulses, which finer steps only make shorter.
bool mostly_work(const Problem& problem, const Solution& solution) {
  constexpr double mostly = 0.5;
  if (!solution.cost_parts || !(problem.cost_weights.work > 0.0 || problem.cost_weights.transport > 0.0)) return false;
  const double smoothed =
      problem.effort * solution.cost_parts->effort + problem.cost_weights.smoothness * solution.cost_parts->smoothness;
  return smoothed < mostly * solution.cost;
}

}  // namespace

std::string words_on_tolerance(const Problem& problem, const Certificate& proof) {
  if (!(proof.kkt > proof.kkt_allowed(problem.search.tolerance) && proof.kkt <= loosest_tolerance)) return "";
  Problem looser = problem;
  looser.search.tolerance = rounded_up(proof.kkt);
  if (!certificate::stationary(looser, proof)) return "";
  return "[search] tolerance = " + number(rounded_up(proof.kkt)) + " accepts it" +
         (proof.kkt > optimality::proof_mark ? ", unproved" : "");
}

namespace {

// Of a search that ran out of time, which tells little of what is asked.
Remedies advice_out_of_time(const Problem& problem, const Certificate& proof, const Solution& solution) {
  Remedies words{"a longer search.time_limit"};
  const bool weak = proof.limits && proof.limits->key.starts_with("limits.torque") && proof.limits->violation > 1.0;
  if (weak) words.push_back(more_time(problem, proof, solution));
  if (problem.steps > few_steps)
    words.emplace_back("fewer time.steps, whose answer lamprey solve --first begins with on as many as these");
  if (problem.duration.free && !solution.time.empty() &&
      solution.time.back() > problem.duration.max * (1.0 + limit_mark))
    words.emplace_back("a larger time.max");
  if (problem.goal && !(proof.goal_error <= evidence::goal_mark) && asks_beside_place(problem))
    words.emplace_back("first the same with goal.move \"free\", which shows where such motions go by themselves");
  return words;
}

// Where a motion shrank to next to rest, where steps are too long or bodies whirl, where positions have too few digits.
void add_advice_on_motion(const Problem& problem, const Certificate& proof, const Solution& solution, Remedies& words) {
  if (!fading(problem, solution).empty()) {
    const auto& move = problem.goal->move;
    const bool partly = std::any_of(move.begin(), move.end(), [](const auto& along) { return along.has_value(); });
    words.emplace_back(partly ? "a goal.move along all axes, which gives the distance" : "a distance (goal.move)");
  }
  if (too_long_for_stages(problem, proof) && problem.swimmer.compliant())
    words.emplace_back("[integrator] scheme = \"midpoint\" (springs and dampers of light bodies ask for short stages)");
  if (has_long_steps(problem, proof, solution) || problem.steps < fewest_steps)
    words.push_back("[time] steps = " + std::to_string(problem.steps < fewest_steps ? few_steps : 2 * problem.steps));
  if (whirls(problem, solution))
    words.push_back(words_on_calming(problem, solution) + ", which calms bodies that whirl");
  if (problem.cost_weights.of_displacement())
    words.emplace_back("a larger cost.effort and, from that answer on (--first), the one that is asked for");
  if (const std::string nearer = advice_far_away(problem); !nearer.empty()) words.push_back(nearer);
}

// Where limits are broken, or leave too little time.
void add_advice_on_limits(const Problem& problem, const Certificate& proof, const Solution& solution, bool drifts,
                          Remedies& words) {
  const bool broken = proof.limits && !(proof.limits->violation <= limit_mark);
  const bool by_long_steps =
      has_long_steps(problem, proof, solution) && broken && proof.limits->key.starts_with("limits.angular_velocity");
  if (broken && proof.limits->key.starts_with("limits.") && !by_long_steps)
    words.push_back("a looser " + proof.limits->key);
  if (broken && proof.limits->key.starts_with("limits.torque") && proof.limits->violation > other_units)
    words.emplace_back("other units (its N m, lengths' m, the density's kg/m³, the time's s)");
  const std::string hurried = limits_on_haste(problem.limits);
  if (!hurried.empty() && !drifts && near_the_most(problem, solution) && !by_long_steps)
    words.push_back(more_time(problem, proof, solution));
  if (broken && proof.limits->key == "time.max" && !hurried.empty()) words.push_back("a looser " + hurried);
  if (!problem.waypoints.empty()) words.emplace_back("waypoints farther apart in time, or fewer");
  if (!broken || (problem.goal && problem.goal->periodic)) return;
  words.emplace_back(maneuver::has_momentum(model::System(problem.swimmer), problem.start)
                         ? "a share of the way"
                         : "a share of the way (what takes many strokes is a gait, goal.periodic, repeated)");
}

}  // namespace

Remedies advice(const Problem& problem, const Certificate& proof, const Solution& solution) {
  if (problem.search.method == maneuver::SearchMethod::shooting) return {"method = \"simultaneous\""};
  const bool resolved = unmet(problem, proof).empty() && fading(problem, solution).empty();
  if (resolved) return advice_where_met(problem, proof, solution);
  if (solution.status == Status::time_limit) return advice_out_of_time(problem, proof, solution);
  Remedies words;
  add_advice_on_motion(problem, proof, solution, words);
  const std::string drift = advice_on_drift(problem, proof, solution);
  if (!drift.empty()) words.push_back(drift);
  add_advice_on_limits(problem, proof, solution, !drift.empty(), words);
  const bool once = problem.search.starts == 1;
  words.emplace_back(once ? "[search] starts = 8" : "more starts");
  words.emplace_back("another seed");
  words.emplace_back(once ? "a nearer goal" : "a nearer goal; check that control_axes can reach it");
  return words;
}

std::string untried_turns(const model::System& system, const Problem& problem) {
  constexpr int enough_starts = 8, proposed_share = 2;
  const maneuver::Search& search = problem.search;
  const auto& joints = system.joints();
  const bool moved_by_all =
      std::all_of(joints.begin(), joints.end(), [](const auto& joint) { return joint.actuation.cols() > 0; });
  if (search.starts < enough_starts || search.whole_turns > 0 || !search::newton_takes(system, problem)) return "";
  if (!problem.goal || problem.goal->periodic || !moved_by_all || system.control_count() < 2) return "";
  if (guess::joints_that_turn_round(system, problem).empty()) return "";
  if (maneuver::has_momentum(system, problem.start)) return "";  // no first guess of such a start does
  return " No first guess had joints turn all the way round, which can be cheaper: [search] whole_turns = " +
         std::to_string(search.starts / proposed_share) + " has that many of the " + std::to_string(search.starts) +
         " first guesses begin with such turns.";
}

std::string on_smoothness(const Problem& problem) {
  return problem.cost_weights.smoothness > 0.0 ? "or on cost.smoothness" : "or one on cost.smoothness";
}

std::string unseen_work(const Problem& problem, const Certificate& proof, const Solution& solution) {
  const auto& parts = solution.cost_parts;
  const auto& replay = proof.replay;
  if (!parts || !replay || !replay->works_otherwise(parts->work)) return "";
  return " By its replay the joints do " + number(replay->work, 4) + " J of work, by the nodes that the cost counts " +
         number(parts->work, 4) +
         " J: moments change faster than these steps show, and costs of work, power and transport are not what they "
         "seem. More weight on cost.effort, " +
         on_smoothness(problem) + ", makes moments smoother.";
}

std::optional<int> steps_to_resolve(const Problem& problem, const Certificate& proof, const Solution& solution) {
  if (solution.status != Status::optimal || unresolved(problem, solution, proof).empty()) return std::nullopt;
  const double steps = static_cast<double>(problem.steps) * more_steps(problem, proof);
  return steps <= most_steps_proposed ? std::optional(static_cast<int>(steps)) : std::nullopt;
}

std::string advice_on_steps(const Problem& problem, const Certificate& proof, const Solution& solution,
                            bool resolving) {
  std::string missed = unresolved(problem, solution, proof);
  const auto& replay = proof.replay;
  const bool lost = replay && replay->feedback_rotation_error > certificate::feedback_mark;
  if (missed.empty() && lost && problem.limits.of_moments())
    return " Its feedback, held to the limits of torque, ends " + number(replay->feedback_rotation_error) +
           " rad beside it: a plan with smaller limits leaves motors a reserve.";
  if (missed.empty() && lost)
    missed = "its replay with feedback ends " + number(replay->feedback_rotation_error) + " rad beside it";
  if (missed.empty()) return "";
  const std::string mend = "try [time] steps = " + std::to_string(problem.steps * more_steps(problem, proof)) +
                           " or more" + (resolving ? "" : " (lamprey solve --resolve goes on to them by itself)");
  return " These steps do not resolve the motion: " + missed + "; " +
         (mostly_work(problem, solution) && unseen_work(problem, proof, solution).empty()
              ? "work is least in impulses, which finer steps only make shorter: more weight on cost.effort" +
                    effort_to_match(problem, solution) + ", " + on_smoothness(problem) +
                    ", makes moments smoother; or " + mend
              : mend) +
         (!replay || std::isnan(replay->servo_rotation_error)
              ? "."
              : ". Servos that lead the joints along its angles end " + number(replay->servo_rotation_error) +
                    " rad and " + number(replay->servo_position_error) + " m beside the goal" +
                    (problem.limits.of_moments() ? ", by whatever moments that takes." : "."));
}

}  // namespace lamprey::study
