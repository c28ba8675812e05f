// Guarded JSON: parsing that refuses what the library would swallow, and typed access by JSON pointer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace lamprey::document {

/// A value of a JsonDocument and where it stands. Every refusal is a model::InputError with the file and the JSON pointer as key.
/// The document must outlive the reader.
class JsonReader {
 public:
  JsonReader(const nlohmann::json& value, std::string pointer, const std::string& path);

  [[noreturn]] void refuse(const std::string& allowed) const;

  bool is_null() const;
  bool is_boolean() const;
  bool is_array() const;
  bool is_object() const;
  bool is_text(std::string_view text) const;
  bool has(const char* name) const;
  std::size_t size() const;
  JsonReader at(const char* name) const;
  JsonReader at(std::size_t index) const;
  std::vector<std::string> keys() const;
  /// Refuses members of other names, which would be read as nothing.
  void allow_only(std::initializer_list<std::string_view> names) const;

  void require_array() const;
  void require_array(std::size_t length) const;
  double number() const;
  double number_or_nan() const;  // NaN for null
  std::string text() const;
  bool boolean() const;
  int integer(int low, int high) const;
  std::uint64_t unsigned_integer() const;

 private:
  const nlohmann::json* value_;
  std::string pointer_;
  const std::string* path_;
};

/// A parsed JSON text. The constructor throws model::InputError with line and column for syntax errors, and with the key for keys
/// given twice and nesting deeper than 64.
class JsonDocument {
 public:
  JsonDocument(const std::string& text, std::string path);
  ~JsonDocument();
  JsonDocument(const JsonDocument&) = delete;
  JsonDocument& operator=(const JsonDocument&) = delete;

  JsonReader root() const { return {*value_, "", path_}; }

 private:
  std::string path_;
  std::unique_ptr<nlohmann::json> value_;
};

}  // namespace lamprey::document
