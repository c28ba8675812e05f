// Which curves of the report limits apply to, and those that only limits ask for.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "evidence/stored_motion.hpp"

namespace lamprey::report {

enum class CurveKind { angle, moment, rate };

/// A curve of a joint with its bounds.
struct LimitCurve {
  int joint;
  CurveKind kind;
  std::optional<int> line;  // the entry of joint_angle or of the stored motion's control that it is; else it has values
  std::string label;        // with values: what they are called
  std::vector<double> values;  // [N + 1] rad, N m or rad/s; NaN where a limit asks for nothing
  std::vector<double> bounds;  // in the same unit
};

/// Of limits of moments, angles, swing, twist and rates, in the order of the joints.
std::vector<LimitCurve> limit_curves(const evidence::StoredMotion& motion);

}  // namespace lamprey::report
