// A maneuver solved, then followed with feedback through the program.
#include <gtest/gtest.h>

#include "lie/so3.hpp"
#include "solved_example.hpp"
#include "task/tasks.hpp"

namespace lamprey::tests {
namespace {

class Following : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<Folder>();
    problem_ = varied_example(*folder_, "rotation", {{"steps", "200"}, {"starts", "4"}});
    const ProgramRun run = lamprey(*folder_, "solve " + problem_ + " --out " + (*folder_ / "solved"));
    ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static ProgramRun simulate(const std::string& arguments, const std::string& problem = problem_) {
    return lamprey(*folder_, "simulate " + problem + " --out " + (*folder_ / "run") + " " + arguments);
  }
  static maneuver::Tracking tracking() {
    return result::read_solution(*folder_ / "run").solution.tracking.value_or(maneuver::Tracking{"", INFINITY});
  }
  static std::string solved() { return *folder_ / "solved"; }

  static std::unique_ptr<Folder> folder_;
  static std::string problem_;
};
std::unique_ptr<Folder> Following::folder_;
std::string Following::problem_;

TEST_F(Following, certificate_tells_the_whole_replay_with_feedback) {
  const result::Results results = result::read_solution(solved());
  const certificate::Replay& replay = *results.certificate->replay;
  EXPECT_LE(replay.feedback_rotation_error, tolerance(1e-2));
  EXPECT_LE(replay.feedback_rotation_error, 0.1 * replay.whole_rotation_error);
  EXPECT_EQ(results.solution.feedback.gain.size(), 201U);
  const ProgramRun run = lamprey(*folder_, "verify " + solved());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.out.find("✓ Replay with feedback, rotation"), std::string::npos) << run.out;
}

TEST_F(Following, holds_a_perturbed_start_with_the_scheme_with_others_and_in_continuous_time) {
  for (const char* how : {"", "--reference", "--scheme order4 --steps 60", "--scheme midpoint --steps 500"}) {
    const ProgramRun run = simulate("--feedback " + solved() + " --perturb 1e-3 --seed 3 " + how);
    ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
    EXPECT_LE(tracking().rotation_error, tolerance(1e-2)) << how;
    EXPECT_GT(tracking().largest_rotation_error, 9e-4) << how;
    EXPECT_NE(run.out.find("Off the plan at the end"), std::string::npos);
  }
}

// A vehicle off its plan that stops on the way and goes on by the rest of the plan ends where one ends that does not stop.
TEST_F(Following, goes_on_in_the_midst_of_a_plan_from_where_the_swimmer_is) {
  const file::ProblemFile problem = file::read_problem_file(problem_);
  task::MarchOptions options{.reference = true, .perturb = 1e-2};
  options.followed = result::read_solution(solved());
  const maneuver::Solution whole = task::march_task(problem, options, "").solution;
  const std::size_t stop = 90;
  file::ProblemFile on_the_way = problem;
  maneuver::Start& start = on_the_way.problem.start;
  for (std::size_t i = 0; i < start.rotation.size(); ++i) start.rotation[i] = lie::log(whole.rotation[stop][i]);
  start.position = whole.position[stop];
  start.angular_velocity = whole.angular_velocity[stop];
  start.linear_velocity = whole.rotation[stop][0] * whole.linear_velocity[stop];
  options.perturb = 0.0;
  options.followed_from = whole.time[stop];
  const result::Results rest = task::march_task(on_the_way, options, "");
  ASSERT_EQ(rest.solution.time.size(), whole.time.size() - stop);
  for (std::size_t k = 0; k < rest.solution.time.size(); ++k)
    for (std::size_t i = 0; i < start.rotation.size(); ++i)
      EXPECT_LE((rest.solution.rotation[k][i] - whole.rotation[stop + k][i]).norm(), tolerance(1e-7));
  EXPECT_NEAR(rest.solution.tracking->rotation_error, whole.tracking->rotation_error, tolerance(1e-7));
  EXPECT_LE((rest.solution.control[7][0] - whole.control[stop + 7][0]).norm(), tolerance(1e-7) * 1e3);
  EXPECT_NE(rest.solution.message.find("takes 1 s, of which this march has 0.45 s to 1 s."), std::string::npos)
      << rest.solution.message;
}

TEST_F(Following, has_a_rest_until_its_plan_ends) {
  const ProgramRun run = simulate("--feedback " + solved() + " --feedback-from 1");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_EQ(run.err,
            "feedback_from: found 1 s of a maneuver that takes 1 s; allowed: less than that; set a smaller "
            "--feedback-from\n");
}

// Motors a tenth weaker than the plan asks for.
TEST_F(Following, gives_no_more_than_the_problems_limits_of_torque_and_says_how_often_it_would) {
  double most = 0.0;
  for (const auto& node : result::read_solution(solved()).solution.control)
    for (const Eigen::Vector3d& moment : node) most = std::max(most, 0.9 * moment.norm());
  const std::string weak = *folder_ / "weak.toml";
  std::ofstream(weak) << text_of(problem_) << "\n[limits]\ntorque = " << most << '\n';
  const ProgramRun run = simulate("--feedback " + solved() + " --perturb 1e-3 --seed 3", weak);
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const maneuver::Tracking followed = tracking();
  EXPECT_GT(followed.cut_share, 0.01);
  EXPECT_LT(followed.cut_share, 0.5);
  EXPECT_LE(followed.rotation_error, tolerance(1e-2));
  EXPECT_NE(run.out.find("Limits of torque"), std::string::npos) << run.out;
  for (const auto& node : result::read_solution(*folder_ / "run").solution.control)
    for (const Eigen::Vector3d& moment : node) EXPECT_LE(moment.norm(), (1.0 + tolerance(1e-5)) * most);
  EXPECT_EQ(lamprey(*folder_, "verify " + (*folder_ / "run")).exit_code, 0);
}

// Bodies up to 3 % heavier or lighter than the plan knows: gains bring them to its end, moments alone do not.
TEST_F(Following, bears_inertia_that_differs_from_the_plans) {
  const std::string heavier = " --perturb-inertia 0.03 --seed 2";
  const ProgramRun followed = simulate("--feedback " + solved() + heavier);
  ASSERT_EQ(followed.exit_code, 0) << followed.err;
  EXPECT_NE(followed.out.find("times what the file says: middle "), std::string::npos) << followed.out;
  const result::Results run = result::read_solution(*folder_ / "run"), plan = result::read_solution(solved());
  for (std::size_t i = 0; i < 3; ++i) {
    const double factor = run.problem.bodies[i].mass_matrix(0, 0) / plan.problem.bodies[i].mass_matrix(0, 0);
    EXPECT_GT(std::abs(factor - 1.0), 1e-4);
    EXPECT_LE(std::abs(factor - 1.0), 0.03);
    EXPECT_NEAR(run.problem.bodies[i].inertia_matrix(2, 2), factor * plan.problem.bodies[i].inertia_matrix(2, 2),
                tolerance(1e-9) * run.problem.bodies[i].inertia_matrix(2, 2));
  }
  EXPECT_LE(tracking().rotation_error, tolerance(0.02));
  EXPECT_EQ(lamprey(*folder_, "verify " + (*folder_ / "run")).exit_code, 0);
  ASSERT_EQ(simulate("--controls " + solved() + "/solution.json" + heavier).exit_code, 0);
  const auto open = result::read_solution(*folder_ / "run").solution.rotation.back();
  EXPECT_GT(lie::rotation_angle(open[0].transpose() * plan.solution.rotation.back()[0]), 0.1);
}

// A swimmer four times as heavy at its front as its plan knows is lost by the gains, and not by motors that could give anything.
TEST_F(Following, lost_for_the_swimmers_sake_does_not_blame_its_motors) {
  std::string text = text_of(problem_);
  const std::string mark = "mass_matrix = [0.2664, 0.6551, 0.3677]";
  text.replace(text.find(mark), mark.size(), "mass_matrix = [1.1, 2.6, 1.5]");
  const std::string heavy = *folder_ / "heavy.toml";
  std::ofstream(heavy) << text << "\n[limits]\ntorque = 1e5\n";
  const ProgramRun run = simulate("--feedback " + solved(), heavy);
  ASSERT_EQ(run.exit_code, 5) << "steps do not follow it" << run.out << run.err;  // but what it came to is there
  ASSERT_TRUE(tracking().lost()) << tracking().rotation_error;
  ASSERT_TRUE(tracking().off_from);
  EXPECT_FALSE(tracking().cut_first());
  EXPECT_NE(run.err.find("its gains answer smaller"), std::string::npos) << run.err;
  EXPECT_EQ(run.err.find("motors are at their limits"), std::string::npos) << run.err;
}

// A plan whose moments stand at their limits leaves motors nothing to answer with: what the certificate says of its feedback is what a
// march by the reference integrator finds.
TEST_F(Following, of_a_plan_at_its_limits_is_certified_with_the_motors_that_it_has) {
  const Folder own;
  const std::string hurried =
      varied_example(own, "free_time", {{"steps", "100"}, {"starts", "1"}, {"torque", "200.0"}, {"time", "1e6"}});
  ASSERT_EQ(lamprey(own, "solve " + hurried + " --no-refinement --out " + (own / "plan")).exit_code, 0);
  const result::Results plan = result::read_solution(own / "plan");
  ASSERT_TRUE(plan.certificate && plan.certificate->replay);
  const ProgramRun run = simulate("--feedback " + (own / "plan") + " --reference", hurried);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(tracking().cut_share, 0.5);
  const double error = plan.certificate->replay->feedback_rotation_error;
  EXPECT_GT(error, 0.1);
  EXPECT_NEAR(tracking().rotation_error, error, 0.02 * error);
}

TEST_F(Following, on_the_plan_stays_on_it) {
  ASSERT_EQ(simulate("--feedback " + solved()).exit_code, 0);
  EXPECT_LE(tracking().largest_rotation_error, tolerance(1e-10));
  EXPECT_EQ(tracking().maneuver, "Rotation about the long axis");
  EXPECT_EQ(lamprey(*folder_, "verify " + (*folder_ / "run")).exit_code, 0);
}

TEST_F(Following, by_the_reference_integrator_claims_no_discrete_equations) {
  ASSERT_EQ(simulate("--feedback " + solved() + " --reference --perturb 1e-3").exit_code, 0);
  const ProgramRun run = lamprey(*folder_, "verify " + (*folder_ / "run"));
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out.find("✗"), std::string::npos) << run.out;
  EXPECT_NE(result::read_solution(*folder_ / "run").solution.marched_by, "");
}

TEST_F(Following, says_what_does_not_fit) {
  const ProgramRun other = simulate("--feedback " + solved(), example("hinge_fins"));
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_NE(other.err.find("choose a motion of the same swimmer"), std::string::npos) << other.err;
  EXPECT_EQ(std::count(other.err.begin(), other.err.end(), '\n'), 1);
  EXPECT_EQ(simulate("--feedback " + solved() + " --duration 2").exit_code, 3);
  EXPECT_EQ(simulate("--feedback " + (*folder_ / "nowhere")).exit_code, 6);
  EXPECT_EQ(simulate("--feedback " + solved() + " --controls " + solved() + "/solution.json").exit_code, 2);
  EXPECT_EQ(simulate("--reference --scheme midpoint").exit_code, 2);
  EXPECT_EQ(simulate("--perturb -1").exit_code, 2);
  ASSERT_EQ(simulate("").exit_code, 0);
  const ProgramRun bare = simulate("--feedback " + (*folder_ / "run"));
  EXPECT_EQ(bare.exit_code, 3);
  EXPECT_NE(bare.err.find("no gains"), std::string::npos) << bare.err;
}

// Its start is part of a gait's answer, bent as the search found it and already moving.
TEST(FollowedGait, begins_as_the_gait_begins) {
  for (const char* name : {"gait", "eel_gait"}) {
    Folder folder;
    ASSERT_EQ(lamprey(folder, "solve " + example(name) + " --no-refinement --out " + (folder / "solved")).exit_code, 0);
    const result::Results gait = result::read_solution(folder / "solved");
    const std::string march = "simulate " + example(name) + " --out " + (folder / "run");
    for (const std::string& how :
         {"--feedback " + (folder / "solved"), "--controls " + (folder / "solved/solution.json")}) {
      ASSERT_EQ(lamprey(folder, march + " " + how).exit_code, 0) << how;
      const result::Results run = result::read_solution(folder / "run");
      double off = 0.0;
      for (std::size_t k = 0; k < gait.solution.rotation.size(); ++k)
        for (std::size_t i = 0; i < gait.solution.rotation[k].size(); ++i)
          off = std::max(off, (run.solution.rotation[k][i] - gait.solution.rotation[k][i]).norm());
      EXPECT_LE(off, tolerance(1e-6)) << name << " " << how;
      EXPECT_EQ(lamprey(folder, "verify " + (folder / "run")).exit_code, 0) << name << " " << how;
    }
  }
}

// A plan that the swimmer finds itself elsewhere for goes with it, gains and all.
TEST(FollowedGait, begins_where_the_problem_says) {
  const Folder folder;
  ASSERT_EQ(lamprey(folder, "solve " + example("gait") + " --no-refinement --out " + (folder / "solved")).exit_code, 0);
  const maneuver::Solution gait = result::read_solution(folder / "solved").solution;
  const Eigen::Vector3d turn(0.3, -0.2, 1.1), position(5.0, 1.0, -2.0);
  std::string text = text_of(example("gait"));
  const std::string start = "[start]\n";
  ASSERT_NE(text.find(start), std::string::npos);
  std::string moved = start + "position = [5.0, 1.0, -2.0]\n";
  for (const char* body : {"middle", "front", "back"})
    moved += "rotation." + std::string(body) + " = [0.3, -0.2, 1.1]\n";
  text.replace(text.find(start), start.size(), moved);
  text = std::regex_replace(text, std::regex("\nrotation\\.back *= *\\[0\\.0[^\n]*"), "");
  std::ofstream(folder / "moved.toml") << text;
  const ProgramRun run = lamprey(folder, "simulate " + (folder / "moved.toml") + " --perturb 1e-5 --feedback " +
                                             (folder / "solved") + " --out " + (folder / "run"));
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const maneuver::Solution marched = result::read_solution(folder / "run").solution;
  const Eigen::Matrix3d heading = lie::exp(turn) * gait.rotation.front()[0].transpose();
  const Eigen::Vector3d end = position + heading * (gait.position.back() - gait.position.front());
  EXPECT_LE((marched.position.back() - end).norm(), tolerance(1e-3));
  EXPECT_LE((marched.rotation.back()[0] - heading * gait.rotation.back()[0]).norm(), tolerance(1e-3));
  const std::string of_moments = lamprey(folder, "simulate " + (folder / "moved.toml") + " --controls " +
                                                     (folder / "solved") + "/solution.json --out " + (folder / "run"))
                                     .out;
  EXPECT_NE(of_moments.find("Simulated"), std::string::npos);
  EXPECT_EQ(of_moments.find("began otherwise"), std::string::npos)
      << "headed otherwise is no other start" << of_moments;
}

// Cycle after cycle the swimmer goes on by the same displacement and in the same shapes, seen from itself.
TEST(FollowedGait, goes_on_for_several_cycles) {
  Folder folder;
  const std::string path =
      varied_example(folder, "gait", {{"steps", "40"}, {"starts", "2"}, {"turn", "[0.0, 0.0, 0.3]"}});
  ASSERT_EQ(lamprey(folder, "solve " + path + " --no-refinement --out " + (folder / "solved")).exit_code, 0);
  const maneuver::Solution gait = result::read_solution(folder / "solved").solution;
  const Eigen::Matrix3d turn = gait.rotation.back()[0] * gait.rotation.front()[0].transpose();
  const Eigen::Vector3d shift = gait.position.back() - turn * gait.position.front();
  const std::string march = "simulate " + path + " --cycles 3 --out " + (folder / "run") + " ";
  for (const std::string& how :
       {"--feedback " + (folder / "solved"), "--controls " + (folder / "solved/solution.json")}) {
    const ProgramRun run = lamprey(folder, march + how);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const maneuver::Solution marched = result::read_solution(folder / "run").solution;
    ASSERT_EQ(marched.time.size(), 121U);
    EXPECT_NEAR(marched.time.back(), 3.0 * gait.time.back(), 1e-12);
    double off = 0.0;
    for (std::size_t k = 0; k + 40 < marched.time.size(); ++k) {
      off = std::max(off, (marched.position[k + 40] - turn * marched.position[k] - shift).norm());
      for (std::size_t i = 0; i < marched.rotation[k].size(); ++i)
        off = std::max(off, (marched.rotation[k + 40][i] - turn * marched.rotation[k][i]).norm());
    }
    EXPECT_LE(off, tolerance(1e-6)) << how;
    EXPECT_GT((marched.position.back() - marched.position.front()).norm(), 2.5 * shift.norm());
    EXPECT_EQ(lamprey(folder, "verify " + (folder / "run")).exit_code, 0) << how;
  }
  // where cycles meet, gains know of the next one
  const Eigen::MatrixXd &first = gait.feedback.gain.front(), &last = gait.feedback.gain.back();
  const Eigen::Index own = first.cols() / 2 - 3;  // turns; what follows is of the world, which has turned
  EXPECT_LE((last.leftCols(own) - first.leftCols(own)).norm(), 0.4 * first.leftCols(own).norm());
  // off the plan only gains that turn with the swimmer lead back to it
  ASSERT_EQ(lamprey(folder, march + "--perturb 1e-3 --reference --feedback " + (folder / "solved")).exit_code, 0);
  EXPECT_LE(result::read_solution(folder / "run").solution.tracking->largest_rotation_error, 0.05);
  const ProgramRun alone = lamprey(folder, march);
  EXPECT_EQ(alone.exit_code, 3);
  EXPECT_NE(alone.err.find("cycles: found a march without a stored motion"), std::string::npos) << alone.err;
  const std::string other = varied_example(folder, "translation", {{"steps", "40"}, {"starts", "2"}});
  ASSERT_EQ(lamprey(folder, "solve " + other + " --no-refinement --out " + (folder / "maneuver")).exit_code, 0);
  const ProgramRun maneuver = lamprey(
      folder, "simulate " + other + " --cycles 2 --feedback " + (folder / "maneuver") + " --out " + (folder / "run"));
  EXPECT_EQ(maneuver.exit_code, 3);
  EXPECT_NE(maneuver.err.find("cycles: found a motion that is not a gait"), std::string::npos) << maneuver.err;
}

// A gait has cycles to come back in: its gains hold the joints along the path and ask for the whole's way by and by, so that they do not
// lose the plan where each body begins nearly six degrees off.
TEST(FollowedGait, comes_back_from_several_degrees) {
  for (const char* name : {"gait", "gait_within_limits", "compliant_tail"}) {
    Folder folder;
    ASSERT_EQ(lamprey(folder, "solve " + example(name) + " --no-refinement --out " + (folder / "solved")).exit_code, 0);
    const ProgramRun run = lamprey(folder, "simulate " + example(name) + " --cycles 3 --perturb 0.1 --feedback " +
                                               (folder / "solved") + " --out " + (folder / "run"));
    ASSERT_EQ(run.exit_code, 0) << name << run.err;
    const maneuver::Tracking tracking = *result::read_solution(folder / "run").solution.tracking;
    EXPECT_FALSE(tracking.lost()) << name;
    EXPECT_LE(tracking.largest_rotation_error, 0.35) << name;
  }
}

// A table of moments of one period is that of as many periods written out; one that does not close has none.
TEST(Simulate, repeats_a_table_that_ends_with_the_moments_it_begins_with) {
  const Folder folder;
  const auto write = [&](const std::string& name, int rows, double last) {
    std::ofstream table(folder / name);
    for (int k = 0; k < rows; ++k) {
      const double t = 0.025 * k, moment = 900.0 * std::sin(2.0 * M_PI * t);
      table << fmt::format("{},0,0,{},0,0,{}\n", t, moment, k + 1 == rows ? last : -0.5 * moment);
    }
  };
  write("period.csv", 41, 0.0);
  write("periods.csv", 121, 0.0);
  const std::string march = "simulate " + example("translation") + " --interpolation linear --out " + (folder / "run");
  const auto marched = [&](const std::string& how) {
    const ProgramRun run = lamprey(folder, march + how);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return result::read_solution(folder / "run").solution;
  };
  const maneuver::Solution repeated = marched(" --cycles 3 --controls " + (folder / "period.csv"));
  const int steps = static_cast<int>(repeated.time.size()) - 1;
  const maneuver::Solution written =
      marched(fmt::format(" --duration 3 --steps {} --controls {}", steps, folder / "periods.csv"));
  EXPECT_NEAR(repeated.time.back(), 3.0, 1e-12);
  EXPECT_EQ(steps % 3, 0) << "as many steps as the problem has, each time";
  EXPECT_LE((repeated.position.back() - written.position.back()).norm(), tolerance(1e-9));
  write("open.csv", 41, 2.0);
  const ProgramRun open = lamprey(folder, march + " --cycles 3 --controls " + (folder / "open.csv"));
  EXPECT_EQ(open.exit_code, 3);
  EXPECT_NE(open.err.find("open.csv: back: found 2 N m between its last and its first moment"), std::string::npos)
      << open.err;
}

}  // namespace
}  // namespace lamprey::tests
