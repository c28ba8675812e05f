#include "document/json_document.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "document/text_file.hpp"
#include "model/input_error.hpp"

namespace lamprey::document {

using Json = nlohmann::json;

namespace {

struct Place {
  int line = 1;
  int column = 1;
};

Place place_of(const std::string& text, std::size_t at) {
  const std::size_t end = std::min(at, text.size());
  const auto stop = text.begin() + static_cast<std::ptrdiff_t>(end);
  const std::size_t newline = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
  const std::size_t start = newline == std::string::npos ? 0 : newline + 1;
  return {static_cast<int>(std::count(text.begin(), stop, '\n')) + 1, static_cast<int>(end - start) + 1};
}

// Builds the document by the library's own builder, which sees only what passed the guards.
class GuardedBuilder : public nlohmann::json_sax<Json> {
 public:
  GuardedBuilder(Json& document, const std::string& path) : builder_(document, true), path_(path) {}

  bool null() override { return builder_.null(); }
  bool boolean(bool value) override { return builder_.boolean(value); }
  bool number_integer(number_integer_t value) override { return builder_.number_integer(value); }
  bool number_unsigned(number_unsigned_t value) override { return builder_.number_unsigned(value); }
  bool number_float(number_float_t value, const string_t& text) override { return builder_.number_float(value, text); }
  bool string(string_t& value) override { return builder_.string(value); }
  bool binary(binary_t& value) override { return builder_.binary(value); }
  bool start_object(std::size_t size) override {
    enter();
    return builder_.start_object(size);
  }
  bool end_object() override {
    keys_.pop_back();
    return builder_.end_object();
  }
  bool start_array(std::size_t size) override {
    enter();
    return builder_.start_array(size);
  }
  bool end_array() override {
    keys_.pop_back();
    return builder_.end_array();
  }
  bool key(string_t& name) override {
    if (!keys_.back().insert(name).second)
      throw model::InputError(path_, Json(name).dump(-1, ' ', true, Json::error_handler_t::replace),
                              "found this key a second time; allowed: once in an object; remove one of the two");
    return builder_.key(name);
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    position_ = position;
    message_ = error.what();  // "[json.exception…] parse error at line 1, column 2: what it is"
    if (const std::size_t place = message_.find(": "); place != std::string::npos) message_.erase(0, place + 2);
    return false;
  }

  std::size_t position() const { return position_; }
  const std::string& message() const { return message_; }

 private:
  void enter() {
    keys_.emplace_back();
    if (static_cast<int>(keys_.size()) > nesting_limit)
      throw model::InputError(
          path_, "file",
          fmt::format("found nesting deeper than {0} levels; allowed: at most {0}; write the file again with lamprey",
                      nesting_limit));
  }

  nlohmann::detail::json_sax_dom_parser<Json> builder_;
  const std::string& path_;
  std::vector<std::set<std::string>> keys_;
  std::size_t position_ = 0;
  std::string message_;
};

}  // namespace

JsonReader::JsonReader(const Json& value, std::string pointer, const std::string& path)
    : value_(&value), pointer_(std::move(pointer)), path_(&path) {}

void JsonReader::refuse(const std::string& allowed) const {
  const bool large = value_->is_structured() && value_->size() > 8;
  std::string found = large ? "" : value_->dump(-1, ' ', true, Json::error_handler_t::replace);
  if (found.empty() || found.size() > 80) found = fmt::format("{} of {} entries", value_->type_name(), value_->size());
  throw model::InputError(
      *path_, pointer_.empty() ? "/" : pointer_,
      fmt::format("found {}; allowed: {}; write the file again with lamprey or mend this field", found, allowed));
}

bool JsonReader::is_null() const { return value_->is_null(); }
bool JsonReader::is_boolean() const { return value_->is_boolean(); }
bool JsonReader::is_array() const { return value_->is_array(); }
bool JsonReader::is_text(std::string_view text) const {
  return value_->is_string() && value_->get_ref<const std::string&>() == text;
}
bool JsonReader::has(const char* name) const { return value_->is_object() && value_->contains(name); }
std::size_t JsonReader::size() const { return value_->size(); }

JsonReader JsonReader::at(const char* name) const {
  if (!value_->is_object()) refuse("an object");
  const auto found = value_->find(name);
  if (found == value_->end())
    throw model::InputError(
        *path_, pointer_ + "/" + name,
        "found nothing; allowed: this field is required; add it or write the file again with lamprey");
  return {*found, pointer_ + "/" + name, *path_};
}

JsonReader JsonReader::at(std::size_t index) const {
  return {(*value_)[index], fmt::format("{}/{}", pointer_, index), *path_};
}

bool JsonReader::is_object() const { return value_->is_object(); }

std::vector<std::string> JsonReader::keys() const {
  if (!value_->is_object()) refuse("an object");
  std::vector<std::string> keys;
  for (const auto& entry : value_->items()) keys.push_back(entry.key());
  return keys;
}

void JsonReader::allow_only(std::initializer_list<std::string_view> names) const {
  for (const std::string& key : keys())
    if (std::find(names.begin(), names.end(), key) == names.end())
      throw model::InputError(
          *path_, pointer_ + "/" + key,
          fmt::format(
              "found a key that this version does not know; allowed: {}; it may be a later version's, which can "
              "read it, or mistyped",
              fmt::join(names, ", ")));
}

void JsonReader::require_array() const {
  if (!value_->is_array()) refuse("an array");
}

void JsonReader::require_array(std::size_t length) const {
  if (!value_->is_array() || value_->size() != length) refuse(fmt::format("an array of {} entries", length));
}

double JsonReader::number() const {
  if (!value_->is_number()) refuse("a number");
  return value_->get<double>();
}

double JsonReader::number_or_nan() const { return is_null() ? std::nan("") : number(); }

std::string JsonReader::text() const {
  if (!value_->is_string()) refuse("a text");
  return value_->get<std::string>();
}

bool JsonReader::boolean() const {
  if (!value_->is_boolean()) refuse("true or false");
  return value_->get<bool>();
}

int JsonReader::integer(int low, int high) const {
  const double number = value_->is_number_integer() ? value_->get<double>() : std::nan("");
  if (!(number >= low && number <= high))
    refuse(low == high ? fmt::format("{}", low) : fmt::format("a whole number from {} to {}", low, high));
  return static_cast<int>(number);
}

std::uint64_t JsonReader::unsigned_integer() const {
  if (!value_->is_number_unsigned()) refuse("a whole number ≥ 0");
  return value_->get<std::uint64_t>();
}

JsonDocument::JsonDocument(const std::string& text, std::string path)
    : path_(std::move(path)), value_(std::make_unique<Json>()) {
  GuardedBuilder builder(*value_, path_);
  if (Json::sax_parse(text, &builder)) return;
  const Place place = place_of(text, builder.position() > 0 ? builder.position() - 1 : 0);
  std::string message = builder.message();
  std::replace_if(
      message.begin(), message.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20U; }, ' ');
  throw model::InputError(
      path_, place.line, place.column, "syntax",
      fmt::format("found what JSON cannot read ({}); allowed: JSON; write the file again with lamprey", message));
}

JsonDocument::~JsonDocument() = default;

}  // namespace lamprey::document
