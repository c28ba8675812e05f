#include "optimizer/ipopt.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#ifndef HAVE_CSTDDEF
#define HAVE_CSTDDEF  // Debian's Ipopt headers ask for it
#endif
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <IpIpoptApplication.hpp>
#include <IpIpoptCalculatedQuantities.hpp>
#include <IpIpoptData.hpp>
#include <IpTNLP.hpp>
#pragma GCC diagnostic pop

// Where the BLAS beneath MUMPS is OpenBLAS, its threads cost more than they bring on blocks of this size.
extern "C" __attribute__((weak)) void openblas_set_num_threads(int);

namespace lamprey::optimizer {

namespace {

using Clock = std::chrono::steady_clock;
using Ipopt::Index;
using Ipopt::Number;

constexpr double sharpness =
    1e-2;  // of the tolerance, that the barrier has to reach: how near limits what they are worth holds

class Adapter : public Ipopt::TNLP {
 public:
  Adapter(Program& program, const Options& options, const VectorXd& start, const VectorXd& multipliers,
          Outcome& outcome)
      : program_(program), options_(options), outcome_(outcome), x_(start), multipliers_(multipliers) {}

  bool get_nlp_info(Index& n, Index& m, Index& jacobian, Index& hessian, IndexStyleEnum& style) override {
    n = program_.variable_count();
    m = program_.constraint_count();
    jacobian = program_.jacobian_pattern().size();
    hessian = program_.has_hessian() ? program_.hessian_pattern().size() : 0;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* c_lower, Number* c_upper) override {
    std::fill(lower, lower + n, -2e19);
    std::fill(upper, upper + n, 2e19);
    std::copy_n(program_.constraint_lower().data(), m, c_lower);
    std::copy_n(program_.constraint_upper().data(), m, c_upper);
    return true;
  }

  bool get_scaling_parameters(Number& of_objective, bool& use_x, Index n, Number* x, bool& use_c, Index m,
                              Number* c) override {
    const VectorXd variable = program_.variable_units(), constraint = program_.constraint_units();
    of_objective = 1.0;
    use_x = variable.size() == n;
    use_c = constraint.size() == m;
    for (Index i = 0; use_x && i < n; ++i) x[i] = 1.0 / variable[i];
    for (Index r = 0; use_c && r < m; ++r) c[r] = 1.0 / constraint[r];
    return true;
  }

  bool get_starting_point(Index n, bool, Number* x, bool init_z, Number* z_lower, Number* z_upper, Index m,
                          bool init_lambda, Number* lambda) override {
    std::copy_n(x_.data(), n, x);
    if (init_z) {
      std::fill(z_lower, z_lower + n, 0.0);
      std::fill(z_upper, z_upper + n, 0.0);
    }
    if (init_lambda) std::copy_n(multipliers_.data(), m, lambda);
    return true;
  }

  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = program_.objective(at(n, x));
    return std::isfinite(value);
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    values_.resize(n);
    program_.gradient(at(n, x), values_);
    std::copy_n(values_.data(), n, gradient);
    return true;
  }

  bool eval_g(Index n, const Number* x, bool, Index m, Number* c) override {
    ++outcome_.evaluations;
    values_.resize(m);
    program_.constraints(at(n, x), values_);
    std::copy_n(values_.data(), m, c);
    return values_.allFinite();
  }

  bool eval_jac_g(Index n, const Number* x, bool, Index, Index entries, Index* rows, Index* columns,
                  Number* values) override {
    if (!values) return copy_pattern(program_.jacobian_pattern(), rows, columns);
    values_.resize(entries);
    program_.jacobian(at(n, x), values_);
    std::copy_n(values_.data(), entries, values);
    return values_.allFinite();
  }

  bool eval_h(Index n, const Number* x, bool, Number factor, Index m, const Number* lambda, bool, Index entries,
              Index* rows, Index* columns, Number* values) override {
    if (!values) return copy_pattern(program_.hessian_pattern(), rows, columns);
    values_.resize(entries);
    program_.hessian(at(n, x), factor, Eigen::Map<const VectorXd>(lambda, m), values_);
    std::copy_n(values_.data(), entries, values);
    return values_.allFinite();
  }

  bool intermediate_callback(Ipopt::AlgorithmMode mode, Index iteration, Number objective, Number infeasibility,
                             Number dual_infeasibility, Number barrier, Number, Number, Number alpha, Number, Index,
                             const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    outcome_.history.push_back(
        {iteration, objective, infeasibility, dual_infeasibility, program_.goal_error(x_), alpha});
    outcome_.iterations = iteration;
    timed_out_ = options_.late(std::chrono::duration<double>(Clock::now() - begin_).count());
    interrupted_ = options_.interrupted && options_.interrupted();
    const bool sharp = !program_.has_inequalities() || barrier <= sharpness * options_.tolerance;
    const bool settled = mode == Ipopt::RegularMode && sharp;
    if (settled && infeasibility <= options_.tolerance && dual_infeasibility <= options_.tolerance) ++converged_points_;
    return !timed_out_ && !interrupted_ && !converged();
  }

  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* x, const Number*, const Number*, Index m,
                         const Number* c, const Number* lambda, Number objective, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    outcome_.point = Eigen::Map<const VectorXd>(x, n);
    outcome_.multipliers = Eigen::Map<const VectorXd>(lambda, m);
    outcome_.objective = objective;
    const Eigen::Map<const VectorXd> values(c, m);
    VectorXd missed = (program_.constraint_lower() - values).cwiseMax(values - program_.constraint_upper());
    if (const VectorXd unit = program_.constraint_units(); unit.size() == m) missed = missed.cwiseQuotient(unit);
    outcome_.infeasibility = m == 0 ? 0.0 : missed.maxCoeff();
  }

  // One point more after the tolerance is met: Newton's last step goes to round-off, further ones only stir it.
  bool converged() const { return converged_points_ >= 2; }
  bool timed_out() const { return timed_out_; }
  bool was_interrupted() const { return interrupted_; }

 private:
  const VectorXd& at(Index n, const Number* x) {
    x_ = Eigen::Map<const VectorXd>(x, n);
    return x_;
  }

  static bool copy_pattern(const SparsePattern& pattern, Index* rows, Index* columns) {
    std::copy(pattern.rows.begin(), pattern.rows.end(), rows);
    std::copy(pattern.columns.begin(), pattern.columns.end(), columns);
    return true;
  }

  Program& program_;
  const Options& options_;
  Outcome& outcome_;
  VectorXd x_;
  VectorXd multipliers_;
  VectorXd values_;
  Clock::time_point begin_ = Clock::now();
  int converged_points_ = 0;
  bool timed_out_ = false;
  bool interrupted_ = false;
};

void set_options(Ipopt::OptionsList& list, const Program& program, const Options& options, bool warm) {
  list.SetStringValue("sb", "yes");
  list.SetIntegerValue("print_level", 0);
  list.SetStringValue("linear_solver", "mumps");
  const bool in_units = program.variable_units().size() > 0 || program.constraint_units().size() > 0;
  list.SetStringValue("nlp_scaling_method", in_units ? "user-scaling" : "none");
  list.SetNumericValue("constr_viol_tol", options.tolerance);
  list.SetNumericValue("dual_inf_tol", 1.0);
  list.SetNumericValue("tol", 1e-3 * options.tolerance);  // the adapter stops earlier, by its own test
  list.SetNumericValue("compl_inf_tol", options.tolerance);
  list.SetNumericValue("bound_relax_factor", 0.0);
  list.SetIntegerValue("acceptable_iter", 0);
  list.SetIntegerValue("max_iter", options.max_iterations);
  // Approximate minimum degree is several times faster here than MUMPS's own choice; near a solution approximate minimum fill
  // without permuting for large diagonals is several times faster again, but far from one it stalls (decision 004).
  list.SetIntegerValue("mumps_pivot_order", options.near_solution ? 2 : 0);
  if (options.near_solution) list.SetIntegerValue("mumps_permuting_scaling", 0);
  if (options.near_solution && program.has_inequalities()) {  // limits that hold must not be left to be found again
    list.SetNumericValue("mu_init", 1e-6);
    list.SetNumericValue("slack_bound_push", 1e-6);
    list.SetNumericValue("slack_bound_frac", 1e-6);
  }
  // a Hessian shifted further than this leads nowhere, and its multipliers ruin the factorisation's pivots
  list.SetNumericValue("max_hessian_perturbation", 1e7);
  if (!program.has_hessian()) list.SetStringValue("hessian_approximation", "limited-memory");
  if (!warm) return;
  list.SetStringValue("warm_start_init_point", "yes");
  list.SetNumericValue("mu_init", 1e-9);
}

void explain(Ipopt::ApplicationReturnStatus status, const Adapter& adapter, Outcome& outcome) {
  const auto set = [&outcome](Termination termination, const char* reason) {
    outcome.termination = termination;
    outcome.reason = reason;
  };
  if (adapter.converged()) return set(Termination::converged, "it converged");
  if (adapter.was_interrupted()) return set(Termination::interrupted, "it was interrupted");
  if (adapter.timed_out()) return set(Termination::time_limit, "the time limit was reached");
  switch (status) {
    case Ipopt::Solve_Succeeded:
      return set(Termination::converged, "it converged");
    case Ipopt::Infeasible_Problem_Detected:
      return set(Termination::infeasible, "the constraints cannot all be met near the last point");
    case Ipopt::Maximum_Iterations_Exceeded:
      return set(Termination::stalled, "the iteration limit was reached");
    case Ipopt::Restoration_Failed:
      return set(Termination::stalled, "no step towards the constraints was found");
    case Ipopt::Solved_To_Acceptable_Level:
    case Ipopt::Search_Direction_Becomes_Too_Small:
      return set(Termination::stalled, "steps became too small to improve");
    case Ipopt::Diverging_Iterates:
      return set(Termination::stalled, "the iterates diverged");
    case Ipopt::Invalid_Number_Detected:
      return set(Termination::stalled, "a value was not finite");
    case Ipopt::Insufficient_Memory:
      return set(Termination::stalled, "memory ran out");
    default:
      return set(Termination::stalled, "Ipopt stopped with an error");
  }
}

}  // namespace

std::unique_lock<std::mutex> turn_of_ipopt() {
  static std::mutex mutex;
  return std::unique_lock(mutex);
}

Outcome solve_with_ipopt(Program& program, const Options& options, const VectorXd& start, const VectorXd& multipliers) {
  const std::unique_lock<std::mutex> turn = turn_of_ipopt();
  if (openblas_set_num_threads) openblas_set_num_threads(1);
  Outcome outcome;
  const bool warm = multipliers.size() == program.constraint_count();
  Ipopt::SmartPtr<Adapter> adapter = new Adapter(program, options, start, multipliers, outcome);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> application = new Ipopt::IpoptApplication(false);
  set_options(*application->Options(), program, options, warm);
  if (application->Initialize("") != Ipopt::Solve_Succeeded) {
    outcome.reason = "Ipopt could not be initialised";
    outcome.point = start;
    return outcome;
  }
  const Ipopt::ApplicationReturnStatus status = application->OptimizeTNLP(Ipopt::GetRawPtr(adapter));
  if (outcome.point.size() == 0) outcome.point = start;
  explain(status, *adapter, outcome);
  return outcome;
}

}  // namespace lamprey::optimizer
