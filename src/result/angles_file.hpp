// Joint angles for `lamprey simulate --angles`: those of an earlier solution.json, or a table that people write.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "result/joint_table.hpp"
#include "result/results.hpp"

namespace lamprey::result {

/// Between their times a cubic (not-a-knot) runs through them.
struct AngleSamples {
  std::vector<double> time;                         // s, rising strictly, at least two
  std::vector<std::vector<Eigen::Vector3d>> angle;  // [time][joints] rad, as `joint_angle` of a solution
  std::vector<bool> passive = {};  // [joints] which say nothing of a joint that no moment drives; empty: none
  std::optional<maneuver::Start> first = {};  // of a stored motion: its first node
  std::string remark = {};                    // of a table: what its reader should be told; may be empty
};

/// Reads a solution.json (text that begins with '{') or a CSV table: t, then the angles of each joint, in the problem's order or as
/// its header names them; of joints that nothing drives the header may name none, and a march lets them move as they do. IoError when the file cannot be read, model::InputError when it is wrong or is of other joints.
AngleSamples read_angles(const std::string& path, const Joints& joints);

/// The same from the file's bytes; `path` only names them.
AngleSamples parse_angles(const std::string& bytes, const std::string& path, const Joints& joints);

/// The angles of a motion that is already there; of joints that nothing drives they say nothing but how a gait begins.
AngleSamples angles_of_results(const Results& results, const std::string& path, const Joints& joints);

/// So many periods one after the other; whole turns about a joint's axes go on. model::InputError where the last angles are not the
/// first ones otherwise, or time does not begin at 0; `path` names them.
void repeat(int cycles, const std::string& path, const Joints& joints, AngleSamples& angles);

/// model::InputError where angles stand beyond the freedoms of their joints, such as a hinge's in the place of z.
void require_freedoms(const AngleSamples& angles, const std::string& path, const Joints& joints);

}  // namespace lamprey::result
