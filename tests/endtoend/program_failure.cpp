#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <numbers>

#include "program.hpp"
#include "result/solution_file.hpp"

namespace lamprey::tests {
namespace {

namespace fs = std::filesystem;

TEST(Program, refuses_every_malformed_problem_with_code_3_and_leaves_no_folder) {
  const Folder folder;
  int files = 0;
  for (const auto& entry : fs::directory_iterator(std::string(LAMPREY_SOURCE_DIR) + "/tests/file/malformed")) {
    if (entry.path().extension() != ".toml") continue;
    const ProgramRun run = lamprey(folder, "solve " + entry.path().string() + " --out " + (folder / "run"));
    EXPECT_EQ(run.exit_code, 3) << entry.path() << run.err;
    EXPECT_EQ(run.err.rfind(entry.path().string() + ":", 0), 0U) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(fs::exists(folder / "run")) << entry.path();
    ++files;
  }
  EXPECT_GE(files, 132);
}

TEST(Program, tells_usage_input_output_and_missing_files_apart) {
  const Folder folder;
  EXPECT_EQ(lamprey(folder, "").exit_code, 2);
  EXPECT_EQ(lamprey(folder, "swim").exit_code, 2);
  EXPECT_NE(lamprey(folder, "solv x")
                .err.find("found \"solv\"; allowed: solve, simulate, check, verify, report, export, inertia, "
                          "bench; did you mean \"solve\"?"),
            std::string::npos);
  EXPECT_EQ(lamprey(folder, "solve " + example("translation")).exit_code, 2);
  for (const auto& [typed, meant] : {std::pair("--threads 2", "--workers"), std::pair("--ouput=3", "--out"),
                                     std::pair("--startes 5", "--starts"), std::pair("-j4 --seed 1", "--workers")}) {
    const ProgramRun run = lamprey(folder, "solve " + example("translation") + " " + typed + " --out x");
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find(fmt::format("did you mean \"{}\"?", meant)), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  EXPECT_EQ(lamprey(folder, "solve " + (folder / "nowhere.toml") + " --out " + (folder / "run")).exit_code, 6);
  EXPECT_EQ(lamprey(folder, "verify " + (folder / "nowhere")).exit_code, 6);
  EXPECT_EQ(lamprey(folder, "--version").exit_code, 0);
  EXPECT_EQ(lamprey(folder, "--help").exit_code, 0);
  std::ofstream(folder / "file") << "in the way";
  EXPECT_EQ(lamprey(folder, "simulate " + example("tumble") + " --steps 10 --duration 0.01 --out " + (folder / "file"))
                .exit_code,
            6);
}

TEST(Program, notices_a_folder_that_cannot_be_written_before_it_searches) {
  const Folder folder;
  std::ofstream(folder / "file") << "in the way";
  const ProgramRun run = lamprey(folder, "solve " + example("translation") + " --out " + (folder / "file/run"));
  EXPECT_EQ(run.exit_code, 6);
  EXPECT_EQ(run.err.find("first guess 1"), std::string::npos) << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
}

TEST(Program, prints_one_json_document_and_the_same_bytes_again) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation", {{"steps", "40"}, {"starts", "2"}});
  const ProgramRun one = lamprey(folder, "solve " + problem + " --json --workers 1 --out " + (folder / "one"));
  const ProgramRun two = lamprey(folder, "solve " + problem + " --json --workers 2 --out " + (folder / "two"));
  ASSERT_EQ(one.exit_code, 0) << one.err;
  auto first = nlohmann::json::parse(one.out);
  auto second = nlohmann::json::parse(two.out);
  for (auto* document : {&first, &second}) {
    document->erase("provenance");
    for (const char* time : {"wall_seconds", "processor_seconds", "total_wall_seconds"})
      (*document)["solver"].erase(time);
  }
  EXPECT_EQ(first.dump(), second.dump());
}

TEST(Program, says_why_a_goal_out_of_reach_was_not_met) {
  const Folder folder;  // joints that bend about e_3 cannot roll the swimmer
  const std::string problem = varied_example(
      folder, "translation", {{"steps", "40"}, {"starts", "1\ntime_limit = 5.0"}, {"turn", "[0.5, 0.0, 0.0]"}});
  const ProgramRun run = lamprey(folder, "solve " + problem + " --out " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 4) << run.out << run.err;
  const result::Results results = result::read_solution(folder / "run");
  EXPECT_NE(results.solution.status, maneuver::Status::optimal);
  EXPECT_NE(results.solution.message.find("Out of reach"), std::string::npos) << results.solution.message;
  EXPECT_NE(run.out.find("Out of reach: the joints' moments turn middle about e₃ alone"), std::string::npos) << run.out;
}

TEST(Program, writes_its_best_point_when_interrupted) {
  const Folder folder;
  const std::string out = folder / "run";
  const std::string command = "sh -c '" + std::string(LAMPREY_PROGRAM) + " solve " + example("translation_in_space") +
                              " --workers 1 --out " + out + " >/dev/null 2>&1 & P=$!; sleep 2; kill -INT $P; wait $P'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_EQ(result::read_solution(out).solution.status, maneuver::Status::interrupted);
}

// The second time nothing is refined any more, and yet nothing is lost.
TEST(Program, writes_its_best_point_when_interrupted_twice) {
  const Folder folder;
  const std::string out = folder / "run", errors = folder / "errors";
  const std::string problem = varied_example(folder, "translation_in_space", {{"steps", "20000"}});
  const std::string command = "sh -c '" + std::string(LAMPREY_PROGRAM) + " solve " + problem + " --workers 1 --out " +
                              out + " >/dev/null 2>" + errors +
                              " & P=$!; while kill -0 $P && ! grep -q \"first guess 2\" " + errors +
                              "; do sleep 0.1; done; kill -INT $P; sleep 0.2; kill -INT $P; wait $P'";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 130);
  const maneuver::Solution solution = result::read_solution(out).solution;
  EXPECT_EQ(solution.status, maneuver::Status::interrupted);
  EXPECT_EQ(solution.message.find("nan"), std::string::npos) << solution.message;
  EXPECT_NE(text_of(errors).find("lamprey: interrupted"), std::string::npos) << text_of(errors);
}

TEST(Program, takes_a_first_motion_of_the_same_swimmer_alone) {
  const Folder folder;
  const std::string found = folder / "found", again = folder / "again";
  ASSERT_EQ(lamprey(folder, "solve " + example("translation") + " --out " + found).exit_code, 0);
  const auto begun = [&](const std::string& problem, const std::string& first) {
    return lamprey(folder, "solve " + example(problem) + " --starts 1 --seed 7 --time-limit 60 --first " + first +
                               " --out " + again);
  };
  EXPECT_EQ(begun("translation", found).exit_code, 0);
  const result::Results results = result::read_solution(again);
  EXPECT_EQ(results.solution.search.starts, 1);
  EXPECT_EQ(results.provenance.seed, 7U);
  const ProgramRun other = begun("eel_gait", found);
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_NE(other.err.find("found 3 bodies; allowed: 10"), std::string::npos) << other.err;
  EXPECT_EQ(begun("translation", folder / "nowhere").exit_code, 6);
  result::Results ended = results;  // as a march that did not get on
  ended.problem.goal.reset();
  ended.solution.status = maneuver::Status::stalled;
  ended.certificate.reset();
  result::write_solution(folder / "ended", ended);
  const ProgramRun half = begun("translation", folder / "ended");
  EXPECT_EQ(half.exit_code, 3);
  EXPECT_NE(half.err.find("/status: found \"stalled\", a march that ended after 1 s"), std::string::npos) << half.err;
  result::Results renamed = results;
  renamed.problem.joints[1].name = "other";
  result::write_solution(folder / "renamed", renamed);
  const ProgramRun told = begun("translation", folder / "renamed");
  EXPECT_EQ(told.exit_code, 0) << told.err;
  EXPECT_NE(told.err.find("whose joint \"other\" is taken for \"" + results.problem.joints[1].name), std::string::npos)
      << told.err;
  EXPECT_EQ(begun("translation", found).err.find("taken for"), std::string::npos);
  for (const char* wrong : {"--time-limit nan", "--time-limit 0", "--starts 0", "--seed -1"})
    EXPECT_EQ(lamprey(folder, "solve " + example("translation") + " --out " + again + " " + wrong).exit_code, 2)
        << wrong;
}

TEST(Program, verify_sees_a_duration_that_is_none) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation", {{"steps", "40"}, {"starts", "2"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --out " + (folder / "run")).exit_code, 0);
  result::Results results = result::read_solution(folder / "run");
  for (const double duration : {-1.0, 0.0}) {
    results.problem.duration = duration;
    result::write_solution(folder / "run", results);
    EXPECT_EQ(lamprey(folder, "verify " + (folder / "run")).exit_code, 4) << duration;
  }
}

// Moments of a scheme above order 2 jump from step to step: another scheme's march stores what it exerted.
TEST(Program, verifies_the_march_of_a_solution_of_higher_order_by_another_scheme) {
  const Folder folder;
  std::string text = text_of(varied_example(folder, "translation", {{"steps", "30"}, {"starts", "2"}}));
  text = std::regex_replace(text, std::regex("scheme = \"trapezoid\""), "scheme = \"order4\"");
  text = std::regex_replace(text, std::regex("\nrule *=[^\n]*"), "");
  std::ofstream(folder / "order4.toml") << text;
  ASSERT_EQ(lamprey(folder, "solve " + (folder / "order4.toml") + " --out " + (folder / "solved")).exit_code, 0);
  const std::string controls = " --controls " + (folder / "solved/solution.json") + " --scheme trapezoid ";
  for (const char* steps : {"--steps 30", "--steps 300", "--steps 77"}) {
    ASSERT_EQ(lamprey(folder, "simulate " + (folder / "order4.toml") + controls + steps + " --out " + (folder / "run"))
                  .exit_code,
              0);
    const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
    EXPECT_EQ(run.exit_code, 0) << steps << run.out;
    EXPECT_NE(run.out.find("✓ Discrete equations"), std::string::npos) << run.out;
  }
}

// Whose momenta are round-off and nothing else.
TEST(Program, verifies_a_swimmer_that_rests_in_a_turned_pose) {
  const Folder folder;
  std::string text = text_of(varied_example(folder, "translation", {{"steps", "20"}}));
  const std::string start = "[start]";
  text.replace(text.find(start), start.size(),
               start + "\nrotation.middle = [0.1, 0.2, 0.3]\nrotation.front = [0.3, 0.1, 0.2]");
  std::ofstream(folder / "rest.toml") << text;
  for (const char* scheme : {"trapezoid", "midpoint"}) {
    ASSERT_EQ(
        lamprey(folder, "simulate " + (folder / "rest.toml") + " --scheme " + scheme + " --out " + (folder / "run"))
            .exit_code,
        0);
    const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
    EXPECT_EQ(run.exit_code, 0) << run.out;
  }
}

TEST(Program, says_that_standard_output_is_full) {
  ASSERT_TRUE(std::filesystem::exists("/dev/full"));  // every Linux has it
  const Folder folder;
  for (const std::string& command : {std::string("--version"), "check " + example("yaw")}) {
    const std::string line =
        std::string(LAMPREY_PROGRAM) + " " + command + " >/dev/full 2>" + (folder / "err.txt") + " </dev/null";
    const int status = std::system(line.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 6) << command;
    EXPECT_EQ(text_of(folder / "err.txt"), "standard output: cannot be written: No space left on device\n");
  }
}

TEST(Program, refuses_options_that_are_no_numbers_and_marches_beyond_the_most_steps) {
  const Folder folder;
  const std::string march = "simulate " + example("gait") + " --out " + (folder / "run") + " ";
  for (const char* option : {"--duration nan", "--perturb nan", "--seed -1"})
    EXPECT_EQ(lamprey(folder, march + option).exit_code, 2) << option;
  ASSERT_EQ(lamprey(folder, "solve " + example("gait") + " --no-refinement --out " + (folder / "solved")).exit_code, 0);
  const ProgramRun run = lamprey(folder, march + "--cycles 60000 --feedback " + (folder / "solved"));
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(run.err.find("at most 10000000 steps in all"), std::string::npos) << run.err;
}

TEST(Program, verify_sees_a_tampered_solution) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation", {{"steps", "40"}, {"starts", "2"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --out " + (folder / "run")).exit_code, 0);
  result::Results results = result::read_solution(folder / "run");
  results.solution.control[20][0][2] += 1e-3;
  result::write_solution(folder / "run", results);
  const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_NE(run.out.find("does not hold"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("/trajectory.h5 does not hold what solution.json does: control[20][0][2] is "),
            std::string::npos)
      << run.out;
}

// A vehicle would follow gains that are somebody else's.
TEST(Program, verify_sees_false_gains) {
  const Folder folder;
  const std::string problem = varied_example(folder, "gait", {{"steps", "60"}, {"starts", "1"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --out " + (folder / "run")).exit_code, 0);
  result::Results results = result::read_solution(folder / "run");
  Eigen::MatrixXd& gain = results.solution.feedback.gain.at(7);
  gain(1, 2) += 0.01 * gain.cwiseAbs().maxCoeff();
  result::write_solution(folder / "run", results);
  const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 4);
  EXPECT_NE(run.out.find("does not hold: feedback.gain[7][1][2] is "), std::string::npos) << run.out;
}

// A march has the file's swimmer, and begins and lasts as its options say.
TEST(Program, verify_says_what_of_a_march_is_not_as_in_the_file) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation", {{"steps", "40"}});
  const auto verified = [&](const std::string& options) {
    EXPECT_EQ(lamprey(folder, "simulate " + problem + options + " --out " + (folder / "run")).exit_code, 0);
    const ProgramRun run = lamprey(folder, "verify " + (folder / "run") + " --problem " + problem);
    EXPECT_EQ(run.exit_code, 0) << run.out;
    return run.out;
  };
  EXPECT_NE(verified("").find("The problem is that of "), std::string::npos);
  const std::string other = verified(" --duration 3 --scheme midpoint");
  EXPECT_NE(other.find("The swimmer is that of "), std::string::npos) << other;
  EXPECT_NE(other.find("it was marched with another duration, another scheme."), std::string::npos) << other;
}

// Nobody interrupted the check of an answer that was interrupted.
TEST(Program, verify_of_an_interrupted_answer_is_not_interrupted) {
  const Folder folder;
  const std::string problem = varied_example(folder, "free_time", {{"steps", "40"}, {"starts", "1"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --no-refinement --out " + (folder / "run")).exit_code, 0);
  result::Results results = result::read_solution(folder / "run");
  results.solution.status = maneuver::Status::interrupted;
  result::write_solution(folder / "run", results);
  const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 4) << run.out;
}

// An answer to an easier question is none.
TEST(Program, verify_compares_the_question_with_a_problem_file) {
  const Folder folder;
  const std::string problem = varied_example(folder, "free_time", {{"steps", "40"}, {"starts", "1"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --no-refinement --out " + (folder / "run")).exit_code, 0);
  const auto verified = [&] { return lamprey(folder, "verify " + (folder / "run") + " --problem " + problem); };
  const ProgramRun same = verified();
  EXPECT_EQ(same.exit_code, 0) << same.out;
  EXPECT_NE(same.out.find("The problem is that of "), std::string::npos) << same.out;
  result::Results results = result::read_solution(folder / "run");
  results.problem.tolerance = 1.0;
  results.problem.goal->move[0] = 1.75;
  results.problem.limits = {};
  result::write_solution(folder / "run", results);
  const ProgramRun other = verified();
  EXPECT_EQ(other.exit_code, 4);
  for (const char* words : {"problem.tolerance is 1, the file asks for 1e-08.",
                            "problem.goal.move[0] is 1.75, the file asks for 2.", "problem.limits is nothing, the"})
    EXPECT_NE(other.out.find(words), std::string::npos) << words << " is missing from\n" << other.out;
  EXPECT_EQ(lamprey(folder, "verify " + (folder / "run") + " --problem " + (folder / "none.toml")).exit_code, 6);
}

// Parts of a question that no problem file may ask are checked by nothing.
TEST(Program, verify_refuses_questions_that_no_problem_file_may_ask) {
  const Folder folder;
  const std::string problem =
      varied_example(folder, "translation", {{"steps", "40"}, {"starts", "1"}, {"scheme", "\"order4\""}});
  const std::string text = std::regex_replace(text_of(problem), std::regex("\nrule = [^\n]*"), "");
  std::ofstream(problem) << text;
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --no-refinement --out " + (folder / "run")).exit_code, 0);
  const result::Results answer = result::read_solution(folder / "run");
  const auto refused = [&](const auto& ask, const std::string& words) {
    result::Results other = answer;
    ask(other.problem);
    result::write_solution(folder / "run", other);
    const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
    EXPECT_EQ(run.exit_code, 4) << words;
    EXPECT_NE(run.out.find("The stored status, optimal, does not hold: " + words), std::string::npos) << run.out;
  };
  using Question = result::ResolvedProblem;
  const std::string may_not = "the files ask what no problem file may (";
  refused([](Question& asked) { asked.limits.torque = 1.0; }, may_not + "limits.torque: found a limit, for which");
  refused([](Question& asked) { asked.limits.swing["nobody"] = 1.0; },
          may_not + "limits.swing.nobody: found a joint that the swimmer does not have");
  refused([](Question& asked) { asked.cost_weights.work = 5.0; }, may_not + "cost.work: found 5, for which");
  refused([](Question& asked) { asked.time_weight = -5.0; }, may_not + "cost.time: found -5; allowed: a number >= 0");
  refused([](Question& asked) { asked.effort = 0.0; }, may_not + "cost.effort: found 0; allowed: a number > 0");
  refused([](Question& asked) { asked.tolerance = 10.0; }, may_not + "search.tolerance: found 10; allowed:");
  refused([](Question& asked) { asked.goal->rotation["nobody"] = std::nullopt; },
          may_not + "goal.rotation.nobody: found a body that the swimmer does not have");
  refused([](Question& asked) { asked.free_shape = true; }, may_not + "start.free_shape: found true without");
  refused([](Question& asked) { asked.start.reset(); }, "the files do not tell the start that was asked for");
  const auto never = [](double time) {
    return [time](Question& asked) {
      asked.scheme = integrator::Scheme::trapezoid;
      asked.waypoints = {{time, {100.0, std::nullopt, std::nullopt}, {}, {}}};
    };
  };
  refused(never(2.0), may_not + "waypoint[0].time: found 2 s; allowed:");
  refused(never(-1.0), may_not + "waypoint[0].time: found -1 s; allowed:");
}

TEST(Program, verify_says_what_a_status_promises) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation", {{"steps", "40"}, {"starts", "1"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --no-refinement --out " + (folder / "run")).exit_code, 0);
  result::Results results = result::read_solution(folder / "run");
  results.solution.status = maneuver::Status::infeasible;
  results.certificate->second_order->negative_eigenvalues = 3;
  result::write_solution(folder / "run", results);
  const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
  EXPECT_NE(run.out.find("The stored status, infeasible, promises nothing."), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("second_order.negative_eigenvalues is 0, it says 3."), std::string::npos) << run.out;
}

TEST(Program, verify_names_what_a_solution_claims_in_vain) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation", {{"steps", "40"}, {"starts", "2"}});
  ASSERT_EQ(lamprey(folder, "solve " + problem + " --out " + (folder / "run")).exit_code, 0);
  const result::Results answer = result::read_solution(folder / "run");
  const auto refused = [&](const result::Results& results) {
    result::write_solution(folder / "run", results);
    const ProgramRun run = lamprey(folder, "verify " + (folder / "run"));
    EXPECT_EQ(run.exit_code, 4);
    return run.out;
  };
  result::Results cheaper = answer, later = answer, elsewhere = answer;
  cheaper.solution.cost *= 0.9;
  EXPECT_NE(refused(cheaper).find("The stored status, optimal, does not hold: the stored cost is off by 0.1 of"),
            std::string::npos);
  later.problem.duration = 0.5;
  EXPECT_NE(refused(later).find("the nodes' times differ by 1 of the duration"), std::string::npos);
  elsewhere.problem.start->position.y() = 0.25;
  EXPECT_NE(refused(elsewhere).find("the motion begins 0.25 (rad or m) beside the problem's start"), std::string::npos);
  result::Results sharper = answer, faster = answer;
  sharper.certificate->replay->whole_rotation_error = 1e-12;
  EXPECT_NE(refused(sharper).find("The stored certificate does not hold: replay.whole_rotation_error is "),
            std::string::npos);
  faster.solution.angular_velocity[7][1] *= 2.0;
  EXPECT_NE(refused(faster).find("stored velocities, momenta or joint angles are off by "), std::string::npos);
}

// An answer, and what verify says of it when it is altered.
struct Forgery : Folder {
  result::Results answer;
  Forgery() {
    const std::string problem = varied_example(*this, "translation", {{"steps", "40"}, {"starts", "2"}});
    EXPECT_EQ(lamprey(*this, "solve " + problem + " --out " + (*this / "run")).exit_code, 0);
    answer = result::read_solution(*this / "run");
  }
  template <typename Alteration>
  void refused(const Alteration& alter, int exit_code, const std::string& words) const {
    result::Results other = answer;
    alter(other);
    result::write_solution(*this / "run", other);
    verified(exit_code, words);
  }
  void refused(const std::string& found, const std::string& other, int exit_code, const std::string& words) const {
    result::write_solution(*this / "run", answer);
    const std::string path = *this / "run/solution.json";
    std::string text = text_of(path);
    const std::size_t place = text.find(found);
    ASSERT_NE(place, std::string::npos) << found;
    std::ofstream(path) << text.replace(place, found.size(), other);
    verified(exit_code, words);
  }

 private:
  void verified(int exit_code, const std::string& words) const {
    const ProgramRun run = lamprey(*this, "verify " + (*this / "run"));
    EXPECT_EQ(run.exit_code, exit_code) << words << '\n' << run.out << run.err;
    EXPECT_NE((run.out + run.err).find(words), std::string::npos) << words << '\n' << run.out << run.err;
  }
};

TEST(Program, verify_refuses_limits_that_no_problem_file_may_have) {
  const Forgery of;
  of.refused([](result::Results& is) { is.problem.limits.torque = -1.0; }, 4,
             "(limits.torque: found -1; allowed: a number > 0");
  of.refused([](result::Results& is) { is.problem.limits.joint_torque_component["front"] = -1.0; }, 4,
             "(limits.torque_component.front: found -1; allowed: a number > 0");
  of.refused([](result::Results& is) { is.problem.limits.angular_velocity = 0.0; }, 4,
             "(limits.angular_velocity: found 0; allowed: a number > 0");
  of.refused([](result::Results& is) { is.problem.limits.clearance = -0.1; }, 4,
             "(limits.clearance: found -0.1; allowed: a number >= 0 (m)");
  of.refused([](result::Results& is) { is.problem.limits.swing["front"] = 7.0; }, 4,
             "(limits.swing.front: found 7; allowed:");
  of.refused(
      [](result::Results& is) {
        is.problem.limits.half_spaces = {{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()}};
      },
      4, "(limits.half_space.normal: found 0; allowed: three numbers, not all 0");
  of.refused(
      [](result::Results& is) {
        is.solution.limit_multipliers.push_back({"limits.torque", 0, -1, -1, -1, false, std::vector<double>(41, 5.0)});
      },
      4, "(limit_multipliers[0]: found \"limits.torque\", which limits nothing else of this problem");
}

TEST(Program, verify_refuses_records_that_contradict_themselves) {
  const Forgery of;
  of.refused([](result::Results& is) { is.problem.time_step *= 2.0; }, 4, "problem.time_step is");
  of.refused([](result::Results& is) { is.certificate->replay->rotation_error /= 8.0; }, 4, "replay.rotation_error is");
  of.refused([](result::Results& is) { is.certificate->replay->growth_rate = 0.0; }, 4, "replay.growth_rate is");
  of.refused([](result::Results& is) { is.certificate->goal_error = -5.0; }, 4, "goal_error is");
  of.refused([](result::Results& is) { is.certificate->refinement->cost_error *= 0.5; }, 4, "refinement.cost_error is");
  of.refused([](result::Results& is) { is.solution.search.solved = 999; }, 3, "minima whose counts add up to solved");
  of.refused([](result::Results& is) { is.problem.start->rotation[1] *= 10.0; }, 3, "a rotation matrix");
  of.refused([](result::Results& is) { is.problem.density = -1.0; }, 3, "a number >= 0 (kg/m³)");
  const bool resolved = of.answer.certificate->replay->rotation_error <= certificate::replay_mark;
  of.refused(resolved ? "\"resolved\": true" : "\"resolved\": false",
             resolved ? "\"resolved\": false" : "\"resolved\": true", 3, "certificate/resolved");
  of.refused("{\"joint\": \"front\", \"axis\": 0}", "{\"joint\": \"back\", \"axis\": 0}", 3,
             "feedback/control_coordinates");
  of.refused("\"quantity\": \"turn\"", "\"quantity\": \"angle\"", 3, "feedback/state_coordinates");
}

// Of an answer that is called a march no certificate is found: one reason, and one sentence of all that it tells.
TEST(Program, verify_tells_an_answer_from_a_march_in_few_words) {
  const Forgery forgery;
  const auto march = [](result::Results& other) { other.solution.status = maneuver::Status::simulated; };
  forgery.refused(march, 4, "simulated, does not hold: No march: a march has no cost, and one is stored.");
  forgery.refused(march, 4, "The stored certificate does not hold: of goal_error, rest_error, iterates_momentum,");
  const std::string words = lamprey(forgery, "verify " + (forgery / "run")).out;
  EXPECT_EQ(words.find("nan"), std::string::npos) << words;
  const std::regex refusal("does not hold");
  EXPECT_LE(std::distance(std::sregex_iterator(words.begin(), words.end(), refusal), std::sregex_iterator()), 4)
      << words;
}

TEST(Program, verify_refuses_marches_of_other_times_or_with_a_cost) {
  const Folder folder;
  const std::string run = folder / "run";
  ASSERT_EQ(lamprey(folder, "simulate " + std::string(LAMPREY_SOURCE_DIR) +
                                "/examples/three_links.toml --steps 50 --out " + run)
                .exit_code,
            0);
  const result::Results marched = result::read_solution(run);
  result::Results swapped = marched, priced = marched, turned = marched;
  turned.solution.joint_angle[7][1][0] += 2.0 * std::numbers::pi;
  std::swap(swapped.solution.time[4], swapped.solution.time[5]);
  priced.solution.cost = -5.0;
  for (const auto& [results, words] :
       {std::pair(&swapped, "the nodes' times differ by "),
        std::pair(&priced, "a march has no cost, and one is stored"), std::pair(&turned, "joint_angle[7][1][0] is")}) {
    result::write_solution(run, *results);
    const ProgramRun verified = lamprey(folder, "verify " + run);
    EXPECT_EQ(verified.exit_code, 4);
    EXPECT_NE(verified.out.find(words), std::string::npos) << verified.out;
  }
}

// A copy of the program with its two companions for benchmarks beside it, the first of them made to leave a trace.
struct BenchFolder : Folder {
  BenchFolder() {
    fs::copy_file(LAMPREY_PROGRAM, *this / "lamprey");
    std::ofstream(*this / "lamprey_bench") << "#!/bin/sh\ntouch " << *this / "measured"
                                           << "\n";
    fs::permissions(*this / "lamprey_bench", fs::perms::owner_all);
    fs::create_symlink(std::string(LAMPREY_SOURCE_DIR) + "/tools/bench_peers.sh", *this / "lamprey_bench_peers");
  }
  ProgramRun bench(const std::string& python, const std::string& arguments) const {
    const std::string command = "LAMPREY_PEERS_PYTHON=" + python + " " + (*this / "lamprey") + " bench " + arguments +
                                " >" + (*this / "out.txt") + " 2>" + (*this / "err.txt") + " </dev/null";
    const int status = std::system(command.c_str());
    return {WEXITSTATUS(status), text_of(*this / "out.txt"), text_of(*this / "err.txt")};
  }
  // A python3 that has venv and can do nothing more, or lacks it.
  std::string python(bool has_venv) const {
    std::ofstream(*this / "python3") << "#!/bin/sh\n[ \"$1\" = -c ] && exit " << (has_venv ? 0 : 1) << "\nexit 1\n";
    fs::permissions(*this / "python3", fs::perms::owner_all);
    return *this / "python3";
  }
};

TEST(Program, measures_nothing_and_says_why_with_code_7_when_peers_cannot_be_installed) {
  const BenchFolder folder;
  for (const std::string& python : {folder / "nowhere", folder.python(false)}) {
    const ProgramRun run = folder.bench(python, "--peers");
    EXPECT_EQ(run.exit_code, 7) << run.err;
    EXPECT_NE(run.err.find("python3-venv"), std::string::npos) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(fs::exists(folder / "measured"));
  }
  const ProgramRun run = folder.bench(folder.python(true), "--peers");
  EXPECT_EQ(run.exit_code, 7) << run.err;
  EXPECT_NE(run.err.find("install.log"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder / "measured"));
  EXPECT_EQ(folder.bench("unused", "").exit_code, 0);
  EXPECT_TRUE(fs::exists(folder / "measured"));
}

// The shell finds it by PATH, and names no folder.
TEST(Program, measures_with_what_lies_beside_it_and_not_in_the_present_folder) {
  const BenchFolder folder;
  const Folder present;
  std::ofstream(present / "lamprey_bench") << "#!/bin/sh\ntouch " << (present / "foreign") << "\n";
  fs::permissions(present / "lamprey_bench", fs::perms::owner_all);
  const std::string command =
      "cd " + (present / "") + " && PATH=" + (folder / "") + ":$PATH lamprey bench >/dev/null 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 0);
  EXPECT_TRUE(fs::exists(folder / "measured"));
  EXPECT_FALSE(fs::exists(present / "foreign"));
}

TEST(Program, says_how_to_build_the_benchmarks_when_they_are_missing) {
  const BenchFolder folder;
  fs::remove(folder / "lamprey_bench_peers");
  EXPECT_EQ(folder.bench("unused", "--peers").exit_code, 7);
  fs::remove(folder / "lamprey_bench");
  const ProgramRun run = folder.bench("unused", "");
  EXPECT_EQ(run.exit_code, 7);
  EXPECT_NE(run.err.find("./dev bench"), std::string::npos) << run.err;
}

TEST(Program, says_what_it_cannot_do_yet) {
  const Folder folder;
  const std::string problem =  // a gait above order 2
      varied_example(folder, "eel_gait", {{"starts", "2\n[integrator]\nscheme = \"order4\""}});
  const ProgramRun run = lamprey(folder, "solve " + problem + " --out " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.err.find("this version seeks no maneuvers yet"), std::string::npos) << run.err;
  EXPECT_FALSE(fs::exists(folder / "run"));
  const ProgramRun check = lamprey(folder, "check " + problem);  // a march may take the file
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_NE(check.out.find("Not for lamprey solve"), std::string::npos) << check.out;
  EXPECT_EQ(lamprey(folder, "check " + example("translation")).out.find("Not for lamprey solve"), std::string::npos);
}

TEST(Program, says_which_limit_is_still_broken_when_its_time_is_up) {
  const Folder folder;
  const std::string problem = varied_example(folder, "translation_with_clearance", {{"starts", "1\ntime_limit = 0.2"}});
  const ProgramRun run = lamprey(folder, "solve " + problem + " --workers 1 --out " + (folder / "run"));
  EXPECT_NE(run.exit_code, 0);
  const result::Results results = result::read_solution(folder / "run");
  EXPECT_EQ(results.solution.status, maneuver::Status::time_limit);
  ASSERT_TRUE(results.certificate && results.certificate->limits);
  const bool broken = results.certificate->limits->violation > 1e-6;  // how far it comes depends on the machine
  EXPECT_NE(results.solution.message.find(broken ? "limits.clearance" : "missed by"), std::string::npos)
      << results.solution.message;
}

TEST(Program, refuses_a_scheme_it_does_not_know_and_names_those_it_does) {
  const Folder folder;
  const ProgramRun run = lamprey(folder, "simulate " + example("tumble") + " --scheme euler --out " + (folder / "run"));
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_NE(run.err.find("paper, trapezoid, midpoint, order4, order6"), std::string::npos) << run.err;
  EXPECT_NE(lamprey(folder, "simulate --help").out.find("paper | trapezoid | midpoint | order4 | order6"),
            std::string::npos);
}

}  // namespace
}  // namespace lamprey::tests
