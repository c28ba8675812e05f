// All commands say the same of a solution.json that no program of ours has written: the file, the key, and exit code 3.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "program.hpp"

namespace lamprey::tests {
namespace {

using nlohmann::json;

struct StoredFiles : ::testing::Test {
  Folder folder;
  json march;

  StoredFiles() {
    EXPECT_EQ(lamprey(folder, "simulate " + example("three_links") + " --steps 4 --out " + (folder / "run")).exit_code,
              0);
    march = json::parse(text_of(folder / "run/solution.json"));
  }
  void refused_by_all(const json& altered, const std::string& key) const {
    std::ofstream(folder / "run/solution.json") << altered.dump();
    const std::string begin = (folder / "run/solution.json") + ": " + key + ": found ";
    for (const char* command : {"verify ", "report ", "export "}) {
      const ProgramRun run = lamprey(folder, command + (folder / "run"));
      EXPECT_EQ(run.exit_code, 3) << command << key;
      EXPECT_EQ(run.err.rfind(begin, 0), 0U) << run.err;
      EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "run/angles.csv"));
  }
};

TEST_F(StoredFiles, with_a_body_on_two_joints) {
  json& joints = march["problem"]["joints"];
  joints[1]["child"] = joints[0]["child"];
  refused_by_all(march, "/problem/joints/1/child");
}

TEST_F(StoredFiles, without_nodes) {
  for (const char* array : {"time", "position", "rotation", "control", "joint_angle"}) march[array] = json::array();
  for (json* group : {&march["velocity"], &march["momentum"]["linear"], &march["momentum"]["angular"]})
    for (json& array : *group) array = json::array();
  refused_by_all(march, "/time");
  march["status"] = "optimal";
  march["problem"]["steps"] = 2'000'000;  // of which verify would make as many
  refused_by_all(march, "/time");
}

}  // namespace
}  // namespace lamprey::tests
