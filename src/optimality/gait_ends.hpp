// The two ends of a gait: what is free at its first state, how its last state has to fit, and what both add to second
// derivatives (chapter 6).
#pragma once

#include <optional>

#include "optimality/reached_tangent.hpp"

namespace lamprey::optimality {

/// Directions of a gait's first state, of a swimmer without total momentum: turns of the bodies but the root (where the
/// shape is free), then momenta along their freedoms by `momentum_unit` kg m²/s; the root's momentum makes up for both.
/// [n][free] as integrator::StateLayout; units [freedoms but the root's].
MatrixXd periodic_start(const StoredMotion& motion, const integrator::State& first, const VectorXd& momentum_unit);

/// Rows of a gait's last state that its first state has to share, shape in rad, then momenta by `momentum_unit`:
/// [2 freedoms but the root's][n]. The last as many as periodic_start has columns belong to these.
MatrixXd closure_rows(const StoredMotion& motion, const integrator::State& last, const VectorXd& momentum_unit);

/// The number of freedoms of all bodies but the root.
Eigen::Index shape_freedoms(const StoredMotion& motion);

/// What of those directions lies in what moments reach, orthonormal combinations [free][kept]. Nothing where a motion out
/// of reach might close as well (equation 6.19). `directions` and `closure` in the tangents' units.
std::optional<MatrixXd> start_within_reach(const StepTangents& tangents, const std::vector<MatrixXd>& basis,
                                           const MatrixXd& directions, const MatrixXd& closure);

/// Second derivative along directions of the first state of costate · root's momentum, which zero total momentum makes
/// depend on the others: [columns]² (equation 6.17).
MatrixXd start_curvature(const StoredMotion& motion, const integrator::State& first, const MatrixXd& directions,
                         const VectorXd& costate);

/// Second derivative of multipliers · closure by the last node's freedoms, where the closure's rows are kept:
/// [turns][turns] (equation 6.18).
MatrixXd closure_curvature(const StoredMotion& motion, const VectorXd& multipliers);

}  // namespace lamprey::optimality
