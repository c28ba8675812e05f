#include "study/enough_memory.hpp"

#include <unistd.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "model/input_error.hpp"

namespace lamprey::study {

namespace {

// bytes of each step, whatever moves, and of each entry of its matrices: 36, 63 and 82 kB for three bodies in a plane and in space and
// for ten in a plane (peaks on 5,000 and 15,000 steps).
constexpr double of_a_step = 31e3, of_an_entry = 55.0;

double bytes_of_step(const model::System& system) {
  double bends = 0.0;  // directions in which moments or nothing bend the joints
  for (const model::Joint& joint : system.joints())
    bends += joint.actuation.cols() > 0 ? static_cast<double>(joint.actuation.cols())
                                        : static_cast<double>(model::freedoms_of(joint.kind));
  const double both = 2.0 * bends + 6.0 + system.control_count();
  return of_a_step + of_an_entry * both * both;
}

std::string in_gigabytes(double bytes) {
  std::ostringstream text;
  text.precision(2);
  text << bytes / 1e9 << " GB";
  return text.str();
}

}  // namespace

double bytes_of_search(const model::System& system, const maneuver::Problem& problem) {
  return bytes_of_step(system) * problem.steps;
}

double bytes_of_machine() {
  const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGE_SIZE);
  return pages > 0 && size > 0 ? static_cast<double>(pages) * static_cast<double>(size)
                               : std::numeric_limits<double>::infinity();
}

std::string short_of_memory(const model::System& system, const maneuver::Problem& problem, double bytes) {
  const double needed = bytes_of_search(system, problem);
  if (needed <= bytes) return "";
  return "a search takes about " + in_gigabytes(needed) + " of memory, of which this machine has " +
         in_gigabytes(bytes);
}

void require_memory(const model::System& system, const maneuver::Problem& problem, double bytes) {
  const double needed = bytes_of_search(system, problem);
  if (needed <= bytes) return;
  const double most = std::floor(bytes / bytes_of_step(system) / 1000.0) * 1000.0;
  std::ostringstream words;
  words << "found " << problem.steps << ", for which a search takes about " << in_gigabytes(needed)
        << " of memory; allowed: what the " << in_gigabytes(bytes) << " of this machine hold, about "
        << static_cast<long long>(most) << " steps; choose fewer, or a larger machine (lamprey simulate takes more)";
  throw model::InputError("time.steps", words.str());
}

}  // namespace lamprey::study
