#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "report/outline.hpp"
#include "report/poses.hpp"
#include "report/report.hpp"
#include "report/sample_results.hpp"
#include "tolerance.hpp"

namespace lamprey {
namespace {

/// (u/a)² + (v/b)² of a point on paper in the ellipse's own axes: 1 on the outline, less inside.
double level(const report::Ellipse& e, const Eigen::Vector2d& point) {
  const Eigen::Vector2d d = point - e.centre;
  const double u = std::cos(e.angle) * d.x() + std::sin(e.angle) * d.y();
  const double v = -std::sin(e.angle) * d.x() + std::cos(e.angle) * d.y();
  return u * u / (e.major * e.major) + v * v / (e.minor * e.minor);
}

struct Case {
  Eigen::Vector3d semi_axes;
  Eigen::Matrix3d rotation;
  Eigen::Vector3d centre;
};

std::vector<Case> cases() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> spread(-3.0, 3.0), length(0.05, 9.0);
  std::vector<Case> list;
  list.reserve(40);
  for (int k = 0; k < 40; ++k) {
    list.push_back({{length(random), length(random), length(random)},
                    lie::exp({spread(random), spread(random), spread(random)}),
                    {spread(random), spread(random), spread(random)}});
  }
  return list;
}

TEST(Outline, passes_through_every_silhouette_point_and_holds_every_surface_point) {
  for (const report::View& view : {report::top_view(), report::side_view(), report::back_view()}) {
    const Eigen::Vector3d eye = Eigen::Vector3d(view.row(0)).cross(Eigen::Vector3d(view.row(1)));
    for (const Case& c : cases()) {
      const report::Ellipse outline = report::projected_outline(c.semi_axes, c.rotation, c.centre, view);
      // the surface's normal R A⁻¹ s is at right angles to the eye's direction on the silhouette
      const Eigen::Vector3d along = c.semi_axes.cwiseInverse().cwiseProduct(c.rotation.transpose() * eye).normalized();
      const Eigen::Vector3d first = along.unitOrthogonal(), second = along.cross(first);
      for (int k = 0; k < 24; ++k) {
        const double angle = k * std::numbers::pi / 12.0;
        const Eigen::Vector3d s = std::cos(angle) * first + std::sin(angle) * second;
        const Eigen::Vector2d edge = view * (c.centre + c.rotation * c.semi_axes.cwiseProduct(s));
        EXPECT_NEAR(level(outline, edge), 1.0, tests::tolerance(1e-10));
        const Eigen::Vector3d inner = (s + 0.3 * along).normalized();
        EXPECT_LT(level(outline, view * (c.centre + c.rotation * c.semi_axes.cwiseProduct(inner))), 1.0);
      }
    }
  }
}

TEST(Outline, box_touches_the_farthest_points) {
  for (const Case& c : cases()) {
    const report::Ellipse outline = report::projected_outline(c.semi_axes, c.rotation, c.centre, report::top_view());
    double right = 0.0, up = 0.0;
    for (int k = 0; k < 2000; ++k) {
      const double s = k * std::numbers::pi / 1000.0, x = outline.major * std::cos(s), y = outline.minor * std::sin(s);
      right = std::max(right, std::cos(outline.angle) * x - std::sin(outline.angle) * y);
      up = std::max(up, std::sin(outline.angle) * x + std::cos(outline.angle) * y);
    }
    EXPECT_NEAR(outline.half_extent().x(), right, tests::tolerance(1e-5) * outline.major);
    EXPECT_NEAR(outline.half_extent().y(), up, tests::tolerance(1e-5) * outline.major);
  }
}

TEST(Outline, of_a_sphere_is_a_circle_and_of_a_disc_on_edge_a_thin_ellipse) {
  const report::Ellipse circle =
      report::projected_outline({2.0, 2.0, 2.0}, lie::exp({0.3, 1.0, -2.0}), {1.0, 2.0, 3.0}, report::top_view());
  EXPECT_NEAR(circle.major, 2.0, tests::tolerance(1e-14));
  EXPECT_NEAR(circle.minor, 2.0, tests::tolerance(1e-14));
  const report::Ellipse edge = report::projected_outline({3.0, 3.0, 1e-9}, Eigen::Matrix3d::Identity(),
                                                         Eigen::Vector3d::Zero(), report::side_view());
  EXPECT_NEAR(edge.major, 3.0, tests::tolerance(1e-14));
  EXPECT_NEAR(edge.minor, 1e-9, tests::tolerance(1e-20));
}

TEST(Outline, views_show_what_their_names_say) {
  const Eigen::Vector3d forward(1.0, 0.0, 0.0), left(0.0, 1.0, 0.0), up(0.0, 0.0, 1.0);
  EXPECT_EQ(Eigen::Vector2d(report::top_view() * forward), Eigen::Vector2d(1.0, 0.0));
  EXPECT_EQ(Eigen::Vector2d(report::top_view() * left), Eigen::Vector2d(0.0, 1.0));
  EXPECT_EQ(Eigen::Vector2d(report::back_view() * left), Eigen::Vector2d(-1.0, 0.0));
  EXPECT_EQ(Eigen::Vector2d(report::back_view() * up), Eigen::Vector2d(0.0, 1.0));
  EXPECT_EQ(Eigen::Vector2d(report::side_view() * forward), Eigen::Vector2d(1.0, 0.0));
}

TEST(Poses, joints_sit_at_the_same_place_on_both_their_bodies_in_any_order_of_joints) {
  result::Results results = tests::sample_results(10);
  results.problem.bodies.push_back(tests::sample_body("tail", {2.0, 0.5, 0.5}, 0.1));
  results.problem.joints.insert(results.problem.joints.begin(),
                                {"tail", model::JointKind::ball, 2, 3, {-5.5, 0.1, 0.0}, {2.5, 0.0, 0.2}, {}});
  const auto order = report::joint_order(results.problem);
  ASSERT_EQ(order.size(), 3u);
  auto rotation = results.solution.rotation[4];
  rotation.push_back(lie::exp({1.0, 2.0, -0.5}));
  const auto centres = report::body_centres(results.problem, order, results.solution.position[4], rotation);
  EXPECT_EQ(centres[0], results.solution.position[4]);
  for (const result::ResolvedJoint& joint : results.problem.joints) {
    const auto p = static_cast<std::size_t>(joint.parent), c = static_cast<std::size_t>(joint.child);
    const Eigen::Vector3d on_parent = centres[p] + rotation[p] * joint.parent_offset;
    EXPECT_LE((on_parent - centres[c] - rotation[c] * joint.child_offset).norm(), tests::tolerance(1e-13))
        << joint.name;
  }
}

TEST(SnapshotSvg, shows_every_body_at_each_seven_hundredths_and_at_the_end) {
  const std::string svg = report::snapshot_svg(tests::sample_results(100));
  const auto count = [&](const std::string& word) {
    std::size_t found = 0;
    for (std::size_t at = svg.find(word); at != std::string::npos; at = svg.find(word, at + 1)) ++found;
    return found;
  };
  EXPECT_EQ(count("<ellipse"), 3u * 16u);
  for (const char* label : {">0 s<", ">0.07 s<", ">0.63 s<", ">0.98 s<", ">1 s<"}) EXPECT_EQ(count(label), 1u) << label;
  EXPECT_EQ(count("http"), 1u) << "only the SVG namespace";
  EXPECT_EQ(count("nan"), 0u);
}

}  // namespace
}  // namespace lamprey
