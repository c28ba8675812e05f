// Whole files as bytes, the digest that names them, and what the readers of text have in common.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace lamprey::document {

/// The bytes of a file; IoError if it is missing, a folder or unreadable, model::InputError if it is longer than `limit` bytes.
std::string read_bytes(const std::string& path, std::size_t limit);

/// The path, or where it is a folder that holds a stored motion, that of its solution.json.
std::string motion_file(const std::string& path);

/// SHA-256 of the bytes as 64 lower-case hexadecimal digits.
std::string sha256(const std::string& bytes);

/// Without blanks, tabs and carriage returns at both ends.
std::string_view trimmed(std::string_view text);

/// Levels to which a document may nest: readers call themselves.
inline constexpr int nesting_limit = 64;

}  // namespace lamprey::document
