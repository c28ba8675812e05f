#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "document/io_error.hpp"
#include "file/refusals.hpp"
#include "file/samples.hpp"
#include "model/input_error.hpp"
#include "result/solution_file.hpp"
#include "result/trajectory_file.hpp"

namespace lamprey {
namespace {

namespace fs = std::filesystem;
using model::InputError;

template <class Error, class Action>
std::string message_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

std::size_t entries(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST(ResultFiles, a_number_that_is_not_finite_is_refused_by_name_before_anything_is_written) {
  const tests::TemporaryFolder folder;
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    result::Results results = tests::sample_results(6);
    results.solution.control[4][1][2] = bad;
    EXPECT_NE(message_of<std::domain_error>([&] {
                result::write_solution(folder / "out", results);
              }).find("control[4][1][2]"),
              std::string::npos);
    EXPECT_NE(message_of<std::domain_error>([&] {
                result::write_trajectory(folder / "out", results);
              }).find("control[4][1][2]"),
              std::string::npos);
  }
  result::Results results = tests::sample_results(6);
  results.problem.bodies[1].mass_matrix(0, 1) = std::nan("");
  EXPECT_NE(
      message_of<std::domain_error>([&] { result::write_solution(folder / "out", results); }).find("problem.bodies"),
      std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(ResultFiles, an_array_of_the_wrong_length_is_refused_by_name) {
  result::Results results = tests::sample_results(6);
  results.solution.angular_momentum.fluid.pop_back();
  EXPECT_NE(message_of<std::domain_error>([&] {
              result::solution_text(results);
            }).find("momentum/angular/fluid: found 6 entries, needs 7"),
            std::string::npos);
  results = tests::sample_results(6);
  results.problem.steps = 7;
  EXPECT_NE(message_of<std::domain_error>([&] {
              result::solution_text(results);
            }).find("time: found 7 nodes, needs problem.steps + 1 = 8"),
            std::string::npos);
}

TEST(ResultFiles, a_target_that_is_a_file_is_refused_and_left_alone) {
  const tests::TemporaryFolder folder;
  std::ofstream(folder / "taken") << "mine";
  EXPECT_THROW(result::write_solution(folder / "taken", tests::sample_results(2)), document::IoError);
  EXPECT_THROW(result::write_solution(folder / "taken/below", tests::sample_results(2)), document::IoError);
  EXPECT_EQ(tests::bytes_of(folder / "taken"), "mine");
  EXPECT_EQ(entries(folder.path()), 1U);
}

TEST(ResultFiles, a_place_where_nothing_can_be_created_is_told) {
  EXPECT_THROW(result::write_solution("/proc/lamprey/out", tests::sample_results(2)), document::IoError);
  EXPECT_THROW(result::write_trajectory("/proc", tests::sample_results(2)), document::IoError);
}

TEST(ResultFiles, a_writer_that_fails_leaves_no_file_and_no_new_folder) {
  const tests::TemporaryFolder folder;
  const document::PendingFile good = document::finished_file("good.txt", "whole");
  const document::PendingFile bad = {"bad.txt", [](const std::string& temporary) {
                                       std::ofstream(temporary) << "half";
                                       throw std::runtime_error("stopped");
                                     }};
  EXPECT_THROW(document::write_files(folder / "a/b/c", {good, bad}), std::runtime_error);
  EXPECT_EQ(entries(folder.path()), 0U);
  std::filesystem::create_directory(folder / "a");
  std::ofstream(folder / "a/good.txt") << "before";
  EXPECT_THROW(document::write_files(folder / "a", {good, bad}), std::runtime_error);
  EXPECT_EQ(entries(folder / "a"), 1U);
  EXPECT_EQ(tests::bytes_of(folder / "a/good.txt"), "before");
}

TEST(ResultFiles, a_folder_in_the_place_of_the_file_is_told_and_nothing_is_left) {
  const tests::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "solution.json/inside");
  EXPECT_THROW(result::write_solution(folder.path(), tests::sample_results(2)), document::IoError);
  EXPECT_EQ(entries(folder.path()), 1U);
}

// Files may grow to `bytes` only while this lives: what a full disk does.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    previous_ = signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, previous_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit before_;
  void (*previous_)(int);
};

TEST(ResultFiles, a_disk_that_fills_up_leaves_the_old_results_whole_and_nothing_half_written) {
  const tests::TemporaryFolder folder;
  document::write_files(folder.path(), {result::solution_file(tests::sample_results(2)),
                                        result::trajectory_file(tests::sample_results(2))});
  const std::string solution = tests::bytes_of(folder / "solution.json");
  const std::string trajectory = tests::bytes_of(folder / "trajectory.h5");
  {
    const FileSizeLimit full(20000);
    EXPECT_THROW(result::write_solution(folder.path(), tests::sample_results(100)), document::IoError);
    EXPECT_THROW(result::write_trajectory(folder.path(), tests::sample_results(100)), document::IoError);
    EXPECT_THROW(result::write_solution(folder / "new", tests::sample_results(100)), document::IoError);
  }
  EXPECT_EQ(entries(folder.path()), 2U);
  EXPECT_EQ(tests::bytes_of(folder / "solution.json"), solution);
  EXPECT_EQ(tests::bytes_of(folder / "trajectory.h5"), trajectory);
}

std::string refusal(const std::string& text) {
  return message_of<InputError>([&] { result::parse_solution(text, "solution.json"); });
}

std::string edited(const std::string& old, const std::string& with) {
  std::string text = result::solution_text(tests::sample_results(2));
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), with);
}

TEST(SolutionReader, what_is_wrong_is_told_by_file_and_json_pointer) {
  EXPECT_EQ(refusal(edited("\"steps\": 2", "\"steps\": 3"))
                .find("solution.json: /time: found array of 3 entries; allowed: an array of 4 entries"),
            std::string::npos)
      << "small arrays are shown";
  EXPECT_NE(refusal(edited("\"steps\": 2", "\"steps\": 3")).find("solution.json: /time: found [0"), std::string::npos);
  EXPECT_NE(refusal(edited("\"status\": \"optimal\"", "\"status\": \"best\""))
                .find("solution.json: /status: found \"best\"; allowed: \"optimal\""),
            std::string::npos);
  EXPECT_NE(refusal(edited("\"rest\": true", "\"rest\": \"limbs\""))
                .find("/problem/goal/rest: found \"limbs\"; allowed: true, false or \"joints\""),
            std::string::npos);
  EXPECT_NE(refusal(edited("\"child\": 1", "\"child\": 3"))
                .find("/problem/joints/0/child: found 3; allowed: a whole number from 0 to 2"),
            std::string::npos);
  EXPECT_NE(refusal(edited("\"child\": 1", "\"child\": 1.5")).find("/problem/joints/0/child: found 1.5"),
            std::string::npos);
  EXPECT_NE(
      refusal(edited("\"semi_axes\": [", "\"semi_axes\": [null, ")).find("/problem/bodies/0/semi_axes: found [null"),
      std::string::npos);
  EXPECT_NE(refusal(edited("\"semi_axes\": [", "\"semi_axes\": [0, ")).find("/problem/bodies/0/semi_axes: found"),
            std::string::npos);
  EXPECT_NE(refusal(edited("\"position\": [\n    [", "\"position\": [\n    [[], ")).find("/position/0"),
            std::string::npos);
  EXPECT_NE(refusal(edited("\"rest\": ", "\"angle\": {\"front\": 0.5}, \"rest\": "))
                .find("/problem/goal/angle/front: found 0.5; allowed: an array"),
            std::string::npos);
  EXPECT_NE(refusal(edited("\"rest\": ", "\"shape\": \"begin\", \"rest\": "))
                .find("/problem/goal/shape: found \"begin\"; allowed: \"start\""),
            std::string::npos);
  EXPECT_NE(refusal(edited("\"schema\": 1", "\"schema\": 2")).find("/schema: found 2; allowed: 1"), std::string::npos);
  EXPECT_NE(refusal(edited("\"provenance\"", "\"provenience\"")).find("/provenance: found nothing"), std::string::npos);
}

// No program of ours writes such: each march and each search has the start at least.
TEST(SolutionReader, a_motion_without_nodes_is_refused_whatever_steps_it_tells) {
  result::Results none = tests::sample_results(2);
  none.solution = {};
  const std::string told = "solution.json: /time: found []; allowed: an array of ";
  EXPECT_EQ(refusal(result::solution_text(none)),
            told + "3 entries; write the file again with lamprey or mend this field");
  none.problem.steps = 2'000'000'000;
  tests::expect_begins(refusal(result::solution_text(none)), told + "2000000001 entries");
}

TEST(SolutionReader, joints_that_make_no_tree_are_refused_at_the_joint) {
  const std::string text = result::solution_text(tests::sample_results(2));
  const auto told = [&](const std::vector<std::pair<int, int>>& parent_and_child) {
    auto document = nlohmann::json::parse(text);
    for (std::size_t j = 0; j < parent_and_child.size(); ++j) {
      document["problem"]["joints"][j]["parent"] = parent_and_child[j].first;
      document["problem"]["joints"][j]["child"] = parent_and_child[j].second;
    }
    return refusal(document.dump());
  };
  EXPECT_EQ(told({{0, 1}, {1, 2}}), "");
  EXPECT_EQ(told({{2, 1}, {0, 2}}), "") << "in any order";
  EXPECT_EQ(
      told({{0, 1}, {2, 1}}),
      "solution.json: /problem/joints/1/child: found 1; allowed: each body but the first below one joint, and the "
      "first below none; write the file again with lamprey or mend this field");
  EXPECT_NE(told({{0, 1}, {1, 0}}).find("/problem/joints/1/child: found 0; allowed: each body but the first"),
            std::string::npos);
  EXPECT_NE(told({{2, 1}, {1, 2}}).find("/problem/joints/0/parent: found 2; allowed: a way up to the first body"),
            std::string::npos);
  auto fewer = nlohmann::json::parse(text);
  fewer["problem"]["joints"].erase(1);
  EXPECT_NE(refusal(fewer.dump()).find("/problem/joints: found array of 1 entries; allowed: an array of 2 entries"),
            std::string::npos)
      << refusal(fewer.dump());
}

TEST(SolutionReader, text_that_is_not_json_is_told_by_line) {
  EXPECT_NE(refusal(edited("\"schema\": 1,", "\"schema\": 1")).find("solution.json:3:"), std::string::npos);
  EXPECT_NE(refusal("").find("solution.json:1:1: syntax"), std::string::npos);
  EXPECT_NE(refusal("[1, 2]").find("allowed: an object"), std::string::npos);
}

TEST(SolutionReader, keys_given_twice_are_refused) {
  EXPECT_NE(refusal(edited("\"schema\": 1", "\"schema\": 1,\n\"schema\": 1"))
                .find("\"schema\": found this key a second time"),
            std::string::npos);
}

TEST(SolutionReader, nesting_of_any_depth_is_refused_without_harm) {
  for (const std::string opening : {"[", "{\"a\":"}) {
    std::string bomb;
    for (int depth = 0; depth < 1'000'000; ++depth) bomb += opening;
    EXPECT_NE(refusal(bomb).find("deeper than 64"), std::string::npos);
    EXPECT_NE(refusal("{\"schema\": " + bomb).find("deeper than 64"), std::string::npos);
  }
}

TEST(SolutionReader, a_missing_file_is_a_failure_of_reading) {
  const tests::TemporaryFolder folder;
  EXPECT_THROW(result::read_solution(folder.path()), document::IoError);
  EXPECT_THROW(result::read_solution(folder / "nothing"), document::IoError);
}

TEST(SolutionReader, truncation_reads_or_is_refused) {
  const std::string text = result::solution_text(tests::sample_results(1));
  for (std::size_t length = 0; length + 2 < text.size(); length += 7)
    EXPECT_NE(refusal(text.substr(0, length)), "") << length;
}

}  // namespace
}  // namespace lamprey
