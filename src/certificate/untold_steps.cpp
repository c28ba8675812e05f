#include "certificate/untold_steps.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "evidence/balance.hpp"
#include "evidence/findings.hpp"
#include "integrator/reference_integrator.hpp"

namespace lamprey::certificate {

namespace {

using Eigen::VectorXd;
using evidence::Largest;
using evidence::unset;
using integrator::ReferenceState;
using model::at;

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr double tolerance = 1e-10;                   // of the reference integrator
constexpr double round_off = 1e-6;                    // of the momenta's scale, rad, m over the swimmer's reach
constexpr double moments_between = 2.0;               // times the largest at a node
constexpr double most_turn = 0.5 * std::numbers::pi;  // rad in a step of a scheme
constexpr double coupled = 2.0;                       // times as fast as a body by itself one may turn under an impulse
constexpr double coarse = 1.0;                        // of the momenta's scale: the error of a divided step's pieces

class UntoldSteps {
 public:
  UntoldSteps(const StoredMotion& motion, double scale)
      : motion_(motion),
        scale_(scale),
        integrator_(
            motion.system, [this](double time) { return moments(time); }, tolerance) {
    for (const model::Body& body : motion.system.bodies()) {
      double reach = motion.system.length_unit();
      for (const model::PathPoint& point : body.path) reach += point.offset.norm();
      reach_ = std::max(reach_, reach);
      lightest_ = std::min(lightest_, body.inertia_matrix.trace() / 3.0);
    }
  }

  // How many times as far as it may step k leads.
  double beyond(int k) {
    step_ = k;
    const integrator::State begun = node(k), asked = node(k + 1);
    ReferenceState state{begun.rotation, begun.position, integrator::velocity_of_state(motion_.system, begun)};
    const std::vector<double>& time = motion_.solution.time;
    if (!integrator_.advance(time[at(k)], time[at(k + 1)], state)) return endless;
    const integrator::State ended =
        integrator::state_of_velocity(motion_.system, state.rotation, state.position, state.velocity);
    Largest turned;
    for (std::size_t i = 0; i < asked.rotation.size(); ++i)
      turned.add(lie::rotation_angle(asked.rotation[i].transpose() * ended.rotation[i]));
    const double impulse = left_open(k), turn = coupled * motion_.time_step * impulse / lightest_ + round_off;
    Largest beyond;
    beyond.add(evidence::largest_part(motion_.system, asked.momentum - ended.momentum) / impulse);
    beyond.add(turned.value() / turn);
    beyond.add((asked.position - ended.position).norm() / (turn * reach_));
    return beyond.value();
  }

  // Whether a body turns by so much that its attitudes do not tell which way round.
  bool hides_its_way(int k) const {
    const auto &from = motion_.solution.rotation[at(k)], &to = motion_.solution.rotation[at(k + 1)];
    for (std::size_t i = 0; i < from.size(); ++i)
      if (lie::rotation_angle(from[i].transpose() * to[i]) > most_turn) return true;
    return false;
  }

  // Whether it obeys the scheme whole.
  bool obeys_scheme(int k) const {
    const evidence::StepMomenta momenta = evidence::step_momenta(motion_, k);
    const double half = 0.5 * motion_.time_step;
    Largest off;
    off.add(evidence::largest_part(motion_.system, momenta.minus - half * force(k) - node(k).momentum));
    off.add(evidence::largest_part(motion_.system, momenta.plus + half * force(k + 1) - node(k + 1).momentum));
    return off.value() <= round_off * scale_;
  }

 private:
  // kg m²/s, the impulse that moments on the way of a step may have beside those that are linear between its nodes.
  double left_open(int k) const {
    Largest moments;
    for (int near = std::max(0, k - 1); near <= std::min(motion_.steps, k + 2); ++near)
      moments.add(evidence::largest_part(motion_.system, force(near)));
    const bool divided = motion_.solution.marched_by.empty();
    return moments_between * motion_.time_step * moments.value() + (divided ? coarse : round_off) * scale_;
  }

  VectorXd force(int k) const {
    return mechanics::generalized_force(motion_.system, motion_.solution.rotation[at(k)], motion_.control[at(k)]);
  }

  integrator::State node(int k) const { return evidence::stored_state(motion_, k); }

  mechanics::Moments moments(double time) const {
    const double share = (time - motion_.solution.time[at(step_)]) / motion_.time_step;
    mechanics::Moments between = motion_.control[at(step_)];
    for (std::size_t j = 0; j < between.size(); ++j)
      between[j] = (1.0 - share) * between[j] + share * motion_.control[at(step_ + 1)][j];
    return between;
  }

  const StoredMotion& motion_;
  double scale_;
  integrator::ReferenceIntegrator integrator_;
  int step_ = 0;
  double lightest_ = endless;  // kg m², a body's mean inertia
  double reach_ = 0.0;         // m
};

}  // namespace

double beyond_moments(const StoredMotion& motion, double scale) {
  const maneuver::Solution& stored = motion.solution;
  const bool divided = stored.marched_by.empty();
  if (divided && !integrator::single_step(motion.problem.scheme)) return unset;
  if (stored.angular_velocity.size() != stored.time.size() || stored.linear_velocity.size() != stored.time.size())
    return unset;
  UntoldSteps steps(motion, scale);
  Largest beyond;
  int others = 0;
  for (int k = 0; k < motion.steps; ++k) {
    if (divided && (steps.obeys_scheme(k) || steps.hides_its_way(k))) continue;
    beyond.add(steps.beyond(k));
    ++others;
  }
  return divided && others > stored.divided.steps ? endless : beyond.value();
}

}  // namespace lamprey::certificate
