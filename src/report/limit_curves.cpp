#include "report/limit_curves.hpp"

#include <array>

#include <fmt/format.h>

#include "evidence/limit_check.hpp"

namespace lamprey::report {

namespace {

using evidence::Bound;
using evidence::StoredMotion;
using model::at;
using Kind = Bound::Kind;

constexpr std::array angle_names{"θ₁", "θ₂"};

// The entry of joint_moments that a column of Joint::actuation is; nothing where it is none alone.
std::optional<int> entry_along(const model::Joint& joint, int column) {
  constexpr double round_off = 1e-9;
  for (int k = 0; k < 3; ++k)
    if (std::abs(std::abs(joint.actuation(k, column)) - 1.0) < round_off) return k;
  return std::nullopt;
}

// Bound less margin, node by node: what a limit of a size bounds.
std::vector<double> bounded_values(const StoredMotion& motion, const Bound& bound) {
  std::vector<double> values = evidence::margins(motion, bound);
  for (double& value : values) value = bound.value - value;
  return values;
}

LimitCurve drawn_anyway(const Bound& bound, CurveKind kind, int line, std::vector<double> bounds) {
  return {bound.joint, kind, line, "", {}, std::move(bounds)};
}

LimitCurve curve_of_its_own(const StoredMotion& motion, const Bound& bound, CurveKind kind, const std::string& label,
                            std::vector<double> bounds) {
  return {bound.joint, kind, std::nullopt, label, bounded_values(motion, bound), std::move(bounds)};
}

LimitCurve of_moment(const StoredMotion& motion, const Bound& bound) {
  const model::Joint& joint = motion.system.joint(bound.joint);
  const std::vector<double> both = {-bound.value, bound.value};
  const bool of_one = bound.kind == Kind::torque_component || joint.actuation.cols() == 1;
  const int column = std::max(bound.component, 0);
  if (of_one)
    if (const std::optional<int> entry = entry_along(joint, column))
      return drawn_anyway(bound, CurveKind::moment, *entry, both);
  return curve_of_its_own(motion, bound, CurveKind::moment,
                          of_one ? fmt::format("|along control axis {}|", column + 1) : "|u|", {bound.value});
}

std::optional<LimitCurve> curve_of(const StoredMotion& motion, const Bound& bound) {
  switch (bound.kind) {
    case Kind::torque:
    case Kind::torque_component:
      return of_moment(motion, bound);
    case Kind::swing:
      return curve_of_its_own(motion, bound, CurveKind::angle, "swing", {bound.value});
    case Kind::twist:
      return curve_of_its_own(motion, bound, CurveKind::angle, "|twist|", {bound.value});
    case Kind::angle:
      return drawn_anyway(bound, CurveKind::angle, std::max(bound.component, 0), {bound.value});
    case Kind::angular_velocity:
      return curve_of_its_own(motion, bound, CurveKind::rate, "|rate|", {bound.value});
    case Kind::angle_rate:
      if (!bound.upper) return std::nullopt;  // the upper one has both
      return curve_of_its_own(
          motion, bound, CurveKind::rate,
          bound.component < 0 ? "rate of θ" : fmt::format("rate of {}", angle_names[at(bound.component)]),
          {-bound.value, bound.value});
    default:
      return std::nullopt;
  }
}

}  // namespace

std::vector<LimitCurve> limit_curves(const StoredMotion& motion) {
  std::vector<LimitCurve> curves;
  for (const Bound& bound : evidence::bounds_of(motion))
    if (std::optional<LimitCurve> curve = curve_of(motion, bound)) {
      LimitCurve* last = curves.empty() ? nullptr : &curves.back();
      const bool other_side = last && curve->line && last->line == curve->line && last->joint == curve->joint &&
                              last->kind == curve->kind && bound.kind == Kind::angle;
      if (other_side)
        last->bounds.push_back(curve->bounds.front());
      else
        curves.push_back(std::move(*curve));
    }
  return curves;
}

}  // namespace lamprey::report
