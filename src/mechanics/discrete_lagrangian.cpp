#include "mechanics/discrete_lagrangian.hpp"

namespace lamprey::mechanics {

namespace {

using lie::hat;
using lie::vee;
using model::Body;
using model::Joint;
using model::System;

using model::at;

struct LocalMomenta {
  Vector3d linear;  // P_i, world
  Vector3d minus;   // π⁻_i, body frame at k
  Vector3d plus;    // π⁺_i, body frame at k + 1
};

// Body i's own share of p⁻ and p⁺ (equation 4.2).
LocalMomenta local_momenta(const System& system, const Quadrature& weights, double h, const Interval& step, int i) {
  const Body& body = system.body(i);
  const Matrix3d& M = body.mass_matrix;
  const Matrix3d& F = step.relative_rotation[at(i)];
  const Matrix3d& E = step.relative_rotation_minus_identity[at(i)];
  const Matrix3d Jd = trace_weight(trace_inertia(system, weights, i));
  const Vector3d w = step.rotation[at(i)].transpose() * step.centre_displacement[at(i)];
  const Vector3d w_next = F.transpose() * w;
  const Vector3d Mw = weights.left * (M * w);
  const Vector3d Mw_next = weights.right * (M * w_next);

  LocalMomenta local;
  local.linear = step.rotation[at(i)] * (Mw + F * Mw_next) / h;
  local.minus = (2.0 * vee(E * Jd) + w.cross(Mw)) / h;
  local.plus = (2.0 * vee(Jd * E) - w_next.cross(Mw_next)) / h;
  if (weights.trace_form && body.parent >= 0) {
    const Vector3d c = -system.joint(body.joint).child_offset;
    const Vector3d M_turn = M * (E * c);
    local.minus -= (F * c).cross(M_turn) / h;
    local.plus -= c.cross(F.transpose() * M_turn) / h;
  }
  return local;
}

}  // namespace

Quadrature quadrature(DiscreteLagrangian lagrangian) {
  return lagrangian == DiscreteLagrangian::paper ? Quadrature{1.0, 0.0, true} : Quadrature{0.5, 0.5, false};
}

Interval::Interval(int bodies)
    : rotation(at(bodies), Matrix3d::Identity()),
      cayley(at(bodies), Vector3d::Zero()),
      displacement(Vector3d::Zero()),
      relative_rotation(at(bodies)),
      relative_rotation_minus_identity(at(bodies)),
      next_rotation(at(bodies)),
      centre_displacement(at(bodies)) {}

DiscreteMomenta::DiscreteMomenta(int bodies) : minus(at(bodies)), plus(at(bodies)), subtree_linear(at(bodies)) {}

void update_interval(const System& system, Interval& step) {
  for (int i : system.root_to_leaves()) {
    const Body& body = system.body(i);
    step.relative_rotation_minus_identity[at(i)] = lie::cayley_minus_identity(step.cayley[at(i)]);
    step.relative_rotation[at(i)] = Matrix3d::Identity() + step.relative_rotation_minus_identity[at(i)];
    step.next_rotation[at(i)] = step.rotation[at(i)] * step.relative_rotation[at(i)];
    if (body.parent < 0) {
      step.centre_displacement[at(i)] = step.displacement;
      continue;
    }
    const Joint& up = system.joint(body.joint);
    step.centre_displacement[at(i)] =
        step.centre_displacement[at(up.parent)] +
        step.rotation[at(up.parent)] * (step.relative_rotation_minus_identity[at(up.parent)] * up.parent_offset) -
        step.rotation[at(i)] * (step.relative_rotation_minus_identity[at(i)] * up.child_offset);
  }
}

double discrete_lagrangian(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step) {
  const Quadrature weights = quadrature(lagrangian);
  double value = 0.0;
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Matrix3d& M = body.mass_matrix;
    const Matrix3d& E = step.relative_rotation_minus_identity[at(i)];
    const Vector3d w = step.rotation[at(i)].transpose() * step.centre_displacement[at(i)];
    const Vector3d w_next = step.relative_rotation[at(i)].transpose() * w;
    value += 0.5 * (weights.left * w.dot(M * w) + weights.right * w_next.dot(M * w_next));
    value -= (E * trace_weight(trace_inertia(system, weights, i))).trace();
    if (weights.trace_form && body.parent >= 0) {
      const Vector3d turn = E * system.joint(body.joint).child_offset;
      value -= 0.5 * turn.dot(M * turn);
    }
  }
  return value / h;
}

void discrete_momenta(const System& system, DiscreteLagrangian lagrangian, double h, const Interval& step,
                      DiscreteMomenta& momenta) {
  const Quadrature weights = quadrature(lagrangian);
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const Body& body = system.body(i);
    const Matrix3d& R = step.rotation[at(i)];
    const Matrix3d& R_next = step.next_rotation[at(i)];
    const LocalMomenta local = local_momenta(system, weights, h, step, i);
    Vector3d P = local.linear;
    Vector3d minus = local.minus;
    Vector3d plus = local.plus;
    for (int child : body.children) {
      const Vector3d& d = system.joint(system.body(child).joint).parent_offset;
      const Vector3d& P_child = momenta.subtree_linear[at(child)];
      P += P_child;
      minus += d.cross(R.transpose() * P_child);
      plus += d.cross(R_next.transpose() * P_child);
    }
    if (body.parent >= 0) {
      const Vector3d& d = system.joint(body.joint).child_offset;
      minus -= d.cross(R.transpose() * P);
      plus -= d.cross(R_next.transpose() * P);
    }
    momenta.subtree_linear[at(i)] = P;
    momenta.minus[at(i)] = minus;
    momenta.plus[at(i)] = plus;
  }
  momenta.linear = momenta.subtree_linear[0];
}

Matrix3d trace_inertia(const System& system, const Quadrature& weights, int i) {
  const Body& body = system.body(i);
  if (!weights.trace_form || body.parent < 0) return body.inertia_matrix;
  const Matrix3d d = hat(system.joint(body.joint).child_offset);
  return body.inertia_matrix - d * body.mass_matrix * d;
}

}  // namespace lamprey::mechanics
