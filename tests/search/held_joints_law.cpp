// Why an answer keeps joints that a search held: what is told is how the search that let go of them ended.
#include <gtest/gtest.h>

#include "lie/so3.hpp"
#include "search/slower_joints.hpp"

namespace lamprey::tests {
namespace {

using optimizer::Termination;

// A body that turns by so much in the last of three steps, after a search that ended so.
search::Found ended(Termination termination, const std::string& reason, double turn) {
  search::Found found;
  found.outcome.termination = termination;
  found.outcome.reason = reason;
  found.path.rotation.assign(4, {Eigen::Matrix3d::Identity()});
  found.path.rotation.back() = {lie::exp(Eigen::Vector3d(0.0, 0.0, turn))};
  return found;
}

TEST(HeldJoints, stay_for_far_turns_only_where_the_freer_search_ran_to_such) {
  search::Found held;
  held.joint_rate = 25.0;
  for (const Termination termination : {Termination::stalled, Termination::infeasible, Termination::feasible}) {
    const std::string whirled = search::why_held(held, ended(termination, "no step makes progress any more", 1.55));
    EXPECT_NE(whirled.find("turns that no step shows"), std::string::npos) << whirled;
    const std::string calm = search::why_held(held, ended(termination, "limits.torque is broken", 0.6));
    EXPECT_EQ(calm.find("turns that no step shows"), std::string::npos) << calm;
    EXPECT_NE(calm.find("limits.torque is broken"), std::string::npos) << calm;
    for (const std::string& words : {whirled, calm})
      EXPECT_EQ(words.find("with limits.angular_velocity = 25 it is a minimum"), 0U) << words;
  }
  for (const Termination termination : {Termination::time_limit, Termination::interrupted})
    for (const double turn : {0.6, 1.55}) {
      const std::string words = search::why_held(held, ended(termination, "late", turn));
      EXPECT_NE(words.find("no time"), std::string::npos) << words;
    }
  search::Found nowhere = ended(Termination::stalled, "no motion", 0.0);
  nowhere.path.rotation.clear();
  EXPECT_NE(search::why_held(held, nowhere).find("no motion"), std::string::npos);
}

}  // namespace
}  // namespace lamprey::tests
