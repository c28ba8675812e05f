// Rules of a problem file that reach beyond one key. Each throws model::InputError with the key alone.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

#include "maneuver/problem.hpp"

namespace lamprey::file {

/// "joint[j].name" and "body[i].name", as key_positions has them.
std::string joint_key(std::size_t j, std::string_view name);
std::string body_key(std::size_t i, std::string_view name);

/// Numbers of the bodies by their names, which are unique.
using BodyIndex = std::map<std::string, std::size_t>;
BodyIndex index_bodies(const model::SwimmerDescription& swimmer);

/// Names are unique; every joint joins two known bodies; the joints make one tree whose root is the first body.
void check_tree(const model::SwimmerDescription& swimmer);

/// Masses and inertias are symmetric positive definite and possible, the coupled 6×6 inertia too; volumes are finite; a vacuum states every mass.
void check_bodies(const model::SwimmerDescription& swimmer);

/// Axes are what the joint's kind needs: present, non-zero, independent, orthogonal at zero angle.
void check_joints(const model::SwimmerDescription& swimmer);

inline constexpr double angle_tolerance = 1e-9;  // rad, for rotations and axes that people write with 16 digits

/// rad: how far a rotation child → parent is from those the joint can take.
double misfit(const model::JointDescription& joint, const Eigen::Matrix3d& child_to_parent);

/// Start rotations and angular velocities fit the joints; free_shape goes with a periodic goal.
void check_start(const maneuver::Problem& problem);

/// Cost rule, spline points and search method go with scheme, steps and control kind.
void check_transcription(const maneuver::Problem& problem);

/// Costs have the distance and the last moment that they count by.
void check_costs(const maneuver::Problem& problem);

/// All of these that are of the question alone, and those of limits and waypoints.
void check_statement(const maneuver::Problem& problem);

}  // namespace lamprey::file
