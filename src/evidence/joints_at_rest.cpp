#include "evidence/joints_at_rest.hpp"

#include "lie/so3.hpp"
#include "mechanics/connection.hpp"
#include "mechanics/resting_joints.hpp"

namespace lamprey::evidence {

namespace {

using mechanics::RestingJoints;
using model::at;
using model::System;

mechanics::SpatialMomentum total_of(const System& system, const maneuver::Problem& problem) {
  const integrator::State start = start_of(system, problem.start);
  return mechanics::spatial_momentum(system, start.rotation, start.position, start.momentum);
}

// The end as its root sees it.
struct SeenEnd {
  SeenEnd(const System& of, const maneuver::Problem& problem, const mechanics::Rotations& rotation,
          const Vector3d& position)
      : system(of), total(total_of(of, problem)), root(rotation[0]), resting(of) {
    for (const Matrix3d& R : rotation) shape.push_back(root.transpose() * R);
    resting.take(shape);
    about = total.angular - position.cross(total.linear);
    carried << root.transpose() * about, root.transpose() * total.linear;
  }
  Eigen::Index freedoms() const { return system.velocity_count() - 6; }

  // How shape, the root's world turn and its position answer to all bodies' freedoms and the position, [f + 6][turns + 3].
  MatrixXd by_configuration() const {
    const Eigen::Index place = system.velocity_count();
    MatrixXd answers = MatrixXd::Zero(freedoms() + 6, place);
    answers.block(0, 3, freedoms(), freedoms()).setIdentity();
    for (int i = 1; i < system.body_count(); ++i)
      if (system.body(i).freedoms == 3)
        answers.block<3, 3>(system.body(i).velocity_offset - 3, 0) = -shape[at(i)].transpose();
    answers.block<3, 3>(freedoms(), 0) = root;
    answers.bottomRightCorner<3, 3>().setIdentity();
    return answers;
  }

  // How what the root sees of total momentum answers to its turn and position, [6][6].
  MatrixXd seen_by_pose() const {
    MatrixXd seen = MatrixXd::Zero(6, 6);
    seen.topLeftCorner<3, 3>() = root.transpose() * lie::hat(about);
    seen.topRightCorner<3, 3>() = seen.bottomLeftCorner<3, 3>() = root.transpose() * lie::hat(total.linear);
    return seen;
  }

  const System& system;
  mechanics::SpatialMomentum total;
  Matrix3d root;
  mechanics::Rotations shape;
  RestingJoints resting;
  Vector3d about;  // kg m²/s, angular momentum about the root, world
  RestingJoints::Momentum carried;
};

}  // namespace

CarriedAtRest carried_at_rest(const System& system, const maneuver::Problem& problem,
                              const mechanics::Rotations& rotation, const Vector3d& position) {
  SeenEnd end(system, problem, rotation, position);
  const Eigen::Index f = end.freedoms();
  MatrixXd rates(f, f), by_seen(f, f + 6);
  end.resting.rates(end.carried, rates);
  by_seen << rates, end.resting.by_total() * end.seen_by_pose();
  return {end.resting.by_total() * end.carried, by_seen * end.by_configuration()};
}

MatrixXd curvature_at_rest(const System& system, const maneuver::Problem& problem, const mechanics::Rotations& rotation,
                           const Vector3d& position, const VectorXd& multiplier) {
  SeenEnd end(system, problem, rotation, position);
  const Eigen::Index f = end.freedoms();
  MatrixXd form(f, f), by_total(f, 6), rates(f, f);
  end.resting.curvature(multiplier, end.carried, form, by_total);
  end.resting.rates(end.carried, rates);
  MatrixXd whole = MatrixXd::Zero(f + 6, f + 6);
  whole.topLeftCorner(f, f) = form;
  whole.topRightCorner(f, 6) = by_total * end.seen_by_pose();
  whole.bottomLeftCorner(6, f) = whole.topRightCorner(f, 6).transpose();
  // exp(−ρ̂)(L − χ × P) and exp(−ρ̂) P to second order, with what the multiplier makes of the total
  const VectorXd answer = end.resting.by_total().transpose() * multiplier;
  const Vector3d spin = end.root * answer.head<3>(), push = end.root * answer.tail<3>();
  whole.block<3, 3>(f, f) = lie::double_cross(spin, end.about) + lie::double_cross(push, end.total.linear);
  whole.block<3, 3>(f + 3, f) = lie::hat(end.total.linear) * lie::hat(spin);
  whole.block<3, 3>(f, f + 3) = whole.block<3, 3>(f + 3, f).transpose();
  const MatrixXd answers = end.by_configuration();
  MatrixXd result = answers.transpose() * whole * answers;
  // a body's turn η seen from a root that turns by a: η − Qᵀa − ½ Qᵀa × η
  const VectorXd pull = rates.transpose() * multiplier;
  for (int i = 1; i < system.body_count(); ++i) {
    if (system.body(i).freedoms != 3) continue;
    const Eigen::Index place = system.body(i).velocity_offset;
    const Matrix3d bent = -0.5 * lie::hat(pull.segment<3>(place - 3)) * end.shape[at(i)].transpose();
    result.block<3, 3>(place, 0) += bent;
    result.block<3, 3>(0, place) += bent.transpose();
  }
  return result;
}

VectorXd momentum_at_rest(const StoredMotion& motion) {
  const System& system = motion.system;
  const mechanics::Rotations& R = motion.solution.rotation.back();
  const mechanics::Vectors still(at(system.joint_count()), Vector3d::Zero());
  return mechanics::generalized_momentum(system, R,
                                         mechanics::velocity_of_rates(system, R, motion.solution.position.back(), still,
                                                                      total_of(system, motion.problem)));
}

}  // namespace lamprey::evidence
