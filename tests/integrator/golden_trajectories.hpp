// The trajectories of tests/golden/dop853.json (scipy's DOP853 at 1e-13; generator make_dop853.py beside it).
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "chains.hpp"
#include "integrator/reference_integrator.hpp"
#include "mechanics/golden_reference.hpp"

namespace lamprey::tests {

struct GoldenState {
  double time;
  integrator::ReferenceState state;
};

struct GoldenTrajectory {
  std::string name;
  integrator::ControlFunction control;
  GoldenState start;
  std::vector<GoldenState> states;
  double estimated_error;  // of the last state
};

inline GoldenState golden_state(const nlohmann::json& a) {
  GoldenState golden{a["time"], {{}, vector3(a["position"]), Eigen::VectorXd(12)}};
  for (std::size_t i = 0; i < 3; ++i) {
    golden.state.rotation.push_back(matrix3(a["rotation"][i]));
    golden.state.velocity.segment<3>(3 * static_cast<int>(i)) = vector3(a["angular_velocity"][i]);
  }
  golden.state.velocity.tail<3>() = vector3(a["linear_velocity"]);
  return golden;
}

// u_j(t)[k] = Σ_m amplitude[j][k][m−1] sin(2π m t + phase[j][k][m−1])
inline integrator::ControlFunction golden_control(const nlohmann::json& a) {
  using WaveNumbers = std::vector<std::vector<std::vector<double>>>;
  return [amplitude = a["amplitude"].get<WaveNumbers>(), phase = a["phase"].get<WaveNumbers>()](double t) {
    mechanics::Moments u(amplitude.size(), Vector3d::Zero());
    for (std::size_t j = 0; j < u.size(); ++j)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t m = 0; m < amplitude[j][c].size(); ++m)
          u[j][static_cast<int>(c)] +=
              amplitude[j][c][m] * std::sin(2.0 * M_PI * static_cast<double>(m + 1) * t + phase[j][c][m]);
    return u;
  };
}

inline std::vector<GoldenTrajectory> golden_trajectories() {
  std::vector<GoldenTrajectory> trajectories;
  const nlohmann::json file = golden("dop853.json");
  for (const auto& a : file["cases"]) {
    trajectories.push_back(
        {a["name"], golden_control(a["control"]), golden_state(a["start"]), {}, a["estimated_error"]});
    for (const auto& state : a["states"]) trajectories.back().states.push_back(golden_state(state));
  }
  return trajectories;
}

}  // namespace lamprey::tests
