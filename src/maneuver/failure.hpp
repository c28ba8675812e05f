// Why a motion is not the answer that was asked for, in the parts of its message.
#pragma once

#include <string>
#include <vector>

namespace lamprey::maneuver {

struct Failure {
  std::string missed;                 // a sentence
  std::string cause;                  // sentences; empty where nothing is known of it
  std::vector<std::string> remedies;  // clauses, what bears on it first

  bool any() const { return !missed.empty(); }

  /// All of it, as a message begins with it.
  std::string text() const {
    std::string words = missed;
    if (!cause.empty()) words += " " + cause;
    for (std::size_t n = 0; n < remedies.size(); ++n)
      words += (n == 0 ? " What may help: try " : n + 1 < remedies.size() ? ", " : ", or ") + remedies[n];
    return remedies.empty() ? words : words + ".";
  }
};

}  // namespace lamprey::maneuver
