// Costs of an answer, measured on the stored motion: turns of the joints by a road of their own, differences of the stored
// rotations. What of them is up to the motion.
#pragma once

#include "evidence/stored_motion.hpp"

namespace lamprey::evidence {

/// What the costs are, and how well the stored multipliers fit the powers' signs.
struct CostCheck {
  maneuver::CostParts parts;
  double cost = 0.0;   // of all parts by the problem's weights
  double signs = 0.0;  // how far powers are from what the stored multipliers belong to, of their drive's largest
};

CostCheck check_cost(const StoredMotion& motion);

/// Work that moments do: they act on the parent, their opposites on the child.
inline double work_of(const Vector3d& moment, const Vector3d& turn) { return -moment.dot(turn); }

/// How far a joint's child turns against the parent over a step, rad, as the moments count it: a vector in the parent's
/// frame, or angles about the axes (equation 13.1).
Vector3d turn_between(const model::Joint& joint, const mechanics::Rotations& left, const mechanics::Rotations& right);

/// Of all joints, [joints].
mechanics::Vectors turns_between(const model::System& system, const mechanics::Rotations& left,
                                 const mechanics::Rotations& right);

/// The nodes' powers and what they are made of (equation 13.2): each goes linearly from value − change to value + change.
struct Powers {
  std::vector<mechanics::Vectors> turn;   // [N][joints] rad
  std::vector<mechanics::Vectors> rate;   // [N + 1][joints] rad/s, mean about the node
  std::vector<mechanics::Vectors> swing;  // [N + 1][joints] rad/s, half of what it changes by over the node
  mechanics::Vectors start;               // [joints] rad/s, at the start: what of the first node no shape changes
  MatrixXd value, change;                 // [drives][N + 1] W
  VectorXd time;                          // [N + 1] s for which a node counts
  double distance;                        // m
};

Powers powers_of(const StoredMotion& motion);

/// W, of each drive's powers the largest, none of them less than round-off leaves of the swimmer's, [drives].
VectorXd largest_powers(const StoredMotion& motion, const Powers& powers);

/// What a power's absolute value is on the average over a node, W.
double mean_size(double value, double change);

/// Slopes of mean_size by value and change.
struct WorkSlopes {
  double by_value, by_change;
};

/// As the stored multipliers have them, or of the powers themselves.
WorkSlopes work_slopes(const StoredMotion& motion, const Powers& powers, int drive, int node);

/// Room of slopes within those that mean_size can have: (1 − by_value²)/2 − |by_change|.
double room_of(const WorkSlopes& slopes);

/// What the displacement takes off the cost, (N m)² s.
double won(const StoredMotion& motion);

/// Whether a bound of the duration leaves it no room.
bool duration_holds(const StoredMotion& motion);

/// What the duration costs where that is up to the motion: free, and not held at a bound.
double cost_of_free_duration(const StoredMotion& motion);

/// A cost without what a duration that is not free adds, before what the displacement takes off: what it is up to the motion.
double spent(const StoredMotion& motion, double cost);

/// (N m)²: what is spent over the duration, the cost of one that is free included, though a bound holds it; 0 where nothing pulls, as
/// in pictures of motions without moments.
double spent_rate(const StoredMotion& motion);

/// Whether no moment acts, and nothing but moments costs, or only what is given: no motion costs less.
bool costs_nothing(const StoredMotion& motion);

/// Difference of the stored cost from a recomputed one, of what is spent. Last digits of what a given duration adds are none.
double cost_error(const StoredMotion& motion, double recomputed);

/// Of a given distance transport is work.
double weight_of_work(const StoredMotion& motion, const Powers& powers);

}  // namespace lamprey::evidence
