// Newton's method for a StageProgram: exact second derivatives, one Riccati sweep for a step, a funnel on violations to
// decide on steps, and the direction of negative curvature out of saddles.
#pragma once

#include "optimizer/outcome.hpp"
#include "optimizer/riccati.hpp"

namespace lamprey::optimizer {

/// Owns its workspace, for programs of one size.
class StageNewton {
 public:
  explicit StageNewton(const StageSizes& sizes);

  /// Solves from the program's point, which holds the best point found on return. Not converging is an Outcome with its
  /// reason; point and multipliers stay empty: they are the program's.
  Outcome solve(StageProgram& program, const Options& options);
  /// The same as the next part of a longer search: effort and history are added to the outcome's.
  void solve(StageProgram& program, const Options& options, Outcome& outcome);

  /// After a solve that converged, when the program's end rows ask for something a little else: the step to first order,
  /// with the factors that the solve has left. Returns false where there are none or there is no motion.
  bool foresee(StageProgram& program);

  /// At a solution, where the program weighs what it asks otherwise than in the solve that found it: one Newton step, if the Hessian
  /// is positive definite there too; whether it is.
  bool step_once_more(StageProgram& program, Outcome& outcome);

  /// Length that the program would take of its first step, at most 1; 0 where there is none.
  double first_length(StageProgram& program);

 private:
  static constexpr int most_corrections = 2;  // of second order, for one step
  static constexpr double largest_shift = 1e8;
  static constexpr double nearly_stationary = 1e-2;
  static constexpr double small_violation = 0.1;  // by which rows are missed that count by more
  static constexpr double good_ratio = 0.75;
  enum class Verdict { accepted, rejected, converged, stuck };

  void begin(const StageProgram& program);
  bool near() const;
  double smallest_shift() const;
  double penalty_of(double worth) const;
  double end_penalty() const;
  bool factor_firmly(double shift);
  bool factor_unshifted();
  bool factor_shifted();
  bool factor(double least_shift);
  void solve_model(double share);
  void find_step();
  bool take_first_multipliers(StageProgram& program);
  void begin_iteration(StageProgram& program);
  Verdict end_iteration(StageProgram& program, const Options& options, Verdict verdict, Outcome& outcome);
  Verdict improve(StageProgram& program, const Options& options, Outcome& outcome);
  double try_out(StageProgram& program, Outcome& outcome);
  double try_corrected(StageProgram& program, const Merit& here, double cheaper, double found, Outcome& outcome);
  bool begin_corrections(StageProgram& program);
  void correct(StageProgram& program);
  bool find_gap_response();
  void find_missed(StageProgram& program, double share);
  void correct_anew();
  void correct_with_gaps(StageProgram& program);
  void correct_bend(StageProgram& program);
  double judge(const Merit& here, const Merit* there, double cheaper);
  void take_gradient();
  bool follow(StageProgram& program, const Options& options, Outcome& outcome);
  void record(const StageProgram& program, Outcome& outcome) const;
  void take_last_step(StageProgram& program, Outcome& outcome);
  bool settle(StageProgram& program, double most_change, Outcome& outcome);
  double raised_shift() const;
  void ease_or_damp(double ratio);
  bool leave_saddle(StageProgram& program, Outcome& outcome);
  bool runs_along_valley(const StageProgram& program, double change_before);
  bool find_step_beside_valley();
  bool find_measured_step(const StageProgram& program);
  const VectorXd& measured(std::size_t k);
  double stationarity();
  double effort_of_step();
  double slope() const;
  double curvature();
  double bare_curvature();

  StageSizes sizes_;
  StageModel model_;
  Riccati riccati_;
  StageStep step_, corrected_, response_;
  StageSlopes slopes_;
  VectorXd state_, input_;        // buffers
  VectorXd missed_;               // what a trial left of the end rows; a buffer
  VectorXd corrected_rows_;       // what corrections of a step have taken off the end rows
  VectorXd multiplier_;           // the end rows' at the point
  VectorXd end_multiplier_;       // at the point, the end rows left as they are
  double shift_ = 0.0;            // of the inputs' metric, added to the Hessian
  double damping_ = 0.0;          // least shift, raised where steps fail
  double valley_ = 0.0;           // least shift where a step has run along a flat valley, else 0
  bool near_ = false;             // whether the latest step began next to a solution
  bool small_miss_ = false;       // whether the point meets the end rows but for what small steps repair
  bool own_factors_ = true;       // whether the latest factors are those of the step, not of its corrections
  double bypassed_ = 0.0;         // shift that was next where none came first, else 0
  bool unshifted_first_ = false;  // whether the next factors may do without
  bool firm_ = false;             // whether the latest ones without a shift needed a firmer penalty
  double share_ = 1.0;            // of the end rows that the step takes away
  double length_ = 1.0;           // of the step that was tried last
  double change_ = 0.0;           // stationarity at the point
  double highest_cost_ = 0.0;     // of the points so far
  double funnel_ = 0.0;           // violation that steps may have which lower the cost
  double idle_violation_ = 0.0;   // of a point that does nothing, where that is small; else infinite
  bool factored_ = false;         // whether the factors belong to a solution
  bool with_costates_ = true;     // whether steps are to have them
  bool by_cost_ = false;          // whether the latest trial was good for its cost
  bool gain_drowns_ = false;      // whether what the latest trial was to gain is less than the cost's round-off
  bool may_be_saddle_ = true;     // whether negative curvature was not yet followed from the point
};

}  // namespace lamprey::optimizer
