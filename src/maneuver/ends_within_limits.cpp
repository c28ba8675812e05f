#include "maneuver/ends_within_limits.hpp"

#include <algorithm>

namespace lamprey::maneuver {

namespace {

using Kind = LimitRow::Kind;
using mechanics::Rotations;
using model::at;
using model::System;

constexpr double breaks = 1e-9;  // of a row's unit: beyond round-off

// One end of the motion, and what is known of it.
struct End {
  Rotations rotation;
  Vector3d position;
  std::vector<bool> turned;    // [bodies]
  std::array<bool, 3> placed;  // world

  // Whether a limit depends on nothing else.
  bool shows(const System& system, const LimitRow& row) const {
    if (row.joint >= 0) {
      const model::Joint& joint = system.joint(row.joint);
      return turned[at(joint.parent)] && turned[at(joint.child)];
    }
    if (!std::all_of(turned.begin(), turned.end(), [](bool known) { return known; })) return false;
    for (int c = 0; c < 3; ++c) {
      const bool seen = row.kind == Kind::sphere || (row.kind == Kind::half_space && row.normal[c] != 0.0);
      if (seen && !placed[at(c)]) return false;
    }
    return true;
  }
};

std::optional<BrokenLimit> broken_by(const System& system, const Maneuver& maneuver, const End& end,
                                     const std::vector<LimitRow>& rows) {
  const VectorXd still = VectorXd::Zero(system.control_count());
  const double step = maneuver.time_step();
  const LimitedNode node{end.rotation, end.rotation, end.position, still, step, maneuver.duration};
  for (const LimitRow& row : rows) {
    if (row.of_moments() || row.of_duration() || row.equality() || row.of_rate()) continue;
    if (!end.shows(system, row)) continue;
    const double value = limit_value(system, row, node, 1.0);
    if (value < -breaks) return {{&row, row.excess(-value, step)}};
  }
  return std::nullopt;
}

}  // namespace

std::optional<BrokenLimit> broken_by_start(const System& system, const Maneuver& maneuver,
                                           const std::vector<LimitRow>& rows) {
  const integrator::State& start = maneuver.start;
  return broken_by(system, maneuver,
                   {start.rotation, start.position, std::vector<bool>(start.rotation.size(), true), {true, true, true}},
                   rows);
}

std::optional<BrokenLimit> broken_by_goal(const System& system, const Maneuver& maneuver,
                                          const std::vector<LimitRow>& rows) {
  End end{maneuver.start.rotation, maneuver.start.position, {}, {}};
  for (std::size_t i = 0; i < end.rotation.size(); ++i) {
    end.turned.push_back(maneuver.end_rotation[i].has_value());
    if (end.turned[i]) end.rotation[i] = *maneuver.end_rotation[i];
  }
  for (int c = 0; c < 3; ++c) {
    const auto& there = maneuver.end_position[at(c)];
    end.placed[at(c)] = there.has_value();
    if (there) end.position[c] = *there;
  }
  return broken_by(system, maneuver, end, rows);
}

}  // namespace lamprey::maneuver
