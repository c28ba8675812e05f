#include <cmath>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "document/io_error.hpp"
#include "document/json_document.hpp"
#include "document/json_words.hpp"
#include "document/text_file.hpp"
#include "file/words.hpp"
#include "model/input_error.hpp"
#include "result/certificate_reader.hpp"
#include "result/limits_json.hpp"
#include "result/result_shapes.hpp"
#include "result/solution_file.hpp"

namespace lamprey::result {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t solution_byte_limit = std::size_t{1} << 30;
constexpr int largest = std::numeric_limits<int>::max();

void read(const document::JsonReader& reader, double& value) { value = reader.number(); }

void read(const document::JsonReader& reader, Vector3d& value) {
  reader.require_array(3);
  for (std::size_t i = 0; i < 3; ++i) value[static_cast<Eigen::Index>(i)] = reader.at(i).number();
}

void read(const document::JsonReader& reader, Matrix3d& value) {
  reader.require_array(3);
  for (std::size_t i = 0; i < 3; ++i) {
    Vector3d row;
    read(reader.at(i), row);
    value.row(static_cast<Eigen::Index>(i)) = row.transpose();
  }
}

template <class Value>
Value value_at(const document::JsonReader& reader) {
  Value value;
  read(reader, value);
  return value;
}

template <class Value>
void read_nodes(const document::JsonReader& reader, std::size_t nodes, std::vector<Value>& values) {
  reader.require_array(nodes);
  values.resize(nodes);
  for (std::size_t k = 0; k < nodes; ++k) read(reader.at(k), values[k]);
}

template <class Value>
void read_nodes(const document::JsonReader& reader, std::size_t nodes, std::size_t count,
                std::vector<std::vector<Value>>& values) {
  reader.require_array(nodes);
  values.resize(nodes);
  for (std::size_t k = 0; k < nodes; ++k) read_nodes(reader.at(k), count, values[k]);
}

ResolvedBody read_body(const document::JsonReader& reader) {
  reader.allow_only(
      {"name", "mass", "semi_axes", "mass_matrix", "inertia_matrix", "body_inertia", "coupling_matrix", "ellipse"});
  ResolvedBody body;
  body.name = reader.at("name").text();
  body.mass = reader.at("mass").number();
  read(reader.at("semi_axes"), body.semi_axes);
  if (!(body.semi_axes.minCoeff() > 0.0)) reader.at("semi_axes").refuse("three numbers > 0 (m)");
  read(reader.at("mass_matrix"), body.mass_matrix);
  read(reader.at("inertia_matrix"), body.inertia_matrix);
  read(reader.at("body_inertia"), body.body_inertia);
  if (reader.has("coupling_matrix")) read(reader.at("coupling_matrix"), body.coupling_matrix);
  if (reader.has("ellipse")) body.ellipse = reader.at("ellipse").boolean();
  return body;
}

ResolvedJoint read_joint(const document::JsonReader& reader, int bodies) {
  reader.allow_only({"name", "kind", "parent", "child", "parent_offset", "child_offset", "control_axes",
                     "reference_rotation", "axis", "axes", "actuated", "stiffness", "damping"});
  ResolvedJoint joint;
  joint.name = reader.at("name").text();
  joint.kind = document::read_word(reader.at("kind"), file::joint_kinds);
  joint.parent = reader.at("parent").integer(0, bodies - 1);
  joint.child = reader.at("child").integer(0, bodies - 1);
  read(reader.at("parent_offset"), joint.parent_offset);
  read(reader.at("child_offset"), joint.child_offset);
  const document::JsonReader axes = reader.at("control_axes");
  axes.require_array();
  for (std::size_t i = 0; i < axes.size(); ++i) joint.control_axes.push_back(value_at<Vector3d>(axes.at(i)));
  joint.actuated = reader.has("actuated") ? reader.at("actuated").boolean() : !joint.control_axes.empty();
  if (reader.has("reference_rotation")) read(reader.at("reference_rotation"), joint.reference_rotation);
  if (joint.kind == file::JointKind::hinge) joint.axis = value_at<Vector3d>(reader.at("axis"));
  if (joint.kind == file::JointKind::universal) {
    const document::JsonReader own = reader.at("axes");
    own.require_array(2);
    joint.axes = std::array{value_at<Vector3d>(own.at(std::size_t{0})), value_at<Vector3d>(own.at(std::size_t{1}))};
  }
  if (reader.has("stiffness")) joint.stiffness = reader.at("stiffness").number();
  if (reader.has("damping")) joint.damping = reader.at("damping").number();
  return joint;
}

// What joints make of the bodies is a tree, whose root is the first of them.
void require_tree(const document::JsonReader& joints, const ResolvedProblem& problem) {
  joints.require_array(problem.bodies.size() - 1);
  std::vector<std::size_t> above(problem.bodies.size(), problem.joints.size());  // joint, of each body but the root
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    const auto child = static_cast<std::size_t>(problem.joints[j].child);
    if (child == 0 || above[child] != problem.joints.size())
      joints.at(j).at("child").refuse("each body but the first below one joint, and the first below none");
    above[child] = j;
  }
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    auto body = static_cast<std::size_t>(problem.joints[j].parent);
    for (std::size_t passed = 0; body != 0; ++passed) {
      if (passed == problem.joints.size()) joints.at(j).at("parent").refuse("a way up to the first body");
      body = static_cast<std::size_t>(problem.joints[above[body]].parent);
    }
  }
}

// Of weights or parts of the cost, where files that are older than it have another value.
double angular_velocity_in(const document::JsonReader& costs, double untold) {
  return costs.has("angular_velocity") ? costs.at("angular_velocity").number() : untold;
}

maneuver::Goal read_goal(const document::JsonReader& reader) {
  reader.allow_only({"move", "turn", "rotation", "angle", "shape", "rest", "periodic"});
  maneuver::Goal goal;
  goal.move = read_move(reader.at("move"));
  if (!reader.at("turn").is_null()) goal.turn = value_at<Vector3d>(reader.at("turn"));
  const document::JsonReader rotation = reader.at("rotation");
  for (const std::string& name : rotation.keys()) {
    const document::JsonReader own = rotation.at(name.c_str());
    goal.rotation[name] = own.is_text("free") ? std::nullopt : std::optional(value_at<Vector3d>(own));
  }
  if (reader.has("angle"))
    for (const std::string& name : reader.at("angle").keys()) {
      const document::JsonReader own = reader.at("angle").at(name.c_str());
      own.require_array();
      std::vector<double>& angles = goal.angle[name];
      for (std::size_t axis = 0; axis < own.size(); ++axis) angles.push_back(own.at(axis).number());
    }
  if (reader.has("shape")) {
    if (!reader.at("shape").is_text("start")) reader.at("shape").refuse("\"start\"");
    goal.shape_of_start = true;
  }
  goal.joints_rest = reader.at("rest").is_text("joints");
  if (!goal.joints_rest && !reader.at("rest").is_boolean()) reader.at("rest").refuse("true, false or \"joints\"");
  goal.rest = !goal.joints_rest && reader.at("rest").boolean();
  goal.periodic = reader.at("periodic").boolean();
  return goal;
}

Matrix3d rotation_at(const document::JsonReader& reader) {
  constexpr double round_off = 1e-9;
  const auto R = value_at<Matrix3d>(reader);
  if (!((R.transpose() * R - Matrix3d::Identity()).norm() <= round_off && R.determinant() > 0.0))
    reader.refuse("a rotation matrix");
  return R;
}

ResolvedStart read_start(const document::JsonReader& reader, std::size_t bodies) {
  reader.allow_only({"rotation", "position", "linear_velocity", "angular_velocity"});
  ResolvedStart start;
  const document::JsonReader rotation = reader.at("rotation"), rate = reader.at("angular_velocity");
  rotation.require_array(bodies);
  rate.require_array(bodies);
  for (std::size_t i = 0; i < bodies; ++i) {
    start.rotation.push_back(rotation_at(rotation.at(i)));
    start.angular_velocity.push_back(value_at<Vector3d>(rate.at(i)));
  }
  start.position = value_at<Vector3d>(reader.at("position"));
  start.linear_velocity = value_at<Vector3d>(reader.at("linear_velocity"));
  return start;
}

ResolvedProblem read_resolved(const document::JsonReader& reader) {
  reader.allow_only({"bodies",   "joints",    "density",       "scheme",       "time_step",
                     "duration", "steps",     "cost_rule",     "start",        "goal",
                     "control",  "effort",    "time_weight",   "cost_weights", "displacement_weight",
                     "limits",   "waypoints", "free_duration", "free_shape",   "tolerance"});
  ResolvedProblem problem;
  const document::JsonReader bodies = reader.at("bodies");
  bodies.require_array();
  if (bodies.size() == 0) bodies.refuse("at least one body");
  for (std::size_t i = 0; i < bodies.size(); ++i) problem.bodies.push_back(read_body(bodies.at(i)));
  const document::JsonReader joints = reader.at("joints");
  joints.require_array();
  for (std::size_t j = 0; j < joints.size(); ++j)
    problem.joints.push_back(read_joint(joints.at(j), static_cast<int>(problem.bodies.size())));
  require_tree(joints, problem);
  if (reader.has("density")) {
    problem.density = reader.at("density").number();
    if (*problem.density < 0.0) reader.at("density").refuse("a number >= 0 (kg/m³)");
  }
  problem.scheme = document::read_word(reader.at("scheme"), file::schemes);
  problem.time_step = reader.at("time_step").number();
  problem.duration = reader.at("duration").number();
  problem.steps = reader.at("steps").integer(0, largest - 1);  // 0: a march that was interrupted at once
  problem.cost_rule = document::read_word(reader.at("cost_rule"), file::cost_rules);
  if (reader.has("start")) problem.start = read_start(reader.at("start"), problem.bodies.size());
  if (!reader.at("goal").is_null()) problem.goal = read_goal(reader.at("goal"));
  if (reader.has("control")) {
    reader.at("control").allow_only({"kind", "points"});
    problem.control = document::read_word(reader.at("control").at("kind"), file::control_kinds);
    const bool spline = problem.control == maneuver::ControlKind::spline;
    problem.points = reader.at("control").at("points").integer(spline ? 2 : 0, spline ? problem.steps + 1 : largest);
  }
  if (reader.has("effort")) problem.effort = reader.at("effort").number();
  if (reader.has("time_weight")) problem.time_weight = reader.at("time_weight").number();
  if (reader.has("cost_weights")) {
    const document::JsonReader weights = reader.at("cost_weights");
    weights.allow_only({"work", "power", "smoothness", "angular_velocity", "transport"});
    problem.cost_weights = {.work = weights.at("work").number(),
                            .power = weights.at("power").number(),
                            .smoothness = weights.at("smoothness").number(),
                            .angular_velocity = angular_velocity_in(weights, 0.0),
                            .transport = weights.at("transport").number()};
  }
  if (reader.has("displacement_weight"))
    problem.cost_weights.displacement = value_at<Vector3d>(reader.at("displacement_weight"));
  if (reader.has("limits")) problem.limits = read_limits(reader.at("limits"));
  if (reader.has("waypoints")) problem.waypoints = read_waypoints(reader.at("waypoints"));
  if (reader.has("free_duration")) {
    problem.free_duration = true;
    problem.between = {reader.at("free_duration").at("min").number(), reader.at("free_duration").at("max").number()};
  }
  if (reader.has("free_shape")) problem.free_shape = reader.at("free_shape").boolean();
  if (reader.has("tolerance")) problem.tolerance = reader.at("tolerance").number();
  return problem;
}

// [N][s] and [N][s][joints], where the file has them; s is that of the first step.
void read_stages(const document::JsonReader& reader, std::size_t steps, std::size_t joints,
                 maneuver::Solution& solution) {
  if (!reader.has("control_stages") || steps == 0) return;
  const document::JsonReader time = reader.at("stage_time");
  time.require_array(steps);
  time.at(std::size_t{0}).require_array();
  const std::size_t stages = time.at(std::size_t{0}).size();
  read_nodes(time, steps, stages, solution.stage_time);
  const document::JsonReader control = reader.at("control_stages");
  control.require_array(steps);
  solution.control_stages.resize(steps);
  for (std::size_t k = 0; k < steps; ++k) read_nodes(control.at(k), stages, joints, solution.control_stages[k]);
}

// What rows and columns of the gains belong to follows from the problem.
void require_coordinates(const document::JsonReader& reader, const ResolvedProblem& problem) {
  const document::JsonReader controls = reader.at("control_coordinates"), states = reader.at("state_coordinates");
  const std::vector<ControlCoordinate> control = control_coordinates(problem);
  const std::vector<StateCoordinate> state = state_coordinates(problem);
  controls.require_array(control.size());
  states.require_array(state.size());
  for (std::size_t c = 0; c < control.size(); ++c) {
    const document::JsonReader own = controls.at(c);
    if (own.at("joint").text() != control[c].joint || own.at("axis").integer(0, 2) != control[c].axis)
      own.refuse("the joints' axes in their order, here " + std::to_string(control[c].axis) + " of " +
                 control[c].joint);
  }
  for (std::size_t s = 0; s < state.size(); ++s) {
    const document::JsonReader own = states.at(s);
    if (own.at("quantity").text() != state[s].quantity || own.at("of").text() != state[s].of ||
        own.at("axis").integer(0, 2) != state[s].axis || own.at("unit").text() != state[s].unit)
      own.refuse("the states in their order, here " + state[s].quantity + " of " + state[s].of);
  }
}

void read_feedback(const document::JsonReader& reader, const ResolvedProblem& problem, maneuver::Feedback& feedback) {
  const document::JsonReader time = reader.at("time");
  time.require_array();
  const std::size_t nodes = time.size();
  read_nodes(time, nodes, feedback.time);
  for (std::size_t m = 1; m < nodes; ++m)
    if (!(feedback.time[m] > feedback.time[m - 1])) time.at(m).refuse("times that rise (s)");
  require_coordinates(reader, problem);
  const std::size_t controls = control_coordinates(problem).size(), states = state_coordinates(problem).size();
  const document::JsonReader gain = reader.at("gain");
  gain.require_array(nodes);
  for (std::size_t m = 0; m < nodes; ++m) {
    gain.at(m).require_array(controls);
    Eigen::MatrixXd matrix(controls, states);
    for (std::size_t row = 0; row < controls; ++row) {
      gain.at(m).at(row).require_array(states);
      for (std::size_t column = 0; column < states; ++column)
        matrix(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column)) =
            gain.at(m).at(row).at(column).number();
    }
    feedback.gain.push_back(matrix);
  }
}

maneuver::Tracking read_tracking(const document::JsonReader& reader) {
  return {reader.at("maneuver").text(),
          reader.at("rotation_error").number_or_nan(),
          reader.at("position_error").number_or_nan(),
          reader.at("largest_rotation_error").number_or_nan(),
          reader.at("largest_position_error").number_or_nan(),
          reader.at("largest_correction").number_or_nan(),
          reader.has("cut_share") ? reader.at("cut_share").number() : 0.0,
          reader.has("cut_from") ? std::optional(reader.at("cut_from").number()) : std::nullopt,
          reader.has("off_from") ? std::optional(reader.at("off_from").number()) : std::nullopt};
}

void read_momentum(const document::JsonReader& reader, std::size_t nodes, maneuver::MomentumHistory& momentum) {
  read_nodes(reader.at("bodies"), nodes, momentum.bodies);
  read_nodes(reader.at("fluid"), nodes, momentum.fluid);
  read_nodes(reader.at("total"), nodes, momentum.total);
}

void read_motion(const document::JsonReader& reader, const ResolvedProblem& problem, maneuver::Solution& solution) {
  const document::JsonReader time = reader.at("time");
  const std::size_t nodes = static_cast<std::size_t>(problem.steps) + 1;
  time.require_array(nodes);
  read_nodes(time, nodes, solution.time);
  read_nodes(reader.at("position"), nodes, solution.position);
  read_nodes(reader.at("rotation"), nodes, problem.bodies.size(), solution.rotation);
  read_nodes(reader.at("control"), nodes, problem.joints.size(), solution.control);
  if (reader.has("joint_angle"))
    read_nodes(reader.at("joint_angle"), nodes, problem.joints.size(), solution.joint_angle);
  read_stages(reader, nodes - 1, problem.joints.size(), solution);
  const document::JsonReader velocity = reader.at("velocity");
  read_nodes(velocity.at("linear"), nodes, solution.linear_velocity);
  read_nodes(velocity.at("angular"), nodes, problem.bodies.size(), solution.angular_velocity);
  read_momentum(reader.at("momentum").at("linear"), nodes, solution.linear_momentum);
  read_momentum(reader.at("momentum").at("angular"), nodes, solution.angular_momentum);
}

maneuver::SearchRecord read_search(const document::JsonReader& reader) {
  maneuver::SearchRecord search;
  search.starts = reader.at("starts").integer(0, largest);
  if (reader.has("strokes")) search.strokes = reader.at("strokes").integer(0, largest);
  if (reader.has("hops")) search.hops = reader.at("hops").integer(0, largest);
  search.solved = reader.at("solved").integer(0, largest);
  const document::JsonReader minima = reader.at("minima");
  minima.require_array();
  for (std::size_t i = 0; i < minima.size(); ++i) {
    const document::JsonReader minimum = minima.at(i);
    search.minima.push_back({minimum.at("cost").number_or_nan(), minimum.at("count").integer(0, largest)});
    maneuver::Minimum& read = search.minima.back();
    if (minimum.has("by_ipopt")) read.by_ipopt = minimum.at("by_ipopt").integer(0, read.count);
  }
  if (reader.has("set_aside")) {
    const document::JsonReader aside = reader.at("set_aside");
    search.set_aside = {aside.at("cost").number(), {}};
    if (!aside.at("steps").is_null()) search.set_aside->steps = aside.at("steps").integer(1, largest);
  }
  long long counted = 0;
  for (const maneuver::Minimum& minimum : search.minima) counted += minimum.count;
  if (counted != search.solved) minima.refuse("minima whose counts add up to solved");
  if (search.solved > static_cast<long long>(search.starts) + search.hops)
    reader.at("solved").refuse("no more than starts and hops");
  return search;
}

maneuver::MultiplierWeight read_weight(const document::JsonReader& reader, const char* key) {
  if (!reader.has(key)) return {};
  const document::JsonReader weight = reader.at(key);
  const maneuver::MultiplierWeight read{weight.at("value").number(), weight.at("largest").number()};
  if (!(read.value > 0.0)) weight.at("value").refuse("positive numbers");
  if (!(read.largest >= read.value)) weight.at("largest").refuse("numbers not below value");
  return read;
}

maneuver::SolverRecord read_solver(const document::JsonReader& reader) {
  maneuver::SolverRecord solver;
  solver.name = reader.at("name").text();
  solver.iterations = reader.at("iterations").integer(0, largest);
  solver.evaluations = reader.at("evaluations").integer(0, largest);
  solver.wall_seconds = reader.at("wall_seconds").number_or_nan();
  if (reader.has("processor_seconds")) solver.processor_seconds = reader.at("processor_seconds").number_or_nan();
  if (reader.has("total_wall_seconds")) solver.total_wall_seconds = reader.at("total_wall_seconds").number_or_nan();
  const document::JsonReader history = reader.at("history");
  history.require_array();
  for (std::size_t i = 0; i < history.size(); ++i) {
    const document::JsonReader entry = history.at(i);
    solver.history.push_back({entry.at("iteration").integer(0, largest), entry.at("cost").number_or_nan(),
                              entry.at("goal_error").number_or_nan(), entry.at("kkt").number_or_nan(),
                              entry.at("step").number_or_nan(),
                              entry.has("momentum") ? entry.at("momentum").number_or_nan() : std::nan("")});
  }
  solver.limit_weight = read_weight(reader, "limit_weight");
  solver.work_weight = read_weight(reader, "work_weight");
  return solver;
}

maneuver::DividedSteps read_divided(const document::JsonReader& reader) {
  return {reader.at("steps").integer(0, largest), reader.at("substeps").integer(0, largest),
          reader.at("smallest_step").number()};
}

Provenance read_provenance(const document::JsonReader& reader) {
  Provenance provenance;
  provenance.version = reader.at("version").text();
  provenance.build_type = reader.at("build_type").text();
  provenance.compiler = reader.at("compiler").text();
  provenance.machine = reader.at("machine").text();
  provenance.command = reader.at("command").text();
  provenance.problem_sha256 = reader.at("problem_sha256").text();
  provenance.seed = reader.at("seed").unsigned_integer();
  return provenance;
}

maneuver::Failure read_failure(const document::JsonReader& reader) {
  maneuver::Failure failure{reader.at("missed").text(), reader.at("cause").text(), {}};
  const document::JsonReader remedies = reader.at("remedies");
  remedies.require_array();
  for (std::size_t n = 0; n < remedies.size(); ++n) failure.remedies.push_back(remedies.at(n).text());
  return failure;
}

std::string path_within(const std::string& folder) {
  return (std::filesystem::path(folder) / "solution.json").string();
}

}  // namespace

Results parse_solution(const std::string& bytes, const std::string& path) {
  const document::JsonDocument document(bytes, path);
  const document::JsonReader reader = document.root();
  Results results;
  reader.at("schema").integer(1, 1);
  results.name = reader.at("name").text();
  if (reader.has("source")) results.source = reader.at("source").text();
  results.solution.status = document::read_word(reader.at("status"), file::statuses);
  results.solution.message = reader.at("message").text();
  if (reader.has("failure")) results.failure = read_failure(reader.at("failure"));
  results.solution.cost = reader.at("cost").number_or_nan();
  results.problem = read_resolved(reader.at("problem"));
  read_motion(reader, results.problem, results.solution);
  if (reader.has("cost_parts")) {
    const document::JsonReader parts = reader.at("cost_parts");
    results.solution.cost_parts = {.effort = parts.at("effort").number(),
                                   .work = parts.at("work").number(),
                                   .power = parts.at("power").number(),
                                   .smoothness = parts.at("smoothness").number(),
                                   .angular_velocity = angular_velocity_in(parts, std::nan("")),
                                   .time = parts.at("time").number(),
                                   .transport = parts.at("transport").number_or_nan()};
  }
  const auto read_multipliers = [&](const char* field, std::vector<std::vector<double>>& values) {
    if (!reader.has(field)) return;
    const document::JsonReader stored = reader.at(field);
    std::size_t drives = 0;
    for (const ResolvedJoint& joint : results.problem.joints) drives += static_cast<std::size_t>(drive_count(joint));
    stored.require_array(drives);
    values.resize(drives);
    for (std::size_t d = 0; d < drives; ++d) read_nodes(stored.at(d), results.solution.time.size(), values[d]);
  };
  read_multipliers("work_multipliers", results.solution.work_multipliers);
  read_multipliers("work_change_multipliers", results.solution.work_change_multipliers);
  if (reader.has("limit_multipliers"))
    results.solution.limit_multipliers =
        read_limit_multipliers(reader.at("limit_multipliers"), results.solution.time.size());
  if (reader.has("feedback")) read_feedback(reader.at("feedback"), results.problem, results.solution.feedback);
  if (reader.has("marched_by")) results.solution.marched_by = reader.at("marched_by").text();
  if (reader.has("tracking")) results.solution.tracking = read_tracking(reader.at("tracking"));
  if (!reader.at("certificate").is_null()) {
    results.certificate = read_certificate(reader.at("certificate"), static_cast<int>(results.problem.bodies.size()));
  }
  if (!reader.at("search").is_null()) results.solution.search = read_search(reader.at("search"));
  if (!reader.at("solver").is_null()) results.solution.solver = read_solver(reader.at("solver"));
  if (reader.has("divided_steps")) results.solution.divided = read_divided(reader.at("divided_steps"));
  results.provenance = read_provenance(reader.at("provenance"));
  results.alone = true;
  return results;
}

Results read_solution(const std::string& folder) {
  const std::string path = path_within(folder);
  return parse_solution(document::read_bytes(path, solution_byte_limit), path);
}

std::optional<Provenance> stored_provenance(const std::string& folder) {
  const std::string path = path_within(folder);
  try {
    const document::JsonDocument document(document::read_bytes(path, solution_byte_limit), path);
    return read_provenance(document.root().at("provenance"));
  } catch (const model::InputError&) {
    return std::nullopt;
  } catch (const document::IoError&) {
    return std::nullopt;
  }
}

}  // namespace lamprey::result
