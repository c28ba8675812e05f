// What the command line takes, and what it says to words that it does not take.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "commands.hpp"

namespace lamprey::app {

/// Of all commands together.
struct Arguments {
  SolveArguments solve;
  SimulateArguments simulate;
  VerifyArguments verify;
  std::string problem, folder;
  std::vector<std::string> folders;
  std::vector<double> semi_axes;
  double density = 0.0;
  bool json = false;
  bool peers = false;
  bool quick = false;
};

/// Adds all commands with their options, which write into `arguments`.
void describe(CLI::App& app, Arguments& arguments);

/// Says what a first word that is no command could mean; done where it is one, or an option.
int refuse_unknown_command(const CLI::App& app, int count, char** words);

/// Says what an option that the command does not have could mean; done where there is none.
int refuse_unknown_option(const CLI::App& app, int count, char** words);

}  // namespace lamprey::app
