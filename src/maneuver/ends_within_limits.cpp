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
  std::vector<bool> turned;    // [bodies] in the world
  std::vector<bool> led;       // [joints]
  std::array<bool, 3> placed;  // world

  // Whether a limit depends on nothing else.
  bool shows(const LimitRow& row) const {
    const auto all = [](const std::vector<bool>& known) {
      return std::all_of(known.begin(), known.end(), [](bool one) { return one; });
    };
    if (row.joint >= 0) return led[at(row.joint)];
    if (row.kind == Kind::clearance) return all(led);
    if (!all(turned)) return false;
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
    if (!end.shows(row)) continue;
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
                   {start.rotation,
                    start.position,
                    std::vector<bool>(start.rotation.size(), true),
                    std::vector<bool>(at(system.joint_count()), true),
                    {true, true, true}},
                   rows);
}

std::optional<BrokenLimit> broken_by_goal(const System& system, const Maneuver& maneuver,
                                          const std::vector<LimitRow>& rows) {
  End end{maneuver.start.rotation, maneuver.start.position, {}, {}, {}};
  for (const auto& asked : maneuver.end_rotation) end.turned.push_back(asked.has_value());
  for (int j = 0; j < system.joint_count(); ++j) end.led.push_back(joint_at_end(system, maneuver, j).has_value());
  for (int i : system.root_to_leaves()) {
    const model::Body& body = system.body(i);
    if (maneuver.end_rotation[at(i)])
      end.rotation[at(i)] = *maneuver.end_rotation[at(i)];
    else if (body.parent >= 0 && end.led[at(body.joint)])
      end.rotation[at(i)] = end.rotation[at(body.parent)] * *joint_at_end(system, maneuver, body.joint);
  }
  for (int c = 0; c < 3; ++c) {
    const auto& there = maneuver.end_position[at(c)];
    end.placed[at(c)] = there.has_value();
    if (there) end.position[c] = *there;
  }
  return broken_by(system, maneuver, end, rows);
}

}  // namespace lamprey::maneuver
