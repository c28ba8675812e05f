#include <algorithm>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "document/json_text.hpp"
#include "file/words.hpp"
#include "result/limits_json.hpp"
#include "result/result_shapes.hpp"
#include "result/solution_file.hpp"

namespace lamprey::result {

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
    out.append(std::string_view(document::json_number(array.values[at++])));
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
  document::require_finite(body.semi_axes.allFinite() && body.mass_matrix.allFinite() &&
                               body.inertia_matrix.allFinite() && body.coupling_matrix.allFinite() &&
                               std::isfinite(body.mass) && body.body_inertia.allFinite(),
                           "problem.bodies");
  ObjectText text(3);
  text.add("name", document::json(body.name));
  text.add("semi_axes", document::json(body.semi_axes));
  text.add("mass_matrix", document::json(body.mass_matrix));
  text.add("inertia_matrix", document::json(body.inertia_matrix));
  text.add("mass", document::json(body.mass));
  text.add("body_inertia", document::json(body.body_inertia));
  text.add("coupling_matrix", document::json(body.coupling_matrix));
  if (body.ellipse) text.add("ellipse", document::json(true));
  return text.finished();
}

std::string joint_text(const ResolvedJoint& joint) {
  document::require_finite(joint.parent_offset.allFinite() && joint.child_offset.allFinite(), "problem.joints");
  for (const Vector3d& axis : joint.control_axes)
    document::require_finite(axis.allFinite(), "problem.joints.control_axes");
  document::require_finite(joint.reference_rotation.allFinite() && (!joint.axis || joint.axis->allFinite()) &&
                               (!joint.axes || ((*joint.axes)[0].allFinite() && (*joint.axes)[1].allFinite())) &&
                               std::isfinite(joint.stiffness) && std::isfinite(joint.damping),
                           "problem.joints");
  const auto vector = [](const Vector3d& v) { return document::json(v); };
  ObjectText text(3);
  text.add("name", document::json(joint.name));
  text.add("kind", document::json(file::word(joint.kind)));
  text.add("parent", document::json(joint.parent));
  text.add("child", document::json(joint.child));
  text.add("parent_offset", document::json(joint.parent_offset));
  text.add("child_offset", document::json(joint.child_offset));
  text.add("control_axes", json_list(joint.control_axes, vector));
  text.add("reference_rotation", document::json(joint.reference_rotation));
  if (joint.axis) text.add("axis", document::json(*joint.axis));
  if (joint.axes) text.add("axes", json_list(*joint.axes, vector));
  text.add("actuated", document::json(joint.actuated));
  text.add("stiffness", document::json(joint.stiffness));
  text.add("damping", document::json(joint.damping));
  return text.finished();
}

std::string goal_text(const maneuver::Goal& goal) {
  const auto free_or = [](const auto& value) { return value ? document::json(*value) : std::string("\"free\""); };
  for (const auto& entry : goal.move) document::require_finite(!entry || std::isfinite(*entry), "problem.goal.move");
  document::require_finite(!goal.turn || goal.turn->allFinite(), "problem.goal.turn");
  std::string rotation;
  for (const auto& [name, value] : goal.rotation) {
    document::require_finite(!value || value->allFinite(), "problem.goal.rotation");
    rotation += fmt::format("{}{}: {}", rotation.empty() ? "" : ", ", document::json(name), free_or(value));
  }
  std::string angle;
  for (const auto& [name, values] : goal.angle) {
    for (double value : values) document::require_finite(std::isfinite(value), "problem.goal.angle");
    angle += fmt::format("{}{}: {}", angle.empty() ? "" : ", ", document::json(name),
                         json_list(values, [](double value) { return document::json(value); }));
  }
  ObjectText text(2);
  text.add("move", move_text(goal.move));
  text.add("turn", goal.turn ? document::json(*goal.turn) : "null");
  text.add("rotation", "{" + rotation + "}");
  if (!goal.angle.empty()) text.add("angle", "{" + angle + "}");
  if (goal.shape_of_start) text.add("shape", document::json(std::string("start")));
  text.add("rest", goal.joints_rest ? document::json(std::string("joints")) : document::json(goal.rest));
  text.add("periodic", document::json(goal.periodic));
  return text.finished();
}

std::string start_text(const ResolvedStart& start) {
  document::require_finite(start.position.allFinite() && start.linear_velocity.allFinite(), "problem.start");
  for (const Matrix3d& rotation : start.rotation)
    document::require_finite(rotation.allFinite(), "problem.start.rotation");
  for (const Vector3d& rate : start.angular_velocity)
    document::require_finite(rate.allFinite(), "problem.start.angular_velocity");
  ObjectText text(2);
  text.add("rotation", json_list(start.rotation, [](const Matrix3d& m) { return document::json(m); }));
  text.add("position", document::json(start.position));
  text.add("linear_velocity", document::json(start.linear_velocity));
  text.add("angular_velocity", json_list(start.angular_velocity, [](const Vector3d& v) { return document::json(v); }));
  return text.finished();
}

}  // namespace

std::string problem_text(const ResolvedProblem& problem) {
  document::require_finite(std::isfinite(problem.time_step) && std::isfinite(problem.duration),
                           "problem.time_step, problem.duration");
  ObjectText text(1);
  text.add("bodies", json_list(problem.bodies, body_text));
  text.add("joints", json_list(problem.joints, joint_text));
  if (problem.density) text.add("density", document::json(*problem.density));
  text.add("scheme", document::json(file::word(problem.scheme)));
  text.add("time_step", document::json(problem.time_step));
  text.add("duration", document::json(problem.duration));
  text.add("steps", document::json(problem.steps));
  text.add("cost_rule", document::json(file::word(problem.cost_rule)));
  if (problem.start) text.add("start", start_text(*problem.start));
  text.add("goal", problem.goal ? goal_text(*problem.goal) : "null");
  text.add("control", fmt::format("{{\"kind\": {}, \"points\": {}}}", document::json(file::word(problem.control)),
                                  problem.points));
  text.add("effort", document::json(problem.effort));
  if (problem.time_weight != 0.0) text.add("time_weight", document::json(problem.time_weight));
  const maneuver::CostWeights& weights = problem.cost_weights;
  if (weights.of_displacement()) text.add("displacement_weight", document::json(weights.displacement));
  if (weights.any())
    text.add(
        "cost_weights",
        fmt::format("{{\"work\": {}, \"power\": {}, \"smoothness\": {}, \"angular_velocity\": {}, \"transport\": {}}}",
                    document::json(weights.work), document::json(weights.power), document::json(weights.smoothness),
                    document::json(weights.angular_velocity), document::json(weights.transport)));
  if (problem.limits.any()) text.add("limits", limits_text(problem.limits));
  if (!problem.waypoints.empty()) text.add("waypoints", waypoints_text(problem.waypoints));
  if (problem.free_duration)
    text.add("free_duration", fmt::format("{{\"min\": {}, \"max\": {}}}", document::json(problem.between[0]),
                                          document::json(problem.between[1])));
  if (problem.free_shape) text.add("free_shape", document::json(true));
  text.add("tolerance", document::json(problem.tolerance));
  return text.finished();
}

namespace {

std::string curvature_text(const optimality::SecondOrder& second) {
  const std::string beside =
      second.along_phase ? fmt::format(", \"along_phase\": {}", document::json(*second.along_phase)) : "";
  return fmt::format("\"smallest_eigenvalue\": {}, \"positive\": {}, \"negative_eigenvalues\": {}{}",
                     document::json(second.smallest_eigenvalue), document::json(second.positive),
                     second.negative_eigenvalues ? document::json(*second.negative_eigenvalues) : "null", beside);
}

std::string clearance_text(const evidence::Clearance& clearance) {
  return fmt::format("{{\"gap\": {}, \"time\": {}, \"bodies\": [{}, {}]}}", document::json(clearance.gap),
                     document::json(clearance.time), clearance.first, clearance.second);
}

std::string limit_check_text(const evidence::LimitsKept& limits) {
  return fmt::format("{{\"violation\": {}, \"key\": {}, \"time\": {}, \"complementarity\": {}, \"negative\": {}}}",
                     document::json(limits.violation), document::json(limits.key), document::json(limits.time),
                     document::json(limits.complementarity), document::json(limits.negative));
}

std::string replay_text(const certificate::Replay& replay) {
  ObjectText text(2);
  text.add("scheme", document::json(replay.scheme));
  text.add("window", document::json(replay.window));
  text.add("rotation_error", document::json(replay.rotation_error));
  text.add("position_error", document::json(replay.position_error));
  text.add("whole_rotation_error", document::json(replay.whole_rotation_error));
  text.add("whole_position_error", document::json(replay.whole_position_error));
  text.add("growth_rate", document::json(replay.growth_rate));
  if (!std::isnan(replay.work)) text.add("work", document::json(replay.work));
  if (replay.rotation_mark < certificate::replay_mark) text.add("rotation_mark", document::json(replay.rotation_mark));
  if (std::isfinite(replay.position_mark)) text.add("position_mark", document::json(replay.position_mark));
  text.add("feedback_rotation_error", document::json(replay.feedback_rotation_error));
  text.add("feedback_position_error", document::json(replay.feedback_position_error));
  text.add("servo_rotation_error", document::json(replay.servo_rotation_error));
  text.add("servo_position_error", document::json(replay.servo_position_error));
  return text.finished();
}

std::string refinement_text(const certificate::Refinement& refinement) {
  const auto grid = [](const certificate::GridCost& g) {
    return fmt::format("{{\"steps\": {}, \"cost\": {}}}", g.steps, document::json(g.cost));
  };
  return fmt::format(
      "{{\"cost_half_step\": {}, \"observed_order\": {}, \"cost_limit\": {}, \"cost_error\": {}, \"grids\": {}}}",
      document::json(refinement.cost_half_step), document::json(refinement.observed_order),
      document::json(refinement.cost_limit), document::json(refinement.cost_error), json_list(refinement.grids, grid));
}

std::string certificate_text(const certificate::Certificate& certificate) {
  ObjectText text(1);
  text.add("goal_error", document::json(certificate.goal_error));
  text.add("rest_error", document::json(certificate.rest_error));
  text.add("momentum_drift", document::json(certificate.momentum_drift));
  text.add("momentum_round_off", document::json(certificate.momentum_round_off));
  text.add("rotation_drift", document::json(certificate.rotation_drift));
  text.add("iterates_momentum", document::json(certificate.iterates_momentum));
  text.add("equation_residual", document::json(certificate.equation_residual));
  text.add("start_error", document::json(certificate.start_error));
  text.add("control_error", document::json(certificate.control_error));
  text.add("time_error", document::json(certificate.time_error));
  text.add("velocity_error", document::json(certificate.velocity_error));
  text.add("cost_error", document::json(certificate.cost_error));
  const auto or_null = [&](const char* name, const auto& part, const auto& text_of) {
    text.add(name, part ? text_of(*part) : "null");
  };
  or_null("clearance", certificate.clearance, clearance_text);
  text.add("kkt", document::json(certificate.kkt));
  text.add("kkt_round_off", document::json(certificate.kkt_round_off));
  if (const auto& costs = certificate.costs)
    text.add("costs", fmt::format("{{\"error\": {}, \"signs\": {}}}", document::json(costs->error),
                                  document::json(costs->signs)));
  if (certificate.limits) text.add("limits", limit_check_text(*certificate.limits));
  or_null("second_order", certificate.second_order,
          [](const optimality::SecondOrder& second) { return "{" + curvature_text(second) + "}"; });
  or_null("second_order_all_axes", certificate.all_axes, [](const auto& all) {
    return fmt::format("{{\"kkt\": {}, {}}}", document::json(all.kkt), curvature_text(all.second_order));
  });
  or_null("verdict", certificate.verdict, [](const auto& verdict) { return document::json(file::word(verdict)); });
  or_null("resolved", certificate.replay,
          [](const auto& replay) { return replay.cut_short ? "null" : document::json(!replay.misses()); });
  or_null("replay", certificate.replay, replay_text);
  or_null("refinement", certificate.refinement, refinement_text);
  return text.finished();
}

std::string search_text(const maneuver::SearchRecord& search) {
  if (search.starts == 0) return "null";
  const auto minimum = [](const maneuver::Minimum& m) {
    const std::string by_ipopt = m.by_ipopt ? fmt::format(", \"by_ipopt\": {}", *m.by_ipopt) : "";
    return fmt::format("{{\"cost\": {}, \"count\": {}{}}}", document::json(m.cost), m.count, by_ipopt);
  };
  ObjectText text(1);
  text.add("starts", document::json(search.starts));
  if (search.strokes > 0) text.add("strokes", document::json(search.strokes));
  if (search.hops > 0) text.add("hops", document::json(search.hops));
  text.add("solved", document::json(search.solved));
  text.add("minima", json_list(search.minima, minimum));
  if (const auto& aside = search.set_aside)
    text.add("set_aside", fmt::format("{{\"cost\": {}, \"steps\": {}}}", document::json(aside->cost),
                                      aside->steps ? document::json(*aside->steps) : "null"));
  return text.finished();
}

std::string solver_text(const maneuver::SolverRecord& solver) {
  if (solver.name.empty()) return "null";
  const auto entry = [](const maneuver::SolverIteration& i) {
    return fmt::format(
        "\n      {{\"iteration\": {}, \"cost\": {}, \"goal_error\": {}, \"kkt\": {}, \"step\": {}, \"momentum\": {}}}",
        i.iteration, document::json(i.cost), document::json(i.goal_error), document::json(i.kkt),
        document::json(i.step), document::json(i.momentum));
  };
  ObjectText text(1);
  text.add("name", document::json(solver.name));
  text.add("iterations", document::json(solver.iterations));
  text.add("evaluations", document::json(solver.evaluations));
  text.add("wall_seconds", document::json(solver.wall_seconds));
  text.add("processor_seconds", document::json(solver.processor_seconds));
  text.add("total_wall_seconds", document::json(solver.total_wall_seconds));
  text.add("history", json_list(solver.history, entry));
  const auto add_weight = [&](const char* key, const maneuver::MultiplierWeight& weight) {
    if (weight.value > 0.0)
      text.add(key, fmt::format("{{\"value\": {}, \"largest\": {}}}", document::json(weight.value),
                                document::json(weight.largest)));
  };
  add_weight("limit_weight", solver.limit_weight);
  add_weight("work_weight", solver.work_weight);
  return text.finished();
}

std::string divided_text(const maneuver::DividedSteps& divided) {
  return fmt::format("{{\"steps\": {}, \"substeps\": {}, \"smallest_step\": {}}}", divided.steps, divided.substeps,
                     document::json(divided.smallest_step));
}

std::string provenance_text(const Provenance& provenance) {
  ObjectText text(1);
  text.add("version", document::json(provenance.version));
  text.add("build_type", document::json(provenance.build_type));
  text.add("compiler", document::json(provenance.compiler));
  text.add("machine", document::json(provenance.machine));
  text.add("command", document::json(provenance.command));
  text.add("problem_sha256", document::json(provenance.problem_sha256));
  text.add("seed", fmt::format("{}", provenance.seed));
  return text.finished();
}

std::string tracking_text(const maneuver::Tracking& tracking) {
  ObjectText text(1);
  text.add("maneuver", document::json(tracking.maneuver));
  text.add("rotation_error", document::json(tracking.rotation_error));
  text.add("position_error", document::json(tracking.position_error));
  text.add("largest_rotation_error", document::json(tracking.largest_rotation_error));
  text.add("largest_position_error", document::json(tracking.largest_position_error));
  text.add("largest_correction", document::json(tracking.largest_correction));
  if (tracking.cut_share > 0.0) text.add("cut_share", document::json(tracking.cut_share));
  if (tracking.cut_from) text.add("cut_from", document::json(*tracking.cut_from));
  if (tracking.off_from) text.add("off_from", document::json(*tracking.off_from));
  return text.finished();
}

// What rows and columns of the gains are, then the gains.
std::string feedback_text(const ResolvedProblem& problem, const std::vector<ShapedArray>& arrays) {
  const auto control = [](const ControlCoordinate& c) {
    return fmt::format("\n      {{\"joint\": {}, \"axis\": {}}}", document::json(c.joint), c.axis);
  };
  const auto state = [](const StateCoordinate& c) {
    return fmt::format("\n      {{\"quantity\": {}, \"of\": {}, \"axis\": {}, \"unit\": {}}}",
                       document::json(c.quantity), document::json(c.of), c.axis, document::json(c.unit));
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
  document::require_finite(std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); }),
                           field);
  if (!solution.time.empty() && values.size() != solution.time.size())
    throw std::domain_error(fmt::format("{}: found {} entries, needs {}", field, values.size(), solution.time.size()));
}

// [drives][N + 1], where there are any.
void add_multipliers(const char* field, const std::vector<std::vector<double>>& values, ObjectText& text) {
  if (values.empty()) return;
  text.add(field, json_list(values, [](const std::vector<double>& drive) {
             return json_list(drive, [](double value) { return document::json(value); });
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
  text.add("name", document::json(results.name));
  text.add("source", document::json(results.source));
  text.add("status", document::json(file::word(solution.status)));
  text.add("message", document::json(solution.message));
  if (const maneuver::Failure& failure = results.failure; failure.any()) {
    std::vector<std::string> remedies;
    for (const std::string& remedy : failure.remedies) remedies.push_back(document::json(remedy));
    text.add("failure",
             fmt::format("{{\"missed\": {}, \"cause\": {}, \"remedies\": [{}]}}", document::json(failure.missed),
                         document::json(failure.cause), fmt::join(remedies, ", ")));
  }
  text.add("cost", document::json(solution.cost));
  if (const auto& parts = solution.cost_parts) {
    for (const double part : {parts->effort, parts->work, parts->power, parts->smoothness, parts->time})
      document::require_finite(std::isfinite(part), "cost_parts");
    const std::string rates = std::isnan(parts->angular_velocity)  // read from a file before it could cost
                                  ? ""
                                  : fmt::format("\"angular_velocity\": {}, ", document::json(parts->angular_velocity));
    text.add("cost_parts",
             fmt::format("{{\"effort\": {}, \"work\": {}, \"power\": {}, \"smoothness\": {}, {}\"time\": {}, "
                         "\"transport\": {}}}",
                         document::json(parts->effort), document::json(parts->work), document::json(parts->power),
                         document::json(parts->smoothness), rates, document::json(parts->time),
                         document::json(parts->transport)));
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
  if (!solution.marched_by.empty()) text.add("marched_by", document::json(solution.marched_by));
  if (solution.tracking) text.add("tracking", tracking_text(*solution.tracking));
  if (solution.divided.steps > 0) text.add("divided_steps", divided_text(solution.divided));
  text.add("provenance", provenance_text(results.provenance));
  return text.finished() + "\n";
}

document::PendingFile solution_file(const Results& results) {
  return document::finished_file("solution.json", solution_text(results));
}

void write_solution(const std::string& folder, const Results& results) {
  document::write_files(folder, {solution_file(results)});
}

}  // namespace lamprey::result
