// Ways to find a maneuver: Lamprey's own Newton method along the stages, or Ipopt on the full transcription.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "optimizer/stage_newton.hpp"
#include "search/budget.hpp"
#include "search/found.hpp"
#include "search/solve.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::search {

class Method {
 public:
  virtual ~Method() = default;
  virtual std::string name() const = 0;
  /// Why no motion meets the goal, where moments' reach shows it; else empty.
  virtual std::string out_of_reach() const = 0;
  /// Solves starts first … first + count − 1 on a coarse grid.
  virtual std::vector<Found> solve_starts(int first, int count) = 0;
  /// Whether there are first guesses of many strokes for the problem, such as parts of the way done several times: the more limits the
  /// fewer single strokes serve.
  virtual bool has_strokes() const { return false; }
  /// Solves from them; nothing where there are none.
  virtual std::vector<Found> solve_strokes() { return {}; }
  /// Where a gait is known that wins what a displacement is worth: solves from gaits of several cycles, more and more of them as long
  /// as more cost less than fewer.
  virtual std::vector<Found> solve_more_cycles() { return {}; }
  /// Solves again from perturbed copies of a motion on the coarse grid, hops first … first + count − 1.
  /// Nothing of methods without hops.
  virtual std::vector<Found> hop(const Found& /*from*/, int /*first*/, int /*count*/) { return {}; }
  /// The motion that the search was given to begin with, as it is, where it has all steps; nothing where it has not.
  virtual std::optional<Found> as_begun() const { return std::nullopt; }
  /// Carries motions on to full resolution.
  virtual std::vector<Found> refine(const std::vector<const Found*>& coarse) = 0;
  /// Carries a motion on to another number of steps.
  virtual Found carry(const Found& from, int steps) = 0;
  /// Whether that takes less than the search.
  virtual bool carries_cheaply() const = 0;
};

/// Steps of the grid on which starts are told apart: enough to tell minima apart, few enough to be quick.
inline constexpr int coarse_steps = 100;

/// Seeds of a start's first guess and of a hop.
std::uint64_t seed_of_start(const maneuver::Problem& problem, int start);
std::uint64_t seed_of_hop(const maneuver::Problem& problem, int hop);

/// Whether the Newton method can take the problem: moments free at each node; with total momentum no periodic goal;
/// above order 2 neither momentum, limits, waypoints, a periodic goal, a free duration nor costs beside effort and time.
bool newton_takes(const model::System& system, const maneuver::Problem& problem);

/// Whether the transcription for Ipopt can: schemes `trapezoid` and `paper`, no coupled inertia, with universal joints no costs beside
/// effort and time, and no joints that end at rest on a whole that drifts.
bool ipopt_takes(const model::System& system, const maneuver::Problem& problem);

std::unique_ptr<Method> newton_method(const model::System& system, const maneuver::Problem& problem,
                                      const SolveOptions& options, const Budget& budget);
std::unique_ptr<Method> ipopt_method(const model::System& system, const maneuver::Problem& problem,
                                     const SolveOptions& options, const Budget& budget);

/// The one that is asked for, or the first that takes the problem. Throws model::InputError where none does.
std::unique_ptr<Method> choose_method(const model::System& system, const maneuver::Problem& problem,
                                      const SolveOptions& options, const Budget& budget);

}  // namespace lamprey::search
