// IoError: the file system said no.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

namespace lamprey::file {

/// A file or folder that cannot be read or written, as opposed to one whose content is wrong (model::InputError).
struct IoError : std::runtime_error {
  IoError(std::string path_, const std::string& reason)
      : std::runtime_error(path_ + ": " + reason), path(std::move(path_)) {}
  std::string path;
};

}  // namespace lamprey::file
