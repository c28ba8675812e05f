// lamprey_bench: what Lamprey's parts take on this machine, as least and median processor time of repeated measurements.
#include <benchmark/benchmark.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "file/resolve.hpp"

namespace lamprey::bench {

void register_steps();
void register_maneuvers();

namespace {

// One line for each benchmark: least and median processor time, and what it counted.
class Table : public benchmark::BenchmarkReporter {
 public:
  bool ReportContext(const Context&) override {
    const file::Provenance here = file::provenance_here();
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

}  // namespace

}  // namespace lamprey::bench

int main(int count, char** words) {
  std::vector<char*> arguments(words, words + count);
  // defaults come first, so that the caller's come last and win
  std::string defaults[] = {"--benchmark_repetitions=5", "--benchmark_report_aggregates_only=true",
                            "--benchmark_min_time=0.1"};
  for (std::string& word : defaults) arguments.insert(arguments.begin() + 1, word.data());
  int arguments_left = static_cast<int>(arguments.size());
  benchmark::Initialize(&arguments_left, arguments.data());
  if (benchmark::ReportUnrecognizedArguments(arguments_left, arguments.data())) return 2;
  lamprey::bench::register_steps();
  lamprey::bench::register_maneuvers();
  lamprey::bench::Table table;
  return benchmark::RunSpecifiedBenchmarks(&table) == 0 ? 2 : 0;
}
