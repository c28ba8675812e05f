#include "guess/guess.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lie/so3.hpp"
#include "maneuver/control_path.hpp"
#include "maneuver/random.hpp"
#include "maneuver/step_polynomial.hpp"
#include "mechanics/joint_moments.hpp"

namespace lamprey::guess {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using maneuver::cayley_between;
using maneuver::ControlPath;
using maneuver::fit_to_joints;
using maneuver::gauss_rule;
using maneuver::GaussRule;
using maneuver::Interpolation;
using maneuver::joint_at_end;
using maneuver::legendre;
using maneuver::polynomial_terms;
using maneuver::Random;
using maneuver::stage_fractions;
using mechanics::Rotations;
using model::System;

constexpr int harmonics = 4;
constexpr double amplitude = 0.8;                   // rad, of the first harmonic; 0.3 to 0.8 serve alike
constexpr int many_joints = 10;                     // of a swimmer, beyond which each by itself would coil it up
constexpr int places_along_run = 3;                 // of joints one behind the other, that are drawn then
constexpr double leaning_amplitude = 0.4;           // rad
constexpr std::uint64_t leaning_seed = 0x6c65616e;  // beside that of the swings
constexpr double same_place = 1e-12;                // rad, units of length

using model::at;

// Joints one behind the other, with as many moments each, from one that is not so on.
std::vector<std::vector<int>> runs_of_joints(const System& system) {
  std::vector<std::vector<int>> runs;
  std::vector<int> run_of(at(system.joint_count()), -1);
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (body.parent < 0) continue;
    const model::Body& parent = system.body(body.parent);
    const bool goes_on = parent.joint >= 0 && parent.children.size() == 1 &&
                         system.joint(parent.joint).actuation.cols() == system.joint(body.joint).actuation.cols();
    int& run = run_of[at(body.joint)];
    run = goes_on ? run_of[at(parent.joint)] : static_cast<int>(runs.size());
    if (!goes_on) runs.emplace_back();
    runs[at(run)].push_back(body.joint);
  }
  return runs;
}

// Random smooth swings of the joints along their actuation, zero at both ends.
class JointSwings {
 public:
  JointSwings(const System& system, Random& random) : system_(system) {
    for (const model::Joint& joint : system.joints()) {
      MatrixXd coefficients(joint.actuation.cols(), harmonics);
      for (int m = 0; m < harmonics; ++m)
        for (Eigen::Index c = 0; c < coefficients.rows(); ++c)
          coefficients(c, m) = amplitude * random.normal() / (m + 1);
      coefficients_.push_back(coefficients);
    }
    if (system.joint_count() <= many_joints) return;
    for (const std::vector<int>& run : runs_of_joints(system))
      if (std::ssize(run) > places_along_run) spread(run);
  }

  Vector3d swing(int j, double s) const {
    VectorXd wave(harmonics);
    for (int m = 0; m < harmonics; ++m)
      wave[m] = std::sin((m + 1) * std::numbers::pi * s) * std::sin(std::numbers::pi * s);
    return system_.joint(j).actuation * (coefficients_[at(j)] * wave);
  }

 private:
  // The swings of a few joints, drawn as any, become those of all along a run, linearly from place to place: bends of a body that stay what
  // they are however many links it is made of.
  void spread(const std::vector<int>& run) {
    std::vector<MatrixXd> drawn;
    for (int place = 0; place < places_along_run; ++place) drawn.push_back(coefficients_[at(run[at(place)])]);
    const auto count = static_cast<double>(run.size());
    for (std::size_t n = 0; n < run.size(); ++n) {
      const double along = static_cast<double>(n) / (count - 1.0) * (places_along_run - 1);
      const std::size_t left = std::min<std::size_t>(static_cast<std::size_t>(along), places_along_run - 2);
      const double share = along - static_cast<double>(left);
      coefficients_[at(run[n])] = places_along_run / count * ((1.0 - share) * drawn[left] + share * drawn[left + 1]);
    }
  }

  const System& system_;
  std::vector<MatrixXd> coefficients_;
};

// Relative rotation of each joint, child → parent, along the guess.
class JointPaths {
 public:
  JointPaths(const System& system, const Maneuver& maneuver, const Swing& swing, const WholeTurns& turns)
      : system_(system), swing_(swing), turns_(turns) {
    for (int j = 0; j < system.joint_count(); ++j) {
      const model::Joint& joint = system.joint(j);
      const Matrix3d start =
          maneuver.start.rotation[at(joint.parent)].transpose() * maneuver.start.rotation[at(joint.child)];
      const Matrix3d end = joint_at_end(system, maneuver, j).value_or(start);
      start_.push_back(start);
      way_.push_back(
          way_between(joint, start, end, !maneuver.may_turn_round.empty() && maneuver.may_turn_round[at(j)]));
    }
  }

  Matrix3d relative(int j, double s) const {
    const model::Joint& joint = system_.joint(j);
    const Vector3d swing = swing_(j, s);
    const Vector3d turned = turns_.empty() ? Vector3d::Zero().eval() : Vector3d(blend(s) * turns_[at(j)]);
    if (joint.free())
      return lie::exp(turned) * lie::exp(swing) * mechanics::turned_by(joint, start_[at(j)], blend(s) * way_[at(j)]);
    return mechanics::turned_by(joint, start_[at(j)], blend(s) * way_[at(j)] + swing + turned);
  }

 private:
  // The shorter way round, unless a limit or a spring has the joint stay within half a turn of its zero.
  static Vector3d way_between(const model::Joint& joint, const Matrix3d& from, const Matrix3d& to,
                              bool may_turn_round) {
    if (may_turn_round || joint.free()) return mechanics::turn_between(joint, from, to);
    return mechanics::joint_angles(joint, to) - mechanics::joint_angles(joint, from);
  }

  const System& system_;
  const Swing& swing_;
  const WholeTurns& turns_;
  std::vector<Matrix3d> start_;
  std::vector<Vector3d> way_;  // of turn_between
};

// Rotations of all bodies from the root's and the joints'.
Rotations compose(const System& system, const Matrix3d& root, const JointPaths& joints, double s) {
  Rotations R(at(system.body_count()), root);
  for (int i : system.root_to_leaves())
    if (system.body(i).parent >= 0) R[at(i)] = R[at(system.body(i).parent)] * joints.relative(system.body(i).joint, s);
  return R;
}

// Quaternions without jumps of sign, position and control of every node, one column each.
MatrixXd stacked_nodes(const System& system, const NodePath& path) {
  const int bodies = system.body_count();
  MatrixXd nodes(4 * bodies + 3 + system.control_count(), static_cast<Eigen::Index>(path.rotation.size()));
  for (Eigen::Index k = 0; k < nodes.cols(); ++k) {
    const auto n = static_cast<std::size_t>(k);
    for (int i = 0; i < bodies; ++i) {
      Eigen::Vector4d q = lie::quaternion_of_rotation(path.rotation[n][at(i)]);
      if (k > 0 && q.dot(nodes.col(k - 1).segment<4>(4 * i)) < 0.0) q = -q;
      nodes.col(k).segment<4>(4 * i) = q;
    }
    nodes.col(k).segment<3>(4 * bodies) = path.position[n];
    nodes.col(k).tail(system.control_count()) = path.control[n];
  }
  return nodes;
}

// Cubic splines through the nodes of a motion, over fractions of its duration.
class NodeSplines {
 public:
  NodeSplines(const System& system, const MatrixXd& nodes)
      : system_(system), path_(Interpolation::not_a_knot_cubic, VectorXd::LinSpaced(nodes.cols(), 0.0, 1.0), nodes) {}

  VectorXd control(double fraction) const { return path_.value(fraction).tail(system_.control_count()); }

  void append(double fraction, NodePath& fine) const {
    const VectorXd node = path_.value(fraction);
    Rotations R(at(system_.body_count()));
    for (int i = 0; i < system_.body_count(); ++i) R[at(i)] = lie::rotation_of_quaternion(node.segment<4>(4 * i));
    fit_to_joints(system_, R);
    if (!fine.rotation.empty()) cayley_between(fine.rotation.back(), R, fine.cayley.emplace_back());
    fine.rotation.push_back(R);
    fine.position.push_back(node.segment<3>(4 * system_.body_count()));
    fine.control.push_back(node.tail(system_.control_count()));
  }

 private:
  const System& system_;
  ControlPath path_;
};

NodePath on_grid(const NodeSplines& splines, int steps, double begin = 0.0) {
  NodePath fine;
  for (int k = 0; k <= steps; ++k) splines.append(begin + (1.0 - begin) * static_cast<double>(k) / steps, fine);
  return fine;
}

}  // namespace

double blend(double s) { return s * s * s * (10.0 + s * (6.0 * s - 15.0)); }

NodePath swung(const System& system, const Maneuver& maneuver, const Swing& swing, const WholeTurns& turns) {
  const JointPaths joints(system, maneuver, swing, turns);
  const Matrix3d root_start = maneuver.start.rotation[0];
  Vector3d root_turn = Vector3d::Zero();
  if (maneuver.end_rotation[0]) root_turn = lie::log(root_start.transpose() * *maneuver.end_rotation[0]);
  Vector3d shift = Vector3d::Zero();
  for (int c = 0; c < 3; ++c)
    if (maneuver.end_position[at(c)]) shift[c] = *maneuver.end_position[at(c)] - maneuver.start.position[c];

  NodePath path;
  path.rotation.push_back(maneuver.start.rotation);
  path.position.push_back(maneuver.start.position);
  for (int k = 0; k < maneuver.steps; ++k) {
    const double s = static_cast<double>(k + 1) / maneuver.steps;
    const Rotations next = compose(system, root_start * lie::exp(blend(s) * root_turn), joints, s);
    cayley_between(path.rotation.back(), next, path.cayley.emplace_back());
    path.rotation.push_back(next);
    path.position.push_back(maneuver.start.position + blend(s) * shift);
  }
  path.control.assign(at(maneuver.steps + 1), VectorXd::Zero(system.control_count()));
  return path;
}

namespace {

// How far joints are bent at the end, [joints] rad along their actuation, that no goal holds there: in the first shape, which may be
// straight, what they move may be no more than of second order. A swimmer that begins in motion is moved on its way.
mechanics::Vectors random_leaning(const System& system, const Maneuver& maneuver, std::uint64_t seed) {
  Random random(seed + leaning_seed);
  mechanics::Vectors leaning;
  const bool from_rest = maneuver.start.momentum.isZero(0.0);
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    VectorXd bend(joint.actuation.cols());
    for (double& angle : bend) angle = leaning_amplitude * random.normal();
    const bool free = from_rest && !maneuver.periodic && !joint_at_end(system, maneuver, j);
    leaning.push_back(free ? Vector3d(joint.actuation * bend) : Vector3d::Zero());
  }
  return leaning;
}

}  // namespace

NodePath random_guess(const System& system, const Maneuver& maneuver, std::uint64_t seed) {
  Random random(seed);
  const JointSwings swings(system, random);
  const mechanics::Vectors leaning = random_leaning(system, maneuver, seed);
  const Swing swing = [&](int joint, double s) -> Vector3d {
    return swings.swing(joint, s) + blend(s) * leaning[at(joint)];
  };
  if (!maneuver.whole_turns) return swung(system, maneuver, swing);
  const double number = 1.5 * random.normal();  // of turns, seldom many, never none
  const double turn = 2.0 * std::numbers::pi * (number < 0.0 ? std::floor(number) : std::ceil(number));
  WholeTurns turns;
  for (const model::Joint& joint : system.joints()) turns.emplace_back(turn * joint.actuation.rowwise().sum());
  return swung(system, maneuver, swing, turns);
}

NodePath at_rest(const System& system, const Maneuver& maneuver, integrator::Scheme scheme) {
  const bool composed = !integrator::single_step(scheme);
  const int stages = composed ? integrator::composition(scheme).stages() : 1;
  const std::size_t nodes = at(maneuver.steps * stages + 1);
  NodePath path;
  if (composed)
    path.polynomial.assign(at(maneuver.steps),
                           VectorXd::Zero(Eigen::Index{polynomial_terms(scheme)} * system.control_count()));
  path.rotation.assign(nodes, maneuver.start.rotation);
  path.position.assign(nodes, maneuver.start.position);
  path.cayley.assign(nodes - 1, mechanics::Vectors(at(system.body_count()), Vector3d::Zero()));
  path.control.assign(nodes, VectorXd::Zero(system.control_count()));
  return path;
}

bool rest_meets_goal(const System& system, const Problem& problem, const Maneuver& maneuver) {
  if (!maneuver.start.momentum.isZero(0.0)) return false;
  if (!problem.waypoints.empty() || problem.cost_weights.transport > 0.0) return false;
  double stiffness = 0.0;  // N m/rad, of springs that must be at rest, too
  for (const model::Joint& joint : system.joints()) stiffness += joint.stiffness;
  if (mechanics::spring_energy(system, maneuver.start.rotation) > stiffness * same_place * same_place) return false;
  double away = 0.0;  // rad, units of length
  for (std::size_t i = 0; i < maneuver.end_rotation.size(); ++i)
    if (const auto& end = maneuver.end_rotation[i])
      away = std::max(away, lie::log(maneuver.start.rotation[i].transpose() * *end).norm());
  for (int j = 0; j < system.joint_count(); ++j)
    if (maneuver.tells_joint(j)) {
      const Matrix3d begins = mechanics::child_to_parent(maneuver.start.rotation, system.joint(j));
      away = std::max(away, lie::rotation_angle(begins.transpose() * *maneuver.end_joint[at(j)]));
    }
  for (int c = 0; c < 3; ++c)
    if (const auto& end = maneuver.end_position[at(c)])
      away = std::max(away, std::abs(*end - maneuver.start.position[c]) / system.length_unit());
  return away <= same_place;
}

bool met_by_rest(const System& system, const Problem& problem, const Maneuver& maneuver) {
  return !problem.cost_weights.of_displacement() && rest_meets_goal(system, problem, maneuver);
}

NodePath perturbed(const System& system, const NodePath& path, std::uint64_t seed) {
  Random random(seed);
  const JointSwings swings(system, random);
  NodePath other = path;
  const std::size_t steps = path.rotation.size() - 1;
  for (std::size_t k = 0; k <= steps; ++k) {
    const Rotations& R = path.rotation[k];
    Rotations& moved = other.rotation[k];
    for (int i : system.root_to_leaves()) {
      const model::Body& body = system.body(i);
      if (body.parent < 0) continue;
      const model::Joint& joint = system.joint(body.joint);
      const Vector3d swing = swings.swing(body.joint, static_cast<double>(k) / static_cast<double>(steps));
      const Matrix3d Q = mechanics::child_to_parent(R, joint);
      moved[at(i)] = moved[at(body.parent)] *
                     (joint.free() ? Matrix3d(lie::exp(swing) * Q)
                                   : mechanics::joint_rotation(joint, mechanics::joint_angles(joint, Q) + swing));
    }
    if (k > 0) cayley_between(other.rotation[k - 1], moved, other.cayley[k - 1]);
  }
  return other;
}

namespace {

// The motion with each joint's rotation, child → parent, another one: by joint, share of the time and what it was.
using OtherJoint = std::function<Matrix3d(const model::Joint& joint, double fraction, const Matrix3d& was)>;

NodePath with_joints(const System& system, const NodePath& path, const OtherJoint& other) {
  NodePath moved = path;
  const double steps = static_cast<double>(path.rotation.size() - 1);
  for (std::size_t k = 0; k < path.rotation.size(); ++k) {
    for (int i : system.root_to_leaves()) {
      const model::Body& body = system.body(i);
      if (body.parent < 0) continue;
      const model::Joint& joint = system.joint(body.joint);
      moved.rotation[k][at(i)] =
          moved.rotation[k][at(body.parent)] *
          other(joint, static_cast<double>(k) / steps, mechanics::child_to_parent(path.rotation[k], joint));
    }
    if (k > 0) cayley_between(moved.rotation[k - 1], moved.rotation[k], moved.cayley[k - 1]);
  }
  return moved;
}

}  // namespace

NodePath led_to_start(const System& system, const NodePath& path, const Rotations& start) {
  const Rotations& before = path.rotation.front();
  return with_joints(system, path, [&](const model::Joint& joint, double fraction, const Matrix3d& was) {
    const Vector3d turn = mechanics::turn_between(joint, mechanics::child_to_parent(before, joint),
                                                  mechanics::child_to_parent(start, joint));
    return mechanics::turned_by(joint, was, (1.0 - fraction) * turn);
  });
}

NodePath calmed(const System& system, const NodePath& path, double share) {
  return with_joints(system, path, [&](const model::Joint& joint, double fraction, const Matrix3d& was) {
    const Matrix3d first = mechanics::child_to_parent(path.rotation.front(), joint),
                   last = mechanics::child_to_parent(path.rotation.back(), joint);
    const Matrix3d straight =
        mechanics::turned_by(joint, first, fraction * mechanics::turn_between(joint, first, last));
    return mechanics::turned_by(joint, straight, share * mechanics::turn_between(joint, straight, was));
  });
}

NodePath rest_of(const System& system, const NodePath& path, double share) {
  return on_grid(NodeSplines(system, stacked_nodes(system, path)), static_cast<int>(path.rotation.size()) - 1, share);
}

NodePath refined(const System& system, const NodePath& coarse, int steps) {
  return on_grid(NodeSplines(system, stacked_nodes(system, coarse)), steps);
}

NodePath extrapolated(const System& system, const NodePath& coarse, const NodePath& coarser, int order, int steps) {
  MatrixXd nodes = stacked_nodes(system, coarse);
  const MatrixXd coarser_nodes = stacked_nodes(system, coarser);
  const Eigen::Index ratio = (nodes.cols() - 1) / (coarser_nodes.cols() - 1);
  MatrixXd difference(nodes.rows(), coarser_nodes.cols());
  for (Eigen::Index k = 0; k < difference.cols(); ++k) {
    const auto node = nodes.col(ratio * k);
    difference.col(k) = node - coarser_nodes.col(k);
    for (int i = 0; i < system.body_count(); ++i)  // of the quaternion's two signs the nearer one
      if (difference.col(k).segment<4>(4 * i).squaredNorm() > 2.0)
        difference.col(k).segment<4>(4 * i) = node.segment<4>(4 * i) + coarser_nodes.col(k).segment<4>(4 * i);
  }
  const ControlPath differences(Interpolation::not_a_knot_cubic, VectorXd::LinSpaced(difference.cols(), 0.0, 1.0),
                                difference);
  const double finer = static_cast<double>(nodes.cols() - 1) / steps;
  const double share = (1.0 - std::pow(finer, order)) / (std::pow(static_cast<double>(ratio), order) - 1.0);
  for (Eigen::Index k = 0; k < nodes.cols(); ++k)
    nodes.col(k) += share * differences.value(static_cast<double>(k) / static_cast<double>(nodes.cols() - 1));
  return on_grid(NodeSplines(system, nodes), steps);
}

NodePath refined(const System& system, const NodePath& coarse, int steps, integrator::Scheme scheme) {
  const NodeSplines splines(system, stacked_nodes(system, coarse));
  const std::vector<double> fractions = stage_fractions(scheme);
  const int terms = polynomial_terms(scheme);
  const GaussRule rule = gauss_rule(terms);
  NodePath fine;
  for (int k = 0; k < steps; ++k) {
    for (std::size_t s = 0; s + 1 < fractions.size(); ++s) splines.append((k + fractions[s]) / steps, fine);
    MatrixXd coefficients = MatrixXd::Zero(system.control_count(), terms);
    for (std::size_t g = 0; g < rule.weight.size(); ++g)
      coefficients += rule.weight[g] * splines.control((k + rule.fraction[g]) / steps) *
                      legendre(rule.fraction[g], terms).transpose();
    fine.polynomial.push_back(coefficients.reshaped());
  }
  splines.append(1.0, fine);
  return fine;
}

NodePath nodes_of_steps(const NodePath& path, int stages) {
  NodePath nodes;
  for (std::size_t n = 0; n < path.rotation.size(); n += at(stages)) {
    if (n > 0) cayley_between(nodes.rotation.back(), path.rotation[n], nodes.cayley.emplace_back());
    nodes.rotation.push_back(path.rotation[n]);
    nodes.position.push_back(path.position[n]);
    nodes.control.push_back(path.control[n]);
  }
  return nodes;
}

}  // namespace lamprey::guess
