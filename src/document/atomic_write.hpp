// Files that appear complete or not at all.
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace lamprey::document {

/// A file to come: `write` gets the path of a temporary file in the target folder, already created and empty, and fills it.
struct PendingFile {
  std::string name;  // within the folder
  std::function<void(const std::string& temporary)> write;
};

/// A pending file whose bytes are known.
PendingFile finished_file(std::string name, std::string content);

/// Throws what write_files would where the folder cannot be made or written to; leaves nothing behind.
void require_writable(const std::string& folder);

/// Writes all files into the folder: each to a temporary name, flushed to the disk, and renamed once all are complete.
/// Creates the folder (and those above it) where missing. On failure nothing half-written stays, nor a folder that was not there
/// before; throws IoError, or what a writer threw. If a rename itself fails, files already renamed keep their new, complete content.
void write_files(const std::string& folder, const std::vector<PendingFile>& files);

}  // namespace lamprey::document
