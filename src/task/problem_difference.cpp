#include "task/problem_difference.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "result/resolve.hpp"
#include "result/solution_file.hpp"
#include "task/tasks.hpp"

namespace lamprey::task {

namespace {

constexpr std::size_t most_told = 10;

std::string found_at(const nlohmann::json& document, const std::string& pointer) {
  const nlohmann::json::json_pointer place(pointer);
  return document.contains(place) ? document[place].dump() : "nothing";
}

// What is asked, and not what came out of it.
nlohmann::json question(const result::ResolvedProblem& problem, bool swimmer_alone) {
  nlohmann::json all = nlohmann::json::parse(result::problem_text(problem));
  if (problem.free_duration) {
    all["duration"] = "free";
    all.erase("time_step");
  }
  if (swimmer_alone) return {{"bodies", all["bodies"]}, {"joints", all["joints"]}};
  return all;
}

}  // namespace

std::string path_in_words(const std::string& pointer) {
  std::string words;
  for (std::size_t begin = 1; begin <= pointer.size();) {
    const std::size_t end = std::min(pointer.find('/', begin), pointer.size());
    const std::string part = pointer.substr(begin, end - begin);
    const bool place = !part.empty() && part.find_first_not_of("0123456789") == std::string::npos;
    words += place ? "[" + part + "]" : (words.empty() ? "" : ".") + part;
    begin = end + 1;
  }
  return words;
}

std::vector<std::string> problem_differences(const result::Results& stored, const file::ProblemFile& asked) {
  const bool marched = stored.marched();
  const nlohmann::json is = question(stored.problem, marched);
  const nlohmann::json should_be = question(result::resolve(system_of(asked), asked.problem), marched);
  std::vector<std::string> differences;
  std::size_t left = 0;
  for (const nlohmann::json& change : nlohmann::json::diff(is, should_be)) {
    const std::string pointer = change["path"];
    if (differences.size() < most_told)
      differences.push_back(fmt::format("problem.{} is {}, the file asks for {}", path_in_words(pointer),
                                        found_at(is, pointer), found_at(should_be, pointer)));
    else
      ++left;
  }
  if (left > 0) differences.push_back(fmt::format("{} more fields differ", left));
  return differences;
}

std::vector<std::string> march_differences(const result::Results& stored, const file::ProblemFile& asked) {
  std::vector<std::string> differences;
  if (!stored.marched()) return differences;
  const nlohmann::json is = question(stored.problem, false);
  const nlohmann::json should_be = question(result::resolve(system_of(asked), asked.problem), false);
  for (const char* key : {"start", "duration", "steps", "scheme"})
    if (is.value(key, nlohmann::json()) != should_be.value(key, nlohmann::json())) differences.emplace_back(key);
  return differences;
}

}  // namespace lamprey::task
