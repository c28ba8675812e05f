#include "search/budget.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <limits>
#include <string>

namespace lamprey::search {

namespace {

using maneuver::Problem;

constexpr double searched_share =
    2.0 / 3.0;  // of the time limit, once a first guess has arrived; hops have half of that
// Of the time limit, unless a guess has arrived: after which no guess begins before strokes, and by when those that run end.
constexpr double last_before_strokes = 0.5, end_before_strokes = 0.6;
constexpr double grace = 5.0;  // s, for the best motion after an interruption

// Of this process and of its children that have ended, s.
double processor_time() {
  double seconds = 0.0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(whose, &usage);
    for (const timeval& part : {usage.ru_utime, usage.ru_stime})
      seconds += static_cast<double>(part.tv_sec) + 1e-6 * static_cast<double>(part.tv_usec);
  }
  return seconds;
}

}  // namespace

Budget::Budget(const Problem& problem, const SolveOptions& options)
    : problem_(problem), options_(options), process_(getpid()), processor_begin_(processor_time()) {}

Budget::Budget(const Problem& problem, const SolveOptions& options, const Budget& whole) : Budget(problem, options) {
  whole_ = &whole;
}

double Budget::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

double Budget::processor_seconds() const { return processor_time() - processor_begin_; }

bool Budget::interrupted() const {
  if (!options_.interrupted || !options_.interrupted()) return false;
  double not_yet = -1.0;
  interrupted_at_.compare_exchange_strong(not_yet, seconds());
  tell_of_interruption();
  return true;
}

void Budget::tell_of_interruption() const {
  if (stage_ == Stage::finishing || !options_.progress || getpid() != process_ || told_.exchange(true)) return;
  if (hurried())
    options_.progress("interrupted twice: what there is is written as it is; once more, and nothing is");
  else if (any_arrived_)
    options_.progress("interrupted: the best motion is refined for " + std::to_string(static_cast<int>(grace)) +
                      " s at most, certified and written; interrupt again and it is not refined");
  else
    options_.progress("interrupted: what there is is certified and written");
}

double Budget::end_of_time() const {
  if (!problem_.search.time_limit) return std::numeric_limits<double>::infinity();
  const bool guessing = stage_ == Stage::guessing || stage_ == Stage::guessing_before_strokes;
  if ((guessing || stage_ == Stage::hopping) && any_arrived_)
    return (guessing && problem_.search.hops > 0 ? 0.5 : 1.0) * searched_share * *problem_.search.time_limit;
  return (strokes_wait() ? end_before_strokes : 1.0) * *problem_.search.time_limit;
}

bool Budget::strokes_wait() const { return stage_ == Stage::guessing_before_strokes && !any_arrived_; }

bool Budget::past(double share) const {
  return interrupted() || (problem_.search.time_limit && seconds() > share * *problem_.search.time_limit);
}

bool Budget::goes_on_late() const { return stage_ == Stage::refining_the_best && any_arrived_; }

bool Budget::closing() const {
  return (whole_ && whole_->closing()) || interrupted() || seconds() > end_of_time() ||
         (strokes_wait() && past(last_before_strokes));
}

bool Budget::stopped() const { return (whole_ && whole_->stopped()) || own_time_is_over(); }

bool Budget::own_time_is_over() const {
  if (!interrupted() && seconds() <= end_of_time()) return false;
  if (!goes_on_late() || hurried()) return true;
  return seconds() > late_share * end_of_time() || (interrupted() && seconds() > interrupted_at_ + grace);
}

void Budget::tell_what_ended(optimizer::Outcome& outcome) const {
  if (outcome.termination != optimizer::Termination::stalled) return;
  outcome.termination = interrupted() ? optimizer::Termination::interrupted : optimizer::Termination::time_limit;
  outcome.reason =
      std::string(interrupted() ? "it was interrupted" : "the time limit was reached") + " before a motion was found";
}

optimizer::Options Budget::optimizer_options(int max_iterations, double tolerance) const {
  optimizer::Options options;
  options.tolerance = tolerance;
  options.max_iterations = max_iterations;
  options.interrupted = [this] { return interrupted() && stopped(); };
  options.out_of_time = [this] { return stopped(); };  // of the stage, and sooner once a first guess arrives
  return options;
}

}  // namespace lamprey::search
