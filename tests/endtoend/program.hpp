// Runs the program as a person would, in a folder of its own.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

namespace lamprey::tests {

struct ProgramRun {
  int exit_code;
  std::string out;
  std::string err;
};

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// A temporary folder that goes with the object.
class Folder {
 public:
  Folder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "lamprey-test-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  ~Folder() { std::filesystem::remove_all(path_); }
  std::string operator/(const std::string& name) const { return (path_ / name).string(); }

 private:
  std::filesystem::path path_;
};

/// `lamprey ARGUMENTS`, arguments quoted by the caller.
inline ProgramRun lamprey(const Folder& folder, const std::string& arguments) {
  const std::string command = std::string(LAMPREY_PROGRAM) + " " + arguments + " >" + (folder / "out.txt") + " 2>" +
                              (folder / "err.txt") + " </dev/null";
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(folder / "out.txt"),
          text_of(folder / "err.txt")};
}

inline std::string example(const std::string& name) {
  return std::string(LAMPREY_SOURCE_DIR) + "/examples/" + name + ".toml";
}

/// A copy of an example with keys set anew: each `key = value` line is replaced (and must be there).
inline std::string varied_example(const Folder& folder, const std::string& name,
                                  const std::vector<std::pair<std::string, std::string>>& values) {
  std::string text = text_of(example(name));
  for (const auto& [key, value] : values) {
    const std::regex line("(^|\n)" + key + " *=[^\n]*");
    EXPECT_TRUE(std::regex_search(text, line)) << name << " has no " << key;
    text = std::regex_replace(text, line, "$1" + key + " = " + value);
  }
  const std::string path = folder / "problem.toml";
  std::ofstream(path) << text;
  return path;
}

}  // namespace lamprey::tests
