#include "task/model_table.hpp"

#include <cmath>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "document/text_table.hpp"
#include "file/words.hpp"
#include "fluid/ellipse.hpp"
#include "fluid/gap.hpp"
#include "fluid/overlap.hpp"
#include "lie/so3.hpp"
#include "maneuver/maneuver.hpp"
#include "model/input_error.hpp"
#include "model/world_axes.hpp"
#include "task/task_words.hpp"

namespace lamprey::task {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using maneuver::Problem;
using model::at;
using model::Body;
using model::Joint;
using model::System;

std::string vector_text(const Vector3d& v) {
  return fmt::format("({}, {}, {})", document::short_number(v[0]), document::short_number(v[1]),
                     document::short_number(v[2]));
}

std::vector<std::string> triple(std::string label, const Vector3d& v, const std::string& unit) {
  return {std::move(label), document::short_number(v[0]), document::short_number(v[1]), document::short_number(v[2]),
          unit};
}

// Whether its bodies are ellipses.
bool plane(const Problem& problem) { return problem.swimmer.bodies.front().ellipse; }

std::string heading(const Problem& problem, const System& system) {
  std::string text = document::printable(problem.name) + "\n";
  if (!problem.source.empty()) text += document::printable(problem.source) + "\n";
  text += system.density() > 0.0 ? fmt::format("Fluid of density {} kg/m³\n", document::short_number(system.density()))
                                 : std::string("Vacuum: no fluid, nothing added\n");
  if (plane(problem)) text += "In the plane: masses, moments, energies and costs are those of one metre of depth\n";
  return text;
}

std::string bodies_section(const Problem& problem, const System& system) {
  document::TextTable table("lr");
  table.add_row({"", "a", "b", "c (m)", "volume (m³)", "mass (kg)", "displaced (kg)"});
  double volume = 0.0;
  double mass = 0.0;
  for (const Body& body : system.bodies()) {
    const double displaced = system.density() * body.volume;
    table.add_row({document::printable(body.name), document::short_number(body.semi_axes[0]),
                   document::short_number(body.semi_axes[1]),
                   plane(problem) ? "" : document::short_number(body.semi_axes[2]), document::short_number(body.volume),
                   document::short_number(body.mass), document::short_number(displaced)});
    volume += body.volume;
    mass += body.mass;
  }
  table.add_row({"all", "", "", "", document::short_number(volume), document::short_number(mass),
                 document::short_number(system.density() * volume)});
  return std::string("\nBodies, solid ") + (plane(problem) ? "ellipses" : "ellipsoids") +
         " with these semi-axes; the first is the root\n" + table.text();
}

// A diagonal as one row; other matrices also show their upper off-diagonal entries.
void add_matrix(document::TextTable& table, const std::string& label, const Matrix3d& m, const std::string& unit) {
  table.add_row(triple(label, m.diagonal(), unit));
  const Vector3d off_diagonal(m(0, 1), m(0, 2), m(1, 2));
  if (off_diagonal.cwiseAbs().maxCoeff() > 1e-14 * m.cwiseAbs().maxCoeff()) {
    table.add_row(triple("    entries 12, 13, 23", off_diagonal, unit));
  }
}

// Whether two bodies have the same inertia, from the same keys.
bool alike(const Problem& problem, const System& system, int i, int j) {
  const Body &a = system.body(i), &b = system.body(j);
  const auto &first = problem.swimmer.bodies[at(i)], &second = problem.swimmer.bodies[at(j)];
  return a.mass == b.mass && a.body_inertia == b.body_inertia && a.mass_matrix == b.mass_matrix &&
         a.inertia_matrix == b.inertia_matrix && a.coupling_matrix == b.coupling_matrix &&
         first.mass_matrix.has_value() == second.mass_matrix.has_value() &&
         first.body_inertia.has_value() == second.body_inertia.has_value() &&
         first.inertia_matrix.has_value() == second.inertia_matrix.has_value();
}

std::string inertia_section(const Problem& problem, const System& system) {
  document::TextTable table("lrrrl");
  table.add_row({"", "1", "2", "3"});
  for (int i = 0; i < system.body_count();) {
    const Body& body = system.body(i);
    const auto& described = problem.swimmer.bodies[static_cast<std::size_t>(i)];
    const int first = i;
    for (++i; i < system.body_count() && alike(problem, system, first, i);) ++i;
    table.add_row({first + 1 == i
                       ? document::printable(body.name)
                       : document::printable(body.name) + " … " + document::printable(system.body(i - 1).name)});
    add_matrix(table, "  added mass", body.mass_matrix - body.mass * Matrix3d::Identity(), "kg");
    add_matrix(table, described.mass_matrix ? "  M, as given" : "  M = mass + added", body.mass_matrix, "kg");
    add_matrix(table, described.body_inertia ? "  body inertia, as given" : "  body inertia, homogeneous",
               body.body_inertia, "kg m²");
    add_matrix(table, "  added inertia", body.inertia_matrix - body.body_inertia, "kg m²");
    add_matrix(table, described.inertia_matrix ? "  J, as given" : "  J = body + added", body.inertia_matrix, "kg m²");
    if (!body.coupled) continue;
    for (int row = 0; row < 3; ++row)
      table.add_row(triple(row == 0 ? "  C, as given (energy V·C Ω), by rows" : "",
                           Vector3d(body.coupling_matrix.row(row)), "kg m"));
  }
  return "\nInertia about each body's own axes\n" + table.text();
}

// Directions of a joint's moments in the parent's frame at zero angle.
std::string control_text(const Joint& joint) {
  if (joint.actuation.cols() == 0) return "none";
  if (joint.free() && joint.actuation.cols() == 3) return "all directions";
  std::vector<std::string> axes;
  for (int k = 0; k < joint.actuation.cols(); ++k) {
    const Vector3d moment = joint.actuation.col(k);
    axes.push_back(vector_text(joint.free() ? moment
                                            : Vector3d(moment[0] * joint.parent_axis +
                                                       moment[1] * (joint.reference_rotation * joint.child_axis))));
  }
  return fmt::format("{}", fmt::join(axes, " "));
}

std::string freedoms_text(const System& system, const Joint& joint) {
  switch (joint.kind) {
    case file::JointKind::hinge:
      return "1: c " + vector_text(joint.child_axis);
    case file::JointKind::universal:
      return fmt::format("2: p {}, c {}", vector_text(joint.parent_axis), vector_text(joint.child_axis));
    default:
      return fmt::format("{}", system.body(joint.child).freedoms);
  }
}

// What the joints table does not say; nothing for ball joints without springs and dampers that are straight at zero.
std::string freedoms_section(const System& system) {
  document::TextTable table("l");
  table.add_row({"", "freedoms", "zero angle (rad)", "spring", "damper"});
  bool plain = true;
  for (const Joint& joint : system.joints()) {
    const Vector3d zero_angle = lie::log(joint.reference_rotation);
    plain = plain && joint.free() && joint.stiffness == 0.0 && joint.damping == 0.0 && zero_angle.isZero(0.0);
    const auto or_none = [](double value) {
      return value == 0.0 ? std::string("none") : document::short_number(value);
    };
    table.add_row({document::printable(joint.name), freedoms_text(system, joint), vector_text(zero_angle),
                   or_none(joint.stiffness), or_none(joint.damping)});
  }
  return plain ? ""
               : "\nFreedoms of the joints, about axes of the parent p or the child c; zero angle: child → parent\n"
                 "Springs (N m/rad) and dampers (N m s/rad) act about each of them\n" +
                     table.text();
}

std::string joints_section(const System& system) {
  if (system.joint_count() == 0) return "\nNo joints: one free body\n";
  document::TextTable table("l");
  table.add_row({"", "kind", "parent", "offset (m)", "child", "offset (m)", "moments"});
  for (const Joint& joint : system.joints()) {
    table.add_row({document::printable(joint.name), std::string(file::word(joint.kind)),
                   document::printable(system.body(joint.parent).name), vector_text(joint.parent_offset),
                   document::printable(system.body(joint.child).name), vector_text(joint.child_offset),
                   control_text(joint)});
  }
  return "\nJoints; offsets run from the mass centre to the joint, each in its body's frame\n" + table.text() +
         freedoms_section(system);
}

std::vector<fluid::PlacedEllipsoid> placed_at_start(const Problem& problem, const System& system) {
  std::vector<Matrix3d> rotation;
  for (const Vector3d& v : problem.start.rotation) rotation.push_back(lie::exp(v));
  const std::vector<Vector3d> centres = system.mass_centres(rotation, problem.start.position);
  std::vector<fluid::PlacedEllipsoid> placed;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    placed.push_back({system.bodies()[i].semi_axes, rotation[i], centres[i]});
  }
  return placed;
}

bool far_apart(const fluid::PlacedEllipsoid& a, const fluid::PlacedEllipsoid& b) {
  return (a.centre - b.centre).norm() > a.semi_axes.maxCoeff() + b.semi_axes.maxCoeff();
}

std::string neighbours_section(const Problem& problem, const System& system) {
  if (system.body_count() < 2) return "";
  const auto placed = placed_at_start(problem, system);
  document::TextTable table("llrrl");
  table.add_row({"", "", "contact function", "gap (m)", ""});
  const auto joined = [&](int a, int b) { return system.body(a).parent == b || system.body(b).parent == a; };
  for (int a = 0; a < system.body_count(); ++a) {
    for (int b = a + 1; b < system.body_count(); ++b) {
      const auto& first = placed[static_cast<std::size_t>(a)];
      const auto& second = placed[static_cast<std::size_t>(b)];
      if (system.move_as_one(a, b) || (!joined(a, b) && far_apart(first, second))) continue;
      const fluid::Gap gap = fluid::gap(
          {first.semi_axes, second.semi_axes, first.rotation, second.rotation, second.centre - first.centre});
      table.add_row({document::printable(system.body(a).name), document::printable(system.body(b).name),
                     document::short_number(fluid::contact(first, second).value), document::short_number(gap.value),
                     gap.value > 0.0 ? "apart" : "OVERLAP"});
    }
  }
  return "\nNeighbours at the start, joined or near: the least distance of their surfaces is the gap; where they\n"
         "overlap, minus the shortest way out (contact function below 1)\n" +
         table.text();
}

std::string move_text(const maneuver::Goal& goal) {
  if (!goal.move[0] && !goal.move[1] && !goal.move[2]) return "root's mass centre may end anywhere";
  std::vector<std::string> parts;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& move = goal.move[k];
    parts.push_back(move ? fmt::format("{} m along {}", document::short_number(*move), model::world_axes[k])
                         : fmt::format("free along {}", model::world_axes[k]));
  }
  return fmt::format("root's mass centre moves {}", fmt::join(parts, ", "));
}

void add_goal(document::TextTable& table, const Problem& problem) {
  if (!problem.goal) {
    table.add_row({"goal", "none"});
    return;
  }
  const maneuver::Goal& goal = *problem.goal;
  const std::string every = goal.periodic ? "the root" : goal.rotation.empty() ? "every body" : "every other body";
  const std::string all_bodies = goal.angle.empty() ? every : every + " not below the joints that follow";
  table.add_row({"goal", move_text(goal)});
  if (!goal.turn) {
    if (!goal.of_joints()) table.add_row({"", "end rotations are free"});
  } else if (goal.turn->norm() == 0.0) {
    table.add_row({"", all_bodies + " ends with its start rotation"});
  } else {
    table.add_row({"", fmt::format("{} turns by {} rad", all_bodies, vector_text(*goal.turn))});
  }
  for (const auto& [name, rotation] : goal.rotation) {
    table.add_row({"", document::printable(name) + (rotation ? fmt::format(" ends at {} rad", vector_text(*rotation))
                                                             : " ends freely turned")});
  }
  for (const std::string& line : joint_end_lines(goal, document::short_number)) table.add_row({"", line});
  if (goal.periodic) table.add_row({"", "a gait: shape and velocity at the end equal those at the start"});
  if (goal.rest)
    table.add_row({"", "ends at rest"});
  else if (goal.joints_rest)
    table.add_row({"", "ends with its joints at rest; the whole drifts on as it must"});
  else if (!goal.periodic)
    table.add_row({"", "velocities at the end are free"});
}

void add_lines(document::TextTable& table, const std::string& name, const std::vector<std::string>& lines) {
  for (std::size_t n = 0; n < lines.size(); ++n) table.add_row({n == 0 ? name : "", lines[n]});
}

std::string time_text(const Problem& problem) {
  const maneuver::Duration& duration = problem.duration;
  if (duration.free) {
    return fmt::format("free between {} and {} s, {} steps", document::short_number(duration.min),
                       document::short_number(duration.max), problem.steps);
  }
  return fmt::format("{} s in {} steps of {} s", document::short_number(duration.value), problem.steps,
                     document::short_number(problem.time_step()));
}

std::string start_text(const Problem& problem) {
  bool moving = problem.start.linear_velocity.norm() > 0.0;
  for (const Vector3d& velocity : problem.start.angular_velocity) moving = moving || velocity.norm() > 0.0;
  const bool gait = problem.goal && problem.goal->periodic && !problem.goal->stills_joints();
  std::string how = moving ? "in motion" : "at rest";
  if (gait && !moving)
    how = problem.start.free_shape ? "shape and velocity are free (first guess of the shape as in the file)"
                                   : "velocity is free";
  return fmt::format("root's mass centre at {} m, {}", vector_text(problem.start.position), how);
}

// Which no joint moment changes; empty where there is none.
std::string momentum_text(const Problem& problem) {
  const System system(problem.swimmer);
  if (!maneuver::has_momentum(system, problem.start)) return "";
  const integrator::State start = maneuver::start_state(system, problem.start);
  const auto total = mechanics::spatial_momentum(system, start.rotation, Eigen::Vector3d::Zero(), start.momentum);
  return fmt::format("total momentum {} kg m/s and, about the root's mass centre, {} kg m²/s, which stays",
                     vector_text(total.linear), vector_text(total.angular));
}

std::string control_kind_text(const Problem& problem) {
  if (problem.control == file::ControlKind::steps) return "one value at each node";
  return fmt::format("natural cubic spline through {} points", problem.points);
}

std::string search_text(const maneuver::Search& search) {
  std::string text = fmt::format("{}, {} start{}, seed {}, tolerance {}", file::word(search.method), search.starts,
                                 search.starts == 1 ? "" : "s", search.seed, document::short_number(search.tolerance));
  if (search.whole_turns > 0) text += fmt::format(", {} by whole turns", std::min(search.whole_turns, search.starts));
  if (search.hops > 0) text += fmt::format(", {} hop{}", search.hops, search.hops == 1 ? "" : "s");
  if (search.time_limit) text += fmt::format(", at most {} s", document::short_number(*search.time_limit));
  return text;
}

std::string task_section(const Problem& problem) {
  document::TextTable table("l");
  table.add_row({"start", start_text(problem)});
  if (const std::string carried = momentum_text(problem); !carried.empty()) table.add_row({"", carried});
  add_goal(table, problem);
  table.add_row({"time", time_text(problem)});
  table.add_row({"scheme", std::string(file::word(problem.scheme))});
  table.add_row(
      {"cost",
       fmt::format("{}, {} rule", cost_words(problem.effort, problem.time_weight, problem.cost_weights),
                   integrator::single_step(problem.scheme) ? file::word(problem.cost_rule()) : "the scheme's own")});
  table.add_row({"control", control_kind_text(problem)});
  const std::vector<std::string> limits = limit_lines(problem.limits, document::short_number);
  add_lines(table, "limits", limits.empty() ? std::vector<std::string>{"none"} : limits);
  add_lines(table, "waypoints", waypoint_lines(problem.waypoints, problem.start.free_shape, document::short_number));
  table.add_row({"search", search_text(problem.search)});
  return "\nTask; e₁, e₂, e₃ are the world's x, y, z\n" + table.text();
}

std::string remarks_section(const std::vector<std::string>& remarks) {
  std::string text;
  for (const std::string& remark : remarks) text += document::wrapped(remark);
  return text.empty() ? "" : "\nWorth a second look\n" + text;
}

fluid::EllipsoidInertia checked_inertia(const VectorXd& semi_axes, double density) {
  fluid::EllipsoidInertia inertia;
  try {
    inertia = semi_axes.size() == 2 ? fluid::ellipse_inertia(semi_axes.head<2>(), density)
                                    : fluid::ellipsoid_inertia(semi_axes.head<3>(), density);
  } catch (const std::invalid_argument& error) {
    throw model::InputError("inertia", error.what());
  }
  if (!inertia.body_inertia.allFinite() || !inertia.added_mass.allFinite() || !inertia.added_inertia.allFinite()) {
    throw model::InputError("inertia", "the numbers overflow; choose smaller lengths or another unit");
  }
  return inertia;
}

}  // namespace

std::string cost_words(double effort, double time_weight, const maneuver::CostWeights& weights) {
  std::string text = fmt::format("{} × ∫ ½ Σ|u|² dt", document::short_number(effort));
  for (const auto& [weight, term] :
       {std::pair(weights.work, "∫ Σ|u·ω| dt"), std::pair(weights.power, "∫ Σ(u·ω)² dt"),
        std::pair(weights.smoothness, "∫ ½ Σ|du/dt|² dt"), std::pair(weights.angular_velocity, "∫ ½ Σ|ω|² dt"),
        std::pair(weights.transport, "∫ Σ|u·ω| dt per distance")})
    if (weight > 0.0) text += fmt::format(" + {} × {}", document::short_number(weight), term);
  if (time_weight > 0.0) text += fmt::format(" + {} × ∫ dt", document::short_number(time_weight));
  for (int c = 0; c < 3; ++c)
    if (const double won = weights.displacement[c]; won != 0.0)
      text += fmt::format(" {} {} × displacement along {}", won > 0.0 ? "−" : "+",
                          document::short_number(std::abs(won)), model::world_axes[static_cast<std::size_t>(c)]);
  return text;
}

std::string model_table(const Problem& problem, const System& system, const std::vector<std::string>& remarks) {
  return heading(problem, system) + bodies_section(problem, system) + inertia_section(problem, system) +
         joints_section(system) + neighbours_section(problem, system) + task_section(problem) +
         remarks_section(remarks);
}

std::string inertia_table(const VectorXd& semi_axes, double density) {
  const fluid::EllipsoidInertia inertia = checked_inertia(semi_axes, density);
  const bool flat = semi_axes.size() == 2;
  document::TextTable table("lrrrl");
  table.add_row({"", "1", "2", "3"});
  if (flat)
    table.add_row({"semi-axes", document::short_number(semi_axes[0]), document::short_number(semi_axes[1]), "", "m"});
  else
    table.add_row(triple("semi-axes", semi_axes.head<3>(), "m"));
  table.add_row(triple("added mass", inertia.added_mass, "kg"));
  table.add_row(triple("total mass", inertia.added_mass + Vector3d::Constant(inertia.mass), "kg"));
  table.add_row(triple("body inertia", inertia.body_inertia, "kg m²"));
  table.add_row(triple("added inertia", inertia.added_inertia, "kg m²"));
  table.add_row(triple("total inertia", inertia.body_inertia + inertia.added_inertia, "kg m²"));
  return fmt::format("Homogeneous, neutrally buoyant {} in fluid of density {} kg/m³\n  volume {} m³, mass {} kg\n{}",
                     flat ? "ellipse, one metre deep," : "ellipsoid", document::short_number(density),
                     document::short_number(inertia.volume), document::short_number(inertia.mass), table.text());
}

std::string inertia_json(const VectorXd& semi_axes, double density) {
  const fluid::EllipsoidInertia inertia = checked_inertia(semi_axes, density);
  const auto list = [](const Vector3d& v) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v[0], v[1], v[2]); };
  const auto diagonal = [&](const Vector3d& v) {
    return fmt::format("[{}, {}, {}]", list({v[0], 0.0, 0.0}), list({0.0, v[1], 0.0}), list({0.0, 0.0, v[2]}));
  };
  return fmt::format(
      "{{\"volume\": {:.17g}, \"mass\": {:.17g}, \"body_inertia\": {}, \"added_mass\": {}, \"added_inertia\": {}, "
      "\"mass_matrix\": {}, \"inertia_matrix\": {}}}\n",
      inertia.volume, inertia.mass, list(inertia.body_inertia), list(inertia.added_mass), list(inertia.added_inertia),
      diagonal(inertia.added_mass + Vector3d::Constant(inertia.mass)),
      diagonal(inertia.body_inertia + inertia.added_inertia));
}

}  // namespace lamprey::task
