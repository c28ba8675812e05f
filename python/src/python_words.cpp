#include "python_words.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace lamprey::python {

namespace {

enum class Takes { value, nothing, word };

struct Option {
  std::string_view name;
  Takes takes;
};

// Those of solve and simulate that both have, as the command line spells them.
constexpr std::array options = {
    Option{"adaptive", Takes::nothing},      Option{"angles", Takes::value},      Option{"controls", Takes::value},
    Option{"cycles", Takes::value},          Option{"duration", Takes::value},    Option{"feedback", Takes::value},
    Option{"feedback-from", Takes::value},   Option{"first", Takes::value},       Option{"perturb", Takes::value},
    Option{"perturb-inertia", Takes::value}, Option{"reference", Takes::nothing}, Option{"resolve", Takes::nothing},
    Option{"scheme", Takes::value},          Option{"seed", Takes::value},        Option{"solver", Takes::word},
    Option{"steps", Takes::value},           Option{"time-limit", Takes::value},  Option{"workers", Takes::value}};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || c == '-'; }

// How many characters from a place on are of a kind.
template <class Kind>
std::size_t run(std::string_view text, std::size_t from, Kind kind) {
  std::size_t end = from;
  while (end < text.size() && kind(text[end])) ++end;
  return end - from;
}

// A number, or the word that follows a blank; empty where the option stands alone.
std::string_view argument(std::string_view rest, Takes takes) {
  if (takes == Takes::nothing || rest.size() < 2 || rest[0] != ' ') return {};
  const auto of_number = [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == 'e' || c == '+' || c == '-'; };
  std::size_t size = 0;
  if (takes == Takes::word)
    size = run(rest, 1, is_letter);
  else if (rest[1] >= '0' && rest[1] <= '9')
    size = run(rest, 1, of_number);
  while (size > 0 && rest[size] == '.') --size;  // the sentence's
  return rest.substr(1, size);
}

// Takes the end off a text; whether it had it.
bool take_end(std::string& text, std::string_view end) {
  if (!text.ends_with(end)) return false;
  text.resize(text.size() - end.size());
  return true;
}

}  // namespace

std::string in_python_words(const std::string& message) {
  std::string words;
  std::size_t at = 0;
  for (std::size_t dashes = message.find("--"); dashes != std::string::npos; dashes = message.find("--", at)) {
    words += message.substr(at, dashes - at);
    const std::string_view rest = std::string_view(message).substr(dashes + 2);
    const std::string_view name = rest.substr(0, run(rest, 0, is_letter));
    const auto option =
        std::find_if(options.begin(), options.end(), [&](const Option& one) { return one.name == name; });
    const bool begins = words.empty() || words.back() == ' ' || words.back() == '(' || words.back() == '[';
    if (option == options.end() || !begins) {
      words += "--";
      at = dashes + 2;
      continue;
    }
    std::string keyword(name);
    std::replace(keyword.begin(), keyword.end(), '-', '_');
    const std::string_view value = argument(rest.substr(name.size()), option->takes);
    keyword += option->takes == Takes::nothing                  ? "=True"
               : option->takes == Takes::word && !value.empty() ? "=\"" + std::string(value) + "\""
                                                                : "=" + std::string(value);
    for (const char* call : {"solve", "simulate"})
      if (take_end(words, std::string("lamprey ") + call + " "))
        keyword = std::string("lamprey.") + call + "(" + keyword + ")";
    words += keyword;
    at = dashes + 2 + name.size() + (value.empty() ? 0 : value.size() + 1);
  }
  return words + message.substr(at);
}

}  // namespace lamprey::python
