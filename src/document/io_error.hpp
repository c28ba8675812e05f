// IoError: the file system said no.
#pragma once

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>
#include <utility>

namespace lamprey::document {

/// A file or folder that cannot be read or written, as opposed to one whose content is wrong (model::InputError).
struct IoError : std::runtime_error {
  IoError(std::string path_, const std::string& reason, int cause_ = 0)
      : std::runtime_error(path_ + ": " + reason), path(std::move(path_)), cause(cause_) {}
  std::string path;
  int cause;  // errno; 0: none of the system's
};

/// Of a call of the system that has failed, with its reason.
[[noreturn]] inline void refuse_io(const std::string& path, const std::string& action) {
  const int cause = errno;
  throw IoError(path, action + ": " + std::strerror(cause), cause);
}

}  // namespace lamprey::document
