// A problem's maneuvers on grids of any number of steps: solved by Newton's method on shapes from a path, and carried from one
// grid to another.
#pragma once

#include <functional>
#include <vector>

#include "search/method.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::search {

/// Grids of fewer than `coarse_steps` only prepare finer ones; where one is asked for, its answer's message names far turns.
shape::Steps steps_for(int steps);

/// In which coordinates a problem's maneuvers move, and which of the goal's conditions these can meet independently, at the
/// first of a few first guesses that is a motion; all coordinates and conditions where none is.
struct Reached {
  maneuver::ShapeCoordinates coordinates;
  std::vector<maneuver::EndRow> rows;
  std::string out_of_reach;  // why no motion meets the goal; empty where none shows
  Reached(const model::System& system, const maneuver::Problem& asked);
};

/// A program and its solver at one resolution.
struct Grid {
  maneuver::Maneuver maneuver;
  shape::ShapeProgram program;
  optimizer::StageNewton newton;
  Grid(const model::System& system, const maneuver::Problem& problem, int steps, const Reached& reached,
       const std::vector<maneuver::LimitRow>& limits);
};

/// Of a solve on a grid, before a last Newton step.
inline constexpr double fine_tolerance = 1e-7;

/// Newton's method from the program's point on, to the tolerance of a last Newton step; where limits count as met a hundredth of
/// it, for such a step is no good where limits begin to hold. The reason of an outcome that did not converge says what is
/// missed most.
void solve_program(optimizer::StageNewton& newton, shape::ShapeProgram& program, optimizer::Options options,
                   optimizer::Outcome& outcome);

/// Steps of a path.
int steps_of(const maneuver::NodePath& path);

class Grids {
 public:
  /// All of these must outlive it.
  Grids(const model::System& system, const maneuver::Problem& problem, const SolveOptions& options,
        const Budget& budget);

  const model::System& system() const { return system_; }
  /// What is sought, and what is solved on the coarse grids: above order 2 the same by the trapezoid.
  const maneuver::Problem& asked() const { return asked_; }
  const maneuver::Problem& problem() const { return problem_; }
  const SolveOptions& options() const { return options_; }
  const Budget& budget() const { return budget_; }
  const Reached& reached() const { return reached_; }
  /// Whether some coordinates are moved by no moment.
  bool passive() const { return reached_.coordinates.shape.cols() > system_.control_count(); }
  bool limited() const { return !limits_.empty(); }
  /// Whether the scheme asked for is above order 2, each of its steps a row of steps.
  bool composed() const;

  /// The same of a problem that differs in what is held.
  Grids with(const maneuver::Problem& problem) const;

  Grid grid(int steps) const;
  /// Of a problem that differs in what is held.
  Grid grid(const maneuver::Problem& problem, int steps) const;
  /// Steps of the grid on which starts are told apart.
  int coarse() const;
  /// From a coarse grid first to twice as many steps: what it foretold wrongly is cheaper to mend there.
  int finer_than(int steps) const;

  /// How far to go at a tolerance on this grid.
  optimizer::Options within(double tolerance) const;

  /// Solves from a path, and from what `found` has of multipliers and duration; its effort and history go on.
  void solve(Grid& grid, const maneuver::NodePath& from, double tolerance, Found& found) const;
  void solve(Grid& grid, const maneuver::NodePath& from, const optimizer::Options& within, Found& found) const;

  /// A motion as it is, with what `found` has of multipliers. Returns false where it is none.
  bool hold(Grid& grid, const maneuver::NodePath& motion, Found& found) const;

  /// A solution carried to a grid of so many steps and solved there.
  Found carry_on(const Found& from, int steps, double tolerance) const;
  Found carry_on(const Found& from, int steps, const optimizer::Options& within) const;
  Found carry_on_composed(const Found& from, int steps) const;
  /// And through finer and finer grids to the steps asked for.
  Found refine(const Found& coarse) const;

  /// Tasks 0 … count − 1, each by itself, so that results do not depend on the number of threads; told of by name if any.
  /// Results of those that began before the search had to stop; of the first always.
  std::vector<Found> in_threads(int count, const char* what, const std::function<Found(int)>& task) const;

 private:
  bool begin(Grid& grid, const maneuver::NodePath& from, Found& found) const;
  void read(const Grid& grid, Found& found) const;
  maneuver::NodePath on_grid(const Found& from, int steps) const;
  void add_coarser(Found& found) const;
  Found refine_composed(const Found& coarse) const;

  const model::System& system_;
  const maneuver::Problem& asked_;
  maneuver::Problem problem_;
  const SolveOptions& options_;
  const Budget& budget_;
  Reached reached_;
  std::vector<maneuver::LimitRow> limits_;
};

/// Of a search that has no motion to begin with.
void fail_for_want_of_motion(optimizer::Outcome& outcome);

/// Counts and history of another try, which went on from those of `found` and did not arrive.
void take_effort(const Found& tried, Found& found);

}  // namespace lamprey::search
