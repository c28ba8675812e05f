#include "fluid/ellipsoid.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tolerance.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Vector3d;

const double paper_density = 0.00994718394324346;  // makes the middle body weigh 1 kg

struct Reference {
  Vector3d semi_axes;
  Vector3d added_mass;     // over ρV
  Vector3d added_inertia;  // over ρV
};

// Twelve digits each, from an evaluation of Lamb's formulas apart from this code.
const std::vector<Reference> references = {
    {{8.0, 1.5, 2.0}, {0.065926392042, 1.16956375896, 0.664096296267}, {0.0980064529342, 6.5500330188, 12.0775794634}},
    {{2.0, 1.0, 1.0}, {0.210015048977, 0.70421042585, 0.70421042585}, {0.0, 0.239423893195, 0.239423893195}},
    {{10.0, 1.0, 1.0}, {0.0207059180772, 0.960234909268, 0.960234909268}, {0.0, 17.8474759657, 17.8474759657}},
    {{1.0, 1.0, 0.5}, {0.30958592847, 0.30958592847, 1.1150604857}, {0.0846444826067, 0.0846444826067, 0.0}},
};

void expect_same(const Vector3d& value, const Vector3d& expected, double relative) {
  for (int i = 0; i < 3; ++i)
    EXPECT_LE(std::abs(value[i] - expected[i]), relative * std::abs(expected[i])) << "entry " << i;
}

}  // namespace

// Lee, Leok, McClamroch 2009, section 5: bodies and fluid together.
TEST(EllipsoidGolden, all_twelve_entries_of_the_papers_table_agree_to_every_printed_digit) {
  struct Row {
    Vector3d semi_axes;
    Vector3d mass_matrix;
    Vector3d inertia_matrix;
  };
  const std::vector<Row> table = {
      {{8.0, 1.5, 2.0}, {1.0659, 2.1696, 1.6641}, {1.3480, 20.1500, 25.3276}},
      {{5.0, 0.8, 1.5}, {0.2664, 0.6551, 0.3677}, {0.1961, 1.7889, 2.9210}},
  };
  for (const Row& row : table) {
    const auto inertia = ellipsoid_inertia(row.semi_axes, paper_density);
    const Vector3d mass = Vector3d::Constant(inertia.mass) + inertia.added_mass;
    EXPECT_LT((mass - row.mass_matrix).cwiseAbs().maxCoeff(), tests::tolerance(5e-5));
    EXPECT_LT((inertia.body_inertia + inertia.added_inertia - row.inertia_matrix).cwiseAbs().maxCoeff(),
              tests::tolerance(5e-5));
  }
}

TEST(EllipsoidGolden, the_papers_totals_agree_to_twelve_digits) {
  const auto middle = ellipsoid_inertia({8.0, 1.5, 2.0}, paper_density);
  EXPECT_NEAR(middle.mass, 1.0, tests::tolerance(1e-14));
  expect_same(Vector3d::Constant(middle.mass) + middle.added_mass, {1.06592639204, 2.16956375896, 1.66409629627},
              tests::tolerance(5e-12));
  expect_same(middle.body_inertia + middle.added_inertia, {1.34800645293, 20.1500330188, 25.3275794634},
              tests::tolerance(5e-12));
  const auto outer = ellipsoid_inertia({5.0, 0.8, 1.5}, paper_density);
  EXPECT_NEAR(outer.mass, 0.25, tests::tolerance(1e-14));
  expect_same(Vector3d::Constant(outer.mass) + outer.added_mass, {0.266372470304, 0.655063460180, 0.367743234496},
              tests::tolerance(5e-12));
  expect_same(outer.body_inertia + outer.added_inertia, {0.196147232928, 1.78893230401, 2.92100919464},
              tests::tolerance(5e-12));
}

TEST(EllipsoidGolden, normalised_references_agree_to_twelve_digits) {
  for (const Reference& reference : references) {
    const auto inertia = ellipsoid_inertia(reference.semi_axes, 1.0);
    expect_same(inertia.added_mass / inertia.mass, reference.added_mass, tests::tolerance(5e-12));
    expect_same(inertia.added_inertia / inertia.mass, reference.added_inertia, tests::tolerance(5e-12));
  }
}

TEST(EllipsoidGolden, hard_shapes_agree_with_sixty_digit_quadrature_to_round_off) {
  std::ifstream file(LAMPREY_SOURCE_DIR "/tests/golden/ellipsoids.json");
  const auto cases = nlohmann::json::parse(file).at("cases");
  ASSERT_GE(cases.size(), 20U);
  const auto vector = [](const nlohmann::json& values) {
    const auto v = values.get<std::array<double, 3>>();
    return Vector3d(v[0], v[1], v[2]);
  };
  for (const auto& entry : cases) {
    SCOPED_TRACE(entry.at("semi_axes").dump());
    const auto inertia = ellipsoid_inertia(vector(entry.at("semi_axes")), 1.0);
    expect_same(inertia.added_mass / inertia.mass, vector(entry.at("added_mass")), tests::tolerance(1e-14));
    expect_same(inertia.added_inertia / inertia.mass, vector(entry.at("added_inertia")), tests::tolerance(1e-14));
  }
}

}  // namespace lamprey::fluid
