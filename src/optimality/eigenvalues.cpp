#include "optimality/eigenvalues.hpp"

#include <cmath>

namespace lamprey::optimality {

namespace {

constexpr double row_weight = 1e6, heavier_rows = 100.0;  // of the metric, and times that
constexpr double agreed_value = 0.01;
constexpr double same_direction = 0.99;  // cosine: of the flat direction with that in which the phase changes

// Nothing where they cannot be told.
std::optional<SecondOrder> eigenvalues_by_one_sweep(const Chain& chain, double cost) {
  ChainSolver solver(chain, penalty_per_cost * cost);
  SecondOrder result;
  const SmallestEigenvalue smallest = smallest_eigenvalue(chain, solver);
  result.smallest_eigenvalue = smallest.value;
  if (std::isnan(result.smallest_eigenvalue)) return std::nullopt;
  result.positive = smallest.bound >= curvature_mark || solver.factor(curvature_mark) == 0;
  result.negative_eigenvalues = result.positive ? 0 : solver.factor(-curvature_mark);  // a flat direction is no descent
  // round-off may count fewer than rows take
  if (result.negative_eigenvalues.value_or(0) < 0) result.negative_eigenvalues = std::nullopt;
  return result;
}

// Of a gait, one direction of whose form is flat: where that is the one in which its phase changes, the numbers without it.
SecondOrder beside_phase(const Chain& chain, double cost, const Inputs& phase, const SecondOrder& whole) {
  ChainSolver solver(chain, penalty_per_cost * cost);
  const std::optional<Eigenvector> flat = eigenvector_near(chain, solver, -2.0 * curvature_mark, phase);
  if (!flat || std::abs(flat->cosine) < same_direction) return whole;
  const SmallestEigenvalue next = smallest_eigenvalue(chain, solver, &flat->inputs);
  const std::optional<int> below = solver.factor(curvature_mark);
  if (std::isnan(next.value) || below != 1 || !(next.value > curvature_mark)) return whole;
  SecondOrder result = whole;
  result.smallest_eigenvalue = next.value;
  result.positive = true;
  result.along_phase = whole.smallest_eigenvalue;
  return result;
}

// A flat direction is neither one of descent nor one of a proof.
bool is_flat(const SecondOrder& found) {
  return !found.positive && found.negative_eigenvalues == 0 && std::abs(found.smallest_eigenvalue) <= curvature_mark;
}

// Whether two weights of rows say the same.
bool agree(const std::optional<SecondOrder>& one, const std::optional<SecondOrder>& two) {
  return one && two && one->negative_eigenvalues == two->negative_eigenvalues &&
         std::abs(one->smallest_eigenvalue - two->smallest_eigenvalue) <=
             agreed_value * std::abs(two->smallest_eigenvalue);
}

// Rows that are weighed in the form prove a minimum wherever they leave it definite. Where they do not, the weight may be too small,
// which rows that are kept do not know; but inputs that keep one row after the other may swing beyond what a sweep can follow.
std::optional<SecondOrder> of_all_directions(const Chain& chain, double cost) {
  if (!keeps_rows(chain)) return eigenvalues_by_one_sweep(chain, cost);
  const auto positive = [](const std::optional<SecondOrder>& found) { return found && found->positive; };
  const std::optional<SecondOrder> weighed = eigenvalues_by_one_sweep(with_rows_weighed(chain, row_weight), cost);
  if (positive(weighed)) return weighed;
  const std::optional<SecondOrder> kept = eigenvalues_by_one_sweep(chain, cost);
  if (positive(kept)) return kept;
  const std::optional<SecondOrder> heavier =
      eigenvalues_by_one_sweep(with_rows_weighed(chain, heavier_rows * row_weight), cost);
  return positive(heavier) || agree(weighed, heavier) ? heavier : kept;
}

}  // namespace

std::optional<SecondOrder> eigenvalues_of(const Chain& chain, double cost, const std::optional<Inputs>& phase) {
  const std::optional<SecondOrder> whole = of_all_directions(chain, cost);
  return whole && phase && is_flat(*whole) ? beside_phase(chain, cost, *phase, *whole) : whole;
}

}  // namespace lamprey::optimality
