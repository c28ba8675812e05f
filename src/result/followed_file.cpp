#include "result/followed_file.hpp"

#include <fmt/format.h>

#include "document/toml_document.hpp"
#include "file/words.hpp"
#include "lie/so3.hpp"
#include "model/input_error.hpp"

namespace lamprey::result {

namespace {

using model::InputError;

constexpr double beyond = 1e-9;  // relative: how far a march may end past the maneuver

[[noreturn]] void refuse_motion(const std::string& path, const std::string& key, const std::string& found,
                                const std::string& allowed, const std::string& cure) {
  throw InputError(path, key, fmt::format("found {}; allowed: {}; {}", found, allowed, cure));
}

// Masses and offsets may differ: a disturbed swimmer follows the same moments.
void require_same_joints(const std::vector<ResolvedJoint>& found, const Joints& joints, const std::string& path) {
  const char* cure = "choose a motion of the same swimmer";
  if (found.size() != joints.size())
    throw InputError(path, "/problem/joints",
                     fmt::format("found {} joints; allowed: the problem's {}; {}", found.size(), joints.size(), cure));
  for (std::size_t j = 0; j < joints.size(); ++j)
    if (found[j].name != joints[j].name || found[j].kind != joints[j].kind)
      throw InputError(path, fmt::format("/problem/joints/{}", j),
                       fmt::format("found the {} joint {}; allowed: the problem's {} joint {}; {}",
                                   file::word(found[j].kind), document::in_quotes(found[j].name),
                                   file::word(joints[j].kind), document::in_quotes(joints[j].name), cure));
}

}  // namespace

void require_motion_of(const Joints& joints, const Results& results, const std::string& path) {
  require_same_joints(results.problem.joints, joints, path);
  if (results.solution.time.size() < 2)
    throw InputError(path, "/time", "found no motion; allowed: at least two nodes; choose a file with a trajectory");
  for (std::size_t k = 1; k < results.solution.time.size(); ++k)
    if (!(results.solution.time[k] > results.solution.time[k - 1]))
      throw InputError(path, fmt::format("/time/{}", k),
                       fmt::format("found {} after {}; allowed: times that rise (s); mend this field",
                                   results.solution.time[k], results.solution.time[k - 1]));
}

void require_same_tree(const Results& results, const std::string& path, const model::System& swimmer, bool same_kinds) {
  const ResolvedProblem& problem = results.problem;
  const auto bodies = static_cast<std::size_t>(swimmer.body_count());
  if (problem.bodies.size() != bodies)
    refuse_motion(path, "/problem/bodies", fmt::format("{} bodies", problem.bodies.size()),
                  fmt::format("{}, as the problem's swimmer has", bodies), "choose a motion of the same swimmer");
  const auto joints = static_cast<std::size_t>(swimmer.joint_count());
  if (problem.joints.size() != joints)
    refuse_motion(path, "/problem/joints", fmt::format("{} joints", problem.joints.size()),
                  fmt::format("{}, as the problem's swimmer has", joints), "choose a motion of the same swimmer");
  for (std::size_t j = 0; j < problem.joints.size(); ++j) {
    const ResolvedJoint& joint = problem.joints[j];
    const model::Joint& own = swimmer.joint(static_cast<int>(j));
    if ((same_kinds && joint.kind != own.kind) || joint.parent != own.parent || joint.child != own.child)
      refuse_motion(
          path, fmt::format("/problem/joints/{}", j),
          fmt::format("a {} joint from body {} to body {}", file::word(joint.kind), joint.parent, joint.child),
          fmt::format("a {} joint from body {} to body {}, as the problem's swimmer has", file::word(own.kind),
                      own.parent, own.child),
          "choose a motion of the same swimmer");
    if (same_kinds && joint.name != own.name)
      refuse_motion(path, fmt::format("/problem/joints/{}", j),
                    fmt::format("the {} joint {}", file::word(joint.kind), document::in_quotes(joint.name)),
                    fmt::format("the problem's {} joint {}", file::word(own.kind), document::in_quotes(own.name)),
                    "choose a motion of the same swimmer");
  }
  if (results.solution.time.size() < 2)
    refuse_motion(path, "/time", "no motion", "the nodes of one", "choose another, or solve it again");
}

void require_whole(const Results& results, const std::string& path) {
  if (results.problem.goal || results.solution.status != maneuver::Status::stalled) return;
  refuse_motion(path, "/status",
                fmt::format("\"stalled\", a march that ended after {} s", results.solution.time.back()),
                "a solution, or a march that came to its end", "march it again in shorter steps, or choose another");
}

void require_followed(const Results& results, const std::string& path, const model::System& follower, double from,
                      double duration) {
  require_same_tree(results, path, follower, true);
  if (results.solution.feedback.gain.empty())
    refuse_motion(path, "/feedback", "no gains", "those that lamprey solve stores with optimal maneuvers",
                  results.solution.status == maneuver::Status::optimal
                      ? "solve the maneuver again to its end: a search that was interrupted, or ended by its time "
                        "limit, may leave none"
                      : fmt::format("this one is not optimal but \"{}\": its message says what may help",
                                    file::word(results.solution.status)));
  const double end = results.solution.time.back();
  if (from > 0.0 && results.problem.goal && results.problem.goal->periodic)
    refuse_motion(path, "/problem/goal", fmt::format("a gait, where the march begins at {} s of it", from),
                  "a maneuver, since gaits begin where they close", "leave --feedback-from out");
  if (!(from + duration <= end * (1.0 + beyond)))
    refuse_motion(path, "/problem/duration",
                  fmt::format("{} s, where the march takes {} s{}", end, duration,
                              from > 0.0 ? fmt::format(" from {} s on", from) : ""),
                  "a maneuver that does not end before the march",
                  from > 0.0 ? "set a shorter --duration, or leave it out" : "set a shorter --duration");
}

maneuver::Start first_node(const maneuver::Solution& solution) {
  maneuver::Start first;
  first.position = solution.position.front();
  for (const Eigen::Matrix3d& R : solution.rotation.front()) first.rotation.push_back(lie::log(R));
  first.angular_velocity = solution.angular_velocity.front();
  first.linear_velocity = solution.rotation.front()[0] * solution.linear_velocity.front();
  return first;
}

}  // namespace lamprey::result
