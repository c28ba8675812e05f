#include "mechanics/continuous.hpp"

#include <Eigen/Cholesky>

#include "lie/so3.hpp"

namespace lamprey::mechanics {

namespace {

using lie::hat;
using model::Body;
using model::PathPoint;
using model::System;

using model::at;

// World velocity of body i's mass centre: ẋ + Σ_a R_a (Ω_a × c_ia).
Vector3d centre_velocity(const Body& body, const Rotations& R, const VectorXd& velocity) {
  Vector3d v = velocity.tail<3>();
  for (const PathPoint& point : body.path)
    v += R[at(point.body)] * velocity.segment<3>(3 * point.body).cross(point.offset);
  return v;
}

// World acceleration of body i's mass centre at ξ̇ = 0: Σ_a R_a (Ω_a × (Ω_a × c_ia)).
Vector3d centripetal_acceleration(const Body& body, const Rotations& R, const VectorXd& velocity) {
  Vector3d a = Vector3d::Zero();
  for (const PathPoint& point : body.path) {
    const Vector3d Omega = velocity.segment<3>(3 * point.body);
    a += R[at(point.body)] * Omega.cross(Omega.cross(point.offset));
  }
  return a;
}

// Adds the generalised force of a world force at body i's mass centre.
void add_centre_force(const Body& body, const Rotations& R, const Vector3d& force, VectorXd& generalized) {
  generalized.tail<3>() += force;
  for (const PathPoint& point : body.path)
    generalized.segment<3>(3 * point.body) += point.offset.cross(R[at(point.body)].transpose() * force);
}

}  // namespace

MatrixXd generalized_inertia(const System& system, const Rotations& R) {
  const int size = system.velocity_count();
  MatrixXd inertia = MatrixXd::Zero(size, size);
  MatrixXd jacobian(3, size);  // world velocity of a mass centre from ξ
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    jacobian.setZero();
    jacobian.rightCols<3>().setIdentity();
    for (const PathPoint& point : body.path)
      jacobian.middleCols<3>(3 * point.body) = -R[at(point.body)] * hat(point.offset);
    inertia += jacobian.transpose() * (R[at(i)] * body.mass_matrix * R[at(i)].transpose()) * jacobian;
    inertia.block<3, 3>(3 * i, 3 * i) += body.inertia_matrix;
  }
  return inertia;
}

double kinetic_energy(const System& system, const Rotations& R, const VectorXd& velocity) {
  double energy = 0.0;
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Vector3d V = R[at(i)].transpose() * centre_velocity(body, R, velocity);
    const Vector3d Omega = velocity.segment<3>(3 * i);
    energy += 0.5 * V.dot(body.mass_matrix * V) + 0.5 * Omega.dot(body.inertia_matrix * Omega);
  }
  return energy;
}

VectorXd generalized_momentum(const System& system, const Rotations& R, const VectorXd& velocity) {
  VectorXd momentum = VectorXd::Zero(system.velocity_count());
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Vector3d V = R[at(i)].transpose() * centre_velocity(body, R, velocity);
    add_centre_force(body, R, R[at(i)] * (body.mass_matrix * V), momentum);
    momentum.segment<3>(3 * i) += body.inertia_matrix * velocity.segment<3>(3 * i);
  }
  return momentum;
}

VectorXd bias(const System& system, const Rotations& R, const VectorXd& velocity) {
  VectorXd result = VectorXd::Zero(system.velocity_count());
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Matrix3d& M = body.mass_matrix;
    const Vector3d Omega = velocity.segment<3>(3 * i);
    const Vector3d V = R[at(i)].transpose() * centre_velocity(body, R, velocity);
    const Vector3d V_rate = -Omega.cross(V) + R[at(i)].transpose() * centripetal_acceleration(body, R, velocity);
    add_centre_force(body, R, R[at(i)] * (Omega.cross(M * V) + M * V_rate), result);
    result.segment<3>(3 * i) += Omega.cross(body.inertia_matrix * Omega) + V.cross(M * V);
  }
  return result;
}

VectorXd generalized_force(const System& system, const Rotations& R, const Moments& control) {
  VectorXd force = VectorXd::Zero(system.velocity_count());
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    const Vector3d& u = control[at(j)];
    force.segment<3>(3 * joint.parent) += u;
    force.segment<3>(3 * joint.child) -= R[at(joint.child)].transpose() * (R[at(joint.parent)] * u);
  }
  return force;
}

VectorXd acceleration(const System& system, const Rotations& R, const VectorXd& velocity, const Moments& control) {
  return generalized_inertia(system, R).llt().solve(generalized_force(system, R, control) - bias(system, R, velocity));
}

SpatialMomentum spatial_momentum(const Rotations& R, const Vector3d& position, const VectorXd& momentum) {
  SpatialMomentum total;
  total.linear = momentum.tail<3>();
  total.angular = position.cross(total.linear);
  for (std::size_t i = 0; i < R.size(); ++i) total.angular += R[i] * momentum.segment<3>(3 * static_cast<int>(i));
  return total;
}

SpatialMomentum momentum_of_bodies(const System& system, const Rotations& R, const Vector3d& position,
                                   const VectorXd& velocity) {
  const std::vector<Vector3d> centres = system.mass_centres(R, position);
  SpatialMomentum total;
  for (int i = 0; i < system.body_count(); ++i) {
    const Body& body = system.body(i);
    const Vector3d p = body.mass * centre_velocity(body, R, velocity);
    total.linear += p;
    total.angular += centres[at(i)].cross(p) + R[at(i)] * (body.body_inertia * velocity.segment<3>(3 * i));
  }
  return total;
}

}  // namespace lamprey::mechanics
