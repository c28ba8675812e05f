#include "task/task_words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "document/text_table.hpp"
#include "model/world_axes.hpp"

namespace lamprey::task {

namespace {

using Lines = std::vector<std::string>;

std::string vector_words(const Eigen::Vector3d& v, NumberText number) {
  return fmt::format("({}, {}, {})", number(v[0]), number(v[1]), number(v[2]));
}

void add_moments(const maneuver::Limits& limits, NumberText number, Lines& lines) {
  if (limits.torque) lines.push_back(fmt::format("moment at each joint up to {} N m", number(*limits.torque)));
  for (const auto& [name, value] : limits.joint_torque)
    lines.push_back(fmt::format("moment at {} up to {} N m", document::printable(name), number(value)));
  if (limits.torque_component)
    lines.push_back(fmt::format("each component of the moments up to {} N m", number(*limits.torque_component)));
  for (const auto& [name, value] : limits.joint_torque_component)
    lines.push_back(
        fmt::format("each component of the moment at {} up to {} N m", document::printable(name), number(value)));
}

void add_rates(const maneuver::Limits& limits, NumberText number, Lines& lines) {
  if (limits.angular_velocity)
    lines.push_back(fmt::format("joints turn by up to {} rad/s", number(*limits.angular_velocity)));
  for (const auto& [name, value] : limits.joint_angular_velocity)
    lines.push_back(fmt::format("{} turns by up to {} rad/s", document::printable(name), number(value)));
  if (limits.angular_velocity_component)
    lines.push_back(
        fmt::format("each angle of the joints by up to {} rad/s", number(*limits.angular_velocity_component)));
  for (const auto& [name, value] : limits.joint_angular_velocity_component)
    lines.push_back(fmt::format("each angle of {} by up to {} rad/s", document::printable(name), number(value)));
}

void add_angles(const maneuver::Limits& limits, NumberText number, Lines& lines) {
  for (const auto& [name, value] : limits.swing)
    lines.push_back(fmt::format("swing of {} up to {} rad", document::printable(name), number(value)));
  for (const auto& [name, value] : limits.twist)
    lines.push_back(fmt::format("twist of {} up to {} rad", document::printable(name), number(value)));
  for (const auto& [name, bounds] : limits.angle)
    for (std::size_t axis = 0; axis < bounds.size(); ++axis)
      lines.push_back(fmt::format("{} of {} in [{}, {}] rad",
                                  bounds.size() == 1 ? "angle"
                                  : axis == 0        ? "first angle"
                                                     : "second angle",
                                  document::printable(name), number(bounds[axis][0]), number(bounds[axis][1])));
}

void add_obstacles(const maneuver::Limits& limits, NumberText number, Lines& lines) {
  if (limits.clearance) lines.push_back(fmt::format("bodies stay {} m apart", number(*limits.clearance)));
  for (const maneuver::KeepOutSphere& sphere : limits.spheres)
    lines.push_back(fmt::format("bodies stay out of the sphere of radius {} m about {} m", number(sphere.radius),
                                vector_words(sphere.centre, number)));
  for (const maneuver::KeepOutHalfSpace& half : limits.half_spaces)
    lines.push_back(fmt::format("bodies stay beyond the plane through {} m, on the side of {}",
                                vector_words(half.point, number), vector_words(half.normal, number)));
}

}  // namespace

Lines limit_lines(const maneuver::Limits& limits, NumberText number) {
  Lines lines;
  add_moments(limits, number, lines);
  add_rates(limits, number, lines);
  add_angles(limits, number, lines);
  add_obstacles(limits, number, lines);
  return lines;
}

Lines waypoint_lines(const std::vector<maneuver::Waypoint>& waypoints, bool free_shape, NumberText number) {
  Lines lines;
  for (const maneuver::Waypoint& waypoint : waypoints) {
    Lines parts;
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (waypoint.move[axis])
        parts.push_back(
            fmt::format("{} m along {} from the start", number(*waypoint.move[axis]), model::world_axes[axis]));
    if (waypoint.turn)
      parts.push_back(fmt::format("{} turned by {} rad", free_shape ? "the root" : "every body",
                                  vector_words(*waypoint.turn, number)));
    for (const auto& [name, rotation] : waypoint.rotation)
      parts.push_back(fmt::format("{} at {} rad", document::printable(name), vector_words(rotation, number)));
    lines.push_back(fmt::format("at {} s: {}", number(waypoint.time), fmt::join(parts, ", ")));
  }
  return lines;
}

std::vector<std::string> joint_end_lines(const maneuver::Goal& goal, NumberText number) {
  std::vector<std::string> lines;
  for (const auto& [joint, angles] : goal.angle) {
    std::string values;
    for (double angle : angles) values += (values.empty() ? "" : ", ") + number(angle);
    if (angles.size() > 1) values = "(" + values + ")";
    lines.push_back(fmt::format("joint {} ends at {} rad", document::printable(joint), values));
  }
  if (goal.shape_of_start)
    lines.emplace_back(goal.angle.empty() ? "ends in the shape of the start" : "other joints end as they begin");
  return lines;
}

}  // namespace lamprey::task
