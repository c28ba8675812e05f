// Tasks: what is done with problem files and stored answers, the same for the command line and for Python.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "certificate/claims.hpp"
#include "file/problem_file.hpp"
#include "model/system.hpp"
#include "result/angles_file.hpp"
#include "result/controls_file.hpp"
#include "result/results.hpp"
#include "search/solve.hpp"

namespace lamprey::task {

/// The system of a problem file; what is wrong with it is told with its place in the file.
model::System system_of(const file::ProblemFile& file);

/// What `lamprey check` prints: the resolved model as a table, and where `lamprey solve` does not take the problem why. Throws
/// model::InputError, with its place, where the start or the goal breaks a limit.
std::string check_task(const file::ProblemFile& file);

/// What is known of an answer before it is sought; `command` goes into its provenance.
result::Results begun_results(const file::ProblemFile& file, const model::System& system, const std::string& command);

/// A stored motion that a search begins with.
struct EarlierMotion {
  result::Results results;
  std::string path;  // names it in messages
};

/// Finds the maneuver and its certificate. Throws model::InputError, with its place, for problems that are not solved, and for
/// a first motion that is none of the problem's swimmer.
result::Results solve_task(const file::ProblemFile& file, const search::SolveOptions& options,
                           const std::string& command, const std::optional<EarlierMotion>& first = {});

struct MarchOptions {
  std::optional<maneuver::Scheme> scheme = {};          // instead of the file's
  int steps = 0;                                        // 0: the file's
  double duration = 0.0;                                // s, 0: the file's
  int cycles = 1;                                       // of a stored gait or of angles that close, one after the other
  bool adaptive = false;                                // divide steps that do not converge
  bool reference = false;                               // by the reference integrator in place of the scheme
  double perturb = 0.0;                                 // rad, by which each body is turned at the start
  double perturb_inertia = 0.0;                         // by which share of itself each body's inertia differs at most
  std::uint64_t seed = 1;                               // of the axes and of these
  std::optional<result::ControlSamples> controls = {};  // moments in time
  std::string controls_path = "controls";               // names them in messages
  /// The same as a function of time in s, [joints] as in ControlSamples; empty: none.
  std::function<std::vector<Eigen::Vector3d>(double)> control = {};
  /// Joint angles in time: the march goes along them and finds the moments (guess/angle_march.hpp).
  std::optional<result::AngleSamples> angles = {};
  std::string angles_path = "angles";  // names them in messages
  /// The same as a function of time in s, [joints] rad; it is asked at the nodes. Empty: none.
  std::function<std::vector<Eigen::Vector3d>(double)> angle = {};
  std::optional<result::Results> followed = {};  // the maneuver to follow by its moments and gains, in place of both
  std::string followed_path = {};                // names it in messages
  double followed_from = 0.0;                    // s of its time, at which the march begins
  std::function<bool()> interrupted = {};
};

/// Marches from the problem's start; where its goal is periodic and the moments or the maneuver to follow are of a stored
/// motion, from that motion's first node, placed and headed as the problem's start. A march that ends before its duration (status stalled or interrupted) holds the nodes
/// before its end, and its problem's steps and duration are those of these nodes. Several cycles of a gait take so many times
/// the file's steps and the gait's duration, where no others are asked for. Along joint angles the march begins bent as they are, moving
/// as they do with the start's total momentum; model::InputError where the scheme cannot follow them.
result::Results march_task(file::ProblemFile file, MarchOptions options, const std::string& command);

/// The same answer with its certificate made anew from its own numbers, and the status that this certificate gives it.
/// Refinement, which takes solving, stays as it was.
result::Results certified(const result::Results& results);

/// What the files of a stored answer say of it, and what is found when it is computed again. verify_task throws what
/// read_solution and trajectory_difference do.
struct Verification {
  result::Results stored, found;
  bool status_holds = true;                      // where it promises something
  std::vector<certificate::FalseClaim> claims;   // of the stored certificate
  std::string fault;                             // why the numbers are no optimal answer's, in words; empty: they are
  std::string trajectory_difference;             // from solution.json, in words; empty: none
  std::vector<std::string> problem_differences;  // from a problem file, in words
  std::vector<std::string> march_differences;    // of a march, what is not as in that file: its start, say
  bool promises() const;  // whether the stored status says something that could be false: "optimal" or "simulated"
  bool holds() const {
    return status_holds && claims.empty() && trajectory_difference.empty() && problem_differences.empty();
  }
};
/// With a problem file the stored problem is compared with what it asks.
Verification verify_task(const std::string& folder, const std::optional<file::ProblemFile>& asked = {});

}  // namespace lamprey::task
