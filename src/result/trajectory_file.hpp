// trajectory.h5: the arrays of solution.json under the same names and shapes, each with a `unit` attribute.
#pragma once

#include <string>

#include "document/atomic_write.hpp"
#include "result/results.hpp"

namespace lamprey::result {

/// trajectory.h5 for write_files: groups velocity and momentum/{linear, angular}, 64-bit floats, the names of bodies and joints as
/// attributes of the file, no times of writing: the same
/// Results give the same bytes. Built in memory (twice its size while writing). std::domain_error as solution_text; IoError when
/// the HDF5 library fails.
document::PendingFile trajectory_file(const Results& results);

/// Writes FOLDER/trajectory.h5 alone.
void write_trajectory(const std::string& folder, const Results& results);

/// Where FOLDER/trajectory.h5 differs from the arrays of Results, in words: an array that is missing, has another shape or
/// another number. Empty where it holds the same, or where there is no such file. IoError where it is no HDF5 file.
std::string trajectory_difference(const std::string& folder, const Results& results);

}  // namespace lamprey::result
