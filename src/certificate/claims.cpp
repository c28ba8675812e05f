#include "certificate/claims.hpp"

#include <algorithm>
#include <cmath>

namespace lamprey::certificate {

namespace {

constexpr double larger = 10.0;           // an error found, over the one told
constexpr double scarcely_larger = 1.05;  // of what comes out the same everywhere
constexpr double same_mark = 1.0 + 1e-9;  // what digits leave of a mark
constexpr double unmarked_floor = 1e-9;   // of errors without a mark: what replays on another machine differ by
constexpr double of_the_mark = 0.1;       // below this share of its mark an error is as good as any
constexpr double kkt_scale = 1e-8;        // the usual tolerance
constexpr double same_digits = 1e-10;     // of the largest number that one is formed from
constexpr double same_value = 1e-3;       // relative, of curvatures, growth rates and gaps

class Claims {
 public:
  void error(const std::string& field, double stored, double found, double mark) {
    if (std::isnan(stored) || (stored >= 0.0 && found <= std::max(larger * stored, of_the_mark * mark))) return;
    claims_.push_back({field, stored, found});  // NaN is found where nothing is
  }

  /// What is far above round-off, and the same wherever it is measured.
  void measured(const std::string& field, double stored, double found) {
    if (std::isnan(stored) || (stored >= 0.0 && found <= std::max(scarcely_larger * stored, unmarked_floor))) return;
    claims_.push_back({field, stored, found});
  }

  /// Beside a `whole` of its unit, for small ones have fewer digits.
  void value(const std::string& field, double stored, double found, double whole) {
    if (std::isnan(stored)) return;
    if (std::abs(stored - found) <= same_value * std::max(std::abs(found), same_value * whole)) return;
    claims_.push_back({field, stored, found});
  }

  /// From other stored numbers, the largest of which is `of`.
  void derived(const std::string& field, double stored, double found, double of) {
    if (std::isnan(stored)) return;
    if (std::abs(stored - found) <= same_digits * of) return;
    claims_.push_back({field, stored, found});
  }

  /// What an error may be by round-off: 0 claims nothing.
  void round_off(const std::string& field, double stored, double found) {
    if (!(stored > larger * found)) return;
    claims_.push_back({field, stored, found});
  }

  void at_most(const std::string& field, double stored, double found) {
    if (!(stored <= found)) claims_.push_back({field, stored, found});
  }

  std::vector<FalseClaim> all() && { return std::move(claims_); }

 private:
  std::vector<FalseClaim> claims_;
};

void compare(const std::string& field, const optimality::SecondOrder& stored, const optimality::SecondOrder& found,
             Claims& claims) {
  claims.value(field + ".smallest_eigenvalue", stored.smallest_eigenvalue, found.smallest_eigenvalue, 1.0);
  if (stored.along_phase)  // of round-off's size: whether it is one
    claims.at_most(field + ".along_phase", std::abs(*stored.along_phase),
                   found.along_phase ? optimality::curvature_mark : 0.0);
  claims.at_most(field + ".positive", stored.positive ? 1.0 : 0.0, found.positive ? 1.0 : 0.0);
  if (stored.negative_eigenvalues)
    claims.value(field + ".negative_eigenvalues", *stored.negative_eigenvalues,
                 found.negative_eigenvalues ? *found.negative_eigenvalues : unset, 1.0);
}

// Whether growing perturbations leave a whole replay's error its digits.
bool settled(const Replay& found, double duration) {
  constexpr double round_off = 1e-12, digits = 1e-2;
  const double grown = round_off * std::exp(found.growth_rate * duration);
  return grown <= digits * std::min(found.whole_rotation_error, found.whole_position_error);
}

void compare(const Replay& stored, const Replay& found, double duration, Claims& claims) {
  const auto error = [&](const char* field, double told, double is) {
    claims.error(std::string("replay.") + field, told, is, unmarked_floor / of_the_mark);
  };
  const auto measured = [&](const char* field, double told, double is) {
    claims.measured(std::string("replay.") + field, told, is);
  };
  measured("rotation_error", stored.rotation_error, found.rotation_error);
  measured("position_error", stored.position_error, found.position_error);
  if (settled(found, duration)) {
    measured("whole_rotation_error", stored.whole_rotation_error, found.whole_rotation_error);
    measured("whole_position_error", stored.whole_position_error, found.whole_position_error);
  } else {
    error("whole_rotation_error", stored.whole_rotation_error, found.whole_rotation_error);
    error("whole_position_error", stored.whole_position_error, found.whole_position_error);
  }
  if (!(stored.feedback_rotation_error > feedback_mark)) {  // else it is not said to arrive
    measured("feedback_rotation_error", stored.feedback_rotation_error, found.feedback_rotation_error);
    measured("feedback_position_error", stored.feedback_position_error, found.feedback_position_error);
  }
  measured("servo_rotation_error", stored.servo_rotation_error, found.servo_rotation_error);
  measured("servo_position_error", stored.servo_position_error, found.servo_position_error);
  claims.value("replay.window", stored.window, found.window, duration);
  claims.value("replay.growth_rate", stored.growth_rate, found.growth_rate, 1.0 / duration);
  claims.value("replay.work", stored.work, found.work, 0.0);
  claims.at_most("replay.rotation_mark", stored.rotation_mark, same_mark * found.rotation_mark);
  claims.at_most("replay.position_mark", stored.position_mark, same_mark * found.position_mark);
}

// Of costs on other grids what they say of the answer's.
void compare(const Refinement& stored, const Refinement& found, Claims& claims) {
  double largest = 0.0;
  for (const GridCost& grid : found.grids) largest = std::max(largest, std::abs(grid.cost));
  const auto cost = [&](const char* field, double told, double is) {
    claims.derived(std::string("refinement.") + field, told, is, largest);
  };
  cost("cost_half_step", stored.cost_half_step, found.cost_half_step);
  cost("cost_limit", stored.cost_limit, found.cost_limit);
  cost("cost_error", stored.cost_error, found.cost_error);
  claims.derived("refinement.observed_order", stored.observed_order, found.observed_order, 1.0);
  for (std::size_t g = 0; g < std::min(stored.grids.size(), found.grids.size()); ++g)
    cost("grids.cost", stored.grids[g].cost, found.grids[g].cost);
}

// How much a verdict says.
double weight_of(const std::optional<Verdict>& verdict) {
  if (!verdict) return 0.0;
  switch (*verdict) {
    case Verdict::proved:
      return 2.0;
    case Verdict::stationary:
      return 1.0;
    case Verdict::not_optimal:
      break;
  }
  return 0.0;
}

}  // namespace

std::vector<FalseClaim> false_claims(const Certificate& stored, const Certificate& found, double duration,
                                     double length) {
  Claims claims;
  claims.error("goal_error", stored.goal_error, found.goal_error, evidence::goal_mark);
  claims.error("rest_error", stored.rest_error, found.rest_error, evidence::rest_mark);
  claims.error("momentum_drift", stored.momentum_drift, found.momentum_drift, found.momentum_allowed());
  claims.error("rotation_drift", stored.rotation_drift, found.rotation_drift, evidence::rotation_mark);
  claims.error("iterates_momentum", stored.iterates_momentum, found.iterates_momentum, found.momentum_allowed());
  claims.error("equation_residual", stored.equation_residual, found.equation_residual, found.equation_allowed());
  claims.error("start_error", stored.start_error, found.start_error, evidence::start_mark);
  claims.error("control_error", stored.control_error, found.control_error, evidence::control_mark);
  claims.error("time_error", stored.time_error, found.time_error, evidence::time_mark);
  claims.error("velocity_error", stored.velocity_error, found.velocity_error, evidence::velocity_mark);
  claims.error("cost_error", stored.cost_error, found.cost_error, evidence::cost_mark);
  claims.round_off("momentum_round_off", stored.momentum_round_off, found.momentum_round_off);
  claims.error("kkt", stored.kkt, found.kkt, kkt_scale);
  if (!std::isnan(found.kkt)) claims.round_off("kkt_round_off", stored.kkt_round_off, found.kkt_round_off);
  if (stored.costs) {
    const evidence::CostsKept is = found.costs.value_or(evidence::CostsKept());
    claims.error("costs.error", stored.costs->error, is.error, evidence::cost_mark);
    claims.error("costs.signs", stored.costs->signs, is.signs, evidence::sign_mark);
  }
  if (stored.limits) {
    const evidence::LimitsKept is = found.limits.value_or(evidence::LimitsKept());
    claims.error("limits.violation", stored.limits->violation, is.violation, evidence::limit_mark);
    claims.error("limits.complementarity", stored.limits->complementarity, is.complementarity,
                 evidence::complementarity_mark);
    claims.error("limits.negative", stored.limits->negative, is.negative, evidence::sign_mark);
  }
  if (stored.second_order)
    compare("second_order", *stored.second_order, found.second_order.value_or(optimality::SecondOrder()), claims);
  if (stored.all_axes) {
    const optimality::AllAxes is = found.all_axes.value_or(optimality::AllAxes());
    claims.error("second_order_all_axes.kkt", stored.all_axes->kkt, is.kkt, kkt_scale);
    compare("second_order_all_axes", stored.all_axes->second_order, is.second_order, claims);
  }
  if (stored.replay) compare(*stored.replay, found.replay.value_or(Replay()), duration, claims);
  if (stored.refinement && found.refinement) compare(*stored.refinement, *found.refinement, claims);
  if (stored.clearance)
    claims.value("clearance.gap", stored.clearance->gap, found.clearance.value_or(evidence::Clearance()).gap, length);
  claims.at_most("verdict", weight_of(stored.verdict), weight_of(found.verdict));
  return std::move(claims).all();
}

}  // namespace lamprey::certificate
