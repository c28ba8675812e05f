// The commands of the program; each returns the exit code of the interface.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace lamprey::app {

enum ExitCode {
  done = 0,
  internal_error = 1,
  usage = 2,
  invalid_input = 3,
  no_optimal_solution = 4,
  numerical_failure = 5,
  input_output = 6,
  program_missing = 7,
  was_interrupted = 130
};

struct SolveArguments {
  std::string problem, out, command;
  bool json = false;
  int workers = 0;                      // 0: one for each core
  std::string solver;                   // newton, ipopt or both; empty: as suits the problem
  bool resolve = false;                 // on more steps, until they resolve the answer
  std::optional<bool> refinement = {};  // default: where it is cheap
  std::string first;                    // folder of the motion to begin at; empty: random first guesses
  int starts = 0, keep = 0;             // 0: the file's
  std::optional<unsigned long long> seed = {};
  std::optional<double> time_limit = {};  // s
};

struct SimulateArguments {
  std::string problem, out, command, controls, angles, scheme;
  std::string interpolation;     // of a CSV table: linear or cubic; empty: as its first line says, else cubic
  int steps = 0;                 // 0: the file's
  double duration = 0.0;         // 0: the file's
  int cycles = 1;                // of a stored gait
  bool adaptive = false;         // divide steps that do not converge
  std::string feedback;          // folder of the maneuver to follow; empty: none
  double feedback_from = 0.0;    // s of its time, at which the march begins
  double perturb = 0.0;          // rad, by which each body is turned at the start
  double perturb_inertia = 0.0;  // share of itself, by which each body's inertia differs at most
  unsigned long long seed = 1;   // of the axes
  bool reference = false;        // by the reference integrator in place of the scheme
};

struct VerifyArguments {
  std::string folder;
  std::string problem;  // file to compare with; empty: none
};

int solve(const SolveArguments& arguments);
int simulate(const SimulateArguments& arguments);
int check(const std::string& problem);
int verify(const VerifyArguments& arguments);
int report(const std::vector<std::string>& folders);
int export_tables(const std::string& folder);
int inertia(const std::vector<double>& semi_axes, double density, bool json);
std::string version_line();

/// Runs a command, turning exceptions into one line on standard error and the exit code.
template <typename Command>
int guarded(const Command& command);

int explain_failure() noexcept;

/// Writes out what is buffered of standard output; throws document::IoError where that cannot be written.
void finish_output();

template <typename Command>
int guarded(const Command& command) {
  try {
    const int code = command();
    finish_output();
    return code;
  } catch (...) {
    return explain_failure();
  }
}

}  // namespace lamprey::app
