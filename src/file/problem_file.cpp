#include "file/problem_file.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "document/text_file.hpp"
#include "file/joint_numbers.hpp"
#include "file/plane_checks.hpp"
#include "file/problem_checks.hpp"
#include "file/problem_limits.hpp"
#include "file/problem_start.hpp"
#include "file/toml_reader.hpp"
#include "file/words.hpp"
#include "fluid/ellipse.hpp"
#include "lie/so3.hpp"

namespace lamprey::file {

namespace {

using Eigen::Vector3d;
using maneuver::Problem;

constexpr std::size_t problem_byte_limit = std::size_t{16} << 20;
constexpr std::size_t body_limit = 1000;

const std::vector<std::string> sections = {"schema",  "name",       "source", "fluid",    "body",
                                           "joint",   "start",      "goal",   "time",     "cost",
                                           "control", "integrator", "limits", "waypoint", "search"};

std::string name_of(const TableReader& table) {
  table.require("name", "a text, unique in the file");
  const std::string name = *table.text("name");
  const bool printable =
      std::all_of(name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) >= 0x20U && c != 0x7F; });
  if (name.empty() || !printable)
    refuse(table.key("name"), document::in_quotes(name), "a text that is not empty, without control characters",
           "name it");
  return name;
}

Vector3d required_vector(const TableReader& table, std::string_view name, const Range& range,
                         const std::string& meaning) {
  table.require(name, "three numbers" + range.in_words() + ": " + meaning);
  return *table.vector(name, range);
}

void read_head(const TableReader& document, const std::string& path, Problem& problem) {
  document.require("schema", "schema = 1, the version of this format");
  document.integer("schema", 1, 1);
  document.allow_only(sections);
  problem.name = document.text("name").value_or(std::filesystem::path(path).stem().string());
  problem.source = document.text("source").value_or("");
}

// Three of an ellipsoid, or the two of an ellipse in its plane.
void read_semi_axes(const TableReader& table, model::BodyDescription& body) {
  constexpr const char* name = "semi_axes";
  const document::TomlValue* value = table.find(name);
  const std::size_t numbers = value && value->kind == document::TomlValue::Kind::array ? value->items.size() : 3;
  if (numbers < 2 || numbers > 3)
    refuse(table.key(name), shown(*value), "three numbers > 0 (m), or two of an ellipse in the plane",
           "write three of them in brackets, as in [1.0, 2.0, 3.0]");
  body.ellipse = numbers == 2;
  if (!body.ellipse) {
    body.semi_axes = required_vector(table, name, positive("m"), "half lengths of the ellipsoid");
    return;
  }
  for (Eigen::Index c = 0; c < 2; ++c)
    body.semi_axes[c] = table.number_in(value->items[static_cast<std::size_t>(c)], name, positive("m"), *value,
                                        "two numbers > 0 (m): half lengths of an ellipse in the plane");
  body.semi_axes[2] = fluid::drawn_depth(body.semi_axes.head<2>());
}

model::BodyDescription read_body(const TableReader& table) {
  table.allow_only({"name", "semi_axes", "mass", "body_inertia", "mass_matrix", "inertia_matrix", "coupling_matrix"});
  model::BodyDescription body;
  body.name = name_of(table);
  read_semi_axes(table, body);
  body.mass = table.number("mass", positive("kg"));
  body.body_inertia = table.matrix("body_inertia", "kg m²");
  body.mass_matrix = table.matrix("mass_matrix", "kg");
  body.inertia_matrix = table.matrix("inertia_matrix", "kg m²");
  body.coupling_matrix = table.matrix("coupling_matrix", "kg m");
  return body;
}

// Keys that only some kinds of joint have, so that a misplaced one is not silently without effect.
void refuse_keys_of_other_kinds(const TableReader& table, JointKind kind) {
  const auto belongs = [&](std::string_view name, bool allowed, const std::string& kinds) {
    if (table.find(name) && !allowed)
      refuse(table.key(name), fmt::format("this key on a {} joint", word(kind)), kinds,
             "remove it or change the joint's kind");
  };
  belongs("axis", kind == JointKind::hinge, "on a hinge only");
  belongs("axes", kind == JointKind::universal, "on a universal joint only");
  for (const char* name : {"control_axes", "stiffness", "damping"})
    belongs(name, kind != JointKind::fixed, "on ball, universal and hinge joints");
}

std::optional<std::array<Vector3d, 2>> read_axes(const TableReader& table) {
  const std::optional<std::vector<Vector3d>> axes = table.vectors("axes", any_number(""), "give two");
  if (!axes) return std::nullopt;
  if (axes->size() != 2)
    refuse(table.key("axes"), shown(*table.find("axes")), "two vectors: parent's frame, child's frame", "give two");
  return std::array<Vector3d, 2>{(*axes)[0], (*axes)[1]};
}

model::JointDescription read_joint(const TableReader& table) {
  table.allow_only({"kind", "name", "parent", "child", "parent_offset", "child_offset", "reference_rotation", "axis",
                    "axes", "actuated", "control_axes", "stiffness", "damping"});
  model::JointDescription joint;
  joint.kind = table.word("kind", joint_kinds).value_or(JointKind::ball);
  refuse_keys_of_other_kinds(table, joint.kind);
  for (const char* end : {"parent", "child"}) table.require(end, "the name of a body");
  joint.parent = *table.text("parent");
  joint.child = *table.text("child");
  joint.name = table.find("name") ? name_of(table) : joint.child;
  joint.parent_offset = required_vector(table, "parent_offset", any_number("m"), "mass centre → joint, parent's frame");
  joint.child_offset = required_vector(table, "child_offset", any_number("m"), "mass centre → joint, child's frame");
  joint.reference_rotation = table.vector("reference_rotation", turn()).value_or(Vector3d::Zero());
  joint.axis = table.vector("axis", any_number(""));
  joint.axes = read_axes(table);
  joint.actuated = table.boolean("actuated").value_or(true);
  joint.control_axes = table.vectors("control_axes", any_number(""), "a joint without motors has actuated = false");
  joint.stiffness = table.number("stiffness", not_negative("N m/rad")).value_or(0.0);
  joint.damping = table.number("damping", not_negative("N m s/rad")).value_or(0.0);
  return joint;
}

void read_swimmer(const TableReader& document, model::SwimmerDescription& swimmer) {
  const TableReader fluid = document.table("fluid");
  fluid.allow_only({"density"});
  fluid.require("density", "a number ≥ 0 (kg/m³), 0 for a vacuum");
  swimmer.density = *fluid.number("density", not_negative("kg/m³"));
  document.require("body", "from 1 to 1000 tables [[body]]");
  const std::vector<TableReader> bodies = document.tables("body");
  if (bodies.empty() || bodies.size() > body_limit)
    refuse("body", fmt::format("{} bodies", bodies.size()), fmt::format("from 1 to {}", body_limit),
           "change the number of [[body]] tables");
  for (const TableReader& body : bodies) swimmer.bodies.push_back(read_body(body));
  for (const TableReader& joint : document.tables("joint")) swimmer.joints.push_back(read_joint(joint));
}

std::vector<std::string> body_names(const Problem& problem) {
  std::vector<std::string> names;
  for (const model::BodyDescription& body : problem.swimmer.bodies) names.push_back(body.name);
  return names;
}

void read_rest(const TableReader& table, maneuver::Goal& goal) {
  const document::TomlValue* rest = table.find("rest");
  if (rest && rest->kind != document::TomlValue::Kind::boolean &&
      !(rest->kind == document::TomlValue::Kind::string && rest->text == "joints"))
    refuse(table.key("rest"), shown(*rest), "true, false or \"joints\"",
           "write true or false without quotes, or \"joints\" for joints that end still on a whole that drifts on");
  goal.joints_rest = rest && rest->kind == document::TomlValue::Kind::string;
  goal.rest = !goal.joints_rest && table.boolean("rest").value_or(!goal.periodic);
}

void read_goal(const TableReader& table, Problem& problem) {
  if (!table.present()) return;
  table.allow_only({"move", "turn", "rotation", "angle", "shape", "rest", "periodic"});
  maneuver::Goal goal;
  goal.move = read_move(table);
  goal.turn = read_turn(table);
  const TableReader rotation = table.table("rotation");
  rotation.allow_only(body_names(problem));
  for (const document::TomlValue& member : rotation.members()) {
    if (member.kind == document::TomlValue::Kind::string && !says_free(member))
      refuse(rotation.key(member.key), shown(member), "three numbers (rad) or \"free\"",
             "write a rotation vector or \"free\"");
    goal.rotation[member.key] = says_free(member) ? std::nullopt : rotation.vector(member.key, turn());
  }
  const TableReader angle = table_of_joints(table, "angle", problem.swimmer);
  for (const model::JointDescription& joint : problem.swimmer.joints) {
    const auto angles = read_angles(angle, joint);
    if (!angles) continue;
    refuse_both(angle, rotation, joint);
    goal.angle[joint.name] = *angles;
  }
  goal.shape_of_start = table.choice("shape", {"start", "free"}) == std::size_t{0};
  goal.periodic = table.boolean("periodic").value_or(false);
  read_rest(table, goal);
  problem.goal = goal;
}

void read_free_duration(const TableReader& table, maneuver::Duration& duration) {
  for (const char* bound : {"min", "max"}) table.require(bound, "a number > 0 (s), with duration = \"free\"");
  duration.free = true;
  duration.min = *table.number("min", positive("s"));
  duration.max = *table.number("max", positive("s"));
  if (duration.min > duration.max)
    refuse(table.key("min"), fmt::format("{} above max = {}", duration.min, duration.max), "min ≤ max (s)",
           "exchange them");
  duration.value = duration.min + 0.5 * (duration.max - duration.min);
}

void read_time(const TableReader& table, Problem& problem) {
  table.allow_only({"duration", "min", "max", "steps"});
  table.require("duration", "a number > 0 (s) or \"free\"");
  table.require("steps", fmt::format("a whole number from 1 to {}", step_limit));
  const document::TomlValue& duration = *table.find("duration");
  if (says_free(duration)) {
    read_free_duration(table, problem.duration);
  } else {
    if (duration.kind == document::TomlValue::Kind::string)
      refuse(table.key("duration"), shown(duration), "a number > 0 (s) or \"free\"",
             "write seconds without quotes, or \"free\"");
    problem.duration.value = *table.number("duration", positive("s"));
    for (const char* bound : {"min", "max"})
      if (const document::TomlValue* value = table.find(bound))
        refuse(table.key(bound), shown(*value), "only with duration = \"free\"", "remove it or free the duration");
  }
  problem.steps = static_cast<int>(*table.integer("steps", 1, step_limit));
}

void read_transcription(const TableReader& document, Problem& problem) {
  const TableReader cost = document.table("cost");
  cost.allow_only(
      {"effort", "time", "work", "power", "smoothness", "angular_velocity", "transport", "displacement", "rule"});
  problem.effort = cost.number("effort", positive("weight, however small")).value_or(1.0);
  maneuver::CostWeights& weights = problem.cost_weights;
  weights.work = cost.number("work", not_negative("(N m)² s/J")).value_or(0.0);
  weights.power = cost.number("power", not_negative("(N m)²/W²")).value_or(0.0);
  weights.smoothness = cost.number("smoothness", not_negative("s²")).value_or(0.0);
  weights.angular_velocity = cost.number("angular_velocity", not_negative("(N m)² s²/rad²")).value_or(0.0);
  weights.transport = cost.number("transport", not_negative("(N m)² s m/J")).value_or(0.0);
  weights.displacement = cost.vector("displacement", any_number("(N m)² s/m")).value_or(Eigen::Vector3d::Zero());
  problem.time_weight = cost.number("time", not_negative("(N m)²")).value_or(0.0);
  problem.rule = cost.word("rule", cost_rules);
  const TableReader control = document.table("control");
  control.allow_only({"kind", "points"});
  problem.control = control.word("kind", control_kinds).value_or(ControlKind::steps);
  problem.points = static_cast<int>(control.integer("points", 2, step_limit + 1).value_or(0));
  const TableReader integrator = document.table("integrator");
  integrator.allow_only({"scheme"});
  problem.scheme = integrator.word("scheme", schemes).value_or(Scheme::trapezoid);
}

void read_search(const TableReader& table, Problem& problem) {
  table.allow_only({"starts", "whole_turns", "hops", "keep", "seed", "method", "tolerance", "time_limit"});
  maneuver::Search& search = problem.search;
  search.starts = static_cast<int>(table.integer("starts", 1, 1'000'000).value_or(search.starts));
  search.whole_turns = static_cast<int>(table.integer("whole_turns", 0, 1'000'000).value_or(0));
  search.hops = static_cast<int>(table.integer("hops", 0, 1'000'000).value_or(0));
  search.keep = static_cast<int>(table.integer("keep", 1, 1000).value_or(search.keep));
  constexpr std::int64_t largest_seed = std::numeric_limits<std::int64_t>::max();
  search.seed = static_cast<std::uint64_t>(table.integer("seed", 0, largest_seed).value_or(1));
  search.method = table.word("method", search_methods).value_or(SearchMethod::simultaneous);
  const Range tolerances{.low = 1e-15, .high = loosest_tolerance, .low_included = true, .unit = "on certificate.kkt"};
  search.tolerance = table.number("tolerance", tolerances).value_or(search.tolerance);
  search.time_limit = table.number("time_limit", positive("s"));
}

Problem read_document(const TableReader& document, const std::string& path) {
  Problem problem;
  read_head(document, path, problem);
  read_swimmer(document, problem.swimmer);
  check_tree(problem.swimmer);
  check_bodies(problem.swimmer);
  check_joints(problem.swimmer);
  read_start(document.table("start"), problem);
  read_goal(document.table("goal"), problem);
  read_time(document.table("time"), problem);
  read_transcription(document, problem);
  read_limits(document.table("limits"), problem);
  read_waypoints(document, problem);
  read_search(document.table("search"), problem);
  require_plane(problem);
  check_statement(problem);
  balance_start(document.table("start"), problem);
  return problem;
}

}  // namespace

ProblemFile parse_problem(const std::string& bytes, const std::string& path) {
  if (bytes.size() > problem_byte_limit)
    throw model::InputError(path, 1, 1, "file",
                            fmt::format("found {} bytes; allowed: at most 16 MiB; shorten the file", bytes.size()));
  ProblemFile file;
  file.path = path;
  file.sha256 = document::sha256(bytes);
  const document::TomlValue document = document::parse_toml(bytes, path);
  file.positions = document::key_positions(document);
  try {
    file.problem = read_document(TableReader(&document, ""), path);
  } catch (const model::InputError& error) {
    throw located(error, file);
  }
  return file;
}

ProblemFile read_problem_file(const std::string& path) {
  return parse_problem(document::read_bytes(path, problem_byte_limit), path);
}

maneuver::Problem read_problem(const std::string& path) { return read_problem_file(path).problem; }

model::InputError located(const model::InputError& error, const ProblemFile& file) {
  if (error.line > 0) return error;
  std::string key = error.key;
  auto place = file.positions.find(key);
  while (place == file.positions.end() && !key.empty()) {
    const std::size_t cut = key.find_last_of(".[");
    key.resize(cut == std::string::npos ? 0 : cut);
    place = file.positions.find(key);
  }
  const document::Position position = place == file.positions.end() ? document::Position{} : place->second;
  return {file.path, position.line, position.column, error.key, error.message};
}

}  // namespace lamprey::file
