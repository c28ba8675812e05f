#pragma once

#include <string>

#include <fmt/format.h>

#include "document/json_document.hpp"

namespace lamprey::document {

/// The value whose word stands there, from one of the tables of file/words.hpp.
template <class Entries>
auto read_word(const JsonReader& reader, const Entries& entries) {
  const std::string text = reader.text();
  std::string allowed;
  for (const auto& entry : entries) {
    if (entry.text == text) return entry.value;
    allowed += fmt::format("{}\"{}\"", allowed.empty() ? "" : ", ", entry.text);
  }
  reader.refuse(allowed);
}

}  // namespace lamprey::document
