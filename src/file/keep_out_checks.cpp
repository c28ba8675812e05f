#include "file/keep_out_checks.hpp"

#include <fmt/format.h>

#include "model/input_error.hpp"

namespace lamprey::file {

namespace {

using Eigen::Vector3d;
using maneuver::Problem;
using Move = std::array<std::optional<double>, 3>;

constexpr double last_digits = 1e-9;  // of the root's smallest semi-axis

// Where the root's mass centre is told to be.
struct Place {
  std::string key;
  Vector3d start;
  const Move& move;

  bool tells(int axis) const { return move[static_cast<std::size_t>(axis)].has_value(); }
  /// What is not told counts as where it began.
  Vector3d point() const {
    Vector3d point = start;
    for (int c = 0; c < 3; ++c) point[c] += move[static_cast<std::size_t>(c)].value_or(0.0);
    return point;
  }
};

[[noreturn]] void refuse_place(const Place& place, const std::string& limit, double before, double least) {
  throw model::InputError(
      place.key,
      fmt::format("found a place of the root's mass centre {:.4g} m {} {}; allowed: at least {:.4g} m before "
                  "it, the root's smallest semi-axis; move farther out, or the limit farther back",
                  std::abs(before), before < 0.0 ? "beyond the surface of" : "before", limit, least));
}

void require_room_at(const Place& place, const Problem& problem, double least) {
  const auto require = [&](const char* kind, std::size_t which, double before) {
    if (before < least * (1.0 - last_digits)) refuse_place(place, fmt::format("{}[{}]", kind, which), before, least);
  };
  const maneuver::Limits& limits = problem.limits;
  for (std::size_t n = 0; n < limits.half_spaces.size(); ++n) {
    const auto& [point, normal] = limits.half_spaces[n];
    bool told = true;
    for (int c = 0; c < 3; ++c) told = told && (normal[c] == 0.0 || place.tells(c));
    if (told) require("limits.half_space", n, normal.normalized().dot(place.point() - point));
  }
  const bool all = place.tells(0) && place.tells(1) && place.tells(2);
  for (std::size_t n = 0; all && n < limits.spheres.size(); ++n)
    require("limits.sphere", n, (place.point() - limits.spheres[n].centre).norm() - limits.spheres[n].radius);
}

}  // namespace

void require_room_for_root(const model::System& system, const Problem& problem) {
  const double least = system.body(0).semi_axes.minCoeff();
  const Vector3d& start = problem.start.position;
  // a first shape that is free moves its limits, but not the root
  static const Move stays = {0.0, 0.0, 0.0};
  if (problem.start.free_shape) require_room_at({"start.position", start, stays}, problem, least);
  if (problem.goal) require_room_at({"goal.move", start, problem.goal->move}, problem, least);
  for (std::size_t n = 0; n < problem.waypoints.size(); ++n)
    require_room_at({fmt::format("waypoint[{}].move", n), start, problem.waypoints[n].move}, problem, least);
}

}  // namespace lamprey::file
