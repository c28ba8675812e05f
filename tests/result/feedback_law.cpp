// Gains, tracking and what marched, in solution.json and trajectory.h5.
#include <gtest/gtest.h>
#include <hdf5.h>

#include <nlohmann/json.hpp>

#include "chains.hpp"
#include "file/samples.hpp"
#include "integrator/feedback_law.hpp"
#include "result/resolve.hpp"
#include "result/result_shapes.hpp"
#include "result/solution_file.hpp"
#include "result/trajectory_file.hpp"

namespace lamprey {
namespace {

using Eigen::MatrixXd;
using nlohmann::json;

result::Results followed_results() {
  result::Results results = tests::sample_results(4);
  tests::SampleNumbers sample;
  results.solution.feedback.time = {-0.1, 0.3, 0.7};
  for (int m = 0; m < 3; ++m) {
    MatrixXd gain(2, 24);
    for (double& entry : gain.reshaped()) entry = sample.number();
    results.solution.feedback.gain.push_back(gain);
  }
  results.solution.marched_by = "another integrator";
  results.solution.tracking = {"a maneuver",    sample.number(), sample.number(),
                               sample.number(), sample.number(), sample.number()};
  results.certificate->replay->feedback_rotation_error = sample.number();
  results.certificate->replay->feedback_position_error = sample.number();
  results.certificate->replay->servo_rotation_error = sample.number();
  results.certificate->replay->servo_position_error = sample.number();
  return results;
}

TEST(FeedbackInFiles, every_number_comes_back_bit_for_bit_and_is_written_again_as_it_was) {
  const result::Results results = followed_results();
  const std::string text = result::solution_text(results);
  const result::Results back = result::parse_solution(text, "x");
  EXPECT_EQ(back.solution.feedback.time, results.solution.feedback.time);
  for (std::size_t m = 0; m < 3; ++m) EXPECT_EQ(back.solution.feedback.gain[m], results.solution.feedback.gain[m]);
  EXPECT_EQ(back.solution.marched_by, "another integrator");
  EXPECT_EQ(back.solution.tracking->maneuver, "a maneuver");
  EXPECT_EQ(back.solution.tracking->largest_correction, results.solution.tracking->largest_correction);
  EXPECT_EQ(back.certificate->replay->feedback_position_error, results.certificate->replay->feedback_position_error);
  EXPECT_EQ(back.certificate->replay->servo_rotation_error, results.certificate->replay->servo_rotation_error);
  EXPECT_EQ(back.certificate->replay->servo_position_error, results.certificate->replay->servo_position_error);
  EXPECT_EQ(result::solution_text(back), text);
  const json document = json::parse(text);
  EXPECT_EQ(document["feedback"]["gain"][2][1][23].get<double>(), results.solution.feedback.gain[2](1, 23));
  EXPECT_FALSE(json::parse(result::solution_text(tests::sample_results(4))).contains("feedback"));
}

// The names of rows and columns against the order that the law itself uses.
TEST(FeedbackInFiles, coordinates_are_named_in_the_order_of_deviations) {
  tests::Random random(5);
  for (int trial = 0; trial < 10; ++trial) {
    maneuver::Problem problem;
    problem.swimmer = tests::random_swimmer(random, 5);
    const model::System system(problem.swimmer);
    const result::ResolvedProblem resolved = result::resolve(system, problem);
    const auto states = result::state_coordinates(resolved);
    const int half = system.velocity_count();
    ASSERT_EQ(states.size(), 2U * static_cast<std::size_t>(half));
    ASSERT_EQ(result::control_coordinates(resolved).size(), static_cast<std::size_t>(system.control_count()));
    const mechanics::Rotations R = tests::random_rotations(random, system);
    const integrator::ReferenceState here{R, Eigen::Vector3d::Zero(), Eigen::VectorXd::Zero(half)};
    for (int i = 0; i < system.body_count(); ++i)
      for (int f = 0; f < system.body(i).freedoms; ++f) {
        mechanics::Freedoms turn(R.size(), Eigen::Vector3d::Zero());
        turn[model::at(i)][f] = 1e-3;
        const Eigen::VectorXd off =
            integrator::deviation(system, here, {tests::turned(system, R, turn), here.position, here.velocity});
        Eigen::Index place = 0;
        EXPECT_NEAR(off.cwiseAbs().maxCoeff(&place), 1e-3, 1e-12);
        const result::StateCoordinate& named = states[static_cast<std::size_t>(place)];
        const bool led = system.body(i).freedoms < 3;
        EXPECT_EQ(named.quantity, led ? "angle" : "turn");
        EXPECT_EQ(named.of, led ? system.joint(system.body(i).joint).name : system.body(i).name);
        EXPECT_EQ(named.axis, f);
        EXPECT_EQ(states[static_cast<std::size_t>(place + half)].quantity, led ? "angle_rate" : "angular_velocity");
      }
    EXPECT_EQ(states[static_cast<std::size_t>(half - 2)].quantity, "position");
    EXPECT_EQ(states.back().unit, "m/s");
  }
}

TEST(FeedbackInFiles, gains_have_their_datasets) {
  const tests::TemporaryFolder folder;
  result::write_trajectory(folder.path(), followed_results());
  const hid_t file = H5Fopen((folder / "trajectory.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t gain = H5Dopen2(file, "feedback/gain", H5P_DEFAULT);
  const hid_t space = H5Dget_space(gain);
  std::array<hsize_t, 3> shape{};
  ASSERT_EQ(H5Sget_simple_extent_dims(space, shape.data(), nullptr), 3);
  EXPECT_EQ(shape, (std::array<hsize_t, 3>{3, 2, 24}));
  H5Sclose(space);
  H5Dclose(gain);
  H5Fclose(file);
}

}  // namespace
}  // namespace lamprey
