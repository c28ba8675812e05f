#include "arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <system_error>
#include <utility>

#include "file/problem_file.hpp"
#include "file/toml_reader.hpp"
#include "help.hpp"
#include "task/choices.hpp"

namespace lamprey::app {

namespace {

// A number from `least` to `most`, or above 0; neither words nor nan, which CLI11's own ranges let through.
CLI::Validator number_in(double least, double most, const std::string& allowed) {
  return {[=](const std::string& text) {
            char* end = nullptr;
            const double value = std::strtod(text.c_str(), &end);
            const bool is = !text.empty() && *end == '\0' && std::isfinite(value) && value >= least && value <= most;
            return is ? std::string() : "found " + text + "; allowed: " + allowed;
          },
          "", "number"};
}

CLI::Validator positive() {
  constexpr double least = std::numeric_limits<double>::denorm_min(), most = std::numeric_limits<double>::max();
  return number_in(least, most, "a number > 0");
}

// Of a solution.json its folder.
CLI::Validator folder() {
  return CLI::Validator(
      [](std::string& text) {
        const std::filesystem::path path(text);
        if (path.filename() == "solution.json") text = path.has_parent_path() ? path.parent_path().string() : ".";
        return std::string();
      },
      "", "folder");
}

// An unset variable of the shell is no folder.
CLI::Validator named() {
  return CLI::Validator(
      [](const std::string& text) {
        return text.empty() ? std::string("found \"\"; allowed: a folder's name; give one (\".\" is this folder)") : "";
      },
      "");
}

// Digits alone: CLI11 would wind a minus sign round, take the largest for what is too large, and eights for tens behind a zero.
CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
  return CLI::Validator(
      [=](std::string& text) {
        std::uint64_t value = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        if (text.empty() || stop != end || error != std::errc() || value < least || value > most)
          return fmt::format("found {}; allowed: a whole number from {} to {}", text.empty() ? "\"\"" : text, least,
                             most);
        text = fmt::format("{}", value);
        return std::string();
      },
      fmt::format("from {} to {}", least, most), "whole number");
}

CLI::Validator seed() { return whole_number(0, std::numeric_limits<std::int64_t>::max()); }  // as problem files

// One of a few words.
CLI::Validator one_of(const std::vector<std::string>& words) {
  return {[=](const std::string& text) {
            return std::count(words.begin(), words.end(), text) > 0
                       ? std::string()
                       : fmt::format("found {}; allowed: {}", text.empty() ? "\"\"" : text, fmt::join(words, ", "));
          },
          "", "word"};
}

CLI::Option* add_problem(CLI::App& command, std::string& problem) {
  return command.add_option("PROBLEM", problem, "a problem file (TOML)")->required();
}

CLI::Option* add_results_folder(CLI::App& command, std::string& folder) {
  return command.add_option("--out", folder, "folder for the results: solution.json, trajectory.h5 and report.html")
      ->type_name("DIR")
      ->required()
      ->check(named());
}

void describe_search(CLI::App& solve, SolveArguments& arguments) {
  solve
      .add_option("--solver", arguments.solver,
                  "newton: Lamprey's own; ipopt: full transcription with Ipopt; both: run both and merge their minima "
                  "(default: newton where it takes the problem)")
      ->type_name("NAME")
      ->check(one_of({"newton", "ipopt", "both"}));
  solve.add_option("--starts", arguments.starts, "number of first guesses; overrides search.starts")
      ->type_name("N")
      ->transform(whole_number(1, 1'000'000));
  solve.add_option("--seed", arguments.seed, "seed of the random first guesses; overrides search.seed")
      ->type_name("N")
      ->transform(seed());
  solve
      .add_option("--first", arguments.first,
                  "folder of a result for the same bodies and joints: begin at its motion instead of at a random one")
      ->type_name("DIR")
      ->transform(folder());
  solve
      .add_option(
          "--time-limit", arguments.time_limit,
          "search for this many seconds; overrides search.time_limit. Refining and proving the best motion then "
          "takes up to half as long again, or as long as one pass over the steps")
      ->type_name("S")
      ->check(positive());
  solve.add_option("--workers", arguments.workers, "number of threads (default: one for each core)")
      ->type_name("N")
      ->transform(whole_number(1, task::most_workers));
  for (CLI::Option* option : solve.get_options({}))
    if (!option->get_positional() && option->get_group() == "Options" && option != solve.get_help_ptr())
      option->group("Search");
}

void describe_solve(CLI::App& app, Arguments& arguments) {
  CLI::App* solve = app.add_subcommand("solve", "Find the best motion for a problem file and prove it a minimum");
  add_problem(*solve, arguments.solve.problem);
  add_results_folder(*solve, arguments.solve.out)->group("Results");
  solve
      ->add_option("--keep", arguments.solve.keep,
                   "write the N cheapest minima (DIR, DIR/minimum_2, ...); overrides search.keep")
      ->type_name("N")
      ->group("Results")
      ->transform(whole_number(1, 1000));
  solve->add_flag("--json", arguments.solve.json, "print solution.json instead of the summary")->group("Results");
  describe_search(*solve, arguments.solve);
  solve
      ->add_flag("--resolve", arguments.solve.resolve,
                 "where the time step is too coarse, solve again with more steps until it is not")
      ->group("Accuracy");
  // not into the optional: absent flags would set it
  solve
      ->add_flag_function(
          "--refinement,!--no-refinement", [&arguments](std::int64_t times) { arguments.solve.refinement = times > 0; },
          "also solve with half and with twice the steps, to see how the cost depends on them (default: with newton)")
      ->group("Accuracy");
}

void describe_what_moves(CLI::App& simulate, SimulateArguments& arguments) {
  const char* group = "What moves the joints (none of these: nothing does)";
  CLI::Option* controls =
      simulate
          .add_option(
              "--controls", arguments.controls,
              "moments to apply: a result (its folder or solution.json) or a CSV table: t, then 3 columns per "
              "joint, N m on the parent, in the parent's frame with the joint at its zero angle; what the joint "
              "cannot exert is ignored. With a header the joints come in any order: \"fin x\", or the name "
              "of a hinge alone for the moment about its axis")
          ->type_name("FILE")
          ->group(group);
  simulate
      .add_option("--interpolation", arguments.interpolation,
                  "between the rows of a CSV table of moments: linear or cubic (default: linear where lamprey export "
                  "wrote it, else cubic, not-a-knot, which overshoots where rows jump)")
      ->type_name("NAME")
      ->group(group)
      ->check(one_of({"linear", "cubic"}))
      ->needs(controls);
  CLI::Option* angles =
      simulate
          .add_option("--angles", arguments.angles,
                      "joint angles to follow, whatever moments that takes: a result (its folder or solution.json) or "
                      "a CSV table, cubic between its rows: t, then one angle per hinge (rad), two per universal "
                      "joint, x, y, z of the rotation vector per ball joint. With a header the joints come in any "
                      "order, all with a unit or none: \"tail (deg)\", \"fin 1 (deg)\", \"spine x (rad)\"; "
                      "joints with actuated = false may be left out and then move freely. Not with --controls")
          ->type_name("FILE")
          ->group(group)
          ->excludes(controls);
  CLI::Option* feedback = simulate
                              .add_option("--feedback", arguments.feedback,
                                          "folder of a solved maneuver: follow it by its moments and feedback gains. "
                                          "Not with --controls or --angles")
                              ->type_name("DIR")
                              ->group(group)
                              ->transform(folder())
                              ->excludes(controls)
                              ->excludes(angles);
  simulate
      .add_option("--feedback-from", arguments.feedback_from,
                  "begin this many seconds into that maneuver (default: 0), from the problem's start; without "
                  "--duration the rest of it is followed")
      ->type_name("S")
      ->group(group)
      ->needs(feedback)
      ->check(number_in(0.0, std::numeric_limits<double>::max(), "a number >= 0 (s)"));
  simulate
      .add_option("--cycles", arguments.cycles,
                  "repeat the gait of --controls or --feedback, or the period of a table, N times (default: 1); "
                  "--steps and --duration are then those of all cycles together")
      ->type_name("N")
      ->group(group)
      ->transform(whole_number(1, task::most_cycles));
}

void describe_integration(CLI::App& simulate, SimulateArguments& arguments) {
  const char* group = "Integration";
  CLI::Option* const angles = simulate.get_option("--angles");
  simulate.add_option("--steps", arguments.steps, "number of steps; overrides time.steps")
      ->type_name("N")
      ->group(group)
      ->transform(whole_number(1, file::step_limit));
  simulate.add_option("--duration", arguments.duration, "seconds to simulate; overrides time.duration")
      ->type_name("S")
      ->group(group)
      ->check(positive());
  CLI::Option* scheme = simulate
                            .add_option("--scheme", arguments.scheme,
                                        "paper | trapezoid | midpoint | order4 | order6; overrides integrator.scheme")
                            ->type_name("NAME")
                            ->group(group);
  CLI::Option* adaptive =
      simulate
          .add_flag("--adaptive", arguments.adaptive,
                    "divide steps that do not converge, into 4096 at most, instead of ending there. Not with --angles")
          ->group(group)
          ->excludes(angles);
  simulate
      .add_flag("--reference", arguments.reference,
                "integrate the continuous equations with a Runge-Kutta method of order 8 instead of a scheme. Not with "
                "--scheme, --adaptive or --angles")
      ->group(group)
      ->excludes(scheme)
      ->excludes(adaptive)
      ->excludes(angles);
}

void describe_disturbances(CLI::App& simulate, SimulateArguments& arguments) {
  const char* group = "Disturbances (total momentum stays that of the start)";
  simulate
      .add_option("--perturb", arguments.perturb,
                  "turn each body by this angle about a random axis at the start; with --feedback about one that the "
                  "gains can answer. Not with --angles")
      ->type_name("RAD")
      ->group(group)
      ->check(number_in(0.0, 3.0, "a number from 0 to 3 (rad)"))
      ->excludes(simulate.get_option("--angles"));
  simulate
      .add_option("--perturb-inertia", arguments.perturb_inertia,
                  "scale each body's mass and inertia, fluid included, randomly by up to this share (0.05 = ±5 %)")
      ->type_name("SHARE")
      ->group(group)
      ->check(number_in(0.0, 0.9, "a number from 0 to 0.9"));
  simulate.add_option("--seed", arguments.seed, "seed of these random axes and shares (default: 1)")
      ->type_name("N")
      ->group(group)
      ->transform(seed());
}

void describe_simulate(CLI::App& app, Arguments& arguments) {
  CLI::App* simulate = app.add_subcommand(
      "simulate", "Simulate from the start: under given moments or none, or along given joint angles");
  add_problem(*simulate, arguments.simulate.problem);
  add_results_folder(*simulate, arguments.simulate.out)->group("Results");
  describe_what_moves(*simulate, arguments.simulate);
  describe_integration(*simulate, arguments.simulate);
  describe_disturbances(*simulate, arguments.simulate);
}

void describe_others(CLI::App& app, Arguments& arguments) {
  CLI::App* check = app.add_subcommand("check", "Validate a problem file and print the model as it will be used");
  add_problem(*check, arguments.problem);
  CLI::App* verify = app.add_subcommand(
      "verify",
      "Recompute a result's certificate from its files alone (costs on other grids take solving: kept as stored)");
  verify->add_option("DIR", arguments.verify.folder, "a result's folder")->required()->transform(folder());
  verify->add_option("--problem", arguments.verify.problem, "also check that the answer solves this problem file")
      ->type_name("FILE");
  CLI::App* report = app.add_subcommand("report", "Write a result's report again, or compare two results");
  report->add_option("DIR", arguments.folders, "one result folder, or two to compare")
      ->required()
      ->expected(1, 2)
      ->transform(folder());
  CLI::App* tables = app.add_subcommand(
      "export", "Write a result's joint angles and moments as tables (angles.csv, moments.csv) that simulate reads");
  tables->add_option("DIR", arguments.folder, "a result's folder, into which the tables go")
      ->required()
      ->transform(folder());
  CLI::App* inertia = app.add_subcommand(
      "inertia", "Print mass and inertia of an ellipsoid, or of an ellipse in the plane, with the fluid that it moves");
  inertia
      ->add_option("--semi-axes", arguments.semi_axes,
                   "half lengths, m: three of an ellipsoid, or two of an ellipse in the plane, one metre deep")
      ->type_name("A B [C]")
      ->required()
      ->expected(-2);
  inertia->add_option("--density", arguments.density, "density of the fluid, kg/m³")->type_name("D")->required();
  inertia->add_flag("--json", arguments.json, "print one JSON document instead of a table");
  CLI::App* bench = app.add_subcommand("bench", "Measure how long steps, derivatives and solves take on this machine");
  bench->add_flag("--peers", arguments.peers,
                  "also measure Pinocchio, Crocoddyl, MuJoCo and CasADi with Ipopt, from PyPI, on the same chain");
  bench->add_flag("--quick", arguments.quick, "with --peers: maneuvers alone, from few first guesses, on coarse grids")
      ->needs("--peers");
}

// By other programs' words for the same, or else the nearest one; nothing where none is near.
std::string option_meant(const std::string& word, const std::vector<std::string>& options) {
  static const std::vector<std::pair<std::string, std::string>> other_words = {
      {"--threads", "--workers"}, {"--jobs", "--workers"},       {"-j", "--workers"}, {"-o", "--out"},
      {"--output", "--out"},      {"--timeout", "--time-limit"}, {"-h", "--help"},    {"--warm", "--first"}};
  for (const auto& [other, here] : other_words)
    if (other == word && std::count(options.begin(), options.end(), here) > 0) return here;
  constexpr std::size_t alike = 4;  // letters, dashes among them
  const std::string near = file::nearest(word, options);
  for (std::size_t i = 0; i + alike <= word.size(); ++i)
    if (near.find(word.substr(i, alike)) != std::string::npos) return near;
  return "";
}

}  // namespace

void describe(CLI::App& app, Arguments& arguments) {
  app.formatter(std::make_shared<Help>());  // commands inherit it
  app.set_help_flag("-h,--help", "print this help");
  describe_solve(app, arguments);
  describe_simulate(app, arguments);
  describe_others(app, arguments);
}

int refuse_unknown_command(const CLI::App& app, int count, char** words) {
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands(nullptr)) commands.push_back(command->get_name());
  if (count < 2 || words[1][0] == '-' || std::count(commands.begin(), commands.end(), words[1]) > 0) return done;
  fmt::print(stderr, "lamprey: found \"{}\"; allowed: {}; did you mean \"{}\"?\n", words[1], fmt::join(commands, ", "),
             file::nearest(words[1], commands));
  return usage;
}

int refuse_unknown_option(const CLI::App& app, int count, char** words) {
  if (app.get_subcommands().empty()) return done;
  std::vector<std::string> options;
  const CLI::App& command = *app.get_subcommands().front();
  for (const CLI::Option* option : command.get_options()) {
    if (!option->get_positional()) options.push_back(option->get_name());
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
  }
  std::sort(options.begin(), options.end());
  options.erase(std::unique(options.begin(), options.end()), options.end());
  for (int i = 2; i < count; ++i) {
    std::string word = words[i];
    const bool number = std::strspn(words[i], "-+.eE0123456789") == word.size();
    word = word.substr(0, word.rfind("--", 0) == 0 ? word.find('=') : 2);
    if (word == "--") break;
    if (word.size() < 2 || word[0] != '-' || number || word == "-h" ||
        std::count(options.begin(), options.end(), word) > 0)
      continue;
    fmt::print(stderr, "lamprey {}: found \"{}\"; allowed: {}", command.get_name(), word, fmt::join(options, ", "));
    const std::string meant = option_meant(word, options);
    fmt::print(stderr, "{}\n", meant.empty() ? "" : fmt::format("; did you mean \"{}\"?", meant));
    return usage;
  }
  return done;
}

}  // namespace lamprey::app
