#include "integrator/tree_newton.hpp"

#include <cmath>

#include <Eigen/LU>

namespace lamprey::integrator {

namespace {

using lie::hat;
using mechanics::Interval;
using mechanics::LocalSensitivity;
using model::Body;
using model::System;

using model::at;

// Body i's balance by its own turn η' and centre displacement, its children condensed (equation 4.16).
struct CondensedBody {
  Matrix3d row_by_centre, row_by_turn;      // of the balance p⁻_i
  Matrix3d force_by_centre, force_by_turn;  // of the subtree's linear momentum
  Vector3d row, force;                      // what is missing in the balance; what the children's residuals push
};

CondensedBody condense(const System& system, const Interval& step, const LocalSensitivity& local,
                       const Vector3d& missing, const TreeNewtonWorkspace& work, int i) {
  CondensedBody c{local.dminus_dcentre, local.dminus_dnext, local.dP_dcentre, local.dP_dnext, missing,
                  Vector3d::Zero()};
  const Matrix3d R_transposed = step.rotation[at(i)].transpose();
  for (int child : system.body(i).children) {
    const TreeNewtonWorkspace::Node& node = work.nodes[at(child)];
    const Matrix3d d = hat(system.joint(system.body(child).joint).parent_offset);
    const Matrix3d lever = d * R_transposed;
    const Matrix3d force_by_turn = -node.force_by_joint * step.next_rotation[at(i)] * d;
    c.force_by_centre += node.force_by_joint;
    c.force_by_turn += force_by_turn;
    c.force += node.force;
    c.row_by_centre += lever * node.force_by_joint;
    c.row_by_turn += lever * force_by_turn;
    c.row -= lever * node.force;
  }
  return c;
}

// Expresses a non-root body by its joint's displacement and eliminates its turn.
bool eliminate(const System& system, const Interval& step, const CondensedBody& c, int i,
               TreeNewtonWorkspace::Node& node) {
  const Matrix3d d = hat(system.joint(system.body(i).joint).child_offset);
  const Matrix3d lever = d * step.rotation[at(i)].transpose();
  const Matrix3d centre_by_turn = step.next_rotation[at(i)] * d;
  const Matrix3d row_by_joint = c.row_by_centre - lever * c.force_by_centre;
  const Matrix3d row_by_turn = c.row_by_turn - lever * c.force_by_turn + row_by_joint * centre_by_turn;
  const double determinant = row_by_turn.determinant();
  if (!(std::abs(determinant) > 0.0)) return false;
  const Matrix3d inverse = row_by_turn.inverse();
  const Matrix3d force_by_turn = c.force_by_centre * centre_by_turn + c.force_by_turn;
  node.turn_by_joint = inverse * row_by_joint;
  node.turn = inverse * (c.row + lever * c.force);
  node.force_by_joint = c.force_by_centre - force_by_turn * node.turn_by_joint;
  node.force = c.force + force_by_turn * node.turn;
  return node.turn.allFinite();
}

}  // namespace

TreeNewtonWorkspace::TreeNewtonWorkspace(int bodies) : nodes(at(bodies)), centre_correction(at(bodies)) {}

bool solve_tree_newton(const System& system, mechanics::DiscreteLagrangian lagrangian, double h, const Interval& step,
                       const std::vector<Vector3d>& missing, const Vector3d& missing_linear, TreeNewtonWorkspace& work,
                       std::vector<Vector3d>& turns, Vector3d& shift) {
  const std::vector<int>& order = system.root_to_leaves();
  for (auto position = order.rbegin(); position != order.rend(); ++position) {
    const int i = *position;
    const LocalSensitivity local = mechanics::local_sensitivity(system, lagrangian, h, step, i);
    const CondensedBody condensed = condense(system, step, local, missing[at(i)], work, i);
    if (i != 0) {
      if (!eliminate(system, step, condensed, i, work.nodes[at(i)])) return false;
      continue;
    }
    Eigen::Matrix<double, 6, 6> root;
    root << condensed.row_by_turn, condensed.row_by_centre, condensed.force_by_turn, condensed.force_by_centre;
    Eigen::Matrix<double, 6, 1> rhs;
    rhs << condensed.row, missing_linear - condensed.force;
    const Eigen::Matrix<double, 6, 1> solved = root.partialPivLu().solve(rhs);
    if (!solved.allFinite()) return false;
    turns[0] = solved.head<3>();
    shift = solved.tail<3>();
    work.centre_correction[0] = shift;
  }
  for (int i : order) {
    const Body& body = system.body(i);
    if (body.parent < 0) continue;
    const model::Joint& up = system.joint(body.joint);
    const Vector3d joint_shift = work.centre_correction[at(up.parent)] -
                                 step.next_rotation[at(up.parent)] * up.parent_offset.cross(turns[at(up.parent)]);
    turns[at(i)] = work.nodes[at(i)].turn - work.nodes[at(i)].turn_by_joint * joint_shift;
    work.centre_correction[at(i)] = joint_shift + step.next_rotation[at(i)] * up.child_offset.cross(turns[at(i)]);
  }
  return true;
}

}  // namespace lamprey::integrator
