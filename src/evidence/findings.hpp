// What is measured of a stored motion, plain numbers, and the marks that an optimal answer keeps. NaN: not computed.
#pragma once

#include <limits>
#include <map>
#include <string>

namespace lamprey::evidence {

inline constexpr double unset = std::numeric_limits<double>::quiet_NaN();

/// Marks of an optimal answer; that of kkt is the problem's tolerance.
inline constexpr double goal_mark = 1e-9;             // rad, m
inline constexpr double rest_mark = 1e-9;             // of the scale
inline constexpr double equation_mark = 1e-10;        // of the scale, or what round-off leaves
inline constexpr double momentum_mark = 1e-11;        // of the scale, or what round-off leaves
inline constexpr double start_mark = 1e-9;            // rad, m
inline constexpr double rotation_mark = 1e-11;        // of |RᵀR − I| and |det R − 1|
inline constexpr double control_mark = 1e-9;          // of the largest moment
inline constexpr double time_mark = 1e-9;             // of the duration
inline constexpr double velocity_mark = 1e-6;         // of the largest: round-off of short steps is in them
inline constexpr double cost_mark = 1e-9;             // of the cost
inline constexpr double limit_mark = 1e-7;            // rad, m, of the bound
inline constexpr double complementarity_mark = 5e-7;  // of the cost over the duration: a barrier leaves 1e-7 or 2e-7
inline constexpr double sign_mark = 1e-6;             // of the largest multiplier, that one may push the wrong way

/// Limits and waypoints along the stored motion.
struct LimitsKept {
  double violation = unset;  // largest: rad or m, moments, rates and durations against the bound; 0 where all are kept
  std::string key;           // of the worst, as in the problem file
  double time = unset;       // s, of the worst
  double complementarity = unset;  // largest |multiplier · margin| / (what is spent / duration)
  double negative = unset;         // most negative multiplier / the largest; 0 where none is
  std::map<std::string, double> reached =
      {};  // key of a limit that is reached or broken somewhere → share of the nodes; not stored
};

/// Costs beside effort and time along the stored motion.
struct CostsKept {
  double error = unset;  // relative difference of the stored cost from the one recomputed
  double signs = unset;  // how far powers are from what their multipliers belong to, of their joint's largest
};

/// Where two bodies come nearest to each other.
struct Clearance {
  double gap = unset;   // m; below zero they overlap, and this is minus the shortest way out
  double time = unset;  // s
  int first = -1;       // body indices, first < second
  int second = -1;
};

}  // namespace lamprey::evidence
