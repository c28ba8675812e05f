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

}  // namespace lamprey::study
