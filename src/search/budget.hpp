// What time a search has, and who may end it.
#pragma once

#include <atomic>
#include <chrono>

#include "optimizer/outcome.hpp"
#include "search/solve.hpp"

namespace lamprey::search {

/// Of the time limit: how long the best motion is refined and proved at most.
inline constexpr double late_share = 1.5;

/// When to stop, whoever asks. First guesses and hops end while there is time left to refine the best of them; that one refinement goes
/// on for a while where it is late or the search is interrupted, since a coarse motion is no answer.
class Budget {
 public:
  enum class Stage { guessing_before_strokes, guessing, hopping, refining_the_best, finishing };
  Budget(const maneuver::Problem& problem, const SolveOptions& options);
  /// Of a search that is a part of another, on the way to whose motions its own are: it ends when that one's stage does, if not sooner.
  Budget(const maneuver::Problem& problem, const SolveOptions& options, const Budget& whole);
  void enter(Stage stage) { stage_ = stage; }
  /// A first guess became a maneuver.
  void arrived() const { any_arrived_ = true; }
  /// Whether nothing begins any more.
  bool closing() const;
  /// Whether what runs ends.
  bool stopped() const;
  /// Whether someone ends it, or so many times the time limit is over.
  bool past(double share) const;
  /// Whether someone, rather than the time, ends it. While it searches it says so, once.
  bool interrupted() const;
  /// Whether that someone wants it to end at once.
  bool hurried() const { return options_.hurried && options_.hurried(); }
  /// Of a search that found no motion before it had tried all that was asked for: what ended it, in the place of `stalled`.
  void tell_what_ended(optimizer::Outcome& outcome) const;
  /// Options of a solve within what is left of the time.
  optimizer::Options optimizer_options(int max_iterations, double tolerance) const;
  double seconds() const;
  /// Of all threads and of worker processes that have ended.
  double processor_seconds() const;

 private:
  double end_of_time() const;  // s, of the stage
  bool own_time_is_over() const;
  bool goes_on_late() const;
  void tell_of_interruption() const;
  bool strokes_wait() const;

  const maneuver::Problem& problem_;
  const SolveOptions& options_;
  const Budget* whole_ = nullptr;
  Stage stage_ = Stage::finishing;
  mutable std::atomic<bool> any_arrived_ = false;
  mutable std::atomic<double> interrupted_at_ = -1.0;  // s, when that was first seen; negative: not yet
  mutable std::atomic<bool> told_ = false;             // of an interruption
  int process_;                                        // that tells; workers do not
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  double processor_begin_;
};

}  // namespace lamprey::search
