// StageProgram: an optimal-control problem along a chain of stages, as StageNewton solves it. The program keeps its point
// (on whatever manifold it lives) and its multipliers; the solver sees linear-quadratic models of it.
#pragma once

#include <limits>
#include <vector>

#include <Eigen/Core>

namespace lamprey::optimizer {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct StageSizes {
  int stages;    // N: stages 0 … N − 1, and the end
  int states;    // n
  int inputs;    // m
  int end_rows;  // conditions on the last state
};

/// One stage: s' = A s + B v + gap, and ½ sᵀQs + vᵀSs + ½ vᵀRv + q·s + r·v of the Lagrangian.
struct Stage {
  MatrixXd A;             // [n][n]
  MatrixXd B;             // [n][m]
  VectorXd gap;           // [n]
  MatrixXd Q;             // [n][n]
  MatrixXd S;             // [m][n]
  MatrixXd R;             // [m][m]
  VectorXd q;             // [n]
  VectorXd r;             // [m]
  double weight = 1.0;    // of ½|v|² in the metric of the inputs, or of what is measured for them
  double gradient = 0.0;  // size of the cost's own derivative by the same, which stationarity is measured against
  MatrixXd metric;        // [n][n] of the states: what a shift of the Hessian adds
  // the rest of it where inputs move what the state does not show, else empty
  MatrixXd metric_mixed;  // [m][n]
  MatrixXd metric_input;  // [m][m]
  /// So many first states s' are but the next so many of s: the first rows of A are [0 I 0], those of B are 0.
  int shifted = 0;
  /// So many states s' after those are the inputs themselves: their rows of A are 0, those of B the identity, and the first
  /// `shifted` states do no more than move on. 0 or [m].
  int placed = 0;
  // [m] what `weight` measures where that is not the inputs: by the state and by the inputs, else empty
  MatrixXd measured_by_state;  // [m][n]
  MatrixXd measured_by_input;  // [m][m]
};

/// The whole program near a point; the first state does not change.
struct StageModel {
  std::vector<Stage> stage;  // [N]
  MatrixXd Q_end;            // [n][n]
  VectorXd q_end;            // [n]
  MatrixXd metric_end;       // [n][n]
  MatrixXd C;                // [end_rows][n] C s + c = 0 at the end
  VectorXd c;                // [end_rows]
  explicit StageModel(const StageSizes& sizes);
};

/// First derivatives along the chain: how states move, and the cost's gradient.
struct StageSlopes {
  struct Slope {
    MatrixXd A;  // [n][n]
    MatrixXd B;  // [n][m]
    VectorXd q;  // [n]
    VectorXd r;  // [m]
  };
  std::vector<Slope> stage;  // [N]
  VectorXd q_end;            // [n]
  MatrixXd C;                // [end_rows][n]
  VectorXd c;                // [end_rows]
  explicit StageSlopes(const StageSizes& sizes);
};

/// A step through all stages, and the multipliers that go with it.
struct StageStep {
  std::vector<VectorXd> state;    // [N + 1][n]
  std::vector<VectorXd> input;    // [N][m]
  std::vector<VectorXd> costate;  // [N + 1][n] gradient of what is still to come by the state
  VectorXd end_multiplier;        // [end_rows]
  bool shifted = false;  // whether the model's Hessian had to be: its multipliers are then those of the shift too
  explicit StageStep(const StageSizes& sizes);
};

/// How good a point is.
struct Merit {
  double cost = 0.0;       // with what multipliers make of the gaps
  double gaps = 0.0;       // that part of it, which a step takes off
  double violation = 0.0;  // sum of the absolute values of end rows and, in the program's own scale, of the gaps
  double round_off = 0.0;  // of the cost, beside a few digits of its own: of terms that weigh a great deal
};

/// What a model says of a step: after a share of it a merit is better by rate·share − ½ bend·share².
struct Promise {
  double rate = 0.0;
  double bend = 0.0;
};

class StageProgram {
 public:
  virtual ~StageProgram() = default;
  virtual StageSizes sizes() const = 0;
  virtual const Merit& merit() const = 0;
  /// The point's cost for people, where merit().cost is more or less than that.
  virtual double cost() const { return merit().cost; }
  /// Whether the point came with multipliers; else a search estimates them first.
  virtual bool has_multipliers() const { return false; }
  /// The model at the point, the Lagrangian with the point's multipliers.
  virtual void linearize(StageModel& model) = 0;
  /// First derivatives at the point alone, without those of the multipliers' terms. Returns false, where the program does not give them by
  /// themselves.
  virtual bool differentiate(StageSlopes&) { return false; }
  /// Moves to a trial point; nothing where there is no motion.
  virtual const Merit* try_step(const StageStep& step, double length) = 0;
  /// End rows at the point and at the trial point.
  virtual const VectorXd& end_rows() const = 0;
  virtual const VectorXd& trial_end_rows() const = 0;
  /// The trial point becomes the point.
  virtual void accept() = 0;
  /// Whether take_multipliers reads a step's costates.
  virtual bool takes_costates() const { return true; }
  /// Takes over a share of a step's multipliers.
  virtual void take_multipliers(const StageStep& step, double length) = 0;
  /// Largest sensible length of a step, at most 1: where limits bend more than the model has it, as far as they leave something of what
  /// it promises. Without a promise no limit may come to an end.
  virtual double longest(const StageStep& step, const Promise& promise) = 0;
  /// Violation of a point that does nothing at all, which a search must not take for a small one; infinite: there is none such.
  virtual double idle_violation() const { return std::numeric_limits<double>::infinity(); }
  /// A number a person understands: how far the point is from the goal.
  virtual double goal_error() const = 0;
  /// How far the point is from keeping what every point of the program keeps, of its own scale; NaN: not measured.
  virtual double drift() const { return std::numeric_limits<double>::quiet_NaN(); }
  /// Whether there are limits at all.
  virtual bool limited() const { return false; }
  /// Limits that are terms of the cost with multipliers: how far they are from being met and complementary, 0 without.
  virtual double limit_error() const { return 0.0; }
  /// How far limits are broken; the rest of limit_error is of kinks in the cost.
  virtual double limit_violation() const { return limit_error(); }
  /// Takes the limits' multipliers that belong to the point and comes nearer to the limits from now on; the cost changes by it.
  /// `heavier`: whether other terms with multipliers weigh more where they have not come much nearer.
  virtual void renew_limits(bool /*heavier*/) {}
  /// Whether limits pull as they do at an answer of the same program.
  virtual bool pulled_as_answer() const { return false; }
  /// Makes those so many times weaker to begin with. Returns false where they are as weak as those of a first guess.
  virtual bool ease_limits(double /*times*/) { return false; }
  /// Adds to the model's gradient what limits changed by beyond first order on the way to the latest trial point, a length of the
  /// step away. Returns false where there are none.
  virtual bool bend_limits(const StageStep& /*step*/, double /*length*/, StageModel& /*model*/) { return false; }
  /// Takes that off again.
  virtual void unbend_limits(StageModel& /*model*/) {}
  /// Whether models have gaps that bend.
  virtual bool has_gaps() const { return false; }
  /// Adds to the model's gaps what the latest trial point, a length of a step away, misses of them beyond first order.
  virtual void bend_gaps(double /*length*/, StageModel& /*model*/) {}
  /// Takes off again what calls since the last one have added.
  virtual void unbend_gaps(StageModel& /*model*/) {}
  /// Once limits are nearly met: those that hold become equalities and others have no part, until renew_limits finds that another
  /// set of them holds. Returns false where there is nothing to do.
  virtual bool land() { return false; }
  virtual bool landed() const { return false; }
  /// Back to the point where `land` was called, and all limits are limits again.
  virtual void take_off() {}
  /// Keeps what limits are worth at an answer that a barrier has found, and after take_off takes it back.
  virtual void keep_worth() {}
  virtual void take_kept_worth() {}
  /// Makes the weight of those equalities so many times larger.
  virtual void weigh_landed(double /*times*/) {}
};

}  // namespace lamprey::optimizer
