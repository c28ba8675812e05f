#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "file/json_text.hpp"
#include "file/limits_json.hpp"
#include "file/result_shapes.hpp"
#include "file/solution_file.hpp"
#include "file/words.hpp"

namespace lamprey::file {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

template <class Values, class Writer>
std::string json_list(const Values& values, const Writer& writer) {
  std::string text = "[";
  for (const auto& value : values) {
    if (text.size() > 1) text += ", ";
    text += writer(value);
  }
  return text + "]";
}

// Members of one object in the order given, each on its own line.
class ObjectText {
 public:
  explicit ObjectText(int depth) : indent_(static_cast<std::size_t>(2 * (depth + 1)), ' ') {}
  void add(std::string_view name, const std::string& value) {
    text_ += fmt::format("{}\n{}\"{}\": {}", text_.empty() ? "{" : ",", indent_, name, value);
  }
  std::string finished() const { return text_ + "\n" + indent_.substr(2) + "}"; }

 private:
  std::string indent_;
  std::string text_;
};

// Entries of one node in nested brackets, the node on one line.
void append_entries(const ShapedArray& array, std::size_t axis, std::size_t& at, fmt::memory_buffer& out) {
  if (axis == array.shape.size()) {
    out.append(std::string_view(json_number(array.values[at++])));
    return;
  }
  out.push_back('[');
  for (std::size_t i = 0; i < array.shape[axis]; ++i) {
    if (i > 0) out.append(std::string_view(", "));
    append_entries(array, axis + 1, at, out);
  }
  out.push_back(']');
}

std::string array_text(const ShapedArray& array, int depth) {
  const std::string indent(static_cast<std::size_t>(2 * (depth + 1)), ' ');
  fmt::memory_buffer out;
  out.push_back('[');
  std::size_t at = 0;
  for (std::size_t node = 0; node < array.shape[0]; ++node) {
    fmt::format_to(std::back_inserter(out), "{}\n{}", node == 0 ? "" : ",", indent);
    append_entries(array, 1, at, out);
  }
  if (array.shape[0] > 0) fmt::format_to(std::back_inserter(out), "\n{}", indent.substr(2));
  out.push_back(']');
  return fmt::to_string(out);
}

std::string body_text(const ResolvedBody& body) {
  require_finite(body.semi_axes.allFinite() && body.mass_matrix.allFinite() && body.inertia_matrix.allFinite() &&
                     body.coupling_matrix.allFinite() && std::isfinite(body.mass) && body.body_inertia.allFinite(),
                 "problem.bodies");
  ObjectText text(3);
  text.add("name", json(body.name));
  text.add("semi_axes", json(body.semi_axes));
  text.add("mass_matrix", json(body.mass_matrix));
  text.add("inertia_matrix", json(body.inertia_matrix));
  text.add("mass", json(body.mass));
  text.add("body_inertia", json(body.body_inertia));
  text.add("coupling_matrix", json(body.coupling_matrix));
  if (body.ellipse) text.add("ellipse", json(true));
  return text.finished();
}

std::string joint_text(const ResolvedJoint& joint) {
  require_finite(joint.parent_offset.allFinite() && joint.child_offset.allFinite(), "problem.joints");
  for (const Vector3d& axis : joint.control_axes) require_finite(axis.allFinite(), "problem.joints.control_axes");
  require_finite(joint.reference_rotation.allFinite() && (!joint.axis || joint.axis->allFinite()) &&
                     (!joint.axes || ((*joint.axes)[0].allFinite() && (*joint.axes)[1].allFinite())) &&
                     std::isfinite(joint.stiffness) && std::isfinite(joint.damping),
                 "problem.joints");
  const auto vector = [](const Vector3d& v) { return json(v); };
  ObjectText text(3);
  text.add("name", json(joint.name));
  text.add("kind", json(word(joint.kind)));
  text.add("parent", json(joint.parent));
  text.add("child", json(joint.child));
  text.add("parent_offset", json(joint.parent_offset));
  text.add("child_offset", json(joint.child_offset));
  text.add("control_axes", json_list(joint.control_axes, vector));
  text.add("reference_rotation", json(joint.reference_rotation));
  if (joint.axis) text.add("axis", json(*joint.axis));
  if (joint.axes) text.add("axes", json_list(*joint.axes, vector));
  text.add("actuated", json(joint.actuated));
  text.add("stiffness", json(joint.stiffness));
  text.add("damping", json(joint.damping));
  return text.finished();
}

std::string goal_text(const maneuver::Goal& goal) {
  const auto free_or = [](const auto& value) { return value ? json(*value) : std::string("\"free\""); };
  for (const auto& entry : goal.move) require_finite(!entry || std::isfinite(*entry), "problem.goal.move");
  require_finite(!goal.turn || goal.turn->allFinite(), "problem.goal.turn");
  std::string rotation;
  for (const auto& [name, value] : goal.rotation) {
    require_finite(!value || value->allFinite(), "problem.goal.rotation");
    rotation += fmt::format("{}{}: {}", rotation.empty() ? "" : ", ", json(name), free_or(value));
  }
  std::string angle;
  for (const auto& [name, values] : goal.angle) {
    for (double value : values) require_finite(std::isfinite(value), "problem.goal.angle");
    angle += fmt::format("{}{}: {}", angle.empty() ? "" : ", ", json(name),
                         json_list(values, [](double value) { return json(value); }));
  }
  ObjectText text(2);
  text.add("move", move_text(goal.move));
  text.add("turn", goal.turn ? json(*goal.turn) : "null");
  text.add("rotation", "{" + rotation + "}");
  if (!goal.angle.empty()) text.add("angle", "{" + angle + "}");
  if (goal.shape_of_start) text.add("shape", json(std::string("start")));
  text.add("rest", goal.joints_rest ? json(std::string("joints")) : json(goal.rest));
  text.add("periodic", json(goal.periodic));
  return text.finished();
}

std::string start_text(const ResolvedStart& start) {
  require_finite(start.position.allFinite() && start.linear_velocity.allFinite(), "problem.start");
  for (const Matrix3d& rotation : start.rotation) require_finite(rotation.allFinite(), "problem.start.rotation");
  for (const Vector3d& rate : start.angular_velocity)
    require_finite(rate.allFinite(), "problem.start.angular_velocity");
  ObjectText text(2);
  text.add("rotation", json_list(start.rotation, [](const Matrix3d& m) { return json(m); }));
  text.add("position", json(start.position));
  text.add("linear_velocity", json(start.linear_velocity));
  text.add("angular_velocity", json_list(start.angular_velocity, [](const Vector3d& v) { return json(v); }));
  return text.finished();
}

}  // namespace

std::string problem_text(const ResolvedProblem& problem) {
  require_finite(std::isfinite(problem.time_step) && std::isfinite(problem.duration),
                 "problem.time_step, problem.duration");
  ObjectText text(1);
  text.add("bodies", json_list(problem.bodies, body_text));
  text.add("joints", json_list(problem.joints, joint_text));
  if (problem.density) text.add("density", json(*problem.density));
  text.add("scheme", json(word(problem.scheme)));
  text.add("time_step", json(problem.time_step));
  text.add("duration", json(problem.duration));
  text.add("steps", json(problem.steps));
  text.add("cost_rule", json(word(problem.cost_rule)));
  if (problem.start) text.add("start", start_text(*problem.start));
  text.add("goal", problem.goal ? goal_text(*problem.goal) : "null");
  text.add("control", fmt::format("{{\"kind\": {}, \"points\": {}}}", json(word(problem.control)), problem.points));
  text.add("effort", json(problem.effort));
  if (problem.time_weight != 0.0) text.add("time_weight", json(problem.time_weight));
  const maneuver::CostWeights& weights = problem.cost_weights;
  if (weights.of_displacement()) text.add("displacement_weight", json(weights.displacement));
  if (weights.any())
    text.add(
        "cost_weights",
        fmt::format("{{\"work\": {}, \"power\": {}, \"smoothness\": {}, \"angular_velocity\": {}, \"transport\": {}}}",
                    json(weights.work), json(weights.power), json(weights.smoothness), json(weights.angular_velocity),
                    json(weights.transport)));
  if (problem.limits.any()) text.add("limits", limits_text(problem.limits));
  if (!problem.waypoints.empty()) text.add("waypoints", waypoints_text(problem.waypoints));
  if (problem.free_duration)
    text.add("free_duration",
             fmt::format("{{\"min\": {}, \"max\": {}}}", json(problem.between[0]), json(problem.between[1])));
  if (problem.free_shape) text.add("free_shape", json(true));
  text.add("tolerance", json(problem.tolerance));
  return text.finished();
}

namespace {

std::string curvature_text(const certificate::SecondOrder& second) {
  return fmt::format("\"smallest_eigenvalue\": {}, \"positive\": {}, \"negative_eigenvalues\": {}",
                     json(second.smallest_eigenvalue), json(second.positive),
                     second.negative_eigenvalues ? json(*second.negative_eigenvalues) : "null");
}

std::string clearance_text(const certificate::Clearance& clearance) {
  return fmt::format("{{\"gap\": {}, \"time\": {}, \"bodies\": [{}, {}]}}", json(clearance.gap), json(clearance.time),
                     clearance.first, clearance.second);
}

std::string limit_check_text(const certificate::LimitsKept& limits) {
  return fmt::format("{{\"violation\": {}, \"key\": {}, \"time\": {}, \"complementarity\": {}, \"negative\": {}}}",
                     json(limits.violation), json(limits.key), json(limits.time), json(limits.complementarity),
                     json(limits.negative));
}

std::string replay_text(const certificate::Replay& replay) {
  ObjectText text(2);
  text.add("scheme", json(replay.scheme));
  text.add("window", json(replay.window));
  text.add("rotation_error", json(replay.rotation_error));
  text.add("position_error", json(replay.position_error));
  text.add("whole_rotation_error", json(replay.whole_rotation_error));
  text.add("whole_position_error", json(replay.whole_position_error));
  text.add("growth_rate", json(replay.growth_rate));
  if (!std::isnan(replay.work)) text.add("work", json(replay.work));
  text.add("feedback_rotation_error", json(replay.feedback_rotation_error));
  text.add("feedback_position_error", json(replay.feedback_position_error));
  text.add("servo_rotation_error", json(replay.servo_rotation_error));
  text.add("servo_position_error", json(replay.servo_position_error));
  return text.finished();
}

std::string refinement_text(const certificate::Refinement& refinement) {
  const auto grid = [](const certificate::GridCost& g) {
    return fmt::format("{{\"steps\": {}, \"cost\": {}}}", g.steps, json(g.cost));
  };
  return fmt::format(
      "{{\"cost_half_step\": {}, \"observed_order\": {}, \"cost_limit\": {}, \"cost_error\": {}, \"grids\": {}}}",
      json(refinement.cost_half_step), json(refinement.observed_order), json(refinement.cost_limit),
      json(refinement.cost_error), json_list(refinement.grids, grid));
}

std::string certificate_text(const certificate::Certificate& certificate) {
  ObjectText text(1);
  text.add("goal_error", json(certificate.goal_error));
  text.add("rest_error", json(certificate.rest_error));
  text.add("momentum_drift", json(certificate.momentum_drift));
  text.add("momentum_round_off", json(certificate.momentum_round_off));
  text.add("rotation_drift", json(certificate.rotation_drift));
  text.add("iterates_momentum", json(certificate.iterates_momentum));
  text.add("equation_residual", json(certificate.equation_residual));
  text.add("start_error", json(certificate.start_error));
  text.add("control_error", json(certificate.control_error));
  text.add("time_error", json(certificate.time_error));
  text.add("velocity_error", json(certificate.velocity_error));
  text.add("cost_error", json(certificate.cost_error));
  const auto or_null = [&](const char* name, const auto& part, const auto& text_of) {
    text.add(name, part ? text_of(*part) : "null");
  };
  or_null("clearance", certificate.clearance, clearance_text);
  text.add("kkt", json(certificate.kkt));
  if (const auto& costs = certificate.costs)
    text.add("costs", fmt::format("{{\"error\": {}, \"signs\": {}}}", json(costs->error), json(costs->signs)));
  if (certificate.limits) text.add("limits", limit_check_text(*certificate.limits));
  or_null("second_order", certificate.second_order,
          [](const certificate::SecondOrder& second) { return "{" + curvature_text(second) + "}"; });
  or_null("second_order_all_axes", certificate.all_axes, [](const auto& all) {
    return fmt::format("{{\"kkt\": {}, {}}}", json(all.kkt), curvature_text(all.second_order));
  });
  or_null("verdict", certificate.verdict, [](const auto& verdict) { return json(word(verdict)); });
  or_null("resolved", certificate.replay,
          [](const auto& replay) { return replay.cut_short ? "null" : json(!replay.misses()); });
  or_null("replay", certificate.replay, replay_text);
  or_null("refinement", certificate.refinement, refinement_text);
  return text.finished();
}

std::string search_text(const maneuver::SearchRecord& search) {
  if (search.starts == 0) return "null";
  const auto minimum = [](const maneuver::Minimum& m) {
    const std::string by_ipopt = m.by_ipopt ? fmt::format(", \"by_ipopt\": {}", *m.by_ipopt) : "";
    return fmt::format("{{\"cost\": {}, \"count\": {}{}}}", json(m.cost), m.count, by_ipopt);
  };
  ObjectText text(1);
  text.add("starts", json(search.starts));
  if (search.strokes > 0) text.add("strokes", json(search.strokes));
  if (search.hops > 0) text.add("hops", json(search.hops));
  text.add("solved", json(search.solved));
  text.add("minima", json_list(search.minima, minimum));
  if (const auto& aside = search.set_aside)
    text.add("set_aside", fmt::format("{{\"cost\": {}, \"steps\": {}}}", json(aside->cost),
                                      aside->steps ? json(*aside->steps) : "null"));
  return text.finished();
}

std::string solver_text(const maneuver::SolverRecord& solver) {
  if (solver.name.empty()) return "null";
  const auto entry = [](const maneuver::SolverIteration& i) {
    return fmt::format(
        "\n      {{\"iteration\": {}, \"cost\": {}, \"goal_error\": {}, \"kkt\": {}, \"step\": {}, \"momentum\": {}}}",
        i.iteration, json(i.cost), json(i.goal_error), json(i.kkt), json(i.step), json(i.momentum));
  };
  ObjectText text(1);
  text.add("name", json(solver.name));
  text.add("iterations", json(solver.iterations));
  text.add("evaluations", json(solver.evaluations));
  text.add("wall_seconds", json(solver.wall_seconds));
  text.add("processor_seconds", json(solver.processor_seconds));
  text.add("total_wall_seconds", json(solver.total_wall_seconds));
  text.add("history", json_list(solver.history, entry));
  const auto add_weight = [&](const char* key, const maneuver::MultiplierWeight& weight) {
    if (weight.value > 0.0)
      text.add(key, fmt::format("{{\"value\": {}, \"largest\": {}}}", json(weight.value), json(weight.largest)));
  };
  add_weight("limit_weight", solver.limit_weight);
  add_weight("work_weight", solver.work_weight);
  return text.finished();
}

std::string divided_text(const maneuver::DividedSteps& divided) {
  return fmt::format("{{\"steps\": {}, \"substeps\": {}, \"smallest_step\": {}}}", divided.steps, divided.substeps,
                     json(divided.smallest_step));
}

std::string provenance_text(const Provenance& provenance) {
  ObjectText text(1);
  text.add("version", json(provenance.version));
  text.add("build_type", json(provenance.build_type));
  text.add("compiler", json(provenance.compiler));
  text.add("machine", json(provenance.machine));
  text.add("command", json(provenance.command));
  text.add("problem_sha256", json(provenance.problem_sha256));
  text.add("seed", fmt::format("{}", provenance.seed));
  return text.finished();
}

std::string tracking_text(const maneuver::Tracking& tracking) {
  ObjectText text(1);
  text.add("maneuver", json(tracking.maneuver));
  text.add("rotation_error", json(tracking.rotation_error));
  text.add("position_error", json(tracking.position_error));
  text.add("largest_rotation_error", json(tracking.largest_rotation_error));
  text.add("largest_position_error", json(tracking.largest_position_error));
  text.add("largest_correction", json(tracking.largest_correction));
  if (tracking.cut_share > 0.0) text.add("cut_share", json(tracking.cut_share));
  if (tracking.cut_from) text.add("cut_from", json(*tracking.cut_from));
  if (tracking.off_from) text.add("off_from", json(*tracking.off_from));
  return text.finished();
}

// What rows and columns of the gains are, then the gains.
std::string feedback_text(const ResolvedProblem& problem, const std::vector<ShapedArray>& arrays) {
  const auto control = [](const ControlCoordinate& c) {
    return fmt::format("\n      {{\"joint\": {}, \"axis\": {}}}", json(c.joint), c.axis);
  };
  const auto state = [](const StateCoordinate& c) {
    return fmt::format("\n      {{\"quantity\": {}, \"of\": {}, \"axis\": {}, \"unit\": {}}}", json(c.quantity),
                       json(c.of), c.axis, json(c.unit));
  };
  ObjectText text(1);
  text.add("control_coordinates", json_list(control_coordinates(problem), control));
  text.add("state_coordinates", json_list(state_coordinates(problem), state));
  for (const ShapedArray& array : arrays)
    if (array.group == "feedback") text.add(array.name, array_text(array, 2));
  return text.finished();
}

// The arrays in order, those of one group gathered into one object (groups nest: momentum/linear).
void add_arrays(const std::vector<ShapedArray>& arrays, ObjectText& text) {
  ObjectText velocity(1);
  ObjectText momentum(1);
  ObjectText linear(2);
  ObjectText angular(2);
  for (const ShapedArray& array : arrays) {
    if (array.group.empty()) text.add(array.name, array_text(array, 1));
    if (array.group == "velocity") velocity.add(array.name, array_text(array, 2));
    if (array.group == "momentum/linear") linear.add(array.name, array_text(array, 3));
    if (array.group == "momentum/angular") angular.add(array.name, array_text(array, 3));
  }
  momentum.add("linear", linear.finished());
  momentum.add("angular", angular.finished());
  text.add("velocity", velocity.finished());
  text.add("momentum", momentum.finished());
}

void require_nodes(const char* field, const std::vector<double>& values, const maneuver::Solution& solution) {
  require_finite(std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }), field);
  if (!solution.time.empty() && values.size() != solution.time.size())
    throw std::domain_error(fmt::format("{}: found {} entries, needs {}", field, values.size(), solution.time.size()));
}

// [drives][N + 1], where there are any.
void add_multipliers(const char* field, const std::vector<std::vector<double>>& values, ObjectText& text) {
  if (values.empty()) return;
  text.add(field, json_list(values, [](const std::vector<double>& drive) {
             return json_list(drive, [](double value) { return json(value); });
           }));
}

}  // namespace

std::string solution_text(const Results& results) {
  const maneuver::Solution& solution = results.solution;
  for (const maneuver::LimitMultiplier& own : solution.limit_multipliers)
    require_nodes("limit_multipliers", own.multiplier, solution);
  for (const std::vector<double>& own : solution.work_multipliers) require_nodes("work_multipliers", own, solution);
  for (const std::vector<double>& own : solution.work_change_multipliers)
    require_nodes("work_change_multipliers", own, solution);
  ObjectText text(0);
  text.add("schema", "1");
  text.add("name", json(results.name));
  text.add("source", json(results.source));
  text.add("status", json(word(solution.status)));
  text.add("message", json(solution.message));
  text.add("cost", json(solution.cost));
  if (const auto& parts = solution.cost_parts) {
    for (const double part : {parts->effort, parts->work, parts->power, parts->smoothness, parts->time})
      require_finite(std::isfinite(part), "cost_parts");
    const std::string rates = std::isnan(parts->angular_velocity)  // read from a file before it could cost
                                  ? ""
                                  : fmt::format("\"angular_velocity\": {}, ", json(parts->angular_velocity));
    text.add("cost_parts",
             fmt::format("{{\"effort\": {}, \"work\": {}, \"power\": {}, \"smoothness\": {}, {}\"time\": {}, "
                         "\"transport\": {}}}",
                         json(parts->effort), json(parts->work), json(parts->power), json(parts->smoothness), rates,
                         json(parts->time), json(parts->transport)));
  }
  text.add("problem", problem_text(results.problem));
  const std::vector<ShapedArray> arrays = shaped_arrays(results);
  add_arrays(arrays, text);
  if (!solution.feedback.gain.empty()) text.add("feedback", feedback_text(results.problem, arrays));
  if (!solution.limit_multipliers.empty())
    text.add("limit_multipliers", limit_multipliers_text(solution.limit_multipliers));
  add_multipliers("work_multipliers", solution.work_multipliers, text);
  add_multipliers("work_change_multipliers", solution.work_change_multipliers, text);
  text.add("certificate", results.certificate ? certificate_text(*results.certificate) : "null");
  text.add("search", search_text(solution.search));
  text.add("solver", solver_text(solution.solver));
  if (!solution.marched_by.empty()) text.add("marched_by", json(solution.marched_by));
  if (solution.tracking) text.add("tracking", tracking_text(*solution.tracking));
  if (solution.divided.steps > 0) text.add("divided_steps", divided_text(solution.divided));
  text.add("provenance", provenance_text(results.provenance));
  return text.finished() + "\n";
}

PendingFile solution_file(const Results& results) { return finished_file("solution.json", solution_text(results)); }

void write_solution(const std::string& folder, const Results& results) {
  write_files(folder, {solution_file(results)});
}

}  // namespace lamprey::file
