#include <gtest/gtest.h>

#include "integrator/step.hpp"
#include "mechanics/golden_reference.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using nlohmann::json;

class GoldenStep : public ::testing::TestWithParam<std::size_t> {};

TEST_P(GoldenStep, one_step_of_both_schemes_agrees_with_80_digit_arithmetic) {
  const json c = golden("reference.json")["cases"][GetParam()];
  const model::System system = golden_system(c["inputs"]);
  const double h = c["inputs"]["h"];
  for (const auto& [name, lagrangian] : {std::pair{"L12", mechanics::DiscreteLagrangian::paper},
                                         std::pair{"TRAP", mechanics::DiscreteLagrangian::trapezoid}}) {
    const json& expected = c["outputs"]["lgvi"][name];
    const Eigen::VectorXd target = generalized(expected["p_plus_kp1"]) + h * generalized(c["outputs"]["U_kp1"]);
    integrator::StepWorkspace work(system);
    for (std::size_t i = 0; i < 3; ++i) {
      work.interval.rotation[i] = matrix3(c["outputs"]["g_kp1"]["R"][i]);
      work.target[i] = target.segment<3>(3 * static_cast<int>(i));
    }
    ASSERT_TRUE(integrator::solve_step(system, lagrangian, h, target.tail<3>(), work).converged) << name;
    const Eigen::Vector3d shift = vector3(expected["dx_kp1"]);
    EXPECT_LE((work.interval.displacement - shift).norm(), tolerance(1e-12) * shift.norm()) << name;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d turn = vector3(expected["F_kp1_rotvec"][i]);
      const double angle = 2.0 * std::atan(work.interval.cayley[i].norm());
      EXPECT_LE((angle * work.interval.cayley[i].normalized() - turn).norm(), tolerance(1e-12) * turn.norm()) << name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cases, GoldenStep, ::testing::Range(std::size_t{0}, std::size_t{5}), named_by_value);

}  // namespace
}  // namespace lamprey::tests
