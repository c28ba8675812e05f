// What a person writes about a swimmer: plain numbers, validated by model::System and by the reader of problem files.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace lamprey::model {

enum class JointKind { ball, universal, hinge, fixed };

/// A body as described; the first one is the root.
struct BodyDescription {
  std::string name;
  Eigen::Vector3d semi_axes =
      Eigen::Vector3d::Zero();  // m, half lengths of the ellipsoid, body frame; of an ellipse the third is drawn alone
  std::optional<double> mass;   // kg; default: density × volume
  std::optional<Eigen::Matrix3d> body_inertia;     // kg m², without fluid, about the mass centre; default: homogeneous
  std::optional<Eigen::Matrix3d> mass_matrix;      // kg, body + fluid: overrides M_i
  std::optional<Eigen::Matrix3d> inertia_matrix;   // kg m², body + fluid: overrides J_i
  std::optional<Eigen::Matrix3d> coupling_matrix;  // kg m, body + fluid: C_i in the energy V·C_iΩ; default: zero
  /// In a fluid that moves along e_1 and e_2: one metre of a cylinder, masses and moments per metre of depth.
  bool ellipse = false;
};

/// A joint as described; the moment u_j acts on the parent, its opposite on the child.
struct JointDescription {
  std::string name;
  JointKind kind = JointKind::ball;
  std::string parent;
  std::string child;
  Eigen::Vector3d parent_offset = Eigen::Vector3d::Zero();       // m, mass centre → joint, parent's frame
  Eigen::Vector3d child_offset = Eigen::Vector3d::Zero();        // m, mass centre → joint, child's frame
  Eigen::Vector3d reference_rotation = Eigen::Vector3d::Zero();  // rad, child → parent at zero angle
  std::optional<Eigen::Vector3d> axis;                           // hinge: free axis, child's frame
  std::optional<std::array<Eigen::Vector3d, 2>> axes;            // universal: in the parent's, in the child's frame
  bool actuated = true;
  std::optional<std::vector<Eigen::Vector3d>> control_axes;  // parent's frame at zero angle; default: all free ones
  double stiffness = 0.0;                                    // N m/rad about the zero angle
  double damping = 0.0;                                      // N m s/rad
  bool compliant() const { return stiffness > 0.0 || damping > 0.0; }
  /// Whether nothing drives it though it may bend: its angles are an outcome.
  bool passive() const { return !actuated && kind != JointKind::fixed; }
};

struct SwimmerDescription {
  double density = 0.0;  // kg/m³ of the fluid; 0 is a vacuum
  std::vector<BodyDescription> bodies;
  std::vector<JointDescription> joints;
  /// Whether any joint has a spring or a damper.
  bool compliant() const {
    return std::any_of(joints.begin(), joints.end(), [](const JointDescription& joint) { return joint.compliant(); });
  }
};

}  // namespace lamprey::model
