// InputError: a caller's mistake, told in one line that says where, what was found, what is allowed and how to mend it.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace lamprey::model {

/// Thrown with a key alone by code that knows no file; the reader of problem files adds file, line and column.
struct InputError : std::runtime_error {
  InputError(std::string key_, std::string message_)
      : std::runtime_error(key_ + ": " + message_), key(std::move(key_)), message(std::move(message_)) {}
  /// For files read by field, not by line (solution.json): the key is a JSON pointer.
  InputError(std::string file_, std::string key_, std::string message_)
      : std::runtime_error(file_ + ": " + key_ + ": " + message_),
        file(std::move(file_)),
        key(std::move(key_)),
        message(std::move(message_)) {}
  InputError(std::string file_, int line_, int column_, std::string key_, std::string message_)
      : std::runtime_error(file_ + ":" + std::to_string(line_) + ":" + std::to_string(column_) + ": " + key_ + ": " +
                           message_),
        file(std::move(file_)),
        line(line_),
        column(column_),
        key(std::move(key_)),
        message(std::move(message_)) {}

  std::string file;  // empty: not known
  int line = 0;
  int column = 0;
  std::string key;
  std::string message;  // what was found, what is allowed, how to mend it
};

}  // namespace lamprey::model
