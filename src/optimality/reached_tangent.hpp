// The linearised motion in coordinates of what its moments reach: no total momentum, nothing out of a plane that they
// keep. What they do not reach may be unstable, and its round-off would drown the rest.
#pragma once

#include <optional>

#include "evidence/stage_motion.hpp"

namespace lamprey::optimality {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using evidence::StageMotion;
using evidence::StoredMotion;

/// Perturbations of states (integrator::StateLayout) in units `scale`, by perturbations of the moments along
/// Joint::actuation. What arrives at a node is its state less the impulse of its own moments (equation 6.9).
struct StepTangents {
  VectorXd scale;           // [n] rad, m, kg m²/s, kg m/s
  std::vector<MatrixXd> A;  // [N][n][n] from node to node
  std::vector<MatrixXd> B;  // [N + 1][n][controls] by u_k of what arrives at node k + 1; the last: of the end state
  std::vector<MatrixXd> impulse;  // [N + 1][n][controls] by u_k of the state at node k itself; the first zero
};

/// Not finite where a step is singular.
StepTangents step_tangents(const StoredMotion& motion);

/// The same of a scheme above order 2, by the coefficients of the steps' polynomials: B is [N][n][inputs], and no impulse is
/// left over at the nodes.
StepTangents step_tangents(const StoredMotion& motion, const StageMotion& stages);

/// What a state at the beginning of a step and the coefficients of its polynomials make of the states at the nodes of its
/// stages, in units `scale`.
struct StepStages {
  std::vector<MatrixXd> A;                // [stages][n][n] from node to node
  std::vector<MatrixXd> by_state;         // [stages + 1][n][n]
  std::vector<MatrixXd> by_coefficients;  // [stages + 1][n][inputs]
  std::vector<MatrixXd> moment;           // [stages + 1][controls][inputs] moments there
  /// Gradients by the states at the stages' nodes from that at the step's end, [stages + 1][n], as integrator::StateLayout.
  std::vector<VectorXd> pull_back(const VectorXd& scale, const VectorXd& costate) const;
};
StepStages step_stages(const StoredMotion& motion, const StageMotion& stages, int k, const VectorXd& scale);

/// Orthonormal bases of what moments reach at each node, [N + 1][n][reached], the first unset: nothing has arrived
/// there (equation 6.10). Empty where they do not
/// fit together.
std::vector<MatrixXd> reached_bases(const StepTangents& tangents);

/// The states at the start that the first step leads into what is reached after it, [n][reached] orthonormal.
MatrixXd basis_at_start(const StepTangents& tangents, const std::vector<MatrixXd>& basis);

/// Bases [N + 1][n][reached] become those of what moments and directions of the start reach together.
void take_in(const StepTangents& tangents, const MatrixXd& directions, std::vector<MatrixXd>& basis);

/// Orthonormal columns of what is beside orthonormal columns.
MatrixXd complement(const MatrixXd& orthonormal_columns);

}  // namespace lamprey::optimality
