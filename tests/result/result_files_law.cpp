#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "chains.hpp"
#include "document/io_error.hpp"
#include "file/samples.hpp"
#include "result/resolve.hpp"
#include "result/result_shapes.hpp"
#include "result/solution_file.hpp"
#include "result/trajectory_file.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

TEST(SolutionFile, written_read_and_written_again_gives_the_same_bytes) {
  const tests::TemporaryFolder folder;
  const result::Results results = tests::sample_results(6);
  result::write_solution(folder / "first", results);
  result::write_solution(folder / "second", result::read_solution(folder / "first"));
  const std::string first = tests::bytes_of(folder / "first/solution.json");
  EXPECT_GT(first.size(), 1000U);
  EXPECT_EQ(first, tests::bytes_of(folder / "second/solution.json"));
}

TEST(SolutionFile, joints_that_are_to_end_at_rest_come_back) {
  const tests::TemporaryFolder folder;
  result::Results results = tests::sample_results(6);
  results.problem.goal->rest = false;
  results.problem.goal->joints_rest = true;
  result::write_solution(folder / "first", results);
  EXPECT_NE(tests::bytes_of(folder / "first/solution.json").find("\"rest\": \"joints\""), std::string::npos);
  const result::Results read = result::read_solution(folder / "first");
  EXPECT_FALSE(read.problem.goal->rest);
  EXPECT_TRUE(read.problem.goal->joints_rest);
}

// Where round-off hides how many directions lower the cost the file says so (it once held −1 of them, and was not read again).
TEST(SolutionFile, directions_that_cannot_be_counted_are_null) {
  result::Results results = tests::sample_results(6);
  results.certificate->second_order = optimality::SecondOrder{};
  results.certificate->second_order->smallest_eigenvalue = -1e-9;
  results.certificate->second_order->positive = false;
  results.certificate->second_order->negative_eigenvalues = std::nullopt;
  const std::string text = result::solution_text(results);
  EXPECT_TRUE(json::parse(text)["certificate"]["second_order"]["negative_eigenvalues"].is_null());
  const result::Results back = result::parse_solution(text, "x");
  ASSERT_TRUE(back.certificate->second_order);
  EXPECT_EQ(back.certificate->second_order->smallest_eigenvalue, -1e-9);
  EXPECT_FALSE(back.certificate->second_order->positive);
  EXPECT_FALSE(back.certificate->second_order->negative_eigenvalues.has_value());
  const std::string negative = R"("negative_eigenvalues": -1)";
  std::string spoilt = text;
  spoilt.replace(spoilt.find("\"negative_eigenvalues\": null"), 28, negative);
  EXPECT_THROW(result::parse_solution(spoilt, "x"), model::InputError);
}

TEST(SolutionFile, every_double_comes_back_bit_for_bit) {
  result::Results results = tests::sample_results(6);
  results.solution.position[3] = {-0.0, 4.9406564584124654e-324, -1.7976931348623157e308};
  const result::Results back = result::parse_solution(result::solution_text(results), "x");
  EXPECT_EQ(back.solution.time, results.solution.time);
  EXPECT_EQ(back.solution.position, results.solution.position);
  EXPECT_TRUE(std::signbit(back.solution.position[3][0]));
  EXPECT_EQ(back.solution.rotation, results.solution.rotation);
  EXPECT_EQ(back.solution.joint_angle, results.solution.joint_angle);
  EXPECT_EQ(back.solution.control, results.solution.control);
  EXPECT_EQ(back.solution.angular_velocity, results.solution.angular_velocity);
  EXPECT_EQ(back.solution.angular_momentum.fluid, results.solution.angular_momentum.fluid);
  EXPECT_EQ(back.problem.bodies[2].body_inertia, results.problem.bodies[2].body_inertia);
  EXPECT_EQ(back.problem.joints[0].control_axes, results.problem.joints[0].control_axes);
  EXPECT_TRUE(back.problem.joints[1].control_axes.empty());
  EXPECT_EQ(back.problem.goal->turn, results.problem.goal->turn);
  EXPECT_EQ(back.problem.goal->rotation, results.problem.goal->rotation);
  EXPECT_EQ(back.problem.points, results.problem.points);
  EXPECT_EQ(back.problem.effort, results.problem.effort);
  EXPECT_EQ(back.problem.tolerance, results.problem.tolerance);
  EXPECT_EQ(back.problem.time_weight, results.problem.time_weight);
  EXPECT_EQ(back.problem.limits.torque, results.problem.limits.torque);
  EXPECT_EQ(back.problem.density, results.problem.density);
  EXPECT_EQ(back.problem.limits.joint_torque_component, results.problem.limits.joint_torque_component);
  EXPECT_EQ(back.problem.limits.angle, results.problem.limits.angle);
  EXPECT_EQ(back.problem.limits.half_spaces[0].normal, results.problem.limits.half_spaces[0].normal);
  EXPECT_EQ(back.problem.waypoints[0].move, results.problem.waypoints[0].move);
  EXPECT_EQ(back.problem.waypoints[1].rotation, results.problem.waypoints[1].rotation);
  EXPECT_EQ(back.solution.limit_multipliers[0].multiplier, results.solution.limit_multipliers[0].multiplier);
  EXPECT_EQ(back.name, results.name);
  EXPECT_EQ(back.certificate->kkt, 1e-300);
  EXPECT_TRUE(std::isnan(back.certificate->rest_error));
  ASSERT_TRUE(back.certificate->clearance);
  EXPECT_EQ(back.certificate->clearance->gap, results.certificate->clearance->gap);
  EXPECT_EQ(back.certificate->clearance->time, results.certificate->clearance->time);
  EXPECT_EQ(back.certificate->clearance->first, 1);
  EXPECT_EQ(back.certificate->clearance->second, 2);
  EXPECT_EQ(back.provenance.seed, 18446744073709551615U);
}

// Joints of every kind, springs, dampers, coupled inertia, written and read.
TEST(SolutionFile, the_swimmer_read_back_is_the_same_system) {
  tests::Random random(7);
  int led = 0, coupled = 0, sprung = 0;
  for (int trial = 0; trial < 50; ++trial) {
    maneuver::Problem problem;
    problem.swimmer = tests::random_swimmer(random, 6);
    const model::System system(problem.swimmer);
    result::Results results;
    results.problem = result::resolve(system, problem);
    results.problem.steps = 0;
    results.solution = tests::standing(6, 5);
    const result::Results back = result::parse_solution(result::solution_text(results), "x");
    const model::System again(result::swimmer_of(back.problem));
    ASSERT_EQ(again.velocity_count(), system.velocity_count());
    ASSERT_EQ(again.control_count(), system.control_count());
    for (int i = 0; i < 6; ++i) {
      EXPECT_EQ(again.body(i).mass_matrix, system.body(i).mass_matrix);
      EXPECT_EQ(again.body(i).inertia_matrix, system.body(i).inertia_matrix);
      EXPECT_EQ(again.body(i).coupling_matrix, system.body(i).coupling_matrix);
      coupled += system.body(i).coupled ? 1 : 0;
    }
    for (int j = 0; j < 5; ++j) {
      const model::Joint &one = system.joint(j), &two = again.joint(j);
      EXPECT_EQ(two.kind, one.kind);
      EXPECT_EQ(two.reference_rotation, one.reference_rotation);
      EXPECT_EQ(two.parent_axis, one.parent_axis);
      EXPECT_EQ(two.child_axis, one.child_axis);
      EXPECT_EQ(two.stiffness, one.stiffness);
      EXPECT_EQ(two.damping, one.damping);
      EXPECT_EQ(Eigen::MatrixXd(two.actuation), Eigen::MatrixXd(one.actuation));
      led += one.free() ? 0 : 1;
      sprung += one.stiffness > 0.0 && one.damping > 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(led, 100);
  EXPECT_GT(coupled, 50);
  EXPECT_GT(sprung, 5);
}

TEST(SolutionFile, control_axes_that_confine_a_universal_joint_come_back_to_round_off) {
  tests::Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    maneuver::Problem problem;
    problem.swimmer = tests::random_swimmer(random, 2);
    model::JointDescription& joint = problem.swimmer.joints[0];
    joint.kind = model::JointKind::universal;
    joint.actuated = true;
    joint.axis.reset();
    joint.axes = {Vector3d(lie::exp(joint.reference_rotation) * Vector3d::UnitX()), Vector3d::UnitY()};
    joint.control_axes = {Vector3d((*joint.axes)[0] + 0.5 * lie::exp(joint.reference_rotation) * Vector3d::UnitY())};
    const model::System system(problem.swimmer);
    ASSERT_EQ(system.control_count(), 1);
    const model::System again(result::swimmer_of(result::resolve(system, problem)));
    ASSERT_EQ(again.control_count(), 1);
    const Vector3d one = system.joint(0).actuation.col(0), two = again.joint(0).actuation.col(0);
    EXPECT_NEAR(std::abs(one.dot(two)), 1.0, tests::tolerance(1e-15));
    EXPECT_NEAR(one[1] / one[0], 0.5, tests::tolerance(1e-14));
  }
}

// A march above order 2 has moments at its stages.
result::Results staged_results() {
  result::Results results = tests::sample_results(2);
  tests::SampleNumbers sample;
  for (int k = 0; k < 2; ++k) {
    results.solution.stage_time.push_back({sample.number(), sample.number(), sample.number(), sample.number()});
    results.solution.control_stages.emplace_back();
    for (int s = 0; s < 4; ++s) results.solution.control_stages.back().push_back({sample.vector(), sample.vector()});
  }
  results.solution.divided = {1, 7, sample.number()};
  results.solution.solver.limit_weight = {0.25, 1e7};
  results.solution.solver.work_weight = {3.5, 3.5};
  return results;
}

TEST(SolutionFile, moments_at_stages_divided_steps_and_weights_come_back) {
  const result::Results results = staged_results();
  const std::string text = result::solution_text(results);
  const json document = json::parse(text);
  EXPECT_EQ(document["control_stages"].size(), 2U);
  EXPECT_EQ(document["control_stages"][1][3][1][2].get<double>(), results.solution.control_stages[1][3][1][2]);
  EXPECT_EQ(document["stage_time"][1][2].get<double>(), results.solution.stage_time[1][2]);
  EXPECT_FALSE(json::parse(result::solution_text(tests::sample_results(2))).contains("control_stages"));
  const result::Results back = result::parse_solution(text, "x");
  EXPECT_EQ(back.solution.stage_time, results.solution.stage_time);
  EXPECT_EQ(back.solution.control_stages, results.solution.control_stages);
  EXPECT_EQ(back.solution.divided.substeps, 7);
  EXPECT_EQ(back.solution.solver.limit_weight.value, 0.25);
  EXPECT_EQ(back.solution.solver.limit_weight.largest, 1e7);
  EXPECT_EQ(back.solution.solver.work_weight.largest, 3.5);
  EXPECT_EQ(result::solution_text(back), text);
}

std::vector<std::string> keys_in_order(const nlohmann::ordered_json& object) {
  std::vector<std::string> keys;
  for (const auto& entry : object.items()) keys.push_back(entry.key());
  return keys;
}

// As files of versions before joint angles were stored.
TEST(SolutionFile, without_joint_angles_is_read_and_written_as_it_is) {
  result::Results results = tests::sample_results(3);
  results.solution.joint_angle.clear();
  const std::string text = result::solution_text(results);
  EXPECT_EQ(text.find("joint_angle"), std::string::npos);
  EXPECT_TRUE(result::parse_solution(text, "old.json").solution.joint_angle.empty());
  const tests::TemporaryFolder folder;
  result::write_trajectory(folder.path(), results);
  EXPECT_EQ(result::trajectory_difference(folder.path(), results), "");
}

TEST(SolutionFile, parts_of_a_failure_come_back_and_are_missing_without_one) {
  result::Results results = tests::sample_results(3);
  EXPECT_EQ(result::solution_text(results).find("failure"), std::string::npos);
  results.failure = {"Not solved: \"it\".", "Too few steps.", {"more steps", "another seed"}};
  results.solution.message = results.failure.text();
  const std::string text = result::solution_text(results);
  const result::Results again = result::parse_solution(text, "solution.json");
  EXPECT_EQ(again.failure.missed, results.failure.missed);
  EXPECT_EQ(again.failure.cause, results.failure.cause);
  EXPECT_EQ(again.failure.remedies, results.failure.remedies);
  EXPECT_EQ(result::solution_text(again), text);
}

TEST(SolutionFile, fields_have_the_names_and_the_order_of_the_interface) {
  const auto document = nlohmann::ordered_json::parse(result::solution_text(tests::sample_results(2)));
  using Keys = std::vector<std::string>;
  EXPECT_EQ(keys_in_order(document), (Keys{"schema", "name", "source", "status", "message", "cost", "problem", "time",
                                           "position", "rotation", "control", "joint_angle", "velocity", "momentum",
                                           "limit_multipliers", "certificate", "search", "solver", "provenance"}));
  EXPECT_EQ(keys_in_order(document["problem"]),
            (Keys{"bodies", "joints", "density", "scheme", "time_step", "duration", "steps", "cost_rule", "goal",
                  "control", "effort", "time_weight", "limits", "waypoints", "tolerance"}));
  EXPECT_EQ(keys_in_order(document["momentum"]["angular"]), (Keys{"bodies", "fluid", "total"}));
  const Keys proof{"goal_error",
                   "rest_error",
                   "momentum_drift",
                   "momentum_round_off",
                   "rotation_drift",
                   "iterates_momentum",
                   "equation_residual",
                   "start_error",
                   "control_error",
                   "time_error",
                   "velocity_error",
                   "cost_error",
                   "clearance",
                   "kkt",
                   "kkt_round_off",
                   "second_order",
                   "second_order_all_axes",
                   "verdict",
                   "resolved",
                   "replay",
                   "refinement"};
  EXPECT_EQ(keys_in_order(document["certificate"]), proof);
  EXPECT_EQ(document["certificate"]["verdict"], "proved local minimum");
  EXPECT_EQ(document["certificate"]["second_order_all_axes"]["negative_eigenvalues"], 14);
  EXPECT_EQ(document["certificate"]["refinement"]["grids"][1]["cost"], 1.0);
  EXPECT_EQ(document["status"], "optimal");
  EXPECT_EQ(document["problem"]["scheme"], "paper");
  EXPECT_EQ(document["problem"]["goal"]["move"], json::parse(R"([2, "free", "free"])"));
  EXPECT_EQ(document["problem"]["goal"]["rotation"]["back"], "free");
  EXPECT_TRUE(document["certificate"]["refinement"]["cost_error"].is_null());
  EXPECT_TRUE(document["certificate"]["rest_error"].is_null());
  EXPECT_TRUE(document["solver"]["history"][1]["step"].is_null());
}

TEST(SolutionFile, rotations_are_written_row_by_row) {
  const result::Results results = tests::sample_results(2);
  const json document = json::parse(result::solution_text(results));
  const Eigen::Matrix3d& rotation = results.solution.rotation[1][2];
  EXPECT_NE(rotation(0, 1), 0.0);
  EXPECT_EQ(document["rotation"][1][2][0][1].get<double>(), rotation(0, 1));
  EXPECT_EQ(document["rotation"][1][2][2][0].get<double>(), rotation(2, 0));
}

TEST(SolutionFile, a_simulation_has_null_where_a_number_would_mean_nothing) {
  result::Results results = tests::sample_results(2);
  results.solution.status = maneuver::Status::simulated;
  results.solution.cost = std::nan("");
  results.certificate.reset();
  results.solution.search = {};
  results.solution.solver = {};
  results.problem.goal.reset();
  const std::string text = result::solution_text(results);
  const json document = json::parse(text);
  for (const char* field : {"cost", "certificate", "search", "solver"}) EXPECT_TRUE(document[field].is_null()) << field;
  EXPECT_TRUE(document["problem"]["goal"].is_null());
  EXPECT_EQ(result::solution_text(result::parse_solution(text, "x")), text);
}

TEST(SolutionFile, costs_beside_effort_come_back_as_they_were) {
  result::Results results = tests::sample_results(2);
  results.problem.cost_weights = {1.5, 0.25, 0.125, 0.75, 3.0, Vector3d(0.5, 0.0, -2.0)};
  results.solution.cost_parts = maneuver::CostParts{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0};
  results.solution.work_multipliers.assign(results.problem.joints.size(),
                                           std::vector<double>(results.solution.time.size(), -0.5));
  results.certificate->costs = evidence::CostsKept{1e-16, 1e-9};
  const std::string text = result::solution_text(results);
  const result::Results back = result::parse_solution(text, "x");
  EXPECT_EQ(result::solution_text(back), text);
  EXPECT_EQ(back.problem.cost_weights.transport, 3.0);
  EXPECT_EQ(back.problem.cost_weights.displacement, Vector3d(0.5, 0.0, -2.0));
  EXPECT_EQ(back.problem.cost_weights.angular_velocity, 0.75);
  EXPECT_EQ(back.solution.cost_parts->angular_velocity, 5.0);
  EXPECT_EQ(back.solution.cost_parts->transport, 7.0);
  EXPECT_EQ(back.solution.work_multipliers.back().back(), -0.5);
  EXPECT_EQ(json::parse(text)["cost_parts"]["work"], 2.0);
}

// Written before angular velocity could cost; read and written again they are what they were.
TEST(SolutionFile, costs_of_older_files_do_not_tell_of_angular_velocity) {
  result::Results results = tests::sample_results(2);
  results.problem.cost_weights.work = 1.5;
  results.solution.cost_parts = maneuver::CostParts{.effort = 1.0, .work = 2.0, .angular_velocity = 5.0};
  json older = json::parse(result::solution_text(results));
  older["cost_parts"].erase("angular_velocity");
  older["problem"]["cost_weights"].erase("angular_velocity");
  const result::Results back = result::parse_solution(older.dump(), "x");
  EXPECT_EQ(back.problem.cost_weights.angular_velocity, 0.0);
  EXPECT_TRUE(std::isnan(back.solution.cost_parts->angular_velocity));
  EXPECT_FALSE(json::parse(result::solution_text(back))["cost_parts"].contains("angular_velocity"));
}

// What is read as nothing would be proved without it.
TEST(SolutionFile, of_a_question_with_keys_that_nobody_knows_is_not_read) {
  result::Results results = tests::sample_results(2);
  results.problem.limits.spheres = {{Eigen::Vector3d(1.0, 2.0, 3.0), 0.5}};
  results.problem.limits.half_spaces = {{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitX()}};
  const std::string text = result::solution_text(results);
  EXPECT_NO_THROW(result::parse_solution(text, "x"));
  const auto refused_at = [&](const std::vector<const char*>& path, const char* key) -> std::string {
    json changed = json::parse(text);
    json* place = &changed["problem"];
    for (const char* member : path) place = &(*place)[member];
    if (place->is_array()) place = &place->at(0);
    (*place)[key] = 0.001;
    try {
      result::parse_solution(changed.dump(), "x");
    } catch (const model::InputError& error) {
      return error.key;
    }
    return "";
  };
  EXPECT_EQ(refused_at({}, "gravity"), "/problem/gravity");
  EXPECT_EQ(refused_at({"limits"}, "torqe"), "/problem/limits/torqe");
  EXPECT_EQ(refused_at({"goal"}, "angel"), "/problem/goal/angel");
  EXPECT_EQ(refused_at({"start"}, "spin"), "/problem/start/spin");
  EXPECT_EQ(refused_at({"limits", "sphere"}, "diameter"), "/problem/limits/sphere/0/diameter");
  EXPECT_EQ(refused_at({"limits", "half_space"}, "offset"), "/problem/limits/half_space/0/offset");
}

struct Dataset {
  std::vector<hsize_t> shape;
  std::vector<double> values;
  std::string unit;
};

Dataset read_dataset(const std::string& path, const std::string& name) {
  Dataset result;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(dataset);
  result.shape.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, result.shape.data(), nullptr);
  result.values.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.values.data());
  const hid_t attribute = H5Aopen(dataset, "unit", H5P_DEFAULT);
  const hid_t type = H5Aget_type(attribute);
  result.unit.resize(H5Tget_size(type));
  H5Aread(attribute, type, result.unit.data());
  H5Tclose(type);
  H5Aclose(attribute);
  H5Sclose(space);
  H5Dclose(dataset);
  H5Fclose(file);
  return result;
}

TEST(TrajectoryFile, datasets_have_the_names_shapes_units_and_numbers_of_the_solution) {
  const tests::TemporaryFolder folder;
  const result::Results results = tests::sample_results(6);
  result::write_trajectory(folder.path(), results);
  const std::string path = folder / "trajectory.h5";
  using Shape = std::vector<hsize_t>;
  const std::vector<std::tuple<std::string, Shape, std::string>> expected = {
      {"time", {7}, "s"},
      {"position", {7, 3}, "m"},
      {"rotation", {7, 3, 3, 3}, "1"},
      {"control", {7, 2, 3}, "N m"},
      {"joint_angle", {7, 2, 3}, "rad"},
      {"velocity/linear", {7, 3}, "m/s"},
      {"velocity/angular", {7, 3, 3}, "rad/s"},
      {"momentum/linear/bodies", {7, 3}, "kg m/s"},
      {"momentum/linear/fluid", {7, 3}, "kg m/s"},
      {"momentum/linear/total", {7, 3}, "kg m/s"},
      {"momentum/angular/bodies", {7, 3}, "kg m²/s"},
      {"momentum/angular/fluid", {7, 3}, "kg m²/s"},
      {"momentum/angular/total", {7, 3}, "kg m²/s"}};
  for (const auto& [name, shape, unit] : expected) {
    SCOPED_TRACE(name);
    const Dataset dataset = read_dataset(path, name);
    EXPECT_EQ(dataset.shape, shape);
    EXPECT_EQ(dataset.unit, unit);
  }
  const Dataset rotation = read_dataset(path, "rotation");
  EXPECT_EQ(rotation.values[(4 * 3 + 1) * 9 + 5], results.solution.rotation[4][1](1, 2));
  const Dataset total = read_dataset(path, "momentum/angular/total");
  EXPECT_EQ(total.values[3 * 5 + 2], results.solution.angular_momentum.total[5][2]);
}

std::vector<std::string> read_names(const std::string& path, const char* attribute_name) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t attribute = H5Aopen(file, attribute_name, H5P_DEFAULT);
  const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
  const std::size_t longest = H5Tget_size(type);
  std::string padded(longest * static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)), '\0');
  H5Aread(attribute, type, padded.data());
  std::vector<std::string> names;
  for (std::size_t begin = 0; begin < padded.size(); begin += longest)
    names.emplace_back(padded.substr(begin, longest).c_str());
  H5Sclose(space);
  H5Tclose(type);
  H5Aclose(attribute);
  H5Fclose(file);
  return names;
}

TEST(TrajectoryFile, tells_the_names_of_bodies_and_joints) {
  const tests::TemporaryFolder folder;
  result::Results results = tests::sample_results(6);
  results.problem.bodies[2].name = "Flosse für hinten";
  result::write_trajectory(folder.path(), results);
  EXPECT_EQ(
      read_names(folder / "trajectory.h5", "bodies"),
      (std::vector<std::string>{results.problem.bodies[0].name, results.problem.bodies[1].name, "Flosse für hinten"}));
  EXPECT_EQ(read_names(folder / "trajectory.h5", "joints"),
            (std::vector<std::string>{results.problem.joints[0].name, results.problem.joints[1].name}));
  results.problem.joints.clear();  // a single body
  results.problem.bodies.resize(1);
  for (auto& control : results.solution.control) control.clear();
  for (auto& angle : results.solution.joint_angle) angle.clear();
  for (auto& rotation : results.solution.rotation) rotation.resize(1);
  for (auto& rate : results.solution.angular_velocity) rate.resize(1);
  result::write_trajectory(folder / "alone", results);
  EXPECT_TRUE(read_names(folder / "alone/trajectory.h5", "joints").empty());
}

TEST(TrajectoryFile, moments_at_stages_have_their_datasets) {
  const tests::TemporaryFolder folder;
  const result::Results results = staged_results();
  result::write_trajectory(folder.path(), results);
  const Dataset control = read_dataset(folder / "trajectory.h5", "control_stages");
  EXPECT_EQ(control.shape, (std::vector<hsize_t>{2, 4, 2, 3}));
  EXPECT_EQ(control.unit, "N m");
  EXPECT_EQ(control.values[((1 * 4 + 2) * 2 + 1) * 3], results.solution.control_stages[1][2][1][0]);
  const Dataset time = read_dataset(folder / "trajectory.h5", "stage_time");
  EXPECT_EQ(time.shape, (std::vector<hsize_t>{2, 4}));
  EXPECT_EQ(time.values[5], results.solution.stage_time[1][1]);
}

TEST(TrajectoryFile, a_second_writing_gives_the_same_bytes) {
  const tests::TemporaryFolder folder;
  const result::Results results = tests::sample_results(6);
  result::write_trajectory(folder / "first", results);
  const auto begin = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(1100))
    continue;  // HDF5 would stamp whole seconds
  result::write_trajectory(folder / "second", results);
  const std::string first = tests::bytes_of(folder / "first/trajectory.h5");
  EXPECT_GT(first.size(), 1000U);
  EXPECT_EQ(first, tests::bytes_of(folder / "second/trajectory.h5"));
}

void write_number(const std::string& path, const std::string& name, std::size_t entry, double number) {
  Dataset all = read_dataset(path, name);
  all.values[entry] = number;
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
  H5Dwrite(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.values.data());
  H5Dclose(dataset);
  H5Fclose(file);
}

TEST(TrajectoryFile, any_changed_number_is_a_difference_told_with_its_place) {
  const tests::TemporaryFolder folder;
  const result::Results results = staged_results();
  const std::string path = folder / "trajectory.h5";
  EXPECT_EQ(result::trajectory_difference(folder.path(), results), "");  // no file
  for (const result::ShapedArray& array : result::shaped_arrays(results)) {
    SCOPED_TRACE(array.path());
    result::write_trajectory(folder.path(), results);
    EXPECT_EQ(result::trajectory_difference(folder.path(), results), "");
    const std::size_t last = array.values.size() - 1;
    const double told = array.values[last];
    write_number(path, array.path(), last, std::nextafter(told, 1e300));
    std::string place = array.path();
    for (const std::size_t length : array.shape) place += "[" + std::to_string(length - 1) + "]";
    EXPECT_EQ(result::trajectory_difference(folder.path(), results).rfind(place + " is ", 0), 0U)
        << result::trajectory_difference(folder.path(), results);
    write_number(path, array.path(), last, std::nan(""));
    EXPECT_EQ(result::trajectory_difference(folder.path(), results).rfind(place + " is nan, not ", 0), 0U);
  }
}

TEST(TrajectoryFile, names_and_units_of_another_answer_are_a_difference) {
  const tests::TemporaryFolder folder;
  const result::Results results = staged_results();
  result::Results renamed = results;
  renamed.problem.bodies.back().name = "tail";
  result::write_trajectory(folder.path(), renamed);
  const std::string told = result::trajectory_difference(folder.path(), results);
  EXPECT_EQ(told.rfind("bodies is \"", 0), 0U) << told;
  EXPECT_NE(told.find("\"tail\", not \""), std::string::npos) << told;
  result::write_trajectory(folder.path(), results);
  const std::string path = folder / "trajectory.h5";
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  const hid_t time = H5Dopen2(file, "time", H5P_DEFAULT);
  const hid_t unit = H5Aopen(time, "unit", H5P_DEFAULT), type = H5Aget_type(unit);
  ASSERT_EQ(H5Tget_size(type), 1U);
  EXPECT_GE(H5Awrite(unit, type, "h"), 0);
  H5Tclose(type);
  H5Aclose(unit);
  H5Dclose(time);
  H5Fclose(file);
  EXPECT_EQ(result::trajectory_difference(folder.path(), results), "time: unit is \"h\", not \"s\"");
}

TEST(TrajectoryFile, of_another_answer_differs_by_its_shapes_and_without_an_array_by_its_name) {
  const tests::TemporaryFolder folder;
  result::write_trajectory(folder.path(), tests::sample_results(6));
  EXPECT_EQ(result::trajectory_difference(folder.path(), tests::sample_results(7)), "time is [7], not [8]");
  const std::string path = folder / "trajectory.h5";
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  H5Ldelete(file, "momentum/linear", H5P_DEFAULT);
  H5Fclose(file);
  EXPECT_EQ(result::trajectory_difference(folder.path(), tests::sample_results(6)),
            "momentum/linear/bodies is missing");
}

TEST(TrajectoryFile, that_is_no_HDF5_is_refused_with_what_to_do) {
  const tests::TemporaryFolder folder;
  std::ofstream(folder / "trajectory.h5") << "no HDF5";
  try {
    result::trajectory_difference(folder.path(), tests::sample_results(2));
    FAIL();
  } catch (const document::IoError& error) {
    EXPECT_EQ(std::string(error.what()),
              folder / "trajectory.h5" +
                  std::string(": cannot be read as HDF5; write it anew with solve or simulate, or delete it"));
  }
}

}  // namespace
}  // namespace lamprey
