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
#include <system_error>
#include <utility>

#include "file/problem_file.hpp"
#include "file/toml_reader.hpp"
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

void describe_solve(CLI::App& app, Arguments& arguments) {
  CLI::App* solve = app.add_subcommand("solve", "Find the maneuver of a problem file and prove it");
  solve->add_option("problem", arguments.solve.problem, "problem file (TOML)")->required();
  solve->add_option("--out", arguments.solve.out, "folder for solution.json, trajectory.h5, report.html")
      ->required()
      ->check(named());
  solve->add_option("--workers", arguments.solve.workers, "threads for multi-start (default: one for each core)")
      ->transform(whole_number(1, task::most_workers));
  solve
      ->add_option("--solver", arguments.solve.solver,
                   "newton: our own along the steps; ipopt: the full transcription; both: both from the same first "
                   "guesses, into one catalogue of minima (default: newton where it can)")
      ->check(CLI::IsMember({"newton", "ipopt", "both"}));
  // not into the optional: absent flags would set it
  solve->add_flag_function(
      "--refinement,!--no-refinement", [&arguments](std::int64_t times) { arguments.solve.refinement = times > 0; },
      "solve on half and on twice the steps too, for the certificate's refinement (default: with newton)");
  solve
      ->add_option(
          "--first", arguments.solve.first,
          "folder of a stored motion of the same bodies and joints: the first guess, in the place of a random one")
      ->transform(folder());
  solve
      ->add_option(
          "--keep", arguments.solve.keep,
          "minima to write, by rising cost, instead of the file's search.keep; the second into DIR/minimum_2 ...")
      ->transform(whole_number(1, 1000));
  solve->add_flag("--resolve", arguments.solve.resolve,
                  "where the file's steps do not resolve the answer, solve from it on again on more, until they do");
  solve->add_option("--starts", arguments.solve.starts, "first guesses to try, instead of the file's search.starts")
      ->transform(whole_number(1, 1'000'000));
  solve->add_option("--seed", arguments.solve.seed, "of the first guesses, instead of the file's search.seed")
      ->transform(seed());
  solve
      ->add_option("--time-limit", arguments.solve.time_limit,
                   "s, instead of the file's search.time_limit; the best motion is refined and proved for half as long "
                   "again, or what one pass over the steps takes")
      ->check(positive());
  solve->add_flag("--json", arguments.solve.json, "print solution.json on standard output");
}

void describe_simulate(CLI::App& app, Arguments& arguments) {
  CLI::App* simulate =
      app.add_subcommand("simulate", "March from the start under given moments or none, or along given joint angles");
  simulate->add_option("problem", arguments.simulate.problem, "problem file (TOML)")->required();
  simulate->add_option("--out", arguments.simulate.out, "folder for solution.json, trajectory.h5, report.html")
      ->required()
      ->check(named());
  CLI::Option* controls = simulate->add_option(
      "--controls", arguments.simulate.controls,
      "solution.json or its folder, or CSV: t, then 3 columns for each joint: N m on the parent, in the parent's frame "
      "with "
      "the joint at its zero angle; what the joint cannot exert is left out. A header names joints in any order: "
      "\"fin x\", or a hinge's name alone for its moment along its axis");
  simulate
      ->add_option(
          "--interpolation", arguments.simulate.interpolation,
          "linear | cubic (default) between the rows of a CSV: a cubic (not-a-knot) swings beyond rows that jump")
      ->check(CLI::IsMember({"linear", "cubic"}))
      ->needs(controls);
  CLI::Option* angles = simulate->add_option(
      "--angles", arguments.simulate.angles,
      "solution.json or its folder, or CSV: t, then the angle of each hinge (rad), two of a universal joint, of a ball "
      "joint x, y, z "
      "of its "
      "rotation vector: the march follows them, a cubic from row to row, and finds the moments. A header names "
      "joints in any order, all with a unit or none: \"tail (deg)\", \"fin 1 (deg)\", \"spine x (rad)\"; joints with "
      "actuated = false that it leaves out "
      "move as they do");
  angles->excludes(controls);
  CLI::Option* scheme = simulate->add_option("--scheme", arguments.simulate.scheme,
                                             "paper | trapezoid | midpoint | order4 | order6 instead of the file's");
  CLI::Option* adaptive =
      simulate->add_flag("--adaptive", arguments.simulate.adaptive,
                         "divide steps that do not converge, into 4096 at most, instead of ending there");
  CLI::Option* feedback = simulate
                              ->add_option("--feedback", arguments.simulate.feedback,
                                           "folder of a maneuver: follow it by its moments and gains")
                              ->transform(folder())
                              ->excludes(controls)
                              ->excludes(angles);
  simulate
      ->add_option("--feedback-from", arguments.simulate.feedback_from,
                   "s of the maneuver's time, at which the march begins, from the problem's start (default 0); without "
                   "--duration it follows the rest")
      ->needs(feedback)
      ->check(number_in(0.0, std::numeric_limits<double>::max(), "a number >= 0 (s)"));
  simulate
      ->add_flag("--reference", arguments.simulate.reference,
                 "march the continuous equations by a Runge-Kutta method of order 8 instead of a scheme")
      ->excludes(scheme)
      ->excludes(adaptive)
      ->excludes(angles);
  adaptive->excludes(angles);
  simulate
      ->add_option("--perturb", arguments.simulate.perturb,
                   "rad by which each body is turned at the start about a random axis; with --feedback one that the "
                   "gains answer; total momentum stays that of the start")
      ->check(number_in(0.0, 3.0, "a number from 0 to 3 (rad)"))
      ->excludes(angles);
  simulate
      ->add_option("--perturb-inertia", arguments.simulate.perturb_inertia,
                   "share of itself by which each body's mass and inertia, fluid included, differ at most from the "
                   "file's, drawn at random: 0.05 for 5 %; total momentum stays that of the start")
      ->check(number_in(0.0, 0.9, "a number from 0 to 0.9"));
  simulate->add_option("--seed", arguments.simulate.seed, "of the random axes and shares (default 1)")
      ->transform(seed());
  simulate->add_option("--steps", arguments.simulate.steps, "number of steps instead of the file's")
      ->transform(whole_number(1, file::step_limit));
  simulate
      ->add_option("--cycles", arguments.simulate.cycles,
                   "how often the gait of --controls or --feedback, or the period of a table, is repeated (default "
                   "1); --steps and --duration are of all "
                   "cycles together")
      ->transform(whole_number(1, task::most_cycles));
  simulate->add_option("--duration", arguments.simulate.duration, "s, instead of the file's")->check(positive());
}

void describe_others(CLI::App& app, Arguments& arguments) {
  CLI::App* check = app.add_subcommand("check", "Validate a problem file and print the resolved model");
  check->add_option("problem", arguments.problem, "problem file (TOML)")->required();
  CLI::App* verify = app.add_subcommand(
      "verify", "Recompute the certificate from the files alone; refinement, which takes solving, is kept as stored");
  verify->add_option("folder", arguments.verify.folder, "folder of a solution.json")->required()->transform(folder());
  verify->add_option("--problem", arguments.verify.problem,
                     "problem file (TOML) whose question the answer has to be one to");
  CLI::App* report = app.add_subcommand("report", "Write the report again; with two folders, compare them");
  report->add_option("folders", arguments.folders, "one folder, or two to compare")
      ->required()
      ->expected(1, 2)
      ->transform(folder());
  CLI::App* tables = app.add_subcommand(
      "export",
      "Write a motion's joint angles and moments as tables, angles.csv and moments.csv, as simulate reads them");
  tables->add_option("folder", arguments.folder, "folder of a solution.json, into which they go")
      ->required()
      ->transform(folder());
  CLI::App* inertia = app.add_subcommand(
      "inertia", "Mass and inertia of an ellipsoid, or of an ellipse in the plane, with the fluid it drags along");
  inertia
      ->add_option("--semi-axes", arguments.semi_axes,
                   "m, half lengths: three of an ellipsoid, or two of an ellipse in the plane, one metre deep")
      ->required()
      ->expected(-2);
  inertia->add_option("--density", arguments.density, "kg/m³ of the fluid")->required();
  inertia->add_flag("--json", arguments.json, "print one JSON document");
  CLI::App* bench = app.add_subcommand("bench", "Time steps, derivatives and solves on this machine");
  bench->add_flag("--peers", arguments.peers,
                  "also measure Pinocchio, Crocoddyl, MuJoCo and CasADi with Ipopt from PyPI on the same chain");
  bench->add_flag("--quick", arguments.quick, "with --peers: maneuvers alone, few first guesses, coarse grids")
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
