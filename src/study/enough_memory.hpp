// Whether a machine has the memory that a search takes: one that has not kills the program before its time is over.
#pragma once

#include <string>

#include "maneuver/problem.hpp"
#include "model/system.hpp"

namespace lamprey::study {

/// bytes: about what a search on all of a problem's steps, its certificate and its files take at the most, as measured; by less than a
/// third too little or too much.
double bytes_of_search(const model::System& system, const maneuver::Problem& problem);

/// bytes: what this machine has in all; infinite where it does not tell.
double bytes_of_machine();

/// What a search takes and the machine has, in words, where the former is more; empty where there is enough.
std::string short_of_memory(const model::System& system, const maneuver::Problem& problem, double bytes);

/// model::InputError (time.steps) where a search takes more than that.
void require_memory(const model::System& system, const maneuver::Problem& problem, double bytes);

}  // namespace lamprey::study
