// The linearised motion in coordinates of what its moments reach: no total momentum, nothing out of a plane that they
// keep. What they do not reach may be unstable, and its round-off would drown the rest.
#pragma once

#include <optional>

#include "certificate/stored_motion.hpp"

namespace lamprey::certificate {

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

/// Orthonormal bases of what moments reach at each node, [N + 1][n][reached], the first unset: nothing has arrived
/// there (equation 6.10). Empty where they do not
/// fit together.
std::vector<MatrixXd> reached_bases(const StepTangents& tangents);

/// The states at the start that the first step leads into what is reached after it, [n][reached] orthonormal.
MatrixXd basis_at_start(const StepTangents& tangents, const std::vector<MatrixXd>& basis);

/// Orthonormal columns of what is beside orthonormal columns.
MatrixXd complement(const MatrixXd& orthonormal_columns);

}  // namespace lamprey::certificate
