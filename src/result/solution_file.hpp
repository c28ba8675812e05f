// solution.json: Results ↔ the fields and shapes of the interface, numbers with 17 digits, the same bytes for the same Results.
#pragma once

#include <optional>
#include <string>

#include "document/atomic_write.hpp"
#include "result/results.hpp"

namespace lamprey::result {

/// The text of solution.json. Single numbers that are not finite become null; std::domain_error names the first array entry that is
/// not finite or the first array of the wrong length (N + 1 = problem.steps + 1 nodes, or none at all, which leaves the motion out and
/// is not read back).
std::string solution_text(const Results& results);

/// Its field `problem`, one JSON object.
std::string problem_text(const ResolvedProblem& problem);

/// solution.json for write_files; the text is made at once, so that a refusal comes before anything touches the disk.
document::PendingFile solution_file(const Results& results);

/// Writes FOLDER/solution.json alone; failures of solution_text and write_files.
void write_solution(const std::string& folder, const Results& results);

/// Reads FOLDER/solution.json. IoError when it cannot be read; model::InputError with line and column for text that is not JSON, keys
/// given twice and nesting deeper than 64, and with the JSON pointer as key for what is missing or has the wrong type or shape.
/// Unknown keys are left alone.
Results read_solution(const std::string& folder);

/// The same from the file's bytes; `path` only names them.
Results parse_solution(const std::string& bytes, const std::string& path);

/// Where FOLDER/solution.json comes from; nothing where there is none that can be read.
std::optional<Provenance> stored_provenance(const std::string& folder);

}  // namespace lamprey::result
