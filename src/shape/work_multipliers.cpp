// How the work's multipliers go on from search to search: their weights, and where they are not needed (chapter 13).
#include <algorithm>
#include <cmath>
#include <limits>

#include "maneuver/node_path.hpp"
#include "shape/cost_terms.hpp"

namespace lamprey::shape {

namespace {

using maneuver::place_on_grid;
using model::at;

constexpr double carried_work_weight = 8.0;   // most of the first, that another grid begins with
constexpr double largest_work_weight = 1e7;   // of the first
constexpr double first_work_weight = 4.0;     // over the root mean square of the powers
constexpr double fitting_multipliers = 1e-6;  // error of those of an answer to this very problem, whose weight stays
constexpr double work_weight_growth = 4.0;    // where the error has not fallen
constexpr double enough_work_progress = 0.5;  // share of the error that may be left
constexpr double multiplier_noise = 1e-8;     // that round-off in the powers may bring, and that is no error
constexpr double far_from_kink = 10.0;        // powers, in what a weight moves multipliers by one with
constexpr double fitting_slopes = 0.3;        // of such powers, between their own and the multipliers
constexpr double least_power = 1e-9;          // of the swimmer's largest, that a drive's is measured by

}  // namespace

double CostTerms::error(const CostValues& values) const {
  if (!of_work()) return 0.0;
  const double least = std::max(least_power * values.power.lpNorm<Eigen::Infinity>(), 1e-300);
  double error = 0.0;
  for (int d = 0; d < system_.drive_count(); ++d) {
    const double largest = std::max(values.power.row(d).lpNorm<Eigen::Infinity>(), least);
    for (int k = 0; k <= steps_; ++k) {
      const NodePower power(values.power(d, k), values.change(d, k));
      error = std::max(error, work_misfit(power / largest, work_term(values, d, k).slope));
    }
  }
  return error > multiplier_noise ? error : 0.0;
}

// Moments follow from second differences of the shapes, rates from first ones: relative to what they are like, round-off in
// them is ε N² and ε N (equation 13.18). A weight turns what that makes of a power into an error of its multiplier.
void CostTerms::find_heaviest(const CostedMotion& motion, const CostValues& values) {
  const double epsilon = std::numeric_limits<double>::epsilon();
  double largest_moment = 0.0, largest_rate = 0.0;
  for (int k = 0; k <= steps_; ++k) {
    find_rates(values, k, motion.time_step);
    largest_moment = std::max(largest_moment, motion.moment[at(k)].head(controls_).lpNorm<Eigen::Infinity>());
    largest_rate = std::max(largest_rate, rate_.lpNorm<Eigen::Infinity>());
  }
  heaviest_.setConstant(std::numeric_limits<double>::infinity());
  for (int k = 0; k <= steps_; ++k) {
    find_rates(values, k, motion.time_step);
    for (int c = 0; c < controls_; ++c) {
      const double of_moment = (std::abs(rate_(c, 0)) + std::abs(rate_(c, 1))) * largest_moment * steps_;
      const double of_rate = std::abs(motion.moment[at(k)][c]) * largest_rate;
      const double noise = epsilon * steps_ * (of_moment + of_rate);
      double& heaviest = heaviest_(drive_[at(c)], k);
      if (noise > 0.0) heaviest = std::min(heaviest, multiplier_noise / noise);
    }
  }
}

// A term whose multipliers are of one sign is cheaper by 2/c where the power has the other: where a joint turns back that
// drives the turn from node to node, round after round. Work itself does not feel where on the grid it is.
void CostTerms::settle(const CostValues& values) {
  settled_.setConstant(false);
  for (int k = 0; k <= steps_; ++k)
    for (int d = 0; d < system_.drive_count() && moves(k); ++d) {
      const NodePower power(values.power(d, k), values.change(d, k));
      const WorkSlopes own = shape::work_term(power, WorkSlopes::Zero(), 0.0).slope;
      settled_(d, k) = weight_of_power(d, k) * power.lpNorm<Eigen::Infinity>() > far_from_kink &&
                       (own - multipliers_.at(d, k)).norm() < fitting_slopes;
    }
}

void CostTerms::renew(const CostedMotion& motion, const CostValues& values, bool heavier) {
  if (!of_work()) return;
  const double error = this->error(values);
  for (int k = 0; k <= steps_; ++k)
    for (int d = 0; d < system_.drive_count(); ++d)
      multipliers_.set(d, k, moves(k) ? work_term(values, d, k).slope : WorkSlopes(0.0, 0.0));
  for (MatrixXd* value : {&multipliers_.mean, &multipliers_.change})
    if (periodic_) value->col(0) = value->col(steps_);
  if (heavier && last_error_ > 0.0 && error > enough_work_progress * last_error_)
    multipliers_.weight = std::min(work_weight_growth * multipliers_.weight, multipliers_.largest_weight);
  last_error_ = error;
  find_heaviest(motion, values);
  if (heavier) settle(values);
}

// Heavier ones make narrow bent valleys of the kinks, u = 0 or ω = 0, that a search creeps along.
void CostTerms::choose_weight(const CostValues& values, bool at_goal) {
  if (!of_work()) return;
  const double mean = std::sqrt(values.power.squaredNorm() / static_cast<double>(values.power.size()));
  const double first = first_work_weight / std::max(mean, 1e-300),
               before = multipliers_.largest_weight / largest_work_weight;
  double carried = multipliers_.weight > 0.0 ? carried_work_weight : 1.0;  // of another method's answer
  if (before > 0.0) carried = multipliers_.weight / before;
  if (!at_goal || !(error(values) <= fitting_multipliers)) carried = std::min(carried, carried_work_weight);
  multipliers_.weight = carried * first;
  multipliers_.largest_weight = largest_work_weight * first;
}

void CostTerms::let_signs_change() {
  const double first = multipliers_.largest_weight / largest_work_weight;
  multipliers_.weight = std::min(multipliers_.weight, carried_work_weight * first);
  settled_.setConstant(false);
}

void CostTerms::take(const WorkMultipliers& from) {
  last_error_ = 0.0;
  multipliers_.set_zero(system_.drive_count(), steps_ + 1);
  heaviest_.setConstant(std::numeric_limits<double>::infinity());
  settled_.setConstant(false);
  multipliers_.largest_weight = from.largest_weight;
  multipliers_.weight = from.weight;
  const auto coarse = static_cast<int>(from.mean.cols()) - 1;
  if (coarse < 1) return;
  for (int k = 0; k <= steps_; ++k) {
    const auto [left, share] = place_on_grid(k, steps_, coarse);
    for (int d = 0; d < system_.drive_count(); ++d)
      multipliers_.set(d, k, (1.0 - share) * from.at(d, left) + share * from.at(d, left + 1));
  }
}

}  // namespace lamprey::shape
