// Whole files as bytes, and the digest that names them.
#pragma once

#include <cstddef>
#include <string>

namespace lamprey::file {

/// The bytes of a file; IoError if it is missing, a folder or unreadable, model::InputError if it is longer than `limit` bytes.
std::string read_bytes(const std::string& path, std::size_t limit);

/// SHA-256 of the bytes as 64 lower-case hexadecimal digits.
std::string sha256(const std::string& bytes);

}  // namespace lamprey::file
