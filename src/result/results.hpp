// Results: everything solution.json holds.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "certificate/certificate.hpp"
#include "maneuver/failure.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::result {

struct Provenance {
  std::string version;
  std::string build_type;
  std::string compiler;
  std::string machine;  // processor model and number of cores
  std::string command;
  std::string problem_sha256;  // of the problem file's bytes
  std::uint64_t seed = 0;

  bool operator==(const Provenance&) const = default;
};

/// A body and a joint as solved: defaults filled in, names resolved to indices.
struct ResolvedBody {
  std::string name;
  Eigen::Vector3d semi_axes;                                  // m
  double mass = 0.0;                                          // kg, body alone
  Eigen::Matrix3d body_inertia;                               // kg m², body alone
  Eigen::Matrix3d mass_matrix;                                // kg, body + fluid
  Eigen::Matrix3d inertia_matrix;                             // kg m², body + fluid
  Eigen::Matrix3d coupling_matrix = Eigen::Matrix3d::Zero();  // kg m, body + fluid
  bool ellipse = false;                                       // one metre of a cylinder in a plane fluid
};

struct ResolvedJoint {
  std::string name;
  model::JointKind kind = model::JointKind::ball;
  int parent = 0;
  int child = 0;
  Eigen::Vector3d parent_offset;                                 // m, parent's frame
  Eigen::Vector3d child_offset;                                  // m, child's frame
  std::vector<Eigen::Vector3d> control_axes;                     // parent's frame at zero angle; empty: not actuated
  Eigen::Vector3d reference_rotation = Eigen::Vector3d::Zero();  // rad, child → parent at zero angle
  std::optional<Eigen::Vector3d> axis = {};                      // hinge: child's frame
  std::optional<std::array<Eigen::Vector3d, 2>> axes = {};       // universal: parent's frame, child's frame
  bool actuated = true;                                          // whether control_axes has any
  double stiffness = 0.0;                                        // N m/rad
  double damping = 0.0;                                          // N m s/rad
};

/// Drives that it has (see model::Drive): two where moments act about both axes of a universal joint.
inline int drive_count(const ResolvedJoint& joint) {
  return joint.kind == model::JointKind::universal && joint.control_axes.size() == 2 ? 2 : 1;
}

/// Where the motion was asked to begin; of a free first shape the root alone counts.
struct ResolvedStart {
  std::vector<Eigen::Matrix3d> rotation;          // [bodies] body → world
  Eigen::Vector3d position;                       // m, root's mass centre
  Eigen::Vector3d linear_velocity;                // m/s, of the root, world
  std::vector<Eigen::Vector3d> angular_velocity;  // [bodies] rad/s, body frames
};

struct ResolvedProblem : maneuver::ProblemStatement {
  std::vector<ResolvedBody> bodies;
  std::vector<ResolvedJoint> joints;
  std::optional<double> density = {};  // kg/m³ of the fluid; nothing in files of early versions
  double time_step = 0.0;              // s
  double duration = 0.0;               // s
  maneuver::CostRule cost_rule = maneuver::CostRule::trapezoid;
  bool free_duration = false;               // then `duration` is the one found
  std::array<double, 2> between{};          // s, its bounds
  bool free_shape = false;                  // of a periodic motion's start
  std::optional<ResolvedStart> start = {};  // nothing in files of early versions
  double tolerance = 1e-8;                  // on certificate.kkt
};

struct Results {
  std::string name;
  std::string source;
  ResolvedProblem problem;
  maneuver::Solution solution;
  std::optional<certificate::Certificate> certificate;
  Provenance provenance;
  maneuver::Failure failure = {};    // what the message begins with, in parts, where nothing optimal was found
  std::vector<Results> others = {};  // of other minima that are kept, by rising cost; each in a folder of its own
  bool alone = false;                // read from a file: whether there are others is not known

  /// Whether a march made it, which seeks no goal, and not a search; one that ended early has another status than the others.
  bool marched() const {
    using maneuver::Status;
    return solution.status == Status::simulated || (!problem.goal && solution.status != Status::optimal);
  }
};

}  // namespace lamprey::result
