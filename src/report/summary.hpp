// What results say, in sentences and rows: the verdict, the facts beneath it, the certificate against its marks.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "result/results.hpp"

namespace lamprey::report {

/// Whether the run did what was asked: a proved minimum, on steps that resolve motion and work and whose cost does not grow on finer ones,
/// or a march that resolves its motion and keeps the limits.
bool succeeded(const result::Results& results);

/// Whether what was sought was not even found as a motion: the nodes, a guess then, do not obey the mechanics.
bool without_motion(const result::Results& results);

/// One line, as "Proved local minimum: goal reached within 3.1×10⁻¹² rad, at rest within …".
std::string verdict(const result::Results& results);

/// What the message says beyond the verdict.
struct Remarks {
  std::vector<std::string> paragraphs;  // of what is not optimal: what is missed, its cause, what else there is to say
  std::vector<std::string> remedies;    // what to try, a clause each
};
Remarks remarks(const result::Results& results);

/// Name and value with its unit, in the order to be read; entries without meaning for the status are left out.
std::vector<std::pair<std::string, std::string>> facts(const result::Results& results);

/// "0.52 m: front and back at 0.42 s", or, where they overlap, "bodies pass through each other: front and back by 0.31 m
/// at 0.42 s".
std::string clearance_words(const evidence::Clearance& clearance, const result::ResolvedProblem& problem);

struct CertificateRow {
  std::string name;
  std::string value;          // with unit; "not computed" where it is
  std::string mark;           // what it is held to; empty: for information
  std::optional<bool> holds;  // nothing: no mark, or not computed
  std::string meaning;
  bool stored = false;  // the solver's own record, which no file allows to compute again
};

/// Every number of the certificate; always the same rows in the same order. Goal and rest are held to marks only where the
/// problem asks for them.
std::vector<CertificateRow> certificate_rows(const certificate::Certificate& certificate,
                                             const result::ResolvedProblem& problem);

/// Problem settings and provenance as name and value.
std::vector<std::pair<std::string, std::string>> problem_settings(const result::ResolvedProblem& problem);
std::vector<std::pair<std::string, std::string>> provenance_rows(const result::Provenance& provenance);

const char* joint_kind_name(model::JointKind kind);

}  // namespace lamprey::report
