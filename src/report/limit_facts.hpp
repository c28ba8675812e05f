// What a motion makes of the limits and waypoints of its problem, in words.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "certificate/certificate.hpp"
#include "evidence/limit_check.hpp"
#include "result/results.hpp"

namespace lamprey::report {

/// Of the stored motion; nothing where neither limits nor waypoints are asked for, or where there is no motion.
std::optional<evidence::LimitCheck> limits_seen(const result::Results& results);

/// The limit that is broken most; nothing where all are kept.
std::optional<evidence::LimitReach> worst_broken(const std::vector<evidence::LimitReach>& reaches);

/// How near a motion comes to each limit: "at limits.swing.front over 12 % of the time; 0.3 m from the sphere at
/// 0.2 s". Of limits of one kind that are not reached the tightest.
std::string reaches_in_words(const std::vector<evidence::LimitReach>& reaches);

/// Rows "Limits" and "Waypoints", each only where the problem has some.
std::vector<std::pair<std::string, std::string>> limit_facts(const result::Results& results);

/// Of a march, which has no certificate; nothing of a single body and of motions too long to be looked through for a
/// summary.
std::optional<evidence::Clearance> march_clearance(const result::Results& results);

/// What of a march nobody should overlook: bodies that pass through each other, broken limits, a plan that feedback
/// has lost.
std::vector<std::string> march_faults(const result::Results& results);

}  // namespace lamprey::report
