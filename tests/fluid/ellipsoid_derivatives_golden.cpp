#include "fluid/ellipsoid_derivatives.hpp"

#include <array>
#include <fstream>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tolerance.hpp"

namespace lamprey::fluid {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d vector_from(const nlohmann::json& values) {
  const auto v = values.get<std::array<double, 3>>();
  return Vector3d(v[0], v[1], v[2]);
}

Matrix3d matrix_from(const nlohmann::json& rows) {
  Matrix3d result;
  for (int i = 0; i < 3; ++i) result.row(i) = vector_from(rows.at(static_cast<std::size_t>(i))).transpose();
  return result;
}

// Each row by its own largest entry, changes for equal relative changes of the axes; a row of zeros must be exact.
void expect_same_rows(const Matrix3d& value, const Matrix3d& expected, const Vector3d& semi_axes) {
  for (int i = 0; i < 3; ++i) {
    const Vector3d exact = expected.row(i).transpose().cwiseProduct(semi_axes);
    const Vector3d ours = value.row(i).transpose().cwiseProduct(semi_axes);
    const double largest = exact.cwiseAbs().maxCoeff();
    if (largest == 0.0) {
      EXPECT_EQ(value.row(i), Eigen::RowVector3d::Zero()) << "row " << i;
    } else {
      EXPECT_LE((ours - exact).cwiseAbs().maxCoeff() / largest, tests::tolerance(1e-14)) << "row " << i;
    }
  }
}

// The largest entry of the whole matrix as the measure, axes as they are.
double error_by_largest_entry(const Matrix3d& value, const Matrix3d& expected) {
  return (value - expected).cwiseAbs().maxCoeff() / expected.cwiseAbs().maxCoeff();
}

}  // namespace

TEST(EllipsoidDerivativesGolden, hard_shapes_agree_with_differences_in_160_digit_arithmetic_to_round_off) {
  std::ifstream file(LAMPREY_SOURCE_DIR "/tests/golden/ellipsoid_derivatives.json");
  const auto cases = nlohmann::json::parse(file).at("cases");
  ASSERT_GE(cases.size(), 17U);
  for (const auto& entry : cases) {
    SCOPED_TRACE(entry.at("semi_axes").dump());
    const Vector3d semi_axes = vector_from(entry.at("semi_axes"));
    const auto derivatives = ellipsoid_inertia_derivatives(semi_axes, 1.0).by_semi_axes;
    const Vector3d volume = vector_from(entry.at("volume"));
    EXPECT_LT((derivatives.volume - volume).cwiseQuotient(volume).norm(), tests::tolerance(1e-15));
    EXPECT_EQ(derivatives.mass, derivatives.volume);
    const Matrix3d body_inertia = matrix_from(entry.at("body_inertia"));
    const Matrix3d added_mass = matrix_from(entry.at("added_mass"));
    const Matrix3d added_inertia = matrix_from(entry.at("added_inertia"));
    expect_same_rows(derivatives.body_inertia, body_inertia, semi_axes);
    expect_same_rows(derivatives.added_mass, added_mass, semi_axes);
    expect_same_rows(derivatives.added_inertia, added_inertia, semi_axes);
    EXPECT_LE(error_by_largest_entry(derivatives.added_mass, added_mass), tests::tolerance(1e-14));
    if (!added_inertia.isZero(0.0)) {
      EXPECT_LE(error_by_largest_entry(derivatives.added_inertia, added_inertia), tests::tolerance(1e-14));
    }
  }
}

// The aspect of a swimmer's body: each entry by itself, however small beside its row.
TEST(EllipsoidDerivativesGolden, single_entries_agree_too_up_to_aspect_ten) {
  std::ifstream file(LAMPREY_SOURCE_DIR "/tests/golden/ellipsoid_derivatives.json");
  const auto cases = nlohmann::json::parse(file).at("cases");
  int checked = 0;
  for (const auto& entry : cases) {
    const Vector3d semi_axes = vector_from(entry.at("semi_axes"));
    if (semi_axes.maxCoeff() > 10.0 * semi_axes.minCoeff()) continue;
    SCOPED_TRACE(entry.at("semi_axes").dump());
    const auto derivatives = ellipsoid_inertia_derivatives(semi_axes, 1.0).by_semi_axes;
    const Matrix3d added_mass = matrix_from(entry.at("added_mass"));
    const Matrix3d added_inertia = matrix_from(entry.at("added_inertia"));
    for (int i = 0; i < 9; ++i) {
      EXPECT_NEAR(derivatives.added_mass(i) / added_mass(i), 1.0, tests::tolerance(1e-13)) << "entry " << i;
      if (added_inertia(i) != 0.0) {
        EXPECT_NEAR(derivatives.added_inertia(i) / added_inertia(i), 1.0, tests::tolerance(1e-13)) << "entry " << i;
      } else {
        EXPECT_EQ(derivatives.added_inertia(i), 0.0) << "entry " << i;
      }
      ++checked;
    }
  }
  EXPECT_GE(checked, 9 * 10);
}

}  // namespace lamprey::fluid
