// Sentences of an answer's message that its certificate's numbers alone make, and the message without them.
#pragma once

#include "certificate/certificate.hpp"
#include "maneuver/solution.hpp"

namespace lamprey::study {

/// A number for a sentence.
std::string number(double value, int digits = 2);

/// How well the goal is met and how stationary the cost is.
std::string words_of_goal(const certificate::Certificate& certificate);

/// That a strict minimum is proved, after a blank; the certificate has its second order.
std::string words_of_minimum(const certificate::Certificate& certificate);

/// An answer's message without what a verdict with the certificate's numbers says already; empty where that is all.
std::string beyond_numbers(const maneuver::Solution& solution, const certificate::Certificate& certificate);

/// With e₁, e₂ and e₃ for the world's axes, which the certificate's words name in letters that all terminals have.
std::string with_world_axes(std::string words);

}  // namespace lamprey::study
