// lamprey_bench: what Lamprey's parts take on this machine, as least and median processor time of repeated measurements.
#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "result/resolve.hpp"
#include "swimmers.hpp"

namespace lamprey::bench {

void register_steps();
void register_maneuvers();

namespace {

// One line for each benchmark: least and median processor time, and what it counted.
class Table : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override {
    const result::Provenance here = result::provenance_here();
    fmt::print("lamprey {}, {} build, {}\n{}\n", here.version, here.build_type, here.compiler, here.machine);
    if (here.build_type != "Release")
      fmt::print("WARNING: a {} build is slow; these times say little. Use ./dev bench.\n", here.build_type);
    fmt::print("\n{:<42} {:>10} {:>10}\n", "processor time, one thread", "least", "median");
    std::fflush(stdout);
    return true;
  }

  void ReportRuns(const std::vector<Run>& runs) override {
    const auto named = [&runs](const std::string& name) {
      return std::find_if(runs.begin(), runs.end(), [&](const Run& run) { return run.aggregate_name == name; });
    };
    if (runs.front().error_occurred) {
      fmt::print("{:<42} {}\n", runs.front().run_name.str(), runs.front().error_message);
      return;
    }
    const auto median = named("median");
    const auto least = named("min");
    if (median == runs.end() || least == runs.end()) return;
    fmt::print("{:<42} {:>10} {:>10} {}", median->run_name.function_name + argument_of(*median),
               digits(least->GetAdjustedCPUTime()), digits(median->GetAdjustedCPUTime()),
               benchmark::GetTimeUnitString(median->time_unit));
    for (const auto& [name, counter] : median->counters) fmt::print("  {} {}", name, digits(counter.value));
    fmt::print("\n");
    std::fflush(stdout);
  }

 private:
  static std::string digits(double value) {
    return value < 1000.0 ? fmt::format("{:.3g}", value) : fmt::format("{:.0f}", value);
  }
  static std::string argument_of(const Run& run) { return run.run_name.args.empty() ? "" : " " + run.run_name.args; }
};

// The numbers of an array, row by row.
template <typename Array>
nlohmann::json numbers(const Array& array) {
  return std::vector<double>(array.data(), array.data() + array.size());
}

// One chain and its march: bodies in order from the root, joints by body names, moments [N+1][joints] N m.
nlohmann::json chain(const model::SwimmerDescription& swimmer) {
  nlohmann::json bodies, joints, moments;
  for (const model::BodyDescription& body : swimmer.bodies)
    bodies.push_back({{"name", body.name},
                      {"mass_matrix", numbers(body.mass_matrix.value())},
                      {"inertia_matrix", numbers(body.inertia_matrix.value())}});
  for (const model::JointDescription& joint : swimmer.joints)
    joints.push_back({{"parent", joint.parent},
                      {"child", joint.child},
                      {"parent_offset", numbers(joint.parent_offset)},
                      {"child_offset", numbers(joint.child_offset)}});
  const March march(swimmer, mechanics::DiscreteLagrangian::trapezoid);
  for (const mechanics::Moments& node : march.moments) {
    nlohmann::json at_node;
    for (const Eigen::Vector3d& moment : node) at_node.push_back(numbers(moment));
    moments.push_back(at_node);
  }
  return {{"bodies", bodies}, {"joints", joints}, {"time_step", March::time_step}, {"moments", moments}};
}

// The chains that are marched, for programs that measure the same ones.
bool write_chains(const std::string& path) {
  nlohmann::json chains = {chain(paper_chain())};
  for (int bodies : {5, 10, 20}) chains.push_back(chain(outer_body_chain(bodies)));
  std::ofstream stream(path);
  stream << chains << std::endl;
  return stream.good();
}

// Takes --chains_out=FILE out of the arguments.
std::optional<std::string> taken_chains_out(std::vector<char*>& arguments) {
  const std::string key = "--chains_out=";
  for (auto word = arguments.begin(); word != arguments.end(); ++word)
    if (std::string(*word).rfind(key, 0) == 0) {
      const std::string path = std::string(*word).substr(key.size());
      arguments.erase(word);
      return path;
    }
  return std::nullopt;
}

}  // namespace

}  // namespace lamprey::bench

int main(int count, char** words) {
  std::vector<char*> arguments(words, words + count);
  const std::optional<std::string> chains_out = lamprey::bench::taken_chains_out(arguments);
  // defaults come first, so that the caller's come last and win
  std::string defaults[] = {"--benchmark_repetitions=5", "--benchmark_report_aggregates_only=true",
                            "--benchmark_min_time=0.1"};
  for (std::string& word : defaults) arguments.insert(arguments.begin() + 1, word.data());
  int arguments_left = static_cast<int>(arguments.size());
  benchmark::Initialize(&arguments_left, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(arguments_left, arguments.data())) return 2;
  if (chains_out && !lamprey::bench::write_chains(*chains_out)) {
    fmt::print(stderr, "lamprey_bench: cannot write {}\n", *chains_out);
    return 6;
  }
  lamprey::bench::register_steps();
  lamprey::bench::register_maneuvers();
  lamprey::bench::Table table;
  return benchmark::RunSpecifiedBenchmarks(&table) == 0 ? 2 : 0;
}
