// Numbers and names as text for people.
#pragma once

#include <string>
#include <string_view>

#include <Eigen/Core>

namespace lamprey::report {

/// `digits` significant digits, as 243152.7 or 3.1×10⁻¹²; "not computed" for NaN.
std::string number(double value, int digits = 6);

/// Of a cost or a work: in groups of three from ten thousand on, as 243 152.7.
std::string cost_number(double cost, int digits = 8);

/// "(1, 2.5, 0)"; what is round-off of the largest entry is 0.
std::string vector(const Eigen::Vector3d& value, int digits = 6);

/// "diag(1, 2, 3)" or, when not diagonal, "[a, b, c; d, e, f; g, h, i]".
std::string matrix(const Eigen::Matrix3d& value, int digits = 5);

/// Text as content or attribute value of HTML and SVG; bytes that XML forbids become U+FFFD.
std::string escaped(std::string_view text);

}  // namespace lamprey::report
