#include "maneuver/feedback.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "algebra/row_space.hpp"
#include "integrator/march.hpp"
#include "integrator/step_derivatives.hpp"
#include "maneuver/asked_attitudes.hpp"
#include "maneuver/end_rows.hpp"
#include "optimizer/riccati.hpp"

namespace lamprey::maneuver {

namespace {

using integrator::ReferenceState;
using integrator::State;
using integrator::StepTangent;
using model::at;
using model::System;

constexpr int most_gains = 1000;   // intervals between gains
constexpr int reach_windows = 25;  // over which it is looked what moments can reach
constexpr int least_window = 6;    // at least so many in each
constexpr double reach_limit = 1e-10;
constexpr double no_row = 1e-12;  // of the longest, what moments do that is round-off
constexpr int cycles_ahead =
    4;  // that a gait's gains look at: more would weigh total momentum, which nothing takes away, without end
constexpr double obeyed = 1e-7;  // rad, how near a step marched again ends to where it did

// Change of the state at the end of a stage by that at its beginning and by the moments at both, which run linearly
// between: (η, δx, δξ) as deviations are.
struct StageTangent {
  MatrixXd A;
  MatrixXd B;
  MatrixXd B_next;
};

// (η, δx, δμ) by (η, δx, δξ) at a node: T = (1 0; by_turn 𝕀), η without the root's shift.
class MomentumByVelocity {
 public:
  MomentumByVelocity(const System& system, const ReferenceState& state)
      : turns_(system.velocity_count() - 3), by_turn_(MatrixXd::Zero(system.velocity_count(), turns_)) {
    mechanics::Freedoms unit(at(system.body_count()), Vector3d::Zero());
    for (int i = 0; i < system.body_count(); ++i)
      for (int f = 0; f < system.body(i).freedoms; ++f) {
        unit[at(i)][f] = 1.0;
        by_turn_.col(system.body(i).velocity_offset + f) =
            mechanics::generalized_momentum_rate(system, state.rotation, state.velocity, unit);
        unit[at(i)][f] = 0.0;
      }
    inertia_ = mechanics::generalized_inertia(system, state.rotation);
    factors_.compute(inertia_);
  }

  // m T
  MatrixXd times(const MatrixXd& m) const {
    MatrixXd result = m;
    const auto by_momentum = m.rightCols(inertia_.cols());
    result.leftCols(turns_) += by_momentum * by_turn_;
    result.rightCols(inertia_.cols()) = by_momentum * inertia_;
    return result;
  }

  // T⁻¹ m
  MatrixXd solved(MatrixXd m) const {
    auto momentum = m.bottomRows(inertia_.rows());
    momentum -= by_turn_ * m.topRows(turns_);
    momentum = factors_.solve(MatrixXd(momentum)).eval();
    return m;
  }

 private:
  Eigen::Index turns_;
  MatrixXd by_turn_;  // [velocity_count][turns]
  MatrixXd inertia_;
  Eigen::LLT<MatrixXd> factors_;
};

// The steps of a motion, one after another, linearised.
class LinearMotion {
 public:
  LinearMotion(const System& system, const Problem& problem, const Solution& solution)
      : system_(system),
        solution_(solution),
        motion_(node_motion(system, solution)),
        composition_(integrator::composition(problem.scheme)),
        march_(system, problem.scheme),
        work_(system),
        tangent_(system),
        interval_(system.body_count()) {}

  int steps() const { return static_cast<int>(solution_.time.size()) - 1; }
  const ReferenceState& state(int k) const { return motion_.state[at(k)]; }

  /// Steps first … last − 1 as one stage.
  StageTangent stage(int first, int last) {
    const int size = 2 * system_.velocity_count();
    StageTangent all{MatrixXd::Identity(size, size), MatrixXd::Zero(size, system_.control_count()),
                     MatrixXd::Zero(size, system_.control_count())};
    const double begin = solution_.time[at(first)], length = solution_.time[at(last)] - begin;
    const auto append = [&](double from, double to) {
      const double a = (from - begin) / length, b = (to - begin) / length;
      all.A = (tangent_.A * all.A).eval();
      all.B = (tangent_.A * all.B + (1.0 - a) * tangent_.B + (1.0 - b) * tangent_.B_next).eval();
      all.B_next = (tangent_.A * all.B_next + a * tangent_.B + b * tangent_.B_next).eval();
    };
    for (int k = first; k < last; ++k) composition_.stages() == 1 ? append_step(k, append) : append_stages(k, append);
    const MomentumByVelocity here(system_, state(last));
    if (first != last_ || !there_) there_.emplace(system_, state(first));
    const MatrixXd A = there_->times(all.A);
    there_ = here;
    last_ = last;
    return {here.solved(A), here.solved(all.B), here.solved(all.B_next)};
  }

 private:
  mechanics::Moments moments(int k) const {
    return mechanics::moments_of_applied(system_, solution_.rotation[at(k)], solution_.control[at(k)]);
  }

  template <typename Append>
  void append_step(int k, const Append& append) {
    const auto n = at(k);
    mechanics::interval_between(system_, solution_.rotation[n], solution_.rotation[n + 1],
                                solution_.position[n + 1] - solution_.position[n], interval_);
    const double h = solution_.time[n + 1] - solution_.time[n];
    integrator::linearize_step(system_, composition_.lagrangian, h, interval_, moments(k), moments(k + 1), work_,
                               tangent_);
    append(solution_.time[n], solution_.time[n + 1]);
  }

  // A step of several stages is marched again: the nodes within are not stored.
  template <typename Append>
  void append_stages(int k, const Append& append) {
    const std::vector<double>& times = solution_.stage_time[at(k)];
    const std::vector<Vectors>& applied = solution_.control_stages[at(k)];
    const ReferenceState& from = state(k);
    State reached = integrator::state_of_velocity(system_, from.rotation, from.position, from.velocity);
    const mechanics::Moments none(at(system_.joint_count()), Vector3d::Zero());
    mechanics::Moments u = mechanics::moments_of_applied(system_, reached.rotation, applied.front());
    std::size_t s = 0;
    const auto control = [&](int node) -> const mechanics::Moments& { return at(node) == s ? u : none; };
    const auto witness = [&](const mechanics::Interval& interval, State& there) {
      const double h = (solution_.time[at(k) + 1] - solution_.time[at(k)]) * composition_.fractions[s];
      const mechanics::Moments u_next = mechanics::moments_of_applied(system_, there.rotation, applied[s + 1]);
      there.momentum += 0.5 * h *
                        (mechanics::generalized_force(system_, there.rotation, u_next) -
                         mechanics::generalized_force(system_, there.rotation, none));
      integrator::linearize_step(system_, composition_.lagrangian, h, interval, u, u_next, work_, tangent_);
      append(times[s], times[s + 1]);
      u = u_next;
      ++s;
    };
    const double time_step = solution_.time[at(k) + 1] - solution_.time[at(k)];
    if (!march_.advance(time_step, control, reached, witness).converged)
      throw std::domain_error("step " + std::to_string(k) + " does not converge when marched again");
    for (std::size_t i = 0; i < reached.rotation.size(); ++i)
      if (!(lie::rotation_angle(reached.rotation[i].transpose() * state(k + 1).rotation[i]) < obeyed))
        throw std::domain_error("step " + std::to_string(k) + " does not end where the motion says");
  }

  const System& system_;
  const Solution& solution_;
  integrator::NodeMotion motion_;
  const integrator::Composition& composition_;
  integrator::March march_;
  integrator::TangentWorkspace work_;
  StepTangent tangent_;
  mechanics::Interval interval_;
  std::optional<MomentumByVelocity> there_;  // at the node where the latest stage ended
  int last_ = 0;
};

// Sizes of a deviation's entries that count alike, [2 velocity_count]: 1 rad, a length, and both in a time.
VectorXd units(const System& system, double time) {
  VectorXd unit = VectorXd::Ones(2 * system.velocity_count());
  unit.segment<3>(system.velocity_count() - 3).setConstant(system.size());
  unit.tail(system.velocity_count()) = unit.head(system.velocity_count()) / time;
  return unit;
}

// Σ_i |η_i|² over these bodies as a quadratic form in the freedoms.
MatrixXd turn_form(const System& system, const mechanics::Rotations& R, const std::vector<char>& counted) {
  const int turns = system.velocity_count() - 3;
  MatrixXd form = MatrixXd::Zero(turns, turns);
  for (int i = 0; i < system.body_count(); ++i) {
    if (!counted[at(i)]) continue;
    const MatrixXd turn = mechanics::turn_by_freedoms(system, R, i);
    form += turn.transpose() * turn;
  }
  return form;
}

bool is_gait(const Problem& problem) { return problem.goal && problem.goal->periodic; }

// What deviations cost, in units.
class DeviationCost {
 public:
  DeviationCost(const System& system, const Problem& problem, const FeedbackWeights& weights)
      : system_(system), problem_(problem), whole_(std::pow(weights.path / weights.gait_whole, 2)) {}

  MatrixXd along(const ReferenceState& state) const {
    const int half = system_.velocity_count();
    MatrixXd form = MatrixXd::Zero(2 * half, 2 * half);
    auto turns = form.topLeftCorner(half - 3, half - 3);
    auto shift = form.block<3, 3>(half - 3, half - 3);
    shift.setIdentity();
    if (!is_gait(problem_)) {
      turns = turn_form(system_, state.rotation, every_body());
      return form;
    }
    std::vector<char> root(at(system_.body_count()), 0);
    root[0] = 1;
    turns = whole_ * turn_form(system_, state.rotation, root);
    for (const model::Joint& joint : system_.joints()) turns += joint_form(state.rotation, joint);
    shift *= whole_;
    return form;
  }

  // Of what the goal asks for; without a goal of everything.
  MatrixXd at_end(const ReferenceState& state) const {
    const int half = system_.velocity_count();
    const auto& goal = problem_.goal;
    MatrixXd form = MatrixXd::Zero(2 * half, 2 * half);
    form.topLeftCorner(half - 3, half - 3) =
        goal ? asked_form(*goal, state.rotation) : turn_form(system_, state.rotation, every_body());
    for (int c = 0; c < 3; ++c)
      if (!goal || goal->move[at(c)]) form(half - 3 + c, half - 3 + c) = 1.0;
    if (!goal || goal->stills_joints())
      form.block(half, half, half - 3, half - 3) = turn_form(system_, state.rotation, every_body());
    return form;
  }

 private:
  // Of attitudes in the world, and of joints.
  MatrixXd asked_form(const Goal& goal, const mechanics::Rotations& R) const {
    const AskedAttitudes attitudes = asked_attitudes(system_, goal, R);
    std::vector<char> asked;
    for (const auto& rotation : attitudes.rotation) asked.push_back(rotation.has_value());
    MatrixXd form = turn_form(system_, R, asked);
    for (int j = 0; j < system_.joint_count(); ++j) {
      if (attitudes.joint[at(j)]) form += joint_form(R, system_.joint(j));
    }
    return form;
  }

  MatrixXd joint_form(const mechanics::Rotations& R, const model::Joint& joint) const {
    const MatrixXd turn =
        mechanics::turn_by_freedoms(system_, R, joint.child) -
        mechanics::child_to_parent(R, joint).transpose() * mechanics::turn_by_freedoms(system_, R, joint.parent);
    return turn.transpose() * turn;
  }

  std::vector<char> every_body() const { return std::vector<char>(at(system_.body_count()), 1); }
  const System& system_;
  const Problem& problem_;
  double whole_;  // share with which squares of a gait's attitude and place count
};

// Stages in units, with their place in time.
struct LinearStages {
  std::vector<int> node;              // [M+1] of the motion, where gains are
  std::vector<double> weight;         // [M+1] s, of the trapezoid rule
  std::vector<StageTangent> tangent;  // [M]
  std::vector<ReferenceState> state;  // [M+1]
  int count() const { return static_cast<int>(tangent.size()); }
};

LinearStages linear_stages(const System& system, const Problem& problem, const Solution& solution,
                           const VectorXd& unit) {
  LinearMotion motion(system, problem, solution);
  const int stride = (motion.steps() + most_gains - 1) / most_gains;
  LinearStages stages;
  for (int k = 0; k < motion.steps(); k += stride) stages.node.push_back(k);
  stages.node.push_back(motion.steps());
  stages.weight.assign(stages.node.size(), 0.0);
  for (std::size_t m = 0; m + 1 < stages.node.size(); ++m) {
    StageTangent tangent = motion.stage(stages.node[m], stages.node[m + 1]);
    tangent.A = (unit.cwiseInverse().asDiagonal() * tangent.A * unit.asDiagonal()).eval();
    tangent.B = (unit.cwiseInverse().asDiagonal() * tangent.B).eval();
    tangent.B_next = (unit.cwiseInverse().asDiagonal() * tangent.B_next).eval();
    if (!tangent.A.allFinite() || !tangent.B.allFinite() || !tangent.B_next.allFinite())
      throw std::domain_error("the motion passes where its steps or velocities are not defined, near t = " +
                              in_words(solution.time[at(stages.node[m])]) + " s");
    stages.tangent.push_back(std::move(tangent));
    const double length = solution.time[at(stages.node[m + 1])] - solution.time[at(stages.node[m])];
    stages.weight[m] += 0.5 * length;
    stages.weight[m + 1] += 0.5 * length;
  }
  for (int k : stages.node) stages.state.push_back(motion.state(k));
  return stages;
}

void add_rows(MatrixXd& rows, const MatrixXd& more) {
  MatrixXd both(rows.rows() + more.rows(), more.cols());
  both << rows, more;
  rows = algebra::condensed_rows(both);
}

// Orthonormal columns that span the deviations which moments can make anywhere along the motion: all of them but where
// symmetry keeps the swimmer in a plane, say. Over short windows: what is unstable would carry round-off everywhere.
MatrixXd reachable_deviations(const LinearStages& stages) {
  const Eigen::Index size = stages.tangent.front().A.rows();
  const int window = std::max(least_window, (stages.count() + reach_windows - 1) / reach_windows);
  MatrixXd all(0, size);
  for (int begin = 0; begin < stages.count(); begin += window) {
    MatrixXd reached(0, size);
    for (int m = begin; m < std::min(begin + window, stages.count()); ++m) {
      const StageTangent& tangent = stages.tangent[at(m)];
      reached = (reached * tangent.A.transpose()).eval();
      MatrixXd by_moments(tangent.B.cols() + tangent.B_next.cols(), size);
      by_moments << tangent.B.transpose(), tangent.B_next.transpose();
      algebra::normalize_rows(by_moments, no_row);
      add_rows(reached, by_moments);
    }
    add_rows(all, reached);
  }
  const MatrixXd basis = algebra::span_of_rows(all, reach_limit);
  return basis.cols() == size ? MatrixXd(MatrixXd::Identity(size, size)) : basis;
}

// Deviations from a gait's last node as those from its first one, where the next cycle begins: world directions have turned.
MatrixXd seen_by_the_next_cycle(const System& system, const Solution& solution) {
  const int half = system.velocity_count();
  const Matrix3d turn = solution.rotation.back()[0] * solution.rotation.front()[0].transpose();
  MatrixXd map = MatrixXd::Identity(2 * half, 2 * half);
  map.block<3, 3>(half - 3, half - 3) = map.block<3, 3>(2 * half - 3, 2 * half - 3) = turn.transpose();
  return map;
}

// Effort of the motion, (N m)² s, and what turning a body of mean inertia by a radian in its duration takes.
double effort_scale(const System& system, const Solution& solution) {
  const double duration = solution.time.back() - solution.time.front();
  double effort = 0.0, inertia = 0.0;
  for (std::size_t k = 0; k + 1 < solution.time.size(); ++k)
    for (std::size_t end : {k, k + 1})
      for (const Vector3d& u : solution.control[end])
        effort += 0.5 * (solution.time[k + 1] - solution.time[k]) * u.squaredNorm();
  for (const model::Body& body : system.bodies()) inertia += body.inertia_matrix.trace() / (3.0 * system.body_count());
  return effort + inertia * inertia / (duration * duration * duration);
}

}  // namespace

integrator::NodeMotion node_motion(const System& system, const Solution& solution) {
  integrator::NodeMotion motion{solution.time, {}};
  for (std::size_t k = 0; k < solution.time.size(); ++k) {
    const mechanics::Rotations& R = solution.rotation[k];
    motion.state.push_back(
        {R, solution.position[k],
         mechanics::velocity_of_bodies(system, R, solution.angular_velocity[k], R[0] * solution.linear_velocity[k])});
  }
  return motion;
}

integrator::FeedbackLaw feedback_law(const System& system, const Solution& solution,
                                     integrator::ControlFunction planned) {
  return {integrator::MotionPath(system, node_motion(system, solution)), std::move(planned), solution.feedback.time,
          solution.feedback.gain};
}

// Stage m has the state y, before what u_m adds at the end of the stage before: z = y + B' u is the deviation at the
// node (equation 11.7).
Feedback design_feedback(const System& system, const Problem& problem, const Solution& solution,
                         const FeedbackWeights& weights) {
  const double duration = solution.time.back() - solution.time.front();
  const VectorXd unit = units(system, weights.rate * duration);
  const LinearStages stages = linear_stages(system, problem, solution, unit);
  const MatrixXd basis = reachable_deviations(stages);
  const int controls = system.control_count();
  const int cycles = is_gait(problem) ? cycles_ahead : 1, nodes = stages.count() + 1;
  const optimizer::StageSizes sizes{cycles * nodes, static_cast<int>(basis.cols()), controls, 0};
  const double scale = effort_scale(system, solution);
  const double along = scale / (duration * weights.path * weights.path);
  const double end = is_gait(problem) ? weights.gait_end : weights.end;
  const DeviationCost cost(system, problem, weights);
  const MatrixXd Q_end = scale / (end * end) * basis.transpose() * cost.at_end(stages.state.back()) * basis;
  const MatrixXd onwards = basis.transpose() * seen_by_the_next_cycle(system, solution) * basis;
  optimizer::StageModel model(sizes);
  std::vector<MatrixXd> late;  // B' of the stage before each node
  for (int n = 0; n < cycles * nodes; ++n) {
    const int m = n % nodes;
    const bool cycle_ends = m == stages.count() && n + 1 < cycles * nodes;
    const double weight = stages.weight[at(m)];
    MatrixXd Q = weight * along * basis.transpose() * cost.along(stages.state[at(m)]) * basis;
    if (cycle_ends) Q += Q_end;
    if (n < nodes)
      late.push_back(m == 0 ? MatrixXd::Zero(basis.cols(), controls)
                            : MatrixXd(basis.transpose() * stages.tangent[at(m - 1)].B_next));
    optimizer::Stage& stage = model.stage[at(n)];
    stage.Q = Q;
    stage.S = late[at(m)].transpose() * Q;
    stage.R = weight * MatrixXd::Identity(controls, controls) + late[at(m)].transpose() * Q * late[at(m)];
    stage.A.setIdentity();
    stage.B.setZero();
    if (m < stages.count()) {
      stage.A = basis.transpose() * stages.tangent[at(m)].A * basis;
      stage.B = basis.transpose() * stages.tangent[at(m)].B;
    }
    if (cycle_ends) stage.A = onwards;
    stage.B += stage.A * late[at(m)];
  }
  model.Q_end = Q_end;
  optimizer::Riccati riccati(sizes);
  if (!riccati.factor(model, 0.0, 0.0)) throw std::domain_error("the Riccati recursion does not stay positive");
  Feedback feedback;
  for (int m = 0; m < nodes; ++m) {                // of the first cycle
    const MatrixXd& answer = riccati.feedback(m);  // u = answer · y
    const MatrixXd gain = (MatrixXd::Identity(controls, controls) + answer * late[at(m)]).partialPivLu().solve(answer);
    feedback.time.push_back(solution.time[at(stages.node[at(m)])]);
    feedback.gain.push_back(gain * basis.transpose() * unit.cwiseInverse().asDiagonal());
    if (!feedback.gain.back().allFinite()) throw std::domain_error("the gains are not finite");
  }
  // What the last node alone would answer, up to hundreds of times the other gains, the stages of a step cannot march.
  if (cycles == 1 && !integrator::single_step(problem.scheme)) feedback.gain.back() = feedback.gain[at(nodes - 2)];
  return feedback;
}

}  // namespace lamprey::maneuver
