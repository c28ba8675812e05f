// The words of problem files and solution.json for each enumeration: one spelling everywhere.
#pragma once

#include <array>
#include <string_view>
#include <utility>

#include "certificate/certificate.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/description.hpp"

namespace lamprey::file {

template <class Enumeration>
struct Word {
  Enumeration value;
  std::string_view text;
};

using JointKind = model::JointKind;
using Scheme = maneuver::Scheme;
using CostRule = maneuver::CostRule;
using ControlKind = maneuver::ControlKind;
using SearchMethod = maneuver::SearchMethod;
using Status = maneuver::Status;
using Verdict = certificate::Verdict;

inline constexpr std::array<Word<JointKind>, 4> joint_kinds{{{JointKind::ball, "ball"},
                                                             {JointKind::universal, "universal"},
                                                             {JointKind::hinge, "hinge"},
                                                             {JointKind::fixed, "fixed"}}};
inline constexpr std::array<Word<Scheme>, 5> schemes{{{Scheme::paper, "paper"},
                                                      {Scheme::trapezoid, "trapezoid"},
                                                      {Scheme::midpoint, "midpoint"},
                                                      {Scheme::order4, "order4"},
                                                      {Scheme::order6, "order6"}}};
inline constexpr std::array<Word<CostRule>, 2> cost_rules{
    {{CostRule::trapezoid, "trapezoid"}, {CostRule::rectangle, "rectangle"}}};
inline constexpr std::array<Word<ControlKind>, 2> control_kinds{
    {{ControlKind::steps, "steps"}, {ControlKind::spline, "spline"}}};
inline constexpr std::array<Word<SearchMethod>, 2> search_methods{
    {{SearchMethod::simultaneous, "simultaneous"}, {SearchMethod::shooting, "shooting"}}};
inline constexpr std::array<Word<Status>, 7> statuses{{{Status::optimal, "optimal"},
                                                       {Status::simulated, "simulated"},
                                                       {Status::feasible, "feasible"},
                                                       {Status::infeasible, "infeasible"},
                                                       {Status::stalled, "stalled"},
                                                       {Status::time_limit, "time_limit"},
                                                       {Status::interrupted, "interrupted"}}};

inline constexpr std::array<Word<Verdict>, 3> verdicts{{{Verdict::proved, "proved local minimum"},
                                                        {Verdict::stationary, "stationary, not proved"},
                                                        {Verdict::not_optimal, "not optimal"}}};

// What other programs call kinds of joints, and what these are here; empty: nothing of the sort.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, 14> other_words{{{"revolute", "hinge"},
                                                                                            {"rotational", "hinge"},
                                                                                            {"rotary", "hinge"},
                                                                                            {"pin", "hinge"},
                                                                                            {"continuous", "hinge"},
                                                                                            {"spherical", "ball"},
                                                                                            {"socket", "ball"},
                                                                                            {"cardan", "universal"},
                                                                                            {"hooke", "universal"},
                                                                                            {"gimbal", "universal"},
                                                                                            {"rigid", "fixed"},
                                                                                            {"weld", "fixed"},
                                                                                            {"prismatic", ""},
                                                                                            {"slider", ""}}};

constexpr const auto& words(JointKind) { return joint_kinds; }
constexpr const auto& words(Scheme) { return schemes; }
constexpr const auto& words(CostRule) { return cost_rules; }
constexpr const auto& words(ControlKind) { return control_kinds; }
constexpr const auto& words(SearchMethod) { return search_methods; }
constexpr const auto& words(Status) { return statuses; }
constexpr const auto& words(Verdict) { return verdicts; }

/// The word of an enumeration's value, as in word(Scheme::paper) == "paper".
template <class Enumeration>
constexpr std::string_view word(Enumeration value) {
  for (const auto& entry : words(value))
    if (entry.value == value) return entry.text;
  return "";
}

}  // namespace lamprey::file
