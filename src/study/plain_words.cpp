#include "study/plain_words.hpp"

#include <utility>

#include "maneuver/end_rows.hpp"

namespace lamprey::study {

std::string number(double value, int digits) { return maneuver::in_words(value, digits); }

std::string words_of_goal(const certificate::Certificate& proof) {
  return "Goal met within " + number(proof.goal_error) + " (rad, m); stationary to " + number(proof.kkt) + ".";
}

std::string words_of_minimum(const certificate::Certificate& proof) {
  if (proof.second_order->costs_nothing) return " It costs nothing, and nothing less can be.";
  if (proof.second_order->held()) return " A strict local minimum: limits leave no direction open.";
  if (proof.second_order->along_phase)
    return " A local minimum, strict but for where along itself the gait begins, which costs the same: smallest "
           "curvature " +
           number(proof.second_order->smallest_eigenvalue, 3) + ".";
  return " A strict local minimum: smallest curvature " + number(proof.second_order->smallest_eigenvalue, 3) + ".";
}

std::string beyond_numbers(const maneuver::Solution& solution, const certificate::Certificate& proof) {
  std::string message = solution.message;
  if (solution.status != maneuver::Status::optimal) return message;
  const auto take_out = [&](const std::string& sentence) {
    if (const auto place = message.find(sentence); place != std::string::npos) message.erase(place, sentence.size());
  };
  take_out(words_of_goal(proof));
  if (proof.second_order && proof.second_order->positive) take_out(words_of_minimum(proof));
  message.erase(0, message.find_first_not_of(' '));
  return message;
}

}  // namespace lamprey::study
