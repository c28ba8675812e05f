// The five cases of tests/golden/reference.json (80-digit arithmetic; generator make_reference.py beside it).
#pragma once

#include <fstream>
#include <string>

#include <nlohmann/json.hpp>

#include "model/system.hpp"

namespace lamprey::tests {

inline nlohmann::json golden(const std::string& file) {
  std::ifstream stream(std::string(LAMPREY_SOURCE_DIR) + "/tests/golden/" + file);
  return nlohmann::json::parse(stream);
}

inline Eigen::Vector3d vector3(const nlohmann::json& a) {
  return Eigen::Vector3d(a[0].get<double>(), a[1].get<double>(), a[2].get<double>());
}

inline Eigen::Matrix3d matrix3(const nlohmann::json& a) {
  Eigen::Matrix3d m;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) m(r, c) = a[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
  return m;
}

/// Golden 12-vectors run (body 0; x; body 1; body 2); ours run (bodies; x).
inline Eigen::VectorXd generalized(const nlohmann::json& a) {
  Eigen::VectorXd v(12);
  const int slot[4] = {0, 9, 3, 6};
  for (std::size_t part = 0; part < 4; ++part)
    for (std::size_t c = 0; c < 3; ++c) v[slot[part] + static_cast<int>(c)] = a[3 * part + c];
  return v;
}

inline model::System golden_system(const nlohmann::json& inputs) {
  const auto& m = inputs["model"];
  model::SwimmerDescription d;
  d.density = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    model::BodyDescription body;
    body.name = std::to_string(i);
    body.semi_axes = Eigen::Vector3d(1, 1, 1);
    body.mass_matrix = matrix3(m["M"][i]);
    body.inertia_matrix = matrix3(m["J"][i]);
    d.bodies.push_back(body);
  }
  for (std::size_t i = 1; i < 3; ++i) {
    model::JointDescription joint;
    joint.name = joint.child = std::to_string(i);
    joint.parent = "0";
    joint.parent_offset = vector3(m["d0" + std::to_string(i)]);
    joint.child_offset = vector3(m["d" + std::to_string(i) + "0"]);
    d.joints.push_back(joint);
  }
  return model::System(d);
}

}  // namespace lamprey::tests
