#include "study/answer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <tuple>

#include "mechanics/continuous.hpp"
#include "search/minima.hpp"
#include "study/advice.hpp"
#include "study/answer_parts.hpp"
#include "study/enough_memory.hpp"
#include "study/faults.hpp"
#include "study/plain_words.hpp"
#include "study/verdict.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Status;

constexpr int few_arrived = 3;    // first guesses for each that arrived, from which on minima may be missing
constexpr double dearer = 1.5;    // times what it cost on the coarse grid, from which on that is said
constexpr int hops_for_each = 4;  // first guess

// Answers in order of worth: proven first, then those that meet what is asked, then motions at all, then by how near they come,
// then resolved, then cheap.
std::tuple<bool, bool, bool, double, bool, double> rank(const Problem& problem, const Answer& answer) {
  const Certificate& proof = answer.certificate;
  return {answer.solution.status != Status::optimal,
          !unmet(problem, proof).empty(),
          !(proof.equation_residual <= proof.equation_allowed()),
          missed_by(problem, proof),
          !unresolved(problem, answer.solution, proof).empty(),
          answer.solution.cost};
}

// What the certificate says of a candidate.
struct Judged {
  Certificate certificate;
  maneuver::Failure failure = {};
};

// A candidate of the search, by its number.
struct Certified {
  std::size_t candidate;
  Answer answer;
};

// Candidates that cost less than the answer, each once, in order of worth.
std::vector<const Answer*> cheaper_ones(const model::System& system, const Problem& problem,
                                        const std::vector<const Certified*>& order, const Solution& best) {
  const auto same = [&](const Solution& one, const Solution& other) {
    return search::same_minimum(search::minimum_of(system, problem, one.cost, one.rotation),
                                search::minimum_of(system, problem, other.cost, other.rotation));
  };
  std::vector<const Answer*> cheaper;
  for (const Certified* one : order) {
    const Solution& is = one->answer.solution;
    if (!(is.cost < best.cost) || same(is, best)) continue;
    const bool told =
        std::any_of(cheaper.begin(), cheaper.end(), [&](const Answer* other) { return same(other->solution, is); });
    if (!told) cheaper.push_back(&one->answer);
  }
  return cheaper;
}

// Whether it would be the answer if its steps resolved it.
bool set_aside(const Problem& problem, const Answer& cheaper) {
  return cheaper.solution.status == Status::optimal &&
         !unresolved(problem, cheaper.solution, cheaper.certificate).empty();
}

// Of those that more steps may resolve the cheapest.
std::optional<maneuver::SetAside> cheapest_set_aside(const Problem& problem,
                                                     const std::vector<const Answer*>& cheaper_ones) {
  for (const Answer* other : cheaper_ones)
    if (set_aside(problem, *other))
      return maneuver::SetAside{other->solution.cost, steps_to_resolve(problem, other->certificate, other->solution)};
  return std::nullopt;
}

// Where a motion is no answer for the digits that its places and attitudes have: what it would keep otherwise.
std::optional<std::string> lost_in_round_off(const Answer& other) {
  constexpr double round_off = 1e-6;  // of the momentum's scale: far below what no motion leaves
  const Certificate& proof = other.certificate;
  const bool obeys = proof.equation_residual <= proof.equation_allowed(), nearly = proof.equation_residual <= round_off;
  if (obeys || !nearly || !(proof.goal_error <= evidence::goal_mark)) return std::nullopt;
  std::string words =
      "its discrete equations are off by " + number(proof.equation_residual) + " of the momentum's scale";
  if (!other.failure.remedies.empty()) words += "; " + other.failure.remedies.front() + " may help";
  return words;
}

std::string in_brackets(const std::string& words) { return words.empty() ? "" : " (" + words + ")"; }

// Why they are not the answer: the cheapest of those that more steps may resolve, and each that is not stationary.
std::string words_of_cheaper_ones(const Problem& problem, const std::vector<const Answer*>& cheaper_ones,
                                  const Solution& best, bool resolving) {
  const auto opening = [](const Answer& other) {
    return " A cheaper motion (cost " + number(other.solution.cost, 6) + ") ";
  };
  std::string words;
  std::vector<const Answer*> coarse;
  for (const Answer* other : cheaper_ones) {
    if (set_aside(problem, *other)) coarse.push_back(other);
    if (other->solution.status == Status::feasible && best.status == Status::optimal &&
        unmet(problem, other->certificate).empty())
      words += opening(*other) + "meets all that is asked, too, but " + unsettled(problem, other->certificate) +
               in_brackets(words_on_tolerance(problem, other->certificate)) + ".";
    const std::optional<std::string> lost = lost_in_round_off(*other);
    if (lost && best.status == Status::optimal) words += opening(*other) + "was set aside: " + *lost + ".";
  }
  if (coarse.empty()) return words;
  const Answer& other = *coarse.front();
  const std::size_t more = coarse.size() - 1;
  words += opening(other) + "was set aside: " + unresolved(problem, other.solution, other.certificate) +
           ", so these steps are too coarse for it" +
           (more > 0 ? ", as for " + std::to_string(more) + (more > 1 ? " others" : " other") : "");
  const std::optional<int> steps = steps_to_resolve(problem, other.certificate, other.solution);
  if (steps && !resolving)
    words += "; on [time] steps = " + std::to_string(*steps) +
             " or more it may be the answer (lamprey solve --resolve goes on to them by itself)";
  return words + ".";
}

// Of the minima those that one search alone ended at: their share in the searches is the chance that the next one finds another.
int met_once(const maneuver::SearchRecord& search) {
  return static_cast<int>(std::count_if(search.minima.begin(), search.minima.end(),
                                        [](const auto& minimum) { return minimum.count == 1; }));
}

// Of a motion that goes on by itself: moments that do no more than a share of its energy, which is all round-off. None costs less.
bool costs_nothing(const Problem& problem, const Solution& solution) {
  constexpr double share = 1e-8;
  if (problem.cost_weights.of_displacement() || solution.time.empty()) return false;
  const model::System system(problem.swimmer);
  const mechanics::Rotations& R = solution.rotation.front();
  const Eigen::VectorXd velocity = mechanics::velocity_of_bodies(system, R, solution.angular_velocity.front(),
                                                                 R[0] * solution.linear_velocity.front());
  const double moments = share * mechanics::kinetic_energy(system, R, velocity);
  return solution.cost <= problem.effort * moments * moments * (solution.time.back() - solution.time.front());
}

std::string few_arrivals(const Solution& solution) {
  const auto& search = solution.search;
  const int tried = search.starts + search.hops;
  if (tried >= few_arrived && few_arrived * search.solved <= tried)
    return " Of " + std::to_string(tried) + " searches " + std::to_string(search.solved) +
           " arrived: more starts or another seed may find a cheaper one.";
  const int once = met_once(search), minima = static_cast<int>(search.minima.size());
  if (search.solved >= few_arrived && 2 * once >= search.solved)
    return " The " + std::to_string(search.solved) + " searches that arrived ended at " + std::to_string(minima) +
           " minima" + (once < minima ? ", " + std::to_string(once) + " of them met once" : "") + ": " +
           (search.hops > 0 ? "more hops" : "[search] hops = " + std::to_string(hops_for_each * search.starts)) +
           ", more starts or another seed may find a cheaper one.";
  return "";
}

std::string grown_dear(const Solution& solution) {
  const auto& minima = solution.search.minima;
  if (minima.empty() || !(dearer * std::abs(minima.front().cost) < solution.cost)) return "";
  return " On the coarse grid where searches begin it cost " + number(minima.front().cost, 3) +
         ": what all steps make of that is dearer, and more starts, another seed or other time.steps may find a "
         "cheaper one.";
}

}  // namespace

std::string on_cheaper_ones(const Solution& solution, bool cheaper_known) {
  const std::string words = few_arrivals(solution);
  return words.empty() && !cheaper_known ? grown_dear(solution) : words;
}

namespace {

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

std::string words_on_steps(const Problem& problem, const Answer& of, bool resolving) {
  return advice_on_steps(problem, of.certificate, of.solution, resolving) +
         unseen_work(problem, of.certificate, of.solution);
}

// Of candidates in order of worth those after the first that are to be kept, each minimum once; where more steps follow, what costs
// less than the first is kept for them as well.
std::vector<Answer> others(const model::System& system, const Problem& problem,
                           const std::vector<const Certified*>& order, const search::SolveOptions& options,
                           Parts& parts) {
  std::vector<Answer> kept;
  const auto minimum = [&](const Answer& of) {
    return search::minimum_of(system, problem, of.solution.cost, of.solution.rotation);
  };
  const auto known = [&](const Answer& other) {
    const search::Minimum own = minimum(other);
    return search::same_minimum(minimum(order.front()->answer), own) ||
           std::any_of(kept.begin(), kept.end(),
                       [&](const Answer& of) { return search::same_minimum(minimum(of), own); });
  };
  for (const Certified* one : order) {
    const bool cheaper = options.resolving && one->answer.solution.cost < order.front()->answer.solution.cost;
    if (static_cast<int>(kept.size()) + 1 >= problem.search.keep && !cheaper) continue;
    if (one->answer.solution.status != Status::optimal || known(one->answer)) continue;
    Answer other = one->answer;
    parts.begin_another();
    add_to(other, problem, complete(system, problem, other, {}, options.workers, parts));
    other.solution.message += words_on_steps(problem, other, options.resolving);
    parts.tell("", other);
    other.solution.solver.total_wall_seconds = parts.seconds();
    kept.push_back(std::move(other));
  }
  return kept;
}

// What is told is told by one thread at a time.
search::SolveOptions telling_one_at_a_time(search::SolveOptions options) {
  if (!options.progress) return options;
  options.progress = [tell = options.progress, turn = std::make_shared<std::mutex>()](const std::string& line) {
    const std::scoped_lock lock(*turn);
    tell(line);
  };
  return options;
}

// Of a search that met something: what is worth most, with all that is to be found out about it.
Answer best_of(const model::System& system, const Problem& problem, const search::Candidates& candidates,
               const std::vector<std::optional<Judged>>& proofs, const search::SolveOptions& options, Parts& parts) {
  std::vector<Certified> found;
  for (std::size_t n = 0; n < candidates.solution.size(); ++n)
    if (proofs[n]) found.push_back({n, {candidates.solution[n], proofs[n]->certificate, {}, proofs[n]->failure}});
  std::vector<const Certified*> order;
  for (const Certified& one : found) order.push_back(&one);
  std::stable_sort(order.begin(), order.end(), [&](const Certified* a, const Certified* b) {
    return rank(problem, a->answer) < rank(problem, b->answer);
  });
  const Certified* const chosen = order.front();
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
  if (best.solution.status == Status::infeasible) {  // searches ended somewhere, but none where the goal is
    best.solution.search.solved = 0;
    best.solution.search.minima.clear();
  }
  const std::vector<const Answer*> cheaper = cheaper_ones(system, problem, order, best.solution);
  best.solution.search.set_aside = cheapest_set_aside(problem, cheaper);
  best.solution.message += words_of_cheaper_ones(problem, cheaper, best.solution, options.resolving);
  if (optimal || best.solution.status == Status::feasible)
    best.solution.message += words_on_steps(problem, best, options.resolving);
  const bool by_itself = optimal && costs_nothing(problem, best.solution);
  if (by_itself && best.solution.solver.iterations > 0)
    best.solution.message += " It goes on by itself: its moments, and what they cost, are round-off.";
  if (optimal && !by_itself)
    best.solution.message += on_cheaper_ones(best.solution, !cheaper.empty()) +
                             (options.solver == search::Backend::ipopt ? "" : untried_turns(system, problem));
  parts.tell(candidates.unsearched, best);
  if (optimal) best.others = others(system, problem, order, options, parts);
  const bool cut = std::any_of(best.others.begin(), best.others.end(),
                               [](const Answer& other) { return other.solution.status == Status::interrupted; });
  if (cut) best.solution.status = Status::interrupted;  // what it stands beside is not complete
  return best;
}

}  // namespace

Answer answer(const model::System& system, const Problem& problem, const search::SolveOptions& asked) {
  require_memory(system, problem, bytes_of_machine());
  const search::SolveOptions options = telling_one_at_a_time(asked);
  Parts parts(problem, options);
  std::vector<std::optional<Judged>> proofs;
  bool proven = false;                                      // whether a candidate is
  double met_at = std::numeric_limits<double>::infinity();  // cost of the cheapest one that keeps all that is asked
  search::SolveOptions certified = options;
  certified.accept = [&](Solution& solution) {
    // without a certificate an answer is worth little: time or not, the first candidate has one, and so have others that
    // may be proven where none is yet, or keep what is asked at less cost than those that do
    const bool needed = proofs.empty() || (!proven && solution.status == Status::optimal) ||
                        (!proven && solution.status == Status::feasible && solution.cost < met_at);
    proofs.emplace_back();
    if (!needed && !parts.begins(Part::other_candidate)) return false;
    parts.progress("certifying");
    Judged& judged = proofs.back().emplace(first_certificate(system, problem, solution, options.workers, parts));
    const Certificate& proof = judged.certificate;
    judged.failure = judge(problem, proof, solution);
    if (solution.status != Status::optimal)
      parts.progress("candidate" + (std::isfinite(solution.cost) ? " of cost " + number(solution.cost, 8) : "") + ": " +
                     solution.message);
    proven = proven || solution.status == Status::optimal;
    if (solution.status == Status::optimal || solution.status == Status::feasible)
      met_at = std::min(met_at, solution.cost);
    return solution.status == Status::optimal && unresolved(problem, solution, proof).empty();
  };
  const search::Candidates candidates = search::find_candidates(system, problem, certified);
  if (!candidates.out_of_reach.empty()) {
    Answer none{candidates.solution.front(), {}};
    none.certificate = first_certificate(system, problem, none.solution, options.workers, parts);
    none.solution.message = none.failure.missed = "Out of reach: " + candidates.out_of_reach + ".";
    none.solution.solver.total_wall_seconds = parts.seconds();
    return none;
  }
  Answer best = best_of(system, problem, candidates, proofs, options, parts);
  best.solution.solver.total_wall_seconds = parts.seconds();
  return best;
}

}  // namespace lamprey::study
