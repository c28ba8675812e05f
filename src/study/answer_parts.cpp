#include "study/answer_parts.hpp"

#include <stdexcept>
#include <utility>

#include "certificate/certify.hpp"
#include "maneuver/feedback.hpp"
#include "search/workers.hpp"

namespace lamprey::study {

namespace {

using certificate::Certificate;
using maneuver::Problem;
using maneuver::Solution;
using maneuver::Status;

constexpr double late_replay = 1.0;  // s, that a replay may take where time is up

std::string part_name(Part part) {
  switch (part) {
    case Part::other_candidate:
      return "the certificate of another candidate";
    case Part::replay:
      return "its replay";
    case Part::minimum:
      return "whether it is a minimum";
    case Part::all_axes:
      return "whether it is one with control_axes set aside";
    case Part::feedback:
      return "feedback";
    case Part::followed_replay:
      return "its replay with feedback";
    case Part::other_grids:
      return "its cost on other grids";
  }
  throw std::logic_error("no part of an answer");
}

// Without what takes long. Its replay, which stiff springs can make long too, goes on for a while where time is up.
certificate::Options first_look(const Parts& parts) {
  certificate::Options options;
  options.second_order = false;
  options.of_misses = !parts.stopped();  // what a search that was cut short has not met yet is not least either
  options.stopped = [&parts, begin = parts.seconds()] {
    return parts.stopped() && parts.seconds() > begin + late_replay;
  };
  return options;
}

// A certificate with what second derivatives say; nothing where that did not begin.
std::optional<Certificate> with_curvature(const model::System& system, const Problem& problem, const Answer& best,
                                          Parts& parts) {
  if (!parts.begins(Part::minimum)) return std::nullopt;
  parts.progress("proving");
  const auto stopped = [&] { return parts.stopped(Part::minimum); };
  Certificate proof = best.certificate;
  if (!certificate::add_second_order(system, problem, best.solution, proof, stopped)) parts.leave_out(Part::all_axes);
  return proof;
}

Followed with_feedback(const model::System& system, const Problem& problem, const Answer& best, Parts& parts) {
  Followed result{{}, best.certificate.replay, ""};
  if (!parts.begins(Part::feedback)) return result;
  Solution followed = best.solution;
  try {
    result.feedback = followed.feedback = maneuver::design_feedback(system, problem, best.solution);
  } catch (const std::domain_error& error) {
    result.refused = error.what();
    return result;
  }
  if (result.replay && parts.begins(Part::followed_replay))
    certificate::certify_feedback(system, problem, followed, *result.replay, first_look(parts));
  return result;
}

// The cost on other grids, all of them or none.
std::optional<certificate::Refinement> cost_on_other_grids(const Problem& problem, const Answer& best,
                                                           const CostOnGrid& cost_on_grid, Parts& parts) {
  if (!cost_on_grid || !parts.begins(Part::other_grids)) return std::nullopt;
  parts.progress("on other grids");
  const certificate::Refinement refinement = refine_cost(problem, best.solution.cost, cost_on_grid);
  if (refinement.grids.size() < 3 && !parts.begins(Part::other_grids)) return std::nullopt;
  return refinement;
}

}  // namespace

void Parts::tell(const std::string& unsearched, Answer& answer) {
  Solution& solution = answer.solution;
  if (answer.certificate.replay && answer.certificate.replay->cut_short) leave_out(Part::replay);
  const bool interrupted = budget_.interrupted();
  if (left_out_.empty() && unsearched.empty() && (!interrupted || solution.status == Status::optimal)) return;
  if (interrupted) solution.status = Status::interrupted;
  if (left_out_.empty() && unsearched.empty()) {
    solution.message += " It was interrupted before it came to its end.";
    return;
  }
  // what was not tried might have met what was tried did not
  if (!interrupted && !unsearched.empty() && solution.status == Status::infeasible)
    solution.status = Status::time_limit;
  std::string& message = solution.message;
  message += std::string(" Since ") + (interrupted ? "it was interrupted" : "the time limit was reached");
  if (!unsearched.empty()) message += ", these were not tried: " + unsearched;
  std::string between = unsearched.empty() ? ", these were not computed: " : "; nor were computed: ";
  for (const Part part : left_out_) message += std::exchange(between, ", ") + part_name(part);
  message += ".";
}

Certificate first_certificate(const model::System& system, const Problem& problem, const Solution& solution,
                              int workers, Parts& parts) {
  certificate::Options options = first_look(parts);
  options.replay = false;
  Certificate proof;
  std::optional<certificate::Replay> replay;
  search::run_in_threads(2, workers, [&](int part) {
    if (part == 0) proof = certificate::certify(system, problem, solution, options);
    if (part == 1) replay = certificate::certify_replay(system, problem, solution, options);
  });
  proof.replay = replay;
  return proof;
}

Completion complete(const model::System& system, const Problem& problem, const Answer& best,
                    const CostOnGrid& cost_on_grid, int workers, Parts& parts) {
  Completion done;
  search::run_in_threads(3, workers, [&](int part) {
    if (part == 0) done.curved = with_curvature(system, problem, best, parts);
    if (part == 1) done.followed = with_feedback(system, problem, best, parts);
    if (part == 2) done.refinement = cost_on_other_grids(problem, best, cost_on_grid, parts);
  });
  return done;
}

}  // namespace lamprey::study
