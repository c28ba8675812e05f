#include "integrator/step_derivatives.hpp"

#include <cmath>
#include <limits>

#include "algebra/tiles.hpp"

namespace lamprey::integrator {

namespace {

using mechanics::ForcedStep;
using model::at;
using model::System;

constexpr int few_freedoms = 40;  // up to here the inverse of a dense matrix is faster than a way through the tree

// Calls f with each freedom of each body: body, entry, its place in generalised vectors.
template <typename Function>
void for_each_freedom(const System& system, const Function& f) {
  for (int i = 0; i < system.body_count(); ++i)
    for (int entry = 0; entry < system.body(i).freedoms; ++entry)
      f(at(i), entry, system.body(i).velocity_offset + entry);
}

// Three numbers of each row from `first` on as columns.
void put(const mechanics::Rows3& rows, Eigen::Index first, double* to, Eigen::Index stride, Eigen::Index count) {
  for (; count > 0; count -= 4, first += 4) {
    mechanics::Four3 v = mechanics::four_rows(rows, first);
    mechanics::Four beyond{};
    algebra::transpose(v.x, v.y, v.z, beyond);
    const mechanics::Four columns[] = {v.x, v.y, v.z, beyond};
    for (Eigen::Index c = 0; c < 4 && c < count; ++c, to += stride) {
      algebra::store(__builtin_shufflevector(columns[c], columns[c], 0, 1), to);
      to[2] = columns[c][2];
    }
  }
}

void put(const mechanics::Rows3& rows, Eigen::Index first, Eigen::Ref<MatrixXd> columns) {
  put(rows, first, columns.data(), columns.outerStride(), columns.cols());
}

// Rows of freedoms from `first` on as columns, bodies one below the other.
void put(const System& system, const mechanics::FreedomRows& freedoms, Eigen::Index first,
         Eigen::Ref<MatrixXd> columns) {
  for (int i = 0; i < system.body_count(); ++i) {
    const model::Body& body = system.body(i);
    const mechanics::Rows3& rows = freedoms[at(i)];
    double* to = columns.data() + body.velocity_offset;
    if (body.freedoms == 3) {
      put(rows, first, to, columns.outerStride(), columns.cols());
      continue;
    }
    for (Eigen::Index r = 0; r < columns.cols(); ++r)
      for (int entry = 0; entry < body.freedoms; ++entry)
        to[r * columns.outerStride() + entry] = rows(first + r, entry);
  }
}

// Rows of freedoms from `first` on as they lie, a column for each freedom.
void lay(const System& system, const mechanics::FreedomRows& freedoms, Eigen::Index first, MatrixXd& columns,
         Eigen::Index place) {
  const Eigen::Index rows = columns.rows();
  for_each_freedom(system, [&](std::size_t i, int entry, int freedom) {
    const double* from = &freedoms[i].coeffRef(first, entry);
    double* to = &columns.coeffRef(0, place + freedom);
    for (Eigen::Index r = 0; r < rows; r += 4) algebra::store(algebra::load<mechanics::Four>(from + r), to + r);
  });
}

// to = fromᵀ, `from` with spare rows up to a multiple of four. Returns the sum of all entries: not finite if any is not.
double put_transposed(const Eigen::Ref<const MatrixXd>& from, Eigen::Ref<MatrixXd> to) {
  using mechanics::Four;
  const auto column = [&](Eigen::Index r, Eigen::Index c) { return algebra::load<Four>(&from.coeffRef(r, c)); };
  const Eigen::Index fours = from.cols() / 4 * 4;
  Four sum{};
  double rest = 0.0;
  for (Eigen::Index r = 0; r < to.cols(); r += 4) {
    const Eigen::Index count = std::min<Eigen::Index>(4, to.cols() - r);
    for (Eigen::Index c = 0; c < fours; c += 4) {
      Four part[] = {column(r, c), column(r, c + 1), column(r, c + 2), column(r, c + 3)};
      algebra::transpose(part[0], part[1], part[2], part[3]);
      for (Eigen::Index i = 0; i < count; ++i) algebra::store(part[i], &to.coeffRef(c, r + i)), sum += part[i];
    }
    for (Eigen::Index c = fours; c < from.cols(); ++c)
      for (Eigen::Index i = 0; i < count; ++i) rest += to(c, r + i) = from(r + i, c);
  }
  return rest + algebra::sum(sum);
}

// Turns at k + 1, the root's displacement and E⁺ by the momentum at k: K⁻¹ and P K⁻¹, where turns at k + 1 and the
// displacement make K of the momentum at k and P of that at k + 1; by the equations Kᵀ Z = (I, Pᵀ).
bool by_momentum_dense(TangentWorkspace& work, const System& system, Eigen::Ref<MatrixXd> result) {
  const Eigen::Index half = system.velocity_count(), turns = half - 3;
  MatrixXd& equations = work.equations;
  lay(system, work.jacobian.minus, work.left_rows, equations, 0);
  equations.middleCols(turns, 3) = work.jacobian.linear.middleRows(work.left_rows, equations.rows());
  equations.middleCols(half, half).setIdentity();
  lay(system, work.jacobian.plus, work.left_rows, equations, 2 * half);
  algebra::solve_columns(half, equations);
  return std::isfinite(put_transposed(equations.rightCols(half + turns), result));
}

// One row for each freedom's momentum, and three for p_x.
void lay_unit_momenta(const System& system, TangentWorkspace& work) {
  const Eigen::Index half = system.velocity_count();
  for (mechanics::Rows3& rows : work.right) mechanics::clear_rows(half, rows);
  for_each_freedom(system, [&](std::size_t i, int entry, int place) { work.right[i](place, entry) = 1.0; });
  mechanics::clear_rows(half, work.displacement);
  work.displacement.middleRows(half - 3, 3).setIdentity();
}

// The same of many bodies.
bool by_momentum_through_tree(const ForcedStep& step, TangentWorkspace& work, Eigen::Ref<MatrixXd> result) {
  const System& system = step.system;
  const mechanics::Rotations &left = step.interval.rotation, &right = step.interval.next_rotation;
  const Eigen::Index half = system.velocity_count(), turns = half - 3;
  mechanics::damping_blocks(system, step.interval, work.damping);
  if (!work.elimination.factor(system, left, right, work.blocks, work.damping)) return false;
  lay_unit_momenta(system, work);
  work.elimination.solve_rows(system, left, right, work.right, work.displacement);
  put(system, work.right, 0, result.topRows(turns));
  put(work.displacement, 0, result.middleRows(turns, 3));
  put(system, work.jacobian.plus, work.left_rows, work.next_by_right);
  algebra::set_product(work.next_by_right, result.topRows(half), result.bottomRows(turns));
  return true;
}

}  // namespace

StepTangent::StepTangent(const System& system)
    : A(MatrixXd::Zero(2 * system.velocity_count(), 2 * system.velocity_count())),
      B(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())),
      B_next(MatrixXd::Zero(2 * system.velocity_count(), system.control_count())) {
  const StateLayout layout{system};
  A.block<3, 3>(layout.position(), layout.position()).setIdentity();
  A.block<3, 3>(layout.linear(), layout.linear()).setIdentity();
}

TangentWorkspace::TangentWorkspace(const System& system)
    : balance(system.body_count()),
      rates(at(system.body_count())),
      blocks(at(system.body_count())),
      damping(at(system.body_count()), Matrix3d::Zero()),
      elimination(system),
      left_rows(mechanics::rows_for(system.velocity_count() - 3)),
      directions(system.body_count(), left_rows + system.velocity_count()),
      jacobian(system.body_count(), left_rows + system.velocity_count()),
      right(at(system.body_count()), mechanics::Rows3(mechanics::rows_for(system.velocity_count()), 3)),
      displacement(mechanics::rows_for(system.velocity_count()), 3),
      by_turns(system.velocity_count(), system.velocity_count() - 3),
      next_by_right(system.velocity_count() - 3, system.velocity_count()),
      dense(system.velocity_count() <= few_freedoms),
      equations(mechanics::rows_for(system.velocity_count()), 3 * system.velocity_count() - 3),
      by_controls(system.velocity_count() - 3, system.control_count()) {
  for_each_freedom(system, [&](std::size_t i, int entry, int place) {
    directions.left[i](place, entry) = 1.0;
    directions.right[i](left_rows + place, entry) = 1.0;
  });
  directions.displacement.middleRows(left_rows + system.velocity_count() - 3, 3).setIdentity();
  for (int i = 0; i < system.body_count(); ++i) {
    if (system.body(i).freedoms < 3) continue;
    directions.left_support[at(i)] = {system.body(i).velocity_offset, {0}};
    directions.right_support[at(i)] = {left_rows + system.body(i).velocity_offset, {0}};
  }
}

bool factor_step(const ForcedStep& step, const mechanics::DiscreteMomenta& momenta,
                 std::vector<mechanics::BodyBlock>& blocks, std::vector<Matrix3d>& damping,
                 mechanics::TreeElimination& elimination) {
  mechanics::step_blocks(step.system, step.lagrangian, step.time_step, step.interval, momenta, blocks);
  mechanics::damping_blocks(step.system, step.interval, damping);
  return elimination.factor(step.system, step.interval.rotation, step.interval.next_rotation, blocks, damping);
}

void linearize_step(const System& system, DiscreteLagrangian lagrangian, double h, const mechanics::Interval& interval,
                    const Moments& control, const Moments& control_next, TangentWorkspace& work, StepTangent& tangent) {
  const int half = system.velocity_count(), turns = half - 3;
  const ForcedStep step{system, lagrangian, h, interval, control, control_next};
  evaluate_balance(step, work.balance);
  body_rates(step, work.balance.momenta, work.blocks, work.rates);
  rates_at_both_ends(step, work.balance, work.blocks, work.rates, work.directions, work.left_rows,
                     work.left_rows + half, work.jacobian);

  const mechanics::StepJacobian& J = work.jacobian;
  auto by_momentum = tangent.A.rightCols(half);
  const auto followed = by_momentum.topRows(half + turns);
  if (!(work.dense ? by_momentum_dense(work, system, followed) : by_momentum_through_tree(step, work, followed))) {
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    tangent.A.leftCols(turns).topRows(half + turns).setConstant(unknown);
    by_momentum.topRows(half + turns).setConstant(unknown);
    tangent.B.topRows(half + turns).setConstant(unknown);
    tangent.B_next.middleRows(half, turns).setConstant(unknown);
    return;
  }

  // what turns at k and u_k change of E⁻ counts as momentum
  put(system, J.minus, 0, work.by_turns.topRows(turns));
  put(J.linear, 0, work.by_turns.bottomRows(3));
  auto by_turns = tangent.A.topLeftCorner(half + turns, turns);
  by_turns.topRows(half).setZero();
  put(system, J.plus, 0, by_turns.bottomRows(turns));
  algebra::add_product(-1.0, followed, work.by_turns, by_turns);
  mechanics::control_columns(system, interval.rotation, 0.5 * h, work.by_controls);
  algebra::set_product(followed.leftCols(turns), work.by_controls, tangent.B.topRows(half + turns));
  mechanics::control_columns(system, interval.next_rotation, 0.5 * h, tangent.B_next.middleRows(half, turns));
}

PulledBack pull_back(const StepTangent& tangent, const MatrixXd& rows) {
  return {rows * tangent.A, rows * tangent.B, rows * tangent.B_next};
}

SweptGradients gradient_sweep(const System& system, DiscreteLagrangian lagrangian, double h,
                              const IntervalSource& source, const std::vector<Moments>& control, StepRange range,
                              const MatrixXd& end_rows) {
  const int controls = system.control_count();
  SweptGradients result{end_rows, MatrixXd::Zero(end_rows.rows(), controls * range.nodes())};
  TangentWorkspace work(system);
  StepTangent tangent(system);
  mechanics::Interval interval(system.body_count());
  for (int k = range.last - 1; k >= range.first; --k) {
    source(k, interval);
    linearize_step(system, lagrangian, h, interval, control[at(k)], control[at(k + 1)], work, tangent);
    PulledBack pulled = pull_back(tangent, result.by_start);
    result.by_control.middleCols(controls * (k - range.first), controls) += pulled.by_control;
    result.by_control.middleCols(controls * (k + 1 - range.first), controls) += pulled.by_next_control;
    result.by_start.swap(pulled.by_state);
  }
  return result;
}

}  // namespace lamprey::integrator
