#include "result/certificate_reader.hpp"

#include <cmath>
#include <limits>
#include <utility>

#include "document/json_words.hpp"
#include "file/words.hpp"

namespace lamprey::result {

namespace {

using certificate::Certificate;

constexpr int largest_count = std::numeric_limits<int>::max();

// What older files lack, or hold nothing of.
bool told(const document::JsonReader& reader, const char* key) { return reader.has(key) && !reader.at(key).is_null(); }

void read_if_there(const document::JsonReader& reader, const char* key, double& value) {
  if (reader.has(key)) value = reader.at(key).number_or_nan();
}

certificate::Refinement read_refinement(const document::JsonReader& reader) {
  certificate::Refinement result;
  result.cost_half_step = reader.at("cost_half_step").number_or_nan();
  result.observed_order = reader.at("observed_order").number_or_nan();
  if (!reader.has("grids")) return result;
  result.cost_limit = reader.at("cost_limit").number_or_nan();
  result.cost_error = reader.at("cost_error").number_or_nan();
  const document::JsonReader grids = reader.at("grids");
  grids.require_array();
  for (std::size_t i = 0; i < grids.size(); ++i)
    result.grids.push_back({grids.at(i).at("steps").integer(1, largest_count), grids.at(i).at("cost").number_or_nan()});
  return result;
}

optimality::SecondOrder read_curvature(const document::JsonReader& reader) {
  optimality::SecondOrder result{reader.at("smallest_eigenvalue").number_or_nan(), reader.at("positive").boolean(), {}};
  if (told(reader, "negative_eigenvalues"))
    result.negative_eigenvalues = reader.at("negative_eigenvalues").integer(0, largest_count);
  if (told(reader, "along_phase")) result.along_phase = reader.at("along_phase").number_or_nan();
  return result;
}

evidence::Clearance read_clearance(const document::JsonReader& reader, int bodies) {
  const document::JsonReader pair = reader.at("bodies");
  pair.require_array(2);
  return {reader.at("gap").number_or_nan(), reader.at("time").number_or_nan(),
          pair.at(std::size_t{0}).integer(-1, bodies - 1), pair.at(std::size_t{1}).integer(-1, bodies - 1)};
}

certificate::Replay read_replay(const document::JsonReader& reader) {
  certificate::Replay replay = {reader.at("scheme").text(),
                                reader.at("window").number_or_nan(),
                                reader.at("rotation_error").number_or_nan(),
                                reader.at("position_error").number_or_nan(),
                                reader.at("whole_rotation_error").number_or_nan(),
                                reader.at("whole_position_error").number_or_nan(),
                                reader.at("growth_rate").number_or_nan()};
  read_if_there(reader, "work", replay.work);
  read_if_there(reader, "rotation_mark", replay.rotation_mark);
  read_if_there(reader, "position_mark", replay.position_mark);
  for (const auto& [key, value] :
       {std::pair("feedback", std::pair(&replay.feedback_rotation_error, &replay.feedback_position_error)),
        std::pair("servo", std::pair(&replay.servo_rotation_error, &replay.servo_position_error))}) {
    const std::string turned = std::string(key) + "_rotation_error", moved = std::string(key) + "_position_error";
    if (!reader.has(turned.c_str())) continue;
    *value.first = reader.at(turned.c_str()).number_or_nan();
    *value.second = reader.at(moved.c_str()).number_or_nan();
  }
  return replay;
}

evidence::LimitsKept read_limits_kept(const document::JsonReader& reader) {
  return {reader.at("violation").number_or_nan(), reader.at("key").text(), reader.at("time").number_or_nan(),
          reader.at("complementarity").number_or_nan(), reader.at("negative").number_or_nan()};
}

// What says whether the motion is one, and the one that is asked for.
void read_errors(const document::JsonReader& reader, Certificate& result) {
  for (const auto& [key, value] :
       {std::pair("goal_error", &result.goal_error), std::pair("rest_error", &result.rest_error),
        std::pair("momentum_drift", &result.momentum_drift), std::pair("rotation_drift", &result.rotation_drift)})
    *value = reader.at(key).number_or_nan();
  for (const auto& [key, value] :
       {std::pair("momentum_round_off", &result.momentum_round_off),
        std::pair("iterates_momentum", &result.iterates_momentum),
        std::pair("equation_residual", &result.equation_residual), std::pair("start_error", &result.start_error),
        std::pair("control_error", &result.control_error), std::pair("time_error", &result.time_error),
        std::pair("velocity_error", &result.velocity_error), std::pair("cost_error", &result.cost_error)})
    read_if_there(reader, key, *value);
}

// What says whether it is the best.
void read_optimality(const document::JsonReader& reader, Certificate& result) {
  result.kkt = reader.at("kkt").number_or_nan();
  read_if_there(reader, "kkt_round_off", result.kkt_round_off);
  if (const document::JsonReader second = reader.at("second_order"); !second.is_null())
    result.second_order = read_curvature(second);
  if (told(reader, "second_order_all_axes")) {
    const document::JsonReader all = reader.at("second_order_all_axes");
    result.all_axes = {all.at("kkt").number_or_nan(), read_curvature(all)};
  }
  if (told(reader, "verdict")) result.verdict = document::read_word(reader.at("verdict"), file::verdicts);
}

}  // namespace

Certificate read_certificate(const document::JsonReader& reader, int bodies) {
  Certificate result;
  read_errors(reader, result);
  if (told(reader, "clearance")) result.clearance = read_clearance(reader.at("clearance"), bodies);
  read_optimality(reader, result);
  if (const document::JsonReader replay = reader.at("replay"); !replay.is_null()) result.replay = read_replay(replay);
  if (result.replay) result.replay->cut_short = std::isnan(result.replay->rotation_error) && !told(reader, "resolved");
  if (told(reader, "resolved") && result.replay && reader.at("resolved").boolean() == result.replay->misses())
    reader.at("resolved").refuse("true where replay's errors are at most their marks, else false");
  if (reader.has("costs"))
    result.costs = {reader.at("costs").at("error").number_or_nan(), reader.at("costs").at("signs").number_or_nan()};
  if (reader.has("limits")) result.limits = read_limits_kept(reader.at("limits"));
  if (const document::JsonReader refinement = reader.at("refinement"); !refinement.is_null())
    result.refinement = read_refinement(refinement);
  return result;
}

}  // namespace lamprey::result
