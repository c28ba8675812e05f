// Work of a moment about a node, over which it is constant and the rate it works at goes linearly from that of the step before
// to that of the step after (chapter 13): the mean of |power|, and its multipliers.
#pragma once

#include <Eigen/Core>

namespace lamprey::shape {

/// Power that goes linearly from mean − change to mean + change: (mean, change), W.
using NodePower = Eigen::Vector2d;

/// What |power| is on the average, W (equation 13.3).
double mean_work(const NodePower& power);

/// Slopes of mean_work by (mean, change): of all that have them somewhere, |change| ≤ (1 − mean²)/2.
using WorkSlopes = Eigen::Vector2d;

/// mean_work with multipliers: smooth, and mean_work itself at a fixed point (equations 13.6 to 13.8).
struct WorkTerm {
  double value;               // W
  WorkSlopes slope;           // also the multipliers to go on with
  Eigen::Matrix2d curvature;  // 1/W
};

/// `weight` in 1/W pulls the power towards where the multipliers belong; 0: mean_work itself, whose slopes at rest are 0.
WorkTerm work_term(const NodePower& power, const WorkSlopes& multiplier, double weight);

/// How far a power of order 1 is from those whose work has these slopes (equation 13.13).
double work_misfit(const NodePower& power, const WorkSlopes& slopes);

}  // namespace lamprey::shape
