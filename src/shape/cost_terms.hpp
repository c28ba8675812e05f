// Costs beside effort and time along a motion of shapes: mechanical work, squared power, smoothness, work per distance
// (chapter 13). Work has a kink where a drive's power vanishes: it is reached exactly by multipliers and a term that pulls the
// power towards where they belong (equations 13.6 to 13.8).
#pragma once

#include <array>

#include "maneuver/maneuver.hpp"
#include "maneuver/solution.hpp"
#include "optimizer/stage_program.hpp"
#include "shape/joint_turns.hpp"
#include "shape/node_work.hpp"

namespace lamprey::shape {

using maneuver::CostParts;
using maneuver::CostWeights;
using maneuver::Maneuver;
using maneuver::ShapeCoordinates;

/// Multipliers of the drives' powers between searches: slopes of the work by them.
struct WorkMultipliers {
  MatrixXd mean;                // [drives][N + 1] between −1 and 1: what the sign of the power is where it has one
  MatrixXd change;              // [drives][N + 1] by the power's change over the node, within ±(1 − mean²)/2
  double weight = 0.0;          // 1/W, of ½ p² where the power has no sign; 0: not chosen yet
  double largest_weight = 0.0;  // 0: multipliers of another method, whose weight is none

  void set_zero(Eigen::Index drives, Eigen::Index nodes) {
    mean.setZero(drives, nodes);
    change.setZero(drives, nodes);
  }
  WorkSlopes at(Eigen::Index drive, Eigen::Index node) const { return {mean(drive, node), change(drive, node)}; }
  void set(Eigen::Index drive, Eigen::Index node, const WorkSlopes& slopes) {
    mean(drive, node) = slopes[0];
    change(drive, node) = slopes[1];
  }
};

/// What the terms look at of a motion.
struct CostedMotion {
  const std::vector<ShapeStep>& step;     // [N]
  const std::vector<VectorXd>& moment;    // [N + 1][≥ controls] N m; of a periodic motion the first is the last
  const std::vector<Vector3d>& position;  // [N + 1] m
  double time_step;                       // s
};

/// Their values, and what derivatives start from.
struct CostValues {
  MatrixXd turn;          // [controls][N] rad, of the joints over the steps
  MatrixXd power;         // [drives][N + 1] W, mean about a node
  MatrixXd change;        // [drives][N + 1] W, half of what it changes by
  CostParts parts;        // before weighting; effort and time unset
  double reached = 0.0;   // J, work as the multipliers have it
  double distance = 0.0;  // m
  double cost = 0.0;      // of all parts by their weights
  double merit = 0.0;     // the same with the work that the multipliers make of it
};

class CostTerms {
 public:
  CostTerms(const model::System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates);

  /// Takes over another start and other weights of the same costs.
  void retarget(const Maneuver& maneuver);

  bool empty() const { return !weights_.any(); }
  bool of_work() const { return weights_.work > 0.0 || weights_.transport > 0.0; }
  /// States that the terms add behind all others.
  int states() const;

  void measure(const CostedMotion& motion, CostValues& values);
  /// Adds the derivative of the merit by a node's moments, [controls].
  void add_by_moments(const CostedMotion& motion, const CostValues& values, int node, VectorXd& gradient);
  /// What the end's position pulls with, N m² s/m and the like.
  Vector3d pull_at_end(const CostedMotion& motion, const CostValues& values) const;

  /// Where the states of a model lie.
  struct Places {
    int leads;   // stages before the first step
    int tau;     // −1: a given duration
    int copies;  // of a periodic motion's first two shapes
    int first;   // of the terms' own states, with which a periodic motion's first moments begin
  };
  /// Adds the terms' second derivatives and their first ones but those by moments. `end_moments`: moments at the last node by the last state, [controls][n].
  void add_to_model(const CostedMotion& motion, const CostValues& values, const Places& places,
                    const Eigen::Ref<const MatrixXd>& end_moments, optimizer::StageModel& model);

  /// How far powers are from what renewed multipliers belong to, of their drive's largest.
  double error(const CostValues& values) const;
  /// Multipliers at the point with these values; where `heavier`, the weight rises if the error has not fallen.
  void renew(const CostedMotion& motion, const CostValues& values, bool heavier);
  const WorkMultipliers& multipliers() const { return multipliers_; }
  /// Takes over multipliers of another grid, whose weight choose_weight then makes fit for the motion there.
  void take(const WorkMultipliers& from);
  /// Chooses the weight to begin with by a motion's powers; of a heavier one before no more stays than lets signs change, but
  /// where the motion is at the goal and its multipliers fit: that is an answer.
  void choose_weight(const CostValues& values, bool at_goal);

 private:
  // Means about a node and half of what changes over it.
  static constexpr int kinds = 2;
  WorkTerm work_term(const CostValues& values, int drive, int node) const;
  WorkTerm term(const CostValues& values, int drive, int node, double work_weight) const;
  double weight_of_power(int drive, int node) const;
  void let_signs_change();
  void settle(const CostValues& values);
  void find_heaviest(const CostedMotion& motion, const CostValues& values);
  double work_weight(const CostValues& values) const;
  double node_time(int node, double time_step) const;
  bool moves(int node) const;  // whether moments at a node count
  void find_rates(const CostValues& values, int node, double time_step);
  void find_turned(const CostedMotion& motion);
  void find_difference(const CostedMotion& motion, int step);
  void add_difference(double factor, const CostedMotion& motion, int step, VectorXd& gradient);
  void add_by_rates(const CostedMotion& motion, const CostValues& values, int node, const NodePower& by_turn);
  void add_node_form(const CostedMotion& motion, const CostValues& values, int node, int tau);
  void add_difference_form(const CostedMotion& motion, int step, const MatrixXd& difference_by, int tau);
  void add_duration(const CostedMotion& motion, const CostValues& values, int node, double& slope);
  void add_step_form(const CostedMotion& motion, const CostValues& values, int step, int tau, MatrixXd& Q, VectorXd& q);
  void add_angular_velocity(const CostedMotion& motion, const CostValues& values, int step, int tau, MatrixXd& Q,
                            VectorXd& q);
  void add_to_stage(const CostedMotion& motion, const CostValues& values, const Places& places, int node,
                    optimizer::Stage& stage);
  void add_to_end(const CostedMotion& motion, const CostValues& values, const Places& places,
                  const Eigen::Ref<const MatrixXd>& end_moments, optimizer::StageModel& model);
  void add_transport(const CostedMotion& motion, const CostValues& values, optimizer::StageModel& model);
  int place_before(const Places& places) const {  // moments at the node before
    return places.first + (smooth() && periodic_ ? controls_ : 0);
  }
  int place_of_work(const Places& places) const { return place_before(places) + (smooth() ? controls_ : 0); }
  bool smooth() const { return weights_.smoothness > 0.0; }

  const model::System& system_;
  JointTurns turns_;
  MatrixXd pose_basis_;
  CostWeights weights_;
  bool periodic_, rest_;
  int steps_, shape_, controls_;
  std::vector<int> drive_;  // [controls] whose moment it is
  VectorXd start_rate_;     // [controls] rad/s, of the joints at the start
  WorkMultipliers multipliers_;
  MatrixXd heaviest_;  // [drives][N + 1] 1/W, weights beyond which multipliers would tell of round-off
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic>
      settled_;  // likewise, powers far from 0, whose work is taken as it is
  double last_error_ = 0.0;
  // workspace
  Eigen::MatrixX2d rate_;                              // [controls][kinds] rad/s, of the joints about a node
  Eigen::MatrixX2d changing_;                          // likewise, what shapes change of it
  VectorXd difference_;                                // [controls] N m, of moments over a step
  VectorXd pull_;                                      // [controls] N m s, on the joints' turns over a step
  MatrixXd turns_before_, turns_after_, first_turns_;  // [controls][2 f] of the joints' turns by the shapes
  MatrixXd next_;                                      // [2 f][n + controls + 1] shapes at a step's ends
  MatrixXd moments_, difference_by_;                   // [controls][n + controls + 1]
  std::array<MatrixXd, kinds> turned_, rate_by_;       // likewise, of rate_
  MatrixXd turned_next_;                               // likewise, of the turns over the step after a node
  MatrixXd form_;                                      // [n + controls + 1] squared, of (state, input, 1)
  std::array<VectorXd, kinds> power_by_;               // [n + controls + 1]
  VectorXd work_, slower_, away_;                      // [n + controls + 1]
  VectorXd turned_pull_;                               // [2 f] of the joints' turns over a step
};

}  // namespace lamprey::shape
