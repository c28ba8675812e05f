#include <gtest/gtest.h>

#include "golden_reference.hpp"
#include "lie/so3.hpp"
#include "mechanics/discrete_lagrangian.hpp"
#include "mechanics/equations_of_motion.hpp"
#include "printed.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using nlohmann::json;

struct GoldenCase {
  explicit GoldenCase(const json& c) : inputs(c["inputs"]), outputs(c["outputs"]), system(golden_system(inputs)) {
    for (const auto& R : inputs["R"]) rotation.push_back(matrix3(R));
    xi = generalized(inputs["xi"]);
    const auto u = inputs["u"].get<std::vector<double>>();
    control = {Vector3d(u[0], u[1], u[2]), Vector3d(u[3], u[4], u[5])};
    h = inputs["h"];
  }
  json inputs, outputs;
  model::System system;
  mechanics::Rotations rotation;
  VectorXd xi;
  mechanics::Moments control;
  double h;
};

void expect_close(const VectorXd& found, const VectorXd& expected, const std::string& what) {
  EXPECT_LE((found - expected).lpNorm<Eigen::Infinity>(), tolerance(1e-12) * expected.lpNorm<Eigen::Infinity>())
      << what;
}

class Reference : public ::testing::TestWithParam<int> {
 protected:
  GoldenCase golden_case() const {
    return GoldenCase(golden("reference.json")["cases"][static_cast<std::size_t>(GetParam())]);
  }
};

TEST_P(Reference, continuous_laws_agree_with_80_digit_arithmetic) {
  const GoldenCase c = golden_case();
  const double energy = c.outputs["T"];
  EXPECT_NEAR(mechanics::kinetic_energy(c.system, c.rotation, c.xi), energy, tolerance(1e-12) * energy);
  const VectorXd momentum = generalized(c.outputs["I_xi"]);
  expect_close(mechanics::generalized_momentum(c.system, c.rotation, c.xi), momentum, "I xi without forming I");
  expect_close(mechanics::generalized_inertia(c.system, c.rotation) * c.xi, momentum, "I xi");
  expect_close(mechanics::generalized_force(c.system, c.rotation, c.control), generalized(c.outputs["U"]), "U");
  expect_close(mechanics::bias(c.system, c.rotation, c.xi), generalized(c.outputs["bias"]), "bias");
  expect_close(mechanics::acceleration(c.system, c.rotation, c.xi, c.control), generalized(c.outputs["xi_dot"]),
               "xi_dot");
}

TEST_P(Reference, discrete_lagrangians_and_momenta_agree_with_80_digit_arithmetic) {
  const GoldenCase c = golden_case();
  for (const auto& [name, lagrangian] : {std::pair{"L12", mechanics::DiscreteLagrangian::paper},
                                         std::pair{"TRAP", mechanics::DiscreteLagrangian::trapezoid}}) {
    const json& expected = c.outputs["lgvi"][name];
    mechanics::Interval step(3);
    step.rotation = c.rotation;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d v = vector3(c.inputs["f_k"]["F_rotvec"][i]);
      step.cayley[i] = std::tan(0.5 * v.norm()) / v.norm() * v;
    }
    step.displacement = vector3(c.inputs["f_k"]["dx"]);
    mechanics::update_interval(c.system, step);
    const double value = expected["Ld_k"];
    EXPECT_NEAR(mechanics::discrete_lagrangian(c.system, lagrangian, c.h, step), value, tolerance(1e-12) * value)
        << name;

    mechanics::DiscreteMomenta momenta(3);
    mechanics::discrete_momenta(c.system, lagrangian, c.h, step, momenta);
    VectorXd minus(12), plus(12);
    minus << momenta.minus[0], momenta.minus[1], momenta.minus[2], momenta.linear;
    plus << momenta.plus[0], momenta.plus[1], momenta.plus[2], momenta.linear;
    expect_close(minus, generalized(expected["p_minus_k"]), std::string(name) + " p minus");
    expect_close(plus, generalized(expected["p_plus_kp1"]), std::string(name) + " p plus");
    const auto total = mechanics::spatial_momentum(c.system, step.rotation, vector3(c.inputs["x"]), minus);
    expect_close(total.angular, vector3(expected["spatial_angular_momentum_about_origin"]),
                 std::string(name) + " angular");
  }
}

INSTANTIATE_TEST_SUITE_P(Golden, Reference, ::testing::Range(0, 5), named_by_value);

}  // namespace
}  // namespace lamprey::tests
