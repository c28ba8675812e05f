// Solver: one maneuver solved again and again as its goal, its start or the time left move, each time from the last answer on
// (chapter 9). What a vehicle runs that plans while it swims.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "search/grids.hpp"

namespace lamprey::search {

/// Owns its workspace. Takes what Lamprey's own Newton method takes (see newton_takes) with schemes of order 1 and 2: limits,
/// waypoints, free durations, periodic goals and all costs. The number of steps stays what it was. Not for two threads at
/// once.
class Solver {
 public:
  /// Begins at a solution of the problem: the swimmer's own or one read from a file, or one of a problem like it. `system` must
  /// outlive the solver. Throws model::InputError where the problem is not one that it takes or the solution has other nodes or
  /// bodies.
  Solver(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution);

  /// Another goal, seen from the problem's own start. Throws model::InputError where it contradicts mechanics, breaks a limit or asks
  /// for what the first goal did not: rows stay what they were, only their values move.
  void set_goal(const maneuver::Goal& goal);

  /// Another start; the goal stays where it is in the world. The motion's shapes follow it, less and
  /// less towards the end. Joints seen beyond a limit of angle, swing or twist begin at it, still. Throws model::InputError where
  /// one is by more than 0.1 rad, where bodies are beyond a clearance or a keep-out by more than a hundredth of the swimmer's size, for periodic goals, and where there is
  /// total momentum but the problem's own start has none. Of a swimmer whose moments and momentum keep it in a plane momentum out of
  /// it is left out, as what measurements err by, and refused where it is more than a tenth of the bodies'.
  void set_start(const integrator::State& start);

  /// Another duration in as many steps, s: the time that is left. Moments stretch with it. Throws model::InputError where it is free
  /// or where waypoints are tied to times.
  void set_duration(double duration);

  /// Time has passed, s, with the swimmer on the last answer: asks for what is left of it, in as many steps. The start is where the
  /// swimmer is now by that answer (set_start tells where it was seen), the time left is less by so much, bounds of a free
  /// duration are, too; the next search begins at the rest of the answer. Until one arrives, times add up. Throws
  /// model::InputError where nothing is left, for periodic goals and where waypoints are tied to times.
  void advance(double elapsed);

  /// Newton steps from the last answer on. The outcome says whether they arrived; the motion is then that of the new problem,
  /// otherwise the last answer stays, with the start, goal and duration that it has; what is asked for stays too, and where the time
  /// ended a search the next one goes on. Goals that the reduced coordinates cannot meet (out of the plane of a planar maneuver) end
  /// as infeasible; where no way is found from the last answer on, they are stalled, and another search may arrive. Where nothing else is asked than the last answer answers that stays, without a step. Where to stay meets the goal that is the answer, at no cost; a goal farther on is then searched from the last
  /// answer that moves. It allocates no memory unless it fails or stays, once it has begun at an answer or found one. What it returns is written anew by the next call.
  const optimizer::Outcome& solve(const optimizer::Options& options = newton_options());

  /// Stationary to 1e-7 of the cost's gradient before a last Newton step.
  static optimizer::Options newton_options();

  /// The last answer: nodes as a solution has them, its cost by the file's rule, its duration, s.
  const maneuver::NodePath& path() const { return last_.path; }
  double cost() const { return last_.cost; }
  double duration() const { return last_.duration; }
  /// s of the last answer that have passed, by `advance`: 0 from a solve on that arrives.
  double passed() const { return passed_; }
  /// What is asked for.
  const maneuver::Maneuver& maneuver() const { return maneuver_; }
  /// Bounds of a free duration that are asked for, s.
  std::array<double, 2> between() const { return {problem_.duration.min, problem_.duration.max}; }
  /// Whether the last answer is one to what is asked: a solution of another problem is none, and after a request none is until a
  /// solve arrives.
  bool answers() const { return answers_; }
  /// What the last answer answers, ends that moments do not reach by less than 1e-6 (rad, units of length) as they are reached: other
  /// than what is asked for until a solve arrives there.
  const maneuver::Maneuver& answered() const { return answered_; }

  /// Nodes, moments, velocities, momenta and multipliers of the last answer, as solution.json has them.
  maneuver::Solution solution() const;
  /// Gains about the last answer, for a swimmer to follow it until the next one (chapter 11). Throws std::domain_error where
  /// that answer is no motion.
  maneuver::Feedback feedback() const;

 private:
  // Where a search begins.
  struct Beginning {
    maneuver::NodePath path;
    double duration = 0.0;  // s, where it is free
    shape::LimitMultipliers limit_multipliers;
    shape::WorkMultipliers work_multipliers;
    Eigen::VectorXd end_multipliers;
  };

  Solver(const model::System& system, const maneuver::Problem& problem, const maneuver::Solution& solution,
         const Reached& reached);
  Beginning& moved_beginning();
  integrator::State kept_within_limits(const integrator::State& seen) const;
  integrator::State with_takeable_momentum(const integrator::State& start) const;
  mechanics::SpatialMomentum total_of(const integrator::State& state) const;
  std::size_t node_before(double time) const;
  integrator::State start_at(double time) const;
  void require_left(double elapsed) const;
  Beginning rest_of_answer(double passed, const mechanics::Rotations& start) const;
  void shorten(double elapsed);
  void take_duration(double duration);
  bool begin();
  bool go_to(const maneuver::NodePath& path, double duration, const shape::LimitMultipliers& limits,
             const shape::WorkMultipliers& work, const Eigen::VectorXd& ends);
  bool same_motion(const maneuver::NodePath& moved) const;
  bool costs_as_before() const;
  maneuver::NodePath stirred_shapes() const;
  bool still() const;
  bool stays();
  void keep_way();
  void answer_what_is_reached();
  void keep_answer();
  void learn_from_answer();

  const model::System& system_;
  maneuver::Problem problem_;
  maneuver::Maneuver maneuver_, answered_;
  shape::ShapeProgram program_;
  optimizer::StageNewton newton_;
  Found last_;
  std::vector<maneuver::LimitRow> answered_rows_;
  bool answers_ = false;              // whether the last answer is one to what is asked
  double passed_ = 0.0;               // s, since the last answer began
  std::optional<Beginning> led_;      // the last answer led to another start that is asked for
  std::optional<Beginning> stirred_;  // where the last answer is to stay: shapes that move, for searches to begin with
  optimizer::Outcome outcome_;
  bool moved_ = true;  // whether start or time did, or the last answer is none: its motion has to be found again
};

}  // namespace lamprey::search
