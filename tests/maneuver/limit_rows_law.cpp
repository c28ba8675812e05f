// A limit that gives way by its excess is just kept, in the units of its bound.
#include "maneuver/limit_rows.hpp"

#include <gtest/gtest.h>

#include "chains.hpp"
#include "tolerance.hpp"

namespace lamprey::tests {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using maneuver::LimitRow;
using Kind = LimitRow::Kind;

struct Case {
  Kind kind;
  double bound;
  double way;  // +1: the bound is an upper one
  const char* unit;
};

TEST(LimitRows, are_just_kept_when_they_give_way_by_their_excess) {
  const model::System system(paper_chain());
  const double h = 0.01;
  const mechanics::Rotations before{lie::exp(Vector3d(0.1, 0.2, -0.3)), lie::exp(Vector3d(0.7, -0.2, 0.1)),
                                    lie::exp(Vector3d(-0.4, 0.5, 0.9))};
  mechanics::Rotations now = before;
  now[1] = before[1] * lie::exp(Vector3d(0.03, -0.02, 0.05));
  const Vector3d position(0.2, -0.1, 0.3);
  VectorXd moment(system.control_count());
  for (Eigen::Index c = 0; c < moment.size(); ++c) moment[c] = 3.0 + static_cast<double>(c);
  const maneuver::LimitedNode node{now, before, position, moment, h, 100 * h};
  for (const Case& limit : {Case{Kind::torque, 2.0, 1.0, "N m"}, Case{Kind::torque_component, 1.5, 1.0, "N m"},
                            Case{Kind::swing, 0.3, 1.0, "rad"}, Case{Kind::twist, 0.01, 1.0, "rad"},
                            Case{Kind::speed, 2.0, 1.0, "rad/s"}, Case{Kind::clearance, 30.0, -1.0, "m"},
                            Case{Kind::not_longer, 0.4, 1.0, "s"}, Case{Kind::not_shorter, 2.5, -1.0, "s"}}) {
    LimitRow row;
    row.kind = limit.kind;
    row.joint = 0;
    row.component = 0;
    row.body = 0;
    row.other_body = 1;
    row.bound = limit.bound;
    row.unit = 0.7;
    const double value = maneuver::limit_value(system, row, node, 1e9);
    ASSERT_LT(value, 0.0) << row.unit_name() << " is kept: nothing is tested";
    EXPECT_STREQ(row.unit_name(), limit.unit);
    row.bound += limit.way * row.excess(-value, h);
    EXPECT_NEAR(maneuver::limit_value(system, row, node, 1e9), 0.0, tolerance(1e-12)) << limit.bound;
  }
}

}  // namespace
}  // namespace lamprey::tests
