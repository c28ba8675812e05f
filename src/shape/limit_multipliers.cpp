// How limits' multipliers, barrier and weight go on from search to search (chapter 10).
#include <algorithm>
#include <cmath>
#include <utility>

#include "maneuver/node_path.hpp"
#include "shape/limit_terms.hpp"

namespace lamprey::shape {

namespace {

using maneuver::place_on_grid;

// Barriers are shares of the cost over the duration, levels in units of the rows.
constexpr double first_weight = 30.0;    // over the cost over the duration
constexpr double largest_weight = 1e15;  // of the first
constexpr double first_level = 0.1, first_barrier = 0.01;
constexpr double carried_level = 1e-5, carried_barrier = 1e-4;
constexpr double finest_level = 1e-9, finest_barrier = 5e-8;
constexpr double fall = 0.1;           // of both from search to search
constexpr double nearly_finest = 3.0;  // times the finest barrier, from where it falls to that
constexpr double least_fall = 0.5;  // share left of a barrier, above which its fall tells nothing of limits that hold
constexpr double weight_growth = 8.0;     // where what is broken has not fallen
constexpr double enough_progress = 0.25;  // share of it that may be left
constexpr double heaviest = 1e5;          // weight over the largest multiplier, whose round-off is 1e-15 of that or so
constexpr double landing_weight = 1e5;    // the same where limits have become equalities
constexpr double digits_per_turn = 3.0;   // share of these that a rate's turn in a step is good for, 1/rad
constexpr double fewest_digits = 0.02;    // least such share
constexpr double least_pull = 1e-3;       // of a limit that holds, over its value, in the cost over the duration
constexpr double landed_off = 1e-9;       // units of the rows, by which limits that do not hold may be broken
constexpr double wrong_pull = 1e-9;       // of the largest multiplier, against a limit that holds
constexpr double wrong = 1.0;             // error of such a limit
constexpr double product_share = 1e-2;    // of λ g over the cost, that counts as a row's error before a landing
constexpr double least_cost = 0.01;  // of the cost before, that barriers are reckoned by from one search to the next

// Whether they limit the same, to whatever bound.
bool same_limit(const LimitRow& a, const LimitRow& b) {
  return a.kind == b.kind && a.joint == b.joint && a.body == b.body && a.other_body == b.other_body &&
         a.component == b.component && a.time == b.time;
}

}  // namespace

LimitMultipliers of_rows(const LimitMultipliers& from, const std::vector<LimitRow>& held,
                         const std::vector<LimitRow>& rows) {
  LimitMultipliers of = from;
  if (from.value.size() == 0) return of;
  of.value.setZero(static_cast<Eigen::Index>(rows.size()), from.value.cols());
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (std::size_t h = 0; h < held.size(); ++h)
      if (same_limit(rows[r], held[h]))
        of.value.row(static_cast<Eigen::Index>(r)) = from.value.row(static_cast<Eigen::Index>(h));
  return of;
}

void LimitTerms::bound_duration(double least, double most) {
  for (LimitRow& row : rows_)
    if (row.of_duration()) row.bound = row.upper() ? most : least;
}

double LimitTerms::largest() const {
  double largest = 0.0;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    const auto row = worth_.multipliers.value.row(static_cast<Eigen::Index>(r));
    largest = std::max(largest, row.lpNorm<Eigen::Infinity>() / time_unit(rows_[r]));
  }
  return largest;
}

LimitError LimitTerms::violation(const MatrixXd& value) const {
  LimitError worst;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (!applies(rows_[r], k)) continue;
      const double g = value(static_cast<Eigen::Index>(r), k), broken = rows_[r].equality() ? std::abs(g) : -g;
      if (broken > worst.value || worst.row < 0) worst = {broken, static_cast<int>(r), k};
    }
  return worst;
}

LimitError LimitTerms::error(const MatrixXd& value) const {
  LimitError worst;
  const double largest = landed_ ? this->largest() : 0.0;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (!applies(rows_[r], k)) continue;
      const auto row = static_cast<Eigen::Index>(r);
      const double g = value(row, k), multiplier = worth_.estimate(row, k) / time_unit(rows_[r]);
      double error = tied(r, k) ? std::abs(g) : -g;
      if (!rows_[r].equality()) {
        const double product = multiplier * g / worth_.base;
        error = std::max(error, landed_ ? std::abs(product) : product_share * product);
        if (landed_ && tied(r, k) && multiplier < -wrong_pull * largest) error = std::max(error, wrong);
      }
      if (error > worst.value || worst.row < 0) worst = {error, static_cast<int>(r), k};
    }
  return worst;
}

// A rate's value is worth fewer digits, the less the bound lets a joint turn in a step, and weights bring round-off into the multipliers.
double LimitTerms::bearable(double weight) const {
  double least_turn = 1.0;
  for (const LimitRow& row : rows_)
    if (row.of_rate()) least_turn = std::min(least_turn, digits_per_turn * row.bound * duration_ / steps_);
  return weight * std::max(least_turn, fewest_digits);
}

void LimitTerms::set_level(double level, double barrier) {
  worth_.level = level;
  worth_.barrier = barrier;
  const double pulling = std::max(largest(), first_weight * first_level * worth_.base);
  worth_.equality_weight = pulling * std::min(1.0 / level, bearable(heaviest));
  const double kept = worth_.taken_off ? std::max(worth_.equality_weight, worth_.multipliers.weight) : pulling / level;
  worth_.multipliers.weight = std::min(kept, worth_.multipliers.largest_weight);
}

void LimitTerms::renew(const MatrixXd& value, double cost) {
  const double largest = this->largest();
  double broken = 0.0;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      if (!applies(rows_[r], k)) continue;
      const double g = value(row, k);
      double& multiplier = worth_.multipliers.value(row, k);
      multiplier = worth_.estimate(row, k);
      broken = std::max(broken, rows_[r].equality() ? std::abs(g) : -g);
      if (!landed_ || rows_[r].equality()) continue;
      bool& holds = holds_(row, k);
      if (holds ? multiplier < -wrong_pull * largest * time_unit(rows_[r]) : g < -landed_off) holds = !holds;
      if (!holds) multiplier = worth_.estimate(row, k) = 0.0;
    }
  if (!landed_) come_nearer(broken, cost);
}

// Where limits are broken by more than the level multipliers alone may mend it, or a larger weight; else barrier and level fall.
void LimitTerms::come_nearer(double broken, double cost) {
  worth_.base = std::clamp(cost / duration_, least_cost * worth_.base, worth_.base);
  const double before = std::exchange(worth_.broken, broken);
  if (broken > worth_.level) {
    if (broken <= enough_progress * before) return;
    worth_.equality_weight *= weight_growth;
    worth_.multipliers.weight = std::min(weight_growth * worth_.multipliers.weight, worth_.multipliers.largest_weight);
    return;
  }
  const double finest = finest_barrier * worth_.base;
  double barrier = fall * worth_.barrier;
  if (barrier < nearly_finest * finest) barrier = finest;
  if (barrier > least_fall * worth_.barrier) barrier = worth_.barrier;
  if (barrier < worth_.barrier) {
    worth_.fallen = barrier / worth_.barrier;
    worth_.before_fall = worth_.multipliers.value;
  }
  set_level(std::max(finest_level, fall * worth_.level), barrier);
}

// Where a limit holds its slack falls with the barrier, elsewhere its multiplier.
void LimitTerms::land(const MatrixXd& value) {
  before_landing_ = worth_.multipliers.value;
  if (!landed_) hold_those_that_pull(value);  // else those that held
  landed_ = true;
  worth_.equality_weight = bearable(landing_weight) * std::max(largest(), first_weight * first_level * worth_.base);
}

void LimitTerms::hold_those_that_pull(const MatrixXd& value) {
  const double outlasts = std::sqrt(worth_.fallen);
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      if (rows_[r].equality()) continue;
      const auto row = static_cast<Eigen::Index>(r);
      double& multiplier = worth_.multipliers.value(row, k);
      holds_(row, k) = applies(rows_[r], k) && multiplier > outlasts * worth_.before_fall(row, k) &&
                       multiplier > least_pull * worth_.base * time_unit(rows_[r]) * value(row, k);
      if (!holds_(row, k)) multiplier = worth_.estimate(row, k) = 0.0;
    }
}

void LimitTerms::take_off(const MatrixXd& value) {
  landed_ = false;
  worth_.taken_off = true;
  worth_.multipliers.weight = 0.0;
  worth_.multipliers.value = worth_.estimate = before_landing_;
  begin_near(value, finest_level, finest_barrier);
}

void LimitTerms::begin(const MatrixXd& value) {
  worth_.estimate = worth_.multipliers.value;
  if (carried_)
    begin_near(value, same_grid_ ? finest_level : carried_level, same_grid_ ? finest_barrier : carried_barrier);
  else
    set_level(first_level, first_barrier * worth_.base);
}

bool LimitTerms::ease(double times) {
  const double weakest = first_barrier * worth_.base;
  if (landed_ || !(worth_.barrier < weakest)) return false;
  worth_.taken_off = false;
  set_level(std::min(times * worth_.level, first_level), std::min(times * worth_.barrier, weakest));
  return true;
}

// What multipliers and rows have to do with the cost, and what is broken, say how near an answer the point is.
void LimitTerms::begin_near(const MatrixXd& value, double least_level, double least_barrier) {
  double broken = 0.0, product = 0.0;
  for (int k = 0; k <= steps_; ++k)
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      if (!applies(rows_[r], k)) continue;
      const double g = value(row, k);
      broken = std::max(broken, rows_[r].equality() ? std::abs(g) : -g);
      if (!rows_[r].equality())
        product += node_time(rows_[r], k) * worth_.multipliers.value(row, k) * std::abs(g) / duration_;
    }
  const double share = std::clamp(product / worth_.base, least_barrier, first_barrier);
  set_level(std::clamp(std::max(broken, least_level * share / least_barrier), least_level, first_level),
            share * worth_.base);
}

void LimitTerms::take(const LimitMultipliers& from, double cost) {
  landed_ = worth_.taken_off = false;
  worth_.broken = 0.0;
  worth_.multipliers.value.setZero();
  const bool weighed = from.weight > 0.0;
  carried_ = weighed || (from.value.size() > 0 && !from.value.isZero(0.0));
  worth_.base = weighed ? from.largest_weight / (largest_weight * first_weight) : cost / duration_;
  worth_.multipliers.largest_weight = largest_weight * first_weight * worth_.base;
  set_level(first_level, first_barrier * worth_.base);
  const auto coarse = static_cast<int>(from.value.cols()) - 1;
  same_grid_ = coarse == steps_;
  if (coarse < 1) return;
  for (int k = 0; k <= steps_; ++k) {
    const auto [left, share] = place_on_grid(k, steps_, coarse);
    for (std::size_t r = 0; r < rows_.size(); ++r) {
      const auto row = static_cast<Eigen::Index>(r);
      if (rows_[r].time >= 0.0)
        worth_.multipliers.value(row, k) = applies(rows_[r], k) ? from.value.row(row).sum() : 0.0;
      else if (applies(rows_[r], k))
        worth_.multipliers.value(row, k) = (1.0 - share) * from.value(row, left) + share * from.value(row, left + 1);
    }
  }
}

}  // namespace lamprey::shape
