// What writing results into a folder removes there: what came with the result that it replaces, and nothing else.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "report/report.hpp"
#include "report/sample_results.hpp"

namespace lamprey {
namespace {

namespace fs = std::filesystem;

class WrittenFolders : public ::testing::Test {
 protected:
  WrittenFolders() {
    std::string pattern = (fs::temp_directory_path() / "lamprey_written_XXXXXX").string();
    run_ = mkdtemp(pattern.data());
  }
  ~WrittenFolders() override { fs::remove_all(run_); }

  static result::Results made_by(const std::string& command) {
    result::Results results = tests::sample_results(5);
    results.provenance.command = command;
    return results;
  }
  static result::Results catalogue(const std::string& command, std::size_t others) {
    result::Results results = made_by(command);
    results.others.assign(others, made_by(command));
    return results;
  }
  void write(const result::Results& results, const std::string& within = "") const {
    report::write_results((run_ / within).string(), results);
  }
  bool holds(const std::string& folder) const { return fs::exists(run_ / folder / "solution.json"); }

  fs::path run_;
};

TEST_F(WrittenFolders, lose_the_minima_that_came_with_the_result_that_is_replaced) {
  write(catalogue("solve --keep 4", 3));
  write(catalogue("solve --keep 2", 1));
  EXPECT_TRUE(holds("minimum_2"));
  EXPECT_FALSE(fs::exists(run_ / "minimum_3") || fs::exists(run_ / "minimum_4"));
  write(made_by("simulate"));
  EXPECT_FALSE(fs::exists(run_ / "minimum_2"));
}

TEST_F(WrittenFolders, keep_results_that_others_have_written_there) {
  write(made_by("solve --out run"));
  write(made_by("solve --out run/minimum_2"), "minimum_2");
  write(made_by("simulate --out run"));
  EXPECT_TRUE(holds("minimum_2")) << "beside a result without other minima";
  write(catalogue("solve --keep 4", 3));
  write(made_by("solve --out run/minimum_3"), "minimum_3");
  write(made_by("simulate --out run"));
  EXPECT_FALSE(holds("minimum_2") || holds("minimum_4"));
  EXPECT_TRUE(holds("minimum_3")) << "in the midst of other minima";
}

TEST_F(WrittenFolders, keep_everything_where_no_result_is_replaced_that_can_be_read) {
  write(made_by("solve"), "minimum_2");
  write(made_by("solve"));
  EXPECT_TRUE(holds("minimum_2"));
  std::ofstream(run_ / "solution.json") << "{";
  write(made_by("solve"));
  EXPECT_TRUE(holds("minimum_2"));
}

}  // namespace
}  // namespace lamprey
