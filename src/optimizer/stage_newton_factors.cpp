// Factors of the Hessian: with the penalty that shows it definite where the end rows are kept, and the least shift that makes it so.
#include <algorithm>
#include <cmath>
#include <utility>

#include "optimizer/stage_newton.hpp"

namespace lamprey::optimizer {

namespace {

constexpr double first_shift = 0.03;  // in units of the states' metric
constexpr double least_shift = 1e-7;
constexpr double leapt_over = 1e-3;         // shift up to which it grows by the square
constexpr double shift_growth = 3.0;        // where a step fails; where one succeeds the shift falls by its square
constexpr double penalty_per_cost = 100.0;  // of the end rows in the Hessian
constexpr double firmer = 1e5;              // penalty next to a solution, where rows in m or rad are small units
constexpr double poor_ratio = 0.3;

}  // namespace

// Where the latest step began next to a solution, one that is too long for its model does not say that this is far.
bool StageNewton::near() const { return near_ || change_ < nearly_stationary; }

double StageNewton::smallest_shift() const { return near() ? least_shift : first_shift; }

// Of the end rows in the Hessian, where a unit of them is worth so much. Where a point that does nothing misses them by little,
// little is much.
double StageNewton::penalty_of(double worth) const {
  const double unit = std::min(1.0, idle_violation_ / small_violation);
  return penalty_per_cost * worth / (unit * unit);
}

double StageNewton::end_penalty() const { return penalty_of(highest_cost_); }

// Rows that bend against multipliers far above the cost take more. Where that drowns small curvatures in round-off, half of it, in
// powers, may do.
bool StageNewton::factor_firmly(double shift) {
  const double multiplier = end_multiplier_.size() > 0 ? end_multiplier_.lpNorm<Eigen::Infinity>() : 0.0;
  const double firmest = firmer * penalty_of(std::max(highest_cost_, multiplier));
  return riccati_.factor(model_, shift, firmest) || riccati_.factor(model_, shift, std::sqrt(end_penalty() * firmest));
}

// Whether the Hessian is positive definite where the end rows are kept. What penalty shows it depends on their units: next
// to a solution a firmer one is tried before a shift makes Newton's method linear.
bool StageNewton::factor_unshifted() {
  if (riccati_.factor(model_, 0.0, end_penalty())) return true;
  firm_ = (near() || small_miss_) && factor_firmly(0.0);
  return firm_;
}

// What needed a firmer penalty without a shift may need it with one, too.
bool StageNewton::factor_shifted() {
  return riccati_.factor(model_, shift_, end_penalty()) || ((firm_ || small_miss_) && factor_firmly(shift_));
}

// The least shift that makes the Hessian positive definite, found by trial. Next to a solution small shifts come first:
// along a flat valley of solutions the Hessian is singular. After a good step there, none comes first.
bool StageNewton::factor(double least) {
  bypassed_ = 0.0;
  if (least > 0.0 && std::exchange(unshifted_first_, false) && factor_unshifted()) {
    bypassed_ = least;
    shift_ = 0.0;
    return true;
  }
  const double growth = near() && least == 0.0 ? shift_growth * shift_growth : shift_growth;
  for (shift_ = least; shift_ < largest_shift; shift_ = std::max(smallest_shift(), growth * shift_))
    if (shift_ == 0.0 ? factor_unshifted() : factor_shifted()) return true;
  return false;
}

double StageNewton::raised_shift() const {
  if (bypassed_ > 0.0) return bypassed_;
  const double growth = shift_ < leapt_over ? shift_growth * shift_growth : shift_growth;
  return std::max(smallest_shift(), growth * shift_);
}

void StageNewton::ease_or_damp(double ratio) {
  damping_ = shift_;
  if (ratio > good_ratio) damping_ = shift_ / (shift_growth * shift_growth);
  if (ratio < poor_ratio) damping_ = raised_shift();
  if (damping_ < 0.1 * smallest_shift()) damping_ = 0.0;
  unshifted_first_ = ratio > good_ratio && change_ < nearly_stationary;
}

}  // namespace lamprey::optimizer
