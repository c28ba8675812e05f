#include "report/page_data.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "lie/so3.hpp"
#include "report/joint_demands.hpp"
#include "report/limit_curves.hpp"
#include "report/limit_facts.hpp"
#include "report/obstacles.hpp"
#include "report/poses.hpp"
#include "report/shape_loop.hpp"
#include "report/summary.hpp"
#include "report/wording.hpp"
#include "result/resolve.hpp"

namespace lamprey::report {
namespace {

using nlohmann::json;
using Nodes = std::vector<std::size_t>;

constexpr std::size_t most_frames = 2001;
constexpr std::size_t most_numbers = 150000;
constexpr std::size_t least_frames = 21;
constexpr std::size_t most_iterations = 2000;  // rows of the solver's history

json triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json pairs(const std::vector<std::pair<std::string, std::string>>& rows) {
  json list = json::array();
  for (const auto& [name, value] : rows) list.push_back({name, value});
  return list;
}

/// A flat JSON array of 7 significant digits, written here because it is most of the document.
class Column {
 public:
  void add(double value) {
    if (!text_.empty()) text_ += ',';
    if (std::isfinite(value))
      fmt::format_to(std::back_inserter(text_), "{:.7g}", value == 0.0 ? 0.0 : value);
    else
      text_ += "null";
  }
  void add(const Eigen::Vector3d& v) {
    for (Eigen::Index k = 0; k < 3; ++k) add(v[k]);
  }
  void add(const std::vector<Eigen::Vector3d>& vectors) {
    for (const Eigen::Vector3d& v : vectors) add(v);
  }
  std::string array() const { return "[" + text_ + "]"; }

 private:
  std::string text_;
};

template <class Rows>
std::string column(const Rows& rows, const Nodes& nodes) {
  Column column;
  for (const std::size_t k : nodes) column.add(rows[k]);
  return column.array();
}

/// Quaternions (x, y, z, w) of [frames][bodies], each with the sign nearest to the frame before.
std::string quaternion_column(const std::vector<std::vector<Eigen::Matrix3d>>& rotation, const Nodes& nodes) {
  Column column;
  std::vector<lie::Vector4> last(rotation.front().size(), lie::Vector4(1.0, 0.0, 0.0, 0.0));
  for (const std::size_t k : nodes) {
    for (std::size_t i = 0; i < last.size(); ++i) {
      lie::Vector4 q = lie::quaternion_of_rotation(rotation[k][i]);
      if (q.dot(last[i]) < 0.0) q = -q;
      last[i] = q;
      for (const Eigen::Index part : {1, 2, 3, 0}) column.add(q[part]);
    }
  }
  return column.array();
}

/// Of a planar motion by two angles or more: its height functions, [first][second] row by row, its loop and what that moved; else
/// null.
std::string heights_text(const result::Results& results, const Nodes& nodes) {
  const std::optional<ShapeLoop> loop = shape_loop(results);
  if (!loop) return "null";
  const auto all = [](const auto& numbers) {
    Column column;
    for (const double number : numbers) column.add(number);
    return column.array();
  };
  const auto by_rows = [&](const Eigen::MatrixXd& values) {
    const Eigen::MatrixXd rows = values.transpose();
    return all(rows.reshaped());
  };
  const auto& [first, second] = loop->heights.at;
  const auto& height = loop->heights.height;
  std::string text = fmt::format(R"({{"variable":{},"run":[{},{}],"normal":{},"at":[{},{}],"height":[{},{},{}])",
                                 json(loop->variable).dump(), column(loop->run[0], nodes), column(loop->run[1], nodes),
                                 loop->heights.normal, all(first), all(second), by_rows(height[0]), by_rows(height[1]),
                                 by_rows(height[2]));
  if (loop->modes) {
    json rows = json::array();
    for (Eigen::Index a = 0; a < loop->modes->direction.rows(); ++a)
      rows.push_back({loop->modes->angle[static_cast<std::size_t>(a)], number(loop->modes->direction(a, 0), 3),
                      number(loop->modes->direction(a, 1), 3)});
    text += fmt::format(R"(,"modes":{},"beside":{:.3g})", rows.dump(), loop->modes->beside);
  }
  if (!loop->lacking.empty()) text += fmt::format(R"(,"lacking":{})", json(loop->lacking).dump());
  if (loop->displacement)
    text += fmt::format(R"(,"by_volume":{},"moved":{})", all(loop->displacement->by_volume),
                        all(loop->displacement->moved));
  return text + "}";
}

std::string momentum_columns(const maneuver::MomentumHistory& momentum, const Nodes& nodes) {
  return fmt::format(R"({{"bodies":{},"fluid":{},"total":{}}})", column(momentum.bodies, nodes),
                     column(momentum.fluid, nodes), column(momentum.total, nodes));
}

/// Of each joint the bounds that its curves have, and the curves that only a limit asks for.
std::string limit_curves_text(const std::vector<LimitCurve>& curves, const Nodes& nodes) {
  constexpr std::array kinds{"angle", "moment", "rate"};
  std::string text = "[";
  for (const LimitCurve& curve : curves) {
    json words = {
        {"joint", curve.joint}, {"kind", kinds[static_cast<std::size_t>(curve.kind)]}, {"bounds", curve.bounds}};
    if (curve.line)
      words["line"] = *curve.line;
    else
      words["label"] = curve.label;
    std::string object = words.dump();
    if (!curve.line) object.insert(object.size() - 1, ",\"values\":" + column(curve.values, nodes));
    text += (text.size() > 1 ? "," : "") + object;
  }
  return text + "]";
}

/// What lies in the swimmer's way, and what it passes.
json obstacles_of(const result::Results& results) {
  json obstacles = {{"sphere", json::array()}, {"half_space", json::array()}, {"waypoint", json::array()}};
  for (const maneuver::KeepOutSphere& sphere : results.problem.limits.spheres)
    obstacles["sphere"].push_back({{"centre", triple(sphere.centre)}, {"radius", sphere.radius}});
  for (const maneuver::KeepOutHalfSpace& half : results.problem.limits.half_spaces)
    obstacles["half_space"].push_back(
        {{"point", triple(half.point)}, {"normal", triple(half.normal.stableNormalized())}});
  for (const PassedPoint& passed : passed_points(results))
    obstacles["waypoint"].push_back({{"time", passed.time}, {"position", triple(passed.position)}});
  return obstacles;
}

std::string frames_text(const result::Results& results, const std::vector<std::vector<Eigen::Vector3d>>& joint_moment,
                        const Nodes& nodes) {
  const maneuver::Solution& s = results.solution;
  return fmt::format(
      R"({{"time":{},"position":{},"rotation":{},"joint_moment":{},"joint_angle":{},"linear_velocity":{},"angular_velocity":{},)"
      R"("linear_momentum":{},"angular_momentum":{}}})",
      column(s.time, nodes), column(s.position, nodes), quaternion_column(s.rotation, nodes),
      column(joint_moment, nodes), s.joint_angle.empty() ? "[]" : column(s.joint_angle, nodes),
      column(s.linear_velocity, nodes), column(s.angular_velocity, nodes), momentum_columns(s.linear_momentum, nodes),
      momentum_columns(s.angular_momentum, nodes));
}

json history_of(const maneuver::SolverRecord& solver) {
  json history = {
      {"iteration", json::array()}, {"cost", json::array()}, {"goal_error", json::array()}, {"kkt", json::array()}};
  const auto value = [](double x) { return std::isfinite(x) ? json(x) : json(nullptr); };
  const std::size_t count = solver.history.size(), stride = count / most_iterations + 1;
  for (std::size_t k = 0; k < count; ++k) {
    if (k % stride != 0 && k + 1 != count) continue;
    const maneuver::SolverIteration& row = solver.history[k];
    history["iteration"].push_back(row.iteration);
    history["cost"].push_back(value(row.cost));
    history["goal_error"].push_back(value(row.goal_error));
    history["kkt"].push_back(value(row.kkt));
  }
  return history;
}

/// The joint's kind and its axes: a hinge's in the child's frame, a universal joint's in the parent's and the child's.
std::string kind_words(const result::ResolvedJoint& joint) {
  std::string words = joint_kind_name(joint.kind);
  if (joint.axis) words += " " + vector(*joint.axis, 4);
  if (joint.axes) words += " " + vector((*joint.axes)[0], 4) + ", " + vector((*joint.axes)[1], 4);
  return words;
}

json problem_of(const result::ResolvedProblem& problem) {
  json bodies = json::array(), joints = json::array();
  for (const result::ResolvedBody& body : problem.bodies) {
    bodies.push_back({body.name, vector(body.semi_axes), number(body.mass), matrix(body.body_inertia),
                      matrix(body.mass_matrix), matrix(body.inertia_matrix)});
  }
  for (const result::ResolvedJoint& joint : problem.joints) {
    std::vector<std::string> axes;
    for (const Eigen::Vector3d& axis : joint.control_axes) axes.push_back(vector(axis, 4));
    joints.push_back({joint.name, kind_words(joint), problem.bodies[static_cast<std::size_t>(joint.parent)].name,
                      problem.bodies[static_cast<std::size_t>(joint.child)].name, vector(joint.parent_offset),
                      vector(joint.child_offset),
                      axes.empty() ? std::string("none") : fmt::format("{}", fmt::join(axes, ", ")),
                      joint.stiffness > 0.0 ? number(joint.stiffness) : "none",
                      joint.damping > 0.0 ? number(joint.damping) : "none"});
  }
  return {
      {"settings", pairs(problem_settings(problem))},
      {"body_heads",
       {"Body", "Semi-axes [m]", "Mass [kg]", "Inertia [kg m²]", "Mass with fluid [kg]", "Inertia with fluid [kg m²]"}},
      {"body_rows", bodies},
      {"joint_heads",
       {"Joint", "Kind, axes", "Parent", "Child", "Offset in the parent [m]", "Offset in the child [m]", "Control axes",
        "Spring [N m/rad]", "Damper [N m s/rad]"}},
      {"joint_rows", joints}};
}

/// Rows of what the motion asks of each joint; none where there are no joints or no motion.
json demands_of(const result::Results& results) {
  const std::optional<std::vector<JointDemand>> demands = joint_demands(results);
  json rows = json::array();
  if (!demands) return rows;
  for (const JointDemand& demand : *demands) {
    std::vector<std::string> angles;
    for (const auto& [least, largest] : demand.angles)
      angles.push_back(demand.ball ? "up to " + number(largest, 4) : number(least, 4) + " … " + number(largest, 4));
    rows.push_back({demand.joint, number(demand.largest_moment, 5), number(demand.largest_rate, 4),
                    number(demand.largest_power, 5), number(demand.work, 5),
                    angles.empty() ? std::string("–") : fmt::format("{}", fmt::join(angles, "; "))});
  }
  return rows;
}

std::optional<evidence::Clearance> clearance_of(const result::Results& results) {
  return results.certificate && results.certificate->clearance ? results.certificate->clearance
                                                               : march_clearance(results);
}

/// Where bodies pass through each other: which, by how much and when, and what keeps them apart; else empty.
std::string overlap_warning(const result::Results& results) {
  if (without_motion(results)) return "";
  const std::optional<evidence::Clearance> gap = clearance_of(results);
  if (!gap || !(gap->gap < 0.0)) return "";
  std::string words = clearance_words(*gap, results.problem);
  words[0] = static_cast<char>(std::toupper(words[0]));
  return words + (results.problem.limits.clearance ? "." : ". Nothing keeps them apart: set limits.clearance.");
}

using Facts = std::vector<std::pair<std::string, std::string>>;

/// The facts that come first, in this order, and all others.
std::pair<Facts, Facts> parted_facts(const result::Results& results) {
  Facts first, others = facts(results);
  for (const char* name :
       {"Cost", "Displacement", "Duration", "Work of the joints", "Cost of transport", "Clearance"}) {
    const auto row = std::find_if(others.begin(), others.end(), [&](const auto& each) { return each.first == name; });
    if (row == others.end()) continue;
    first.push_back(std::move(*row));
    others.erase(row);
  }
  const std::optional<evidence::Clearance> gap = clearance_of(results);
  if (gap && gap->gap < 0.0 && !first.empty() && first.back().first == "Clearance")  // the warning tells whose
    first.back().second = fmt::format("{} m at {} s", number(gap->gap, 3), number(gap->time, 6));
  return {std::move(first), std::move(others)};
}

json words_of(const result::Results& results) {
  const maneuver::Solution& solution = results.solution;
  const auto [figures, details] = parted_facts(results);
  const bool sought = solution.status != maneuver::Status::simulated;
  json run = {{"name", results.name},
              {"source", results.source},
              {"good", succeeded(results)},
              {"verdict", verdict(results)},
              {"paragraphs", remarks(results).paragraphs},
              {"remedies", remarks(results).remedies},
              {"warning", overlap_warning(results)},
              {"figures", pairs(figures)},
              {"details", pairs(details)},
              {"obstacles", obstacles_of(results)},
              {"problem", problem_of(results.problem)},
              {"provenance", pairs(provenance_rows(results.provenance))},
              {"joint_order", joint_order(results.problem)},
              {"periodic", results.problem.goal && results.problem.goal->periodic},
              {"planar", planar(results)},
              {"flat", !results.problem.bodies.empty() && results.problem.bodies.front().ellipse}};
  if (results.certificate) {
    for (const CertificateRow& row : certificate_rows(*results.certificate, results.problem)) {
      run["certificate"].push_back({{"name", row.name},
                                    {"value", row.value},
                                    {"mark", row.mark},
                                    {"meaning", row.meaning},
                                    {"stored", row.stored},
                                    {"holds", row.holds ? json(*row.holds) : json(nullptr)}});
    }
  }
  if (sought && solution.search.starts > 0) {
    run["search"] = {
        {"starts", solution.search.starts}, {"hops", solution.search.hops}, {"solved", solution.search.solved}};
    run["minima"] = json::array();
    for (const maneuver::Minimum& minimum : solution.search.minima)
      run["minima"].push_back({minimum.cost, minimum.count});
  }
  if (sought && !solution.solver.history.empty()) run["history"] = history_of(solution.solver);
  run["demand_heads"] = {"Joint",           "Largest moment [N m]", "Largest rate [rad/s]", "Largest power [W]",
                         "Work ∫|u·ω| [J]", "Angle from zero [rad]"};
  run["demands"] = demands_of(results);
  run["bodies"] = run["joints"] = json::array();
  for (const result::ResolvedBody& body : results.problem.bodies) {
    run["bodies"].push_back({{"name", body.name}, {"semi_axes", triple(body.semi_axes)}});
  }
  for (const result::ResolvedJoint& joint : results.problem.joints) {
    run["joints"].push_back({{"name", joint.name},
                             {"kind", joint_kind_name(joint.kind)},
                             {"parent", joint.parent},
                             {"child", joint.child},
                             {"parent_offset", triple(joint.parent_offset)},
                             {"child_offset", triple(joint.child_offset)}});
  }
  return run;
}

std::size_t curves_with_values(const std::vector<LimitCurve>& curves) {
  return static_cast<std::size_t>(
      std::count_if(curves.begin(), curves.end(), [](const LimitCurve& curve) { return !curve.line; }));
}

void escape_less_than(std::string& text) {
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
    text.replace(at, 1, "\\u003c");
}

}  // namespace

std::vector<std::size_t> drawn_nodes(std::size_t nodes, std::size_t numbers_per_frame) {
  const std::size_t frames =
      std::clamp(most_numbers / std::max<std::size_t>(numbers_per_frame, 1), least_frames, most_frames);
  const std::size_t count = std::min(nodes, frames);
  Nodes chosen(count, 0);
  for (std::size_t k = 1; k < count; ++k) chosen[k] = k * (nodes - 1) / (count - 1);
  return chosen;
}

std::string page_data(const std::vector<const result::Results*>& runs) {
  std::string text = "{\"runs\":[";
  for (const result::Results* run : runs) {
    ensure_shapes(*run);
    std::string words = words_of(*run).dump(-1, ' ', false, json::error_handler_t::replace);
    escape_less_than(words);
    if (run != runs.front()) text += ',';
    words.back() = ',';
    const maneuver::Problem problem = result::problem_of(*run);
    const model::System system(problem.swimmer);
    const evidence::StoredMotion motion(system, problem, run->solution);
    const std::vector<LimitCurve> curves = limit_curves(motion);
    const std::size_t numbers =
        25 + 7 * run->problem.bodies.size() + 6 * run->problem.joints.size() + curves_with_values(curves);
    const Nodes nodes = drawn_nodes(run->solution.time.size(), numbers);
    std::string heights = heights_text(*run, nodes);
    escape_less_than(heights);
    text += words + "\"heights\":" + heights + ",\"limit_curves\":" + limit_curves_text(curves, nodes) +
            ",\"frames\":" + frames_text(*run, motion.control, nodes) + "}";
  }
  return text + "]}";
}

}  // namespace lamprey::report
