#include "optimality/reached_tangent.hpp"

#include <array>

#include <Eigen/QR>

#include "algebra/row_space.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/step_polynomial.hpp"

namespace lamprey::optimality {

namespace {

using model::at;

constexpr int windows = 20;       // a growth of 1e20 over the whole is 10 over each
constexpr int least_window = 12;  // steps: brackets of shapes take their time
// Of what is reached most. Steps reach directions that no motion does, by their own error: of a single joint angle the pose that
// goes with it, to 1e-9. Spaces that hold such a direction do not lead into each other, and are looked for without it.
constexpr std::array beyond_reach = {1e-10, 1e-8, 1e-6};
// Slow motions of many steps show little of what brackets of moments reach in a short while, where nothing grows fast.
constexpr std::array parts_of_motion = {windows, 8, 4, 2, 1};
constexpr double misfit = 1e-6;
constexpr double beside_reach = 1e-7;  // of the longest direction of a start

int window_steps(int steps, int parts = windows) {
  return std::min(steps, std::max(least_window, (steps + parts - 1) / parts));
}

// Sizes of turns, shifts and momenta that belong together: a turn by 1 rad within `duration` s.
VectorXd balanced_scale(const StoredMotion& motion, double duration) {
  const VectorXd inertia = mechanics::generalized_inertia(motion.system, motion.solution.rotation.front()).diagonal();
  const Eigen::Index turns = inertia.size() - 3;
  VectorXd size = VectorXd::Ones(inertia.size());
  size.tail<3>().setConstant(std::sqrt(inertia.head(turns).maxCoeff() / inertia.tail<3>().maxCoeff()));
  VectorXd scale(2 * inertia.size());
  scale << size, inertia.cwiseProduct(size) / duration;
  return scale;
}

// Orthonormal columns that span what `steps` steps up to a node reach there.
MatrixXd reached_at(const StepTangents& tangents, int node, int steps, double least) {
  const Eigen::Index n = tangents.scale.size(), controls = tangents.B.front().cols();
  MatrixXd root = MatrixXd::Zero(n, n), both(n + controls, n);
  for (int k = std::max(0, node - steps); k < node; ++k) {
    both.topRows(n).noalias() = (tangents.A[at(k)] * root).transpose();
    both.bottomRows(controls) = tangents.B[at(k)].transpose();
    const Eigen::HouseholderQR<MatrixXd> qr(both);
    root = MatrixXd(qr.matrixQR().topRows(n).triangularView<Eigen::Upper>()).transpose();
  }
  return algebra::span_of_rows(root.transpose(), least);
}

MatrixXd orthonormal(const MatrixXd& columns) { return algebra::span_of_rows(columns.transpose(), 0.0); }

double misses(const MatrixXd& space, const MatrixXd& columns) {
  return (columns - space * (space.transpose() * columns)).norm() / columns.norm();
}

}  // namespace

MatrixXd complement(const MatrixXd& orthonormal_columns) {
  return algebra::null_space(orthonormal_columns.transpose());
}

StepTangents step_tangents(const StoredMotion& motion) {
  const model::System& system = motion.system;
  StepTangents result;
  result.scale = balanced_scale(motion, motion.time_step * window_steps(motion.steps));
  const auto unit = result.scale.cwiseInverse().asDiagonal();
  integrator::TangentWorkspace work(system);
  integrator::StepTangent tangent(system);
  mechanics::Interval interval(system.body_count());
  result.impulse.emplace_back(MatrixXd::Zero(result.scale.size(), system.control_count()));
  for (int k = 0; k < motion.steps; ++k) {
    evidence::read_interval(motion, k, interval);
    integrator::linearize_step(system, motion.lagrangian, motion.time_step, interval, motion.control[at(k)],
                               motion.control[at(k + 1)], work, tangent);
    result.A.emplace_back(unit * tangent.A * result.scale.asDiagonal());
    result.B.emplace_back(unit * tangent.B);
    result.B.back().noalias() += result.A.back() * result.impulse.back();
    result.impulse.emplace_back(unit * tangent.B_next);
  }
  result.B.push_back(result.impulse.back());
  return result;
}

std::vector<VectorXd> StepStages::pull_back(const VectorXd& scale, const VectorXd& costate) const {
  std::vector<VectorXd> result(A.size() + 1, costate);
  VectorXd scaled = scale.cwiseProduct(costate);
  for (std::size_t s = A.size(); s-- > 0;) {
    scaled = (A[s].transpose() * scaled).eval();
    result[s] = scaled.cwiseQuotient(scale);
  }
  return result;
}

StepStages step_stages(const StoredMotion& motion, const StageMotion& stages, int k, const VectorXd& scale) {
  const Eigen::Index n = scale.size(), controls = motion.system.control_count(), inputs = stages.terms * controls;
  const auto unit = scale.cwiseInverse().asDiagonal();
  integrator::TangentWorkspace work(motion.system);
  integrator::StepTangent tangent(motion.system);
  StepStages result;
  for (double fraction : stages.fraction) {
    const VectorXd value = maneuver::legendre(fraction, stages.terms);
    MatrixXd& moment = result.moment.emplace_back(MatrixXd::Zero(controls, inputs));
    for (int term = 0; term < stages.terms; ++term)
      moment.middleCols(term * controls, controls).diagonal().setConstant(value[term]);
  }
  result.by_state.emplace_back(MatrixXd::Identity(n, n));
  result.by_coefficients.emplace_back(MatrixXd::Zero(n, inputs));
  for (int s = 0; s < stages.stages; ++s) {
    const mechanics::ForcedStep stage = evidence::forced_stage(motion, stages, k, s);
    integrator::linearize_step(motion.system, motion.lagrangian, stage.time_step, stage.interval, stage.control,
                               stage.control_next, work, tangent);
    const MatrixXd& A = result.A.emplace_back(unit * tangent.A * scale.asDiagonal());
    const MatrixXd driven = tangent.B * result.moment[at(s)] + tangent.B_next * result.moment[at(s + 1)];
    result.by_state.emplace_back(A * result.by_state.back());
    result.by_coefficients.emplace_back(A * result.by_coefficients.back() + unit * driven);
  }
  return result;
}

StepTangents step_tangents(const StoredMotion& motion, const StageMotion& stages) {
  StepTangents result;
  result.scale = balanced_scale(motion, motion.time_step * window_steps(motion.steps));
  for (int k = 0; k < motion.steps; ++k) {
    StepStages step = step_stages(motion, stages, k, result.scale);
    result.A.push_back(std::move(step.by_state.back()));
    result.B.push_back(std::move(step.by_coefficients.back()));
  }
  return result;
}

namespace {

// The spaces of what is reached by more than the least share; empty where they do not lead into each other.
std::vector<MatrixXd> bases_of_share(const StepTangents& tangents, int window, double least) {
  const int steps = static_cast<int>(tangents.A.size());
  std::vector<MatrixXd> basis(at(steps + 1));
  Eigen::Index most = 0;
  std::vector<int> anchors;
  for (int node = steps; node > 0; node -= window) {
    if (node < window && !anchors.empty()) break;  // too short to reach everything
    basis[at(node)] = reached_at(tangents, node, window, least);
    most = std::max(most, basis[at(node)].cols());
    anchors.push_back(node);
  }
  int last = 0;
  for (int node : anchors)
    if (basis[at(node)].cols() < most)
      basis[at(node)].resize(0, 0);
    else
      last = std::max(last, node);
  for (int k = last; k < steps; ++k) basis[at(k + 1)] = orthonormal(tangents.A[at(k)] * basis[at(k)]);
  // what is not reached is carried back by the transposed steps
  MatrixXd rest;
  for (int k = steps; k > 0; --k) {
    if (basis[at(k)].size() > 0) {
      rest = complement(basis[at(k)]);
    } else {
      rest = orthonormal(tangents.A[at(k)].transpose() * rest);
      basis[at(k)] = complement(rest);
    }
  }
  for (int k = 0; k < steps; ++k) {
    const MatrixXd& next = basis[at(k + 1)];
    if (!(misses(next, tangents.B[at(k)]) <= misfit)) return {};
    if (k > 0 && !(misses(next, tangents.A[at(k)] * basis[at(k)]) <= misfit)) return {};
  }
  return basis;
}

}  // namespace

std::vector<MatrixXd> reached_bases(const StepTangents& tangents) {
  const int steps = static_cast<int>(tangents.A.size());
  for (const double least : beyond_reach)
    for (const int parts : parts_of_motion)
      if (auto basis = bases_of_share(tangents, window_steps(steps, parts), least); !basis.empty()) return basis;
  return {};
}

MatrixXd basis_at_start(const StepTangents& tangents, const std::vector<MatrixXd>& basis) {
  return complement(orthonormal(tangents.A.front().transpose() * complement(basis[1])));
}

void take_in(const StepTangents& tangents, const MatrixXd& directions, std::vector<MatrixXd>& basis) {
  const auto beside = [](const MatrixXd& space, const MatrixXd& columns) {
    return MatrixXd(columns - space * (space.transpose() * columns));
  };
  MatrixXd added = algebra::span_of_rows(beside(basis.front(), directions).transpose(), beside_reach);
  for (std::size_t k = 0; k < basis.size(); ++k) {
    if (k > 0) added = orthonormal(beside(basis[k], tangents.A[k - 1] * added));
    MatrixXd both(added.rows(), basis[k].cols() + added.cols());
    both << basis[k], added;
    basis[k] = both;
  }
}

}  // namespace lamprey::optimality
