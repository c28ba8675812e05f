#include "search/solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <sstream>
#include <tuple>

#include "guess/guess.hpp"
#include "guess/mirror.hpp"
#include "optimizer/ipopt.hpp"
#include "search/drifting.hpp"
#include "search/method.hpp"
#include "search/minima.hpp"
#include "transcription/goal_rank.hpp"
#include "transcription/shooting.hpp"

namespace lamprey::search {

namespace {

using maneuver::Maneuver;
using maneuver::NodePath;
using maneuver::Problem;
using maneuver::Solution;
using model::System;
using optimizer::Outcome;

constexpr std::size_t batch = 2;  // refined side by side; fixed, so that the answer does not depend on the machine
constexpr std::size_t spare_candidates = 4;
constexpr std::size_t refined_candidates =
    16;                     // coarse grids lie about cost: at most so many are compared at full resolution
constexpr int retries = 4;  // further guesses where a single start fails
constexpr int shooting_iterations = 200;
constexpr int hop_round = 8;         // hops from one minimum; fixed, so that the answer does not depend on the machine
constexpr int confirming_steps = 4;  // times the coarse grid's
constexpr double settled_cost = 0.05;   // relative difference of cost between the two
constexpr double faded = 1e-6;          // displacement over the swimmer's size: as good as none
constexpr double won_at_least = 1e-14;  // of what the swimmer's size of displacement wins: less is round-off
constexpr const char* at_rest = "at rest";
constexpr const char* without_moments = "without moments";
constexpr int second_guesses = 4;      // of the second solver, where it is tried because the first one found nothing
constexpr int candidates_of_kept = 4;  // for each minimum that is to be kept

class Search {
 public:
  Search(const System& system, const Problem& problem, const SolveOptions& options)
      : system_(system),
        problem_(problem),
        options_(options),
        budget_(problem, options),
        full_(maneuver::make_maneuver(system, problem, problem.steps)),
        method_(choose_method(system, problem, options, budget_)) {
    if (options.solver == Backend::both) add_second(problem.search.starts);
  }

  std::vector<Solution> run() {
    budget_.enter(Budget::Stage::guessing);
    if (stays() || coasts() || cannot()) return solutions_;
    search_starts();
    if (nothing_wins()) return solutions_;
    ended_early_ = budget_.closing();
    budget_.enter(Budget::Stage::hopping);
    hop();
    ended_early_ = ended_early_ || budget_.closing();
    count_minima();
    choose_candidates();
    budget_.enter(Budget::Stage::refining_the_best);
    refine_candidates();
    add_first_motion();
    for (Solution& solution : solutions_) {
      solution.search = record_;
      solution.solver.iterations = iterations_;
      solution.solver.evaluations = evaluations_;
    }
    return solutions_;
  }

  const std::string& out_of_reach() const { return out_of_reach_; }

  // Of what was asked for, where the search had to end before.
  std::string unsearched() const {
    std::string words;
    const auto add = [&](int tried, int asked, const char* what) {
      if (tried >= asked) return;
      words += (words.empty() ? "" : ", ") + std::to_string(asked - tried) + " of " + std::to_string(asked) + what;
    };
    if (!ended_early_) return words;
    add(guesses_, problem_.search.starts + asked_of_second_,
        second_ ? " first guesses of two solvers" : " first guesses");
    add(static_cast<int>(starts_.size()) - first_hop_, problem_.search.hops, " hops");
    return words;
  }

  bool refines() const { return options_.refinement.value_or(method_->carries_cheaply()); }

  std::optional<double> cost_on_grid(std::size_t candidate, int steps) const {
    if (candidate >= found_.size() || budget_.stopped() || !out_of_reach_.empty()) return std::nullopt;
    if (rests_ == candidate) return found_[candidate].cost;
    const Found carried = method_->carry(found_[candidate], steps);
    return carried.converged() && reaches_goal(system_, problem_, carried.path) ? std::optional(carried.cost)
                                                                                : std::nullopt;
  }

 private:
  void count_effort(const Outcome& outcome) {
    iterations_ += outcome.iterations;
    evaluations_ += outcome.evaluations;
  }

  // Nothing costs less than to stay where the goal is: an answer without a search, where it is accepted.
  bool stays() { return guess::met_by_rest(system_, problem_, full_) && rest("the goal is where the swimmer rests"); }

  bool coasts() {
    const std::optional<Found> coast = coasting_to_goal(system_, problem_, full_, [this] { return budget_.stopped(); });
    return coast && offer(*coast, without_moments, " It does nothing: " + coast->outcome.reason + ".");
  }

  // Where a displacement wins less than it costs, searches fade away towards rest.
  bool nothing_wins() {
    if (!problem_.cost_weights.of_displacement() || budget_.stopped()) return false;
    if (!guess::rest_meets_goal(system_, problem_, full_)) return false;
    bool tried = false;
    for (const Found& found : starts_) {
      if (found.path.position.empty()) continue;
      tried = true;
      const double way = (found.path.position.back() - found.path.position.front()).norm();
      if (way > faded * system_.size() || (found.converged() && wins(found))) return false;
    }
    return tried &&
           rest(
               "every motion that was tried costs more than its displacement wins, as cost.displacement has it: a "
               "larger one may move");
  }

  // Whether a motion costs less than to stay, if only a little where limits keep it small.
  bool wins(const Found& found) const {
    const double most = problem_.cost_weights.displacement.norm() * system_.size();
    return found.cost - problem_.cost_of_given_duration() < -won_at_least * most;
  }

  // What moments cannot do needs no search.
  bool cannot() {
    out_of_reach_ = method_->out_of_reach();
    if (out_of_reach_.empty()) return false;
    Outcome outcome;
    outcome.termination = optimizer::Termination::infeasible;
    outcome.reason = out_of_reach_;
    outcome.infeasibility = 0.0;
    add_rest(outcome);
    return true;
  }

  bool rest(const char* reason) {
    return offer(staying(system_, problem_, full_, reason), at_rest,
                 std::string(" It stays where it is: ") + reason + ".");
  }

  // An answer without a search, where it is accepted.
  bool offer(const Found& answer, const char* by, const std::string& message) {
    add_unsought(answer, by);
    if (options_.accept && !options_.accept(solutions_.back())) return false;
    rests_ = found_.size() - 1;
    solutions_.back().message += message;
    return true;
  }

  // A start in motion does not stay: what it does without moments is shown.
  void add_rest(const Outcome& outcome) {
    const std::optional<Found> coast = coasting(system_, problem_, full_, [this] { return budget_.hurried(); });
    Found shown = coast ? *coast : staying(system_, problem_, full_, outcome.reason);
    shown.outcome = outcome;
    add_unsought(shown, coast ? without_moments : at_rest);
  }

  void add_unsought(const Found& still, const char* by) {
    Solution solution =
        search::describe(system_, full_, problem_.scheme, maneuver::limit_rows(system_, problem_), still);
    solution.solver.name = by;
    solution.solver.wall_seconds = budget_.seconds();
    solution.solver.processor_seconds = budget_.processor_seconds();
    solution.solver.iterations = iterations_;
    solution.solver.evaluations = evaluations_;
    add_solution(still, solution);
  }

  void add_solution(const Found& found, const Solution& solution) {
    found_.push_back(found);
    solutions_.push_back(solution);
  }

  // Every start on the coarse grid, by one solver or by both; a single start that fails is followed by others. Where none has
  // arrived, strokes are tried, when half of the time is over before the starts that are left.
  void search_starts() {
    if (method_->has_strokes()) budget_.enter(Budget::Stage::guessing_before_strokes);
    starts_ = method_->solve_starts(0, problem_.search.starts);
    const int begun = static_cast<int>(starts_.size()), left = problem_.search.starts - begun;
    if (second_ && !budget_.stopped()) search_by_second();
    for (int more = 0; more < retries && problem_.search.starts == 1 && !second_ && !options_.first_alone &&
                       !starts_.back().converged() && !budget_.closing();
         ++more)
      append(method_->solve_starts(static_cast<int>(starts_.size()), 1), starts_);
    budget_.enter(Budget::Stage::guessing);
    std::vector<Found> strokes;
    if (!any_converged(starts_) && method_->has_strokes() && !options_.first_alone) strokes = method_->solve_strokes();
    if (any_converged(starts_) && !options_.first_alone && !budget_.closing()) strokes = method_->solve_more_cycles();
    if (left > 0 && !any_converged(starts_) && !any_converged(strokes) && !budget_.closing())
      append(method_->solve_starts(begun, left), starts_);
    if (may_try_second(strokes)) {
      add_second(std::min(problem_.search.starts, second_guesses));
      search_by_second();
    }
    guesses_ = static_cast<int>(starts_.size());
    append(std::move(strokes), starts_);
    for (const Found& start : starts_) count_effort(start.outcome);
    first_hop_ = static_cast<int>(starts_.size());
  }

  void add_second(int guesses) {
    second_ = ipopt_method(system_, problem_, options_, budget_);
    asked_of_second_ = guesses;
  }

  void search_by_second() {
    for (Found& found : second_->solve_starts(0, asked_of_second_)) {
      found.by_second = true;
      starts_.push_back(std::move(found));
    }
  }

  // From a start with momentum there are no strokes to try; motions that may leave mechanics on the way get past some obstacles.
  bool may_try_second(const std::vector<Found>& strokes) const {
    return options_.solver == Backend::automatic && maneuver::has_momentum(system_, problem_.start) &&
           newton_takes(system_, problem_) && ipopt_takes(system_, problem_) && !any_converged(starts_) &&
           !any_converged(strokes) && !options_.first_alone && !budget_.closing();
  }

  // Basin hopping (chapter 9): rounds of perturbed copies of the cheapest minimum that a finer grid confirms.
  void hop() {
    if (problem_.search.hops == 0) return;
    std::optional<std::size_t> base = cheapest_confirmed();
    for (int first = 0; first < problem_.search.hops && base && !budget_.stopped(); first += hop_round) {
      const std::vector<Found> hops =
          method_->hop(starts_[*base], first, std::min(hop_round, problem_.search.hops - first));
      for (const Found& found : hops) count_effort(found.outcome);
      starts_.insert(starts_.end(), hops.begin(), hops.end());
      base = cheapest_confirmed();
      if (!base || !options_.progress) continue;
      std::ostringstream text;
      text << "best after " << first + static_cast<int>(hops.size()) << " hops: cost " << starts_[*base].cost;
      options_.progress(text.str());
    }
  }

  // Coarse grids lie: the cheapest solution whose cost is much the same with four times the steps, or the cheapest where
  // there is none such.
  std::optional<std::size_t> cheapest_confirmed() {
    confirmed_.resize(starts_.size());
    const std::vector<std::size_t> order = by_rising_cost();
    for (std::size_t s : order) {
      if (!starts_[s].converged()) break;
      if (!confirmed_[s]) {
        const int steps = confirming_steps * static_cast<int>(starts_[s].path.rotation.size() - 1);
        const Found fine = method_->carry(starts_[s], steps);
        count_effort(fine.outcome);
        confirmed_[s] =
            fine.converged() && std::abs(fine.cost - starts_[s].cost) <
                                    settled_cost * std::abs(starts_[s].cost - problem_.cost_of_given_duration());
      }
      if (*confirmed_[s]) return s;
    }
    return starts_[order.front()].converged() ? std::optional(order.front()) : std::nullopt;
  }

  std::vector<std::size_t> by_rising_cost() const {
    std::vector<std::size_t> order(starts_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    // solved ones by cost, then others by how near they came, last those without a motion
    const auto rank = [this](std::size_t s) {
      const Found& found = starts_[s];
      const bool keeps = found.converged() || found.outcome.termination == optimizer::Termination::feasible;
      const double missed = keeps ? 0.0 : found.outcome.infeasibility;
      return std::tuple(found.path.rotation.empty(), !found.converged(), std::isnan(missed), missed,
                        std::isnan(found.cost), found.cost);
    };
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rank(a) < rank(b); });
    return order;
  }

  Minimum minimum(const Found& found) const { return minimum_of(system_, problem_, found.cost, found.path.rotation); }

  // Distinct costs; the first start that ended at each is a candidate.
  void count_minima() {
    const std::vector<std::size_t> order = by_rising_cost();
    std::vector<Minimum> known;
    record_.starts = first_hop_;
    record_.strokes = first_hop_ - guesses_;
    record_.hops = static_cast<int>(starts_.size()) - first_hop_;
    for (std::size_t s : order) {
      if (!starts_[s].converged()) continue;
      const Minimum own = minimum(starts_[s]);
      ++record_.solved;
      const auto same =
          std::find_if(known.begin(), known.end(), [&](const Minimum& other) { return same_minimum(other, own); });
      const auto place = static_cast<std::size_t>(same - known.begin());
      if (place == known.size()) {
        known.push_back(own);
        record_.minima.push_back({own.cost, 0});
        if (second_) record_.minima.back().by_ipopt = 0;
        candidates_.push_back(s);
      }
      ++record_.minima[place].count;
      if (starts_[s].by_second) ++*record_.minima[place].by_ipopt;
    }
  }

  // As many minima as are worth all steps; should all of these fail, starts that did not arrive may on more steps.
  void choose_candidates() {
    const std::vector<std::size_t> order = by_rising_cost();
    if (candidates_.empty()) candidates_.push_back(order.front());
    const std::size_t most =
        std::max(refined_candidates, static_cast<std::size_t>(candidates_of_kept * problem_.search.keep));
    if (candidates_.size() > most) candidates_.resize(most);
    firsts_ = candidates_.size();
    for (std::size_t s : order) {
      const bool arrives_nowhere =
          starts_[s].path.rotation.empty() || starts_[s].outcome.termination == optimizer::Termination::infeasible;
      if (candidates_.size() == firsts_ + spare_candidates) break;
      if (!starts_[s].converged() && !arrives_nowhere && s != candidates_.front()) candidates_.push_back(s);
    }
  }

  // Adds a candidate; where it arrived, but less near to stationary than is asked, once more from there on. Returns whether it is
  // accepted.
  bool take_candidate(const Found& fine) {
    const auto add = [&](const Found& found) {
      add_solution(found, describe(found));
      return options_.accept && options_.accept(solutions_.back());
    };
    if (add(fine)) return true;
    if (solutions_.back().status != maneuver::Status::feasible || !fine.converged() || budget_.stopped()) return false;
    const Found again = method_->carry(fine, full_.steps);
    count_effort(again.outcome);
    return again.converged() && same_minimum(minimum(again), minimum(fine)) && add(again);
  }

  // Candidates at full resolution, where costs can be compared, two at a time by rising coarse cost, until as many accepted ones as
  // are to be kept cost less than those still waiting; then spare ones, until one is accepted.
  void refine_candidates() {
    DistinctMinima accepted;
    double arrived_cost = std::numeric_limits<double>::infinity();
    for (std::size_t first = 0, end = 0; first < candidates_.size(); first = end) {
      const bool spare = first >= firsts_;
      const double cheapest = spare ? std::numeric_limits<double>::max() : starts_[candidates_[first]].cost;
      if (first > 0 && (budget_.stopped() || accepted.below(cheapest) >= (spare ? 1 : problem_.search.keep))) break;
      end = std::min(first + batch, spare ? candidates_.size() : firsts_);
      std::vector<const Found*> coarse;
      for (std::size_t c = first; c < end; ++c) coarse.push_back(&starts_[candidates_[c]]);
      const std::vector<Found> refined = method_->refine(coarse);
      budget_.enter(Budget::Stage::finishing);
      for (const Found& fine : refined) {
        count_effort(fine.outcome);
        if (fine.path.rotation.empty()) continue;
        if (take_candidate(fine))
          accepted.add(minimum_of(system_, problem_, solutions_.back().cost, solutions_.back().rotation));
        if (solutions_.back().status == maneuver::Status::optimal)
          arrived_cost = std::min(arrived_cost, solutions_.back().cost);
      }
    }
    if (record_.solved == 0 && std::isfinite(arrived_cost)) {  // a start that arrived on all steps alone
      record_.solved = 1;
      record_.minima.push_back({arrived_cost, 1});
      if (second_) record_.minima.back().by_ipopt = 0;
    }
    if (!solutions_.empty())
      return;  // otherwise no motion was found: what happens without moments, so that there is something to look at
    Outcome outcome = starts_.front().outcome;
    if (ended_early_) budget_.tell_what_ended(outcome);
    outcome.reason += "; what is shown has no moments";
    add_rest(outcome);
    if (options_.accept) options_.accept(solutions_.back());
  }

  // What the search was given to begin with may keep more of what is asked than what it came to.
  void add_first_motion() {
    for (const Solution& solution : solutions_)
      if (solution.status == maneuver::Status::optimal) return;
    const std::optional<Found> begun = method_->as_begun();
    if (!begun) return;
    add_solution(*begun, describe(*begun));
    if (options_.accept) options_.accept(solutions_.back());
  }

  // By single shooting from there on, where the problem asks for it.
  Found shot(Found found) {
    if (problem_.search.method != maneuver::SearchMethod::shooting) return found;
    const Maneuver probe = maneuver::make_maneuver(system_, problem_, std::min(problem_.steps, 20));
    transcription::Shooting program(
        system_, full_,
        transcription::independent_goal_rows(system_, probe,
                                             guess::random_guess(system_, probe, seed_of_start(problem_, 0))));
    found.outcome = optimizer::solve_with_ipopt(
        program, budget_.optimizer_options(shooting_iterations, std::min(1e-9, 0.1 * problem_.search.tolerance)),
        program.pack(found.path));
    NodePath path = program.unpack(found.outcome.point);
    if (static_cast<int>(path.rotation.size()) <= full_.steps)  // its moments lead to no motion
      found.outcome.reason += "; shown is the motion that single shooting began at";
    else
      found.path = std::move(path);
    count_effort(found.outcome);
    return found;
  }

  // As a solution.
  Solution describe(const Found& found) {
    const bool shooting = problem_.search.method == maneuver::SearchMethod::shooting;
    Found shown = shot(found);
    shown.path = turned_as_asked(shown.path);
    if (shown.outcome.termination == optimizer::Termination::infeasible &&
        guess::rest_meets_goal(system_, problem_, full_)) {
      shown.outcome.termination = optimizer::Termination::stalled;
      shown.outcome.reason = "limits are still broken where it ended, which does not show that no motion keeps them";
    }
    Solution solution =
        search::describe(system_, full_, problem_.scheme, maneuver::limit_rows(system_, problem_), shown);
    solution.solver.name = method_->name() + (shooting ? ", single shooting" : "");
    solution.solver.wall_seconds = budget_.seconds();
    solution.solver.processor_seconds = budget_.processor_seconds();
    for (const optimizer::Iteration& step : shown.outcome.history)
      solution.solver.history.push_back(
          {step.iteration, step.objective, step.goal_error, step.dual_infeasibility, step.step, step.drift});
    return solution;
  }

  // Of two mirror images of equal cost the one that turns as the goal's rotation vector does.
  NodePath turned_as_asked(const NodePath& path) const {
    const auto& turn = problem_.goal->turn;
    const maneuver::Limits& limits = problem_.limits;  // those that know left from right stay as they are
    const bool sided = !limits.spheres.empty() || !limits.half_spaces.empty() || !limits.angle.empty();
    if (sided || !problem_.waypoints.empty()) return path;
    if (!turn || turn->norm() == 0.0 || !guess::turns_against(*turn, path)) return path;
    const std::optional<int> axis = guess::mirror_axis(system_, full_, *turn);
    return axis ? guess::mirrored(system_, path, *axis) : path;
  }

  const System& system_;
  const Problem& problem_;
  const SolveOptions& options_;
  Budget budget_;
  Maneuver full_;
  std::unique_ptr<Method> method_;
  std::unique_ptr<Method> second_;              // where two solvers search
  std::vector<Found> starts_;                   // then hops
  int guesses_ = 0;                             // first guesses among them; strokes follow
  int asked_of_second_ = 0;                     // first guesses
  int first_hop_ = 0;                           // where hops begin
  std::vector<std::optional<bool>> confirmed_;  // [starts] by a finer grid
  std::vector<std::size_t> candidates_;         // starts to refine, by rising cost; spare ones after
  std::size_t firsts_ = 0;                      // of them, but spare ones
  maneuver::SearchRecord record_;
  std::vector<Solution> solutions_;
  std::vector<Found> found_;          // of the solutions
  std::string out_of_reach_;          // why nothing meets the goal, where that shows without a search
  bool ended_early_ = false;          // by time or interruption
  std::optional<std::size_t> rests_;  // of these the one that does nothing to get to the goal, where it is accepted
  int iterations_ = 0;
  int evaluations_ = 0;
};

}  // namespace

std::uint64_t seed_of_start(const Problem& problem, int start) {
  return problem.search.seed * 0x100000001B3ULL + static_cast<std::uint64_t>(start);
}

std::uint64_t seed_of_hop(const Problem& problem, int hop) {
  return ~problem.search.seed * 0x100000001B3ULL + static_cast<std::uint64_t>(hop);
}

std::vector<Solution> solve(const System& system, const Problem& problem, const SolveOptions& options) {
  return Search(system, problem, options).run();
}

Candidates find_candidates(const System& system, const Problem& problem, const SolveOptions& options) {
  const auto search = std::make_shared<Search>(system, problem, options);
  Candidates candidates{search->run(), {}, search->out_of_reach(), search->unsearched()};
  if (search->refines())
    candidates.cost_on_grid = [search](std::size_t candidate, int steps) {
      return search->cost_on_grid(candidate, steps);
    };
  return candidates;
}

}  // namespace lamprey::search
