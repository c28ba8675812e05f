// The parts of an answer that are found out about a motion once it is there, side by side, while there is time.
#pragma once

#include <mutex>
#include <optional>
#include <set>
#include <string>

#include "search/budget.hpp"
#include "study/answer.hpp"
#include "study/refinement.hpp"

namespace lamprey::study {

/// What an answer consists of beside a motion and its certificate, in the order in which it is told.
enum class Part { other_candidate, replay, minimum, all_axes, feedback, followed_replay, other_grids };

/// Once the search shall stop no part begins any more, but where only the time is over those that take little and that the answer
/// is worth most by: whether it is a minimum, and its feedback. They may run side by side.
class Parts {
 public:
  Parts(const maneuver::Problem& problem, const search::SolveOptions& options)
      : options_(options), budget_(problem, options) {}
  bool stopped() const { return budget_.closing(); }
  double seconds() const { return budget_.seconds(); }
  bool stopped(Part part) const {
    const bool late = part == Part::minimum || part == Part::feedback || part == Part::followed_replay;
    return late ? budget_.past(search::late_share) : stopped();
  }
  bool begins(Part part) {
    if (!stopped(part)) return true;
    leave_out(part);
    return false;
  }
  void leave_out(Part part) {
    const std::scoped_lock lock(mutex_);
    left_out_.insert(part);
  }
  /// Of another answer nothing has been left out yet.
  void begin_another() { left_out_.clear(); }

  /// Says what was left out of the answer; one that was interrupted before it was complete has that status.
  void tell(const std::string& unsearched, Answer& answer);
  void progress(const std::string& line) const {
    if (options_.progress) options_.progress(line);
  }

 private:
  const search::SolveOptions& options_;  // for progress
  search::Budget budget_;
  mutable std::mutex mutex_;
  std::set<Part> left_out_;
};

/// The part of a candidate's certificate that decides whether it is accepted: without what takes long. Its replay, which stiff springs
/// can make long too, goes on for a while where time is up.
certificate::Certificate first_certificate(const model::System& system, const maneuver::Problem& problem,
                                           const maneuver::Solution& solution, int workers, Parts& parts);

/// Gains about an answer, and its replay with them; or why there are none.
struct Followed {
  maneuver::Feedback feedback;
  std::optional<certificate::Replay> replay;
  std::string refused;
};

/// What was found out about an answer; nothing of parts that did not begin.
struct Completion {
  std::optional<certificate::Certificate> curved;  // the answer's, with what second derivatives say
  Followed followed;
  std::optional<certificate::Refinement> refinement;
};

/// Finds out in up to so many threads; with one worker what may take long comes last.
Completion complete(const model::System& system, const maneuver::Problem& problem, const Answer& best,
                    const CostOnGrid& cost_on_grid, int workers, Parts& parts);

}  // namespace lamprey::study
