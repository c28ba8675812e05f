// How far a motion of shapes is from what is asked of it, in numbers and in words.
#include <algorithm>
#include <cmath>
#include <limits>

#include "shape/shape_program.hpp"

namespace lamprey::shape {

namespace {

using maneuver::closure_row;
using maneuver::end_row;
using maneuver::has_momentum;
using maneuver::in_words;

}  // namespace

using model::at;

namespace {

constexpr double worth_telling = 1e-7;  // units of the rows

}  // namespace

void ShapeProgram::find_idle_violation() {
  double sum = 0.0;
  for (const EndRow& row : end_rows_)
    if (row.kind != EndRow::Kind::moment && row.kind != EndRow::Kind::closure)
      sum += std::abs(end_row(system_, maneuver_, row, maneuver_.start.rotation, maneuver_.start.position, by_last_));
  const bool goes_on = drifts_ && has_momentum(system_, maneuver_.start);  // whatever its joints do
  idle_violation_ = sum > 0.0 && !goes_on ? sum : std::numeric_limits<double>::infinity();
}

double ShapeProgram::value_of(const EndRow& row, const Motion& motion) {
  switch (row.kind) {
    case EndRow::Kind::moment:
      return motion.moment.back()[row.index] / row.unit;
    case EndRow::Kind::closure:
      return closure_row(system_, row, motion.shape.front(), motion.shape.back(), by_first_, by_last_);
    case EndRow::Kind::orientation:
    case EndRow::Kind::shape:
    case EndRow::Kind::joint:
    case EndRow::Kind::position:
      break;
  }
  return end_row(system_, maneuver_, row, motion.rotation.back(), motion.position.back(), by_last_);
}

ShapeProgram::Miss ShapeProgram::worst_stated() {
  Miss worst;
  for (std::size_t r = 0; r < stated_rows_.size(); ++r)
    if (const double value = std::abs(value_of(stated_rows_[r], now_)); value > worst.value) worst = {value, r};
  return worst;
}

std::string ShapeProgram::stated_goal_miss() {
  const Miss worst = worst_stated();
  return worst.value > 0.0 ? end_row_in_words(system_, stated_rows_[worst.row], worst.value) : "";
}

double ShapeProgram::goal_error() const {
  double error = 0.0;
  for (std::size_t r = 0; r < end_rows_.size(); ++r)
    if (end_rows_[r].kind != EndRow::Kind::moment)
      error = std::max(error, end_rows_[r].unit * std::abs(now_.end_rows[static_cast<Eigen::Index>(r)]));
  return error;
}

std::string ShapeProgram::largest_miss() const {
  if (end_rows_.empty()) return "";
  Eigen::Index worst = 0;
  const double value = now_.end_rows.cwiseAbs().maxCoeff(&worst);
  if (value < worth_telling) return "";
  const EndRow& row = end_rows_[at(static_cast<int>(worst))];
  return end_row_in_words(system_, row, value);
}

std::string ShapeProgram::largest_violation(bool cut_short) const {
  if (limits_.empty()) return "";
  const LimitError worst = limits_.violation(now_.limit_value);
  if (worst.value < worth_telling || worst.row < 0) return "";
  const LimitRow& row = limits_.rows()[at(worst.row)];
  return row.key + row.bearer(system_) +
         (cut_short ? " is not kept yet: broken by " : " is not kept where it ended: broken by ") +
         in_words(row.excess(worst.value, h_ * now_.stretch)) + " " + row.unit_name() + " at " +
         in_words(worst.node * h_ * now_.stretch) + " s";
}

}  // namespace lamprey::shape
