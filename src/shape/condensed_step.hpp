// The stages of one step as one: shapes between the step's ends are eliminated, which leaves a stage of the optimizer
// whose state is (shape, momenta of the shape, root's turn ρ and position χ in the world) and whose inputs are the
// coefficients of the step's moments (equations 12.4 to 12.7).
#pragma once

#include <vector>

#include "optimizer/stage_program.hpp"
#include "shape/shape_step.hpp"

namespace lamprey::shape {

/// One stage of the step: how momenta and the root's motion depend on the shapes at its ends.
struct StageLink {
  ShapeTangent tangent;   // moments held
  MatrixXd hessian;       // [2 f + 3] squared, of the Lagrangian by (left shape, right shape, ρ at its end)
  Vector3d displacement;  // m, of the root, world
  VectorXd missing;       // [f] impulse that the moments at its beginning leave open
};

/// Moments at a node of the step.
struct StageForce {
  MatrixXd impulse;           // [f][m] along the shape's coordinates by unit moments over unit time
  MatrixXd control_by_shape;  // [m][f] second derivative of the Lagrangian by moments and shape, over unit time
  VectorXd value;             // [terms] polynomials at the node
};

/// Sizes of a step and its stages' lengths.
struct StepLayout {
  int shape;                 // f
  int moments;               // m
  int terms;                 // coefficients of each moment
  std::vector<double> time;  // [stages] s, some negative
  MatrixXd pose_basis;       // [6][p]
  int stages() const { return static_cast<int>(time.size()); }
  int inputs() const { return moments * terms; }
  int poses() const { return static_cast<int>(pose_basis.cols()); }
  int states() const { return 2 * shape + poses(); }
  int constant() const { return 2 * shape + inputs(); }  // place of the 1 in (shape, momenta, inputs, 1)
};

/// Costate at a node of the step: gradient of what is still to come by shape, its momenta and the root's pose.
struct StepCostate {
  VectorXd shape;     // [f]
  VectorXd momentum;  // [f]
  Vector6d pose;
};

/// What condensing one step after the other writes on. Rows, padded: by (shape, momenta, inputs, 1) at the step's beginning.
struct CondensingSpace {
  explicit CondensingSpace(const StepLayout& layout);
  MatrixXd equations;      // [f, padded][2 f]
  MatrixXd momentum;       // [rows][f]
  MatrixXd shift;          // [rows][3] of the root's position
  MatrixXd hessian;        // [2 f + 3] squared, by (left shape, ρ, right shape)
  MatrixXd bent;           // [rows][2 f + 3]
  MatrixXd mixed;          // [rows][inputs]
  MatrixXd gram;           // [rows] squared
  MatrixXd gram_turn;      // [rows][3]
  MatrixXd rate, weighed;  // [rows][f]
  MatrixXd metric;         // [rows] squared
  MatrixXd pose, by_pose;  // [rows][p]
};

class CondensedStep {
 public:
  explicit CondensedStep(const StepLayout& layout);

  /// To be filled: links [stages] and forces [stages + 1].
  std::vector<StageLink> link;
  std::vector<StageForce> force;

  /// Eliminates the inner shapes: A, B, gap, Q, S, R, q, r of a stage, the effort left out. Returns false where a stage is singular.
  bool condense(CondensingSpace& space, optimizer::Stage& stage);

  /// A change of state and inputs that also closes the gaps, as (shape, momenta, inputs, 1), padded.
  void pack(const VectorXd& state, const VectorXd& input, VectorXd& all) const;
  /// Change of the shape along it at a node of the step, 1 … stages.
  void shape_along(int node, const VectorXd& all, Eigen::Ref<VectorXd> shape) const;

  /// Costates at the nodes 0 … stages − 1 of the step from that at its end, along a change of state and inputs.
  void carry_back(const VectorXd& state, const VectorXd& input, const StepCostate& end,
                  std::vector<StepCostate>& costate) const;

  /// The metric of a stage: Σ (θ_{s+1} − θ_s)ᵀ D_s (θ_{s+1} − θ_s) over the stages of the step, D_s = scale · |diag E⁻_{s,r}|.
  void measure_rates(double scale, CondensingSpace& space, optimizer::Stage& stage) const;

 private:
  bool invert(int s, MatrixXd& equations);
  void add_force(int node, double weight, MatrixXd& rows) const;
  void eliminate(int s, CondensingSpace& space);
  void add_curvature(CondensingSpace& space) const;
  void add_mixed(CondensingSpace& space) const;
  void write_motion(CondensingSpace& space, optimizer::Stage& stage) const;
  void write_curvature(CondensingSpace& space, optimizer::Stage& stage) const;
  void reorder(const MatrixXd& hessian, MatrixXd& ordered) const;
  double half_time(int node) const;

  int node(int s) const { return s * (layout_.shape + 3); }
  auto turn(int s) const { return nodes_.middleCols<3>(node(s)); }
  auto turn(int s) { return nodes_.middleCols<3>(node(s)); }
  auto shape(int s) const { return nodes_.middleCols(node(s) + 3, layout_.shape); }
  auto shape(int s) { return nodes_.middleCols(node(s) + 3, layout_.shape); }
  auto ends(int s) const { return nodes_.middleCols(node(s) + 3, 2 * layout_.shape + 3); }

  const StepLayout& layout_;
  // [rows][stages + 1 times (3 + f)], rows as in CondensingSpace: at each node the root's turn, beside what the pose at the
  // beginning makes, and the shape. A stage's left shape, turn at its end and right shape thus lie side by side.
  MatrixXd nodes_;
  std::vector<MatrixXd> inverse_;  // [stages][f][f] of E⁻ by the right shape
};

}  // namespace lamprey::shape
