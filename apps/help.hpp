// What `--help` prints, and what is said where words of the command line are missing or too many.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace lamprey::app {

/// Help of the program or of one command: a line of usage, then arguments and options by their groups, wrapped at 100 columns.
class Help : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

/// "lamprey solve PROBLEM --out DIR [options]".
std::string usage_line(const CLI::App& app, const std::string& name);

/// One line on why the command line was refused, and what to give in its place.
std::string refusal(const CLI::App& app, const CLI::ParseError& error);

}  // namespace lamprey::app
