#include "help.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

namespace lamprey::app {

namespace {

constexpr std::size_t columns = 100, widest_name = 26;

using Options = std::vector<const CLI::Option*>;
using Rows = std::vector<std::pair<std::string, std::string>>;  // name, description

// Characters of UTF-8 text: every byte that does not continue one.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

// Words in lines that end before the last column; all but the first are indented.
std::string wrapped(const std::string& words, std::size_t indent) {
  std::string text, line;
  std::istringstream stream(words);
  for (std::string word; stream >> word;) {
    if (!line.empty() && indent + width(line) + 1 + width(word) > columns) {
      text += line + "\n" + std::string(indent, ' ');
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return text + line + "\n";
}

// Names in a column of their own; one that is too wide for it has its description on the next line.
std::string table(const Rows& rows) {
  std::size_t widest = 0;
  for (const auto& [name, description] : rows)
    if (width(name) <= widest_name) widest = std::max(widest, width(name));
  const std::size_t indent = 2 + widest + 2;
  std::string text;
  for (const auto& [name, description] : rows) {
    const bool fits = width(name) <= widest;
    text += "  " + name + (fits ? std::string(indent - 2 - width(name), ' ') : "\n" + std::string(indent, ' ')) +
            wrapped(description, indent);
  }
  return text;
}

bool is_flag(const CLI::Option& option) { return option.get_expected_max() == 0; }

// Without what CLI11 adds for each check.
std::string type(const CLI::Option& option) {
  const std::string name = option.get_type_name();
  return name.substr(0, name.find(':'));
}

// "--out DIR", "-h, --help", "--[no-]refinement", "PROBLEM", "DIR [DIR2]".
std::string name_of(const CLI::Option& option) {
  if (option.get_positional()) {
    const std::string name = option.get_name();
    return option.get_expected_max() > 1 ? fmt::format("{0} [{0}2]", name) : name;
  }
  std::string words;
  const std::vector<std::string>& names = option.get_lnames();
  for (const std::string& letter : option.get_snames()) words += "-" + letter + ", ";
  const bool both = names.size() == 2 && names[1] == "no-" + names[0];
  words += both ? "--[no-]" + names[0] : fmt::format("--{}", fmt::join(names, ", --"));
  return is_flag(option) ? words : words + " " + type(option);
}

template <typename Wanted>
Options options_of(const CLI::App& app, const Wanted& wanted) {
  return app.get_options([&](const CLI::Option* option) { return wanted(*option); });
}

std::string section(const std::string& title, const Options& options) {
  if (options.empty()) return "";
  Rows rows;
  for (const CLI::Option* option : options) rows.emplace_back(name_of(*option), option->get_description());
  return "\n" + title + ":\n" + table(rows);
}

std::string commands_section(const CLI::App& app) {
  Rows rows;
  for (const CLI::App* command : app.get_subcommands(nullptr))
    rows.emplace_back(command->get_name(), command->get_description());
  return rows.empty() ? "" : "\nCommands (lamprey COMMAND --help tells their options):\n" + table(rows);
}

// "--out DIR: folder for …"; of an argument its description alone.
std::string to_give(const CLI::Option& option) {
  if (option.get_positional()) return option.get_description();
  return name_of(option) + " (" + option.get_description() + ")";
}

}  // namespace

std::string usage_line(const CLI::App& app, const std::string& name) {
  std::string line = name + (app.get_subcommands(nullptr).empty() ? "" : " COMMAND");
  for (const CLI::Option* option : options_of(app, [](const CLI::Option& each) { return each.get_positional(); }))
    line += " " + name_of(*option);
  const auto required = [](const CLI::Option& each) { return each.get_required() && !each.get_positional(); };
  for (const CLI::Option* option : options_of(app, required)) line += " " + name_of(*option);
  const auto optional = [&](const CLI::Option& each) {
    return !each.get_required() && !each.get_positional() && &each != app.get_help_ptr();
  };
  return line + (options_of(app, optional).empty() ? "" : " [options]");
}

std::string Help::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode /*mode*/) const {
  std::string text = "Usage: " + usage_line(*app, name) + "\n\n" + wrapped(app->get_description(), 0);
  text += commands_section(*app);
  text += section("Arguments", options_of(*app, [](const CLI::Option& each) { return each.get_positional(); }));
  std::vector<std::string> groups = app->get_groups();
  std::stable_partition(groups.begin(), groups.end(), [](const std::string& group) { return group != "Options"; });
  for (const std::string& group : groups) {
    Options options =
        options_of(*app, [&](const CLI::Option& each) { return !each.get_positional() && each.get_group() == group; });
    std::stable_partition(options.begin(), options.end(),
                          [&](const CLI::Option* each) { return each != app->get_help_ptr(); });
    text += section(group, options);
  }
  return app->get_parent() == nullptr ? text + "\n" + app->get_footer() + "\n" : text;
}

std::string refusal(const CLI::App& app, const CLI::ParseError& error) {
  const std::vector<CLI::App*> chosen = app.get_subcommands();
  std::string what = error.what();
  if (chosen.empty()) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
    return fmt::format("lamprey: give a command, one of {}; lamprey --help tells what they do", fmt::join(names, ", "));
  }
  const CLI::App& command = *chosen.front();
  const std::string name = "lamprey " + command.get_name();
  const auto give = [&](const Options& options) {
    std::vector<std::string> words;
    for (const CLI::Option* option : options) words.push_back(to_give(*option));
    return fmt::format("{}: give {}", name, fmt::join(words, " and "));
  };
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    const Options missing =
        options_of(command, [](const CLI::Option& each) { return each.get_required() && each.count() == 0; });
    if (!missing.empty()) return give(missing);
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    const Options meant =
        options_of(command, [&](const CLI::Option& each) { return what.starts_with(each.get_name() + ":"); });
    if (!meant.empty()) return give(meant);
  }
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
    return fmt::format("{}: found \"{}\" beyond what it takes; usage: {}", name,
                       fmt::join(command.remaining(), "\", \""), usage_line(command, name));
  return fmt::format("{}: {}", name, what);
}

}  // namespace lamprey::app
