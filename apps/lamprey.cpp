// The command line of Lamprey: arguments in, exit code out; what they mean is in arguments.cpp, the work in commands.cpp.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "commands.hpp"
#include "help.hpp"
#include "interrupt.hpp"

namespace {

using namespace lamprey::app;

// The command as typed, for provenance.
std::string typed(int count, char** words) {
  std::string line = "lamprey";
  for (int i = 1; i < count; ++i) line += std::string(" ") + words[i];
  return line;
}

// Becomes lamprey_bench, or the script that also measures peers; both sit beside this program, wherever it was called from.
int run_bench(bool peers, bool quick) {
  const std::filesystem::path folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  const std::string bench = folder / "lamprey_bench", with_peers = folder / "lamprey_bench_peers";
  for (const std::string& beside : {bench, with_peers}) {
    if ((peers || beside == bench) && access(beside.c_str(), X_OK) != 0) {
      fmt::print(stderr, "lamprey: {} is missing; ./dev bench builds it\n", beside);
      return program_missing;
    }
  }
  if (peers)
    execl(with_peers.c_str(), with_peers.c_str(), bench.c_str(), quick ? "--quick" : nullptr,
          static_cast<char*>(nullptr));
  else
    execl(bench.c_str(), bench.c_str(), static_cast<char*>(nullptr));
  fmt::print(stderr, "lamprey: {} does not start\n", peers ? with_peers : bench);
  return program_missing;
}

int dispatch(const CLI::App& app, const Arguments& arguments) {
  if (app.got_subcommand("solve")) return solve(arguments.solve);
  if (app.got_subcommand("simulate")) return simulate(arguments.simulate);
  if (app.got_subcommand("check")) return check(arguments.problem);
  if (app.got_subcommand("verify")) return verify(arguments.verify);
  if (app.got_subcommand("report")) return report(arguments.folders);
  if (app.got_subcommand("export")) return export_tables(arguments.folder);
  if (app.got_subcommand("inertia")) return inertia(arguments.semi_axes, arguments.density, arguments.json);
  return run_bench(arguments.peers, arguments.quick);
}

int run(int count, char** words) {
  CLI::App app("Optimal maneuvers and gaits of articulated swimmers in an ideal fluid", "lamprey");
  app.set_version_flag("--version", version_line(), "print version, build type and compiler");
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 internal error, 2 usage, 3 invalid input file, 4 no optimal solution,\n"
      "5 numerical failure, 6 input/output, 7 an optional program is missing, 130 interrupted.");
  Arguments arguments;
  describe(app, arguments);
  if (const int refused = refuse_unknown_command(app, count, words)) return refused;
  try {
    app.parse(count, words);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0)
      if (const int refused = refuse_unknown_option(app, count, words)) return refused;
    if (error.get_exit_code() == 0) {  // help or version
      app.exit(error);
      return done;
    }
    fmt::print(stderr, "{}\n", refusal(app, error));
    return usage;
  }
  arguments.solve.command = arguments.simulate.command = typed(count, words);
  return dispatch(app, arguments);
}

}  // namespace

int main(int count, char** words) {
  return guarded([&] { return run(count, words); });
}
