#include "report/snapshots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "report/obstacles.hpp"
#include "report/poses.hpp"
#include "report/report.hpp"
#include "report/wording.hpp"

namespace lamprey::report {
namespace {

constexpr double interval = 0.07;      // of the duration, between two snapshots
constexpr double label_height = 17.0;  // px above the drawing of a cell
constexpr int colours = 10;            // of bodies, those of page.css

/// One body of a drawing, in the order to be painted.
struct Shape {
  std::size_t body = 0;
  Ellipse outline;
};

/// From where to where bodies reach towards the eye, m.
struct DepthRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  void add(double from, double to) { low = std::min(low, from), high = std::max(high, to); }
};

struct Snapshot {
  double time = 0.0;  // s
  std::vector<Shape> shapes;
  std::vector<Eigen::Vector2d> joints;
  DepthRange depth;
};

/// What lies in the way, on paper.
struct Obstacles {
  struct Circle {
    Eigen::Vector2d centre;
    double radius;
    double depth;  // m, of the centre, towards the eye
  };
  std::vector<Circle> spheres;
  std::vector<PaperHalfPlane> half_planes;
  std::vector<Eigen::Vector2d> waypoints;
};

/// The snapshots of one view and the box, in m on paper, that holds them all.
struct Strip {
  std::vector<Snapshot> snapshots;
  Obstacles obstacles;  // that lie in the box
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  DepthRange depth;
  Eigen::Vector2d start = Eigen::Vector2d::Zero();  // the root's mass centre at the start
};

std::vector<std::size_t> chosen_nodes(const std::vector<double>& time) {
  std::vector<std::size_t> nodes;
  const double duration = time.back() - time.front();
  for (int k = 0; k * interval <= 1.0; ++k) {
    const auto after =
        std::lower_bound(time.begin(), time.end(), time.front() + k * interval * duration - 1e-9 * duration);
    const auto node = static_cast<std::size_t>(std::min(after, time.end() - 1) - time.begin());
    if (nodes.empty() || nodes.back() != node) nodes.push_back(node);
  }
  if (nodes.back() + 1 != time.size()) nodes.push_back(time.size() - 1);
  return nodes;
}

Eigen::Vector3d towards_eye(const View& view) {
  return Eigen::Vector3d(view.row(0)).cross(Eigen::Vector3d(view.row(1)));
}

Snapshot draw_node(const result::Results& results, const std::vector<int>& order, std::size_t node, const View& view) {
  const auto& bodies = results.problem.bodies;
  const auto& rotation = results.solution.rotation[node];
  const auto centres = body_centres(results.problem, order, results.solution.position[node], rotation);
  const Eigen::Vector3d eye = towards_eye(view);
  std::vector<std::size_t> depth(bodies.size());
  std::iota(depth.begin(), depth.end(), std::size_t{0});
  std::stable_sort(depth.begin(), depth.end(),
                   [&](std::size_t a, std::size_t b) { return eye.dot(centres[a]) < eye.dot(centres[b]); });
  Snapshot snapshot;
  snapshot.time = results.solution.time[node];
  for (const std::size_t i : depth) {
    snapshot.shapes.push_back({i, projected_outline(bodies[i].semi_axes, rotation[i], centres[i], view)});
    const double middle = eye.dot(centres[i]),
                 half = bodies[i].semi_axes.cwiseProduct(rotation[i].transpose() * eye).norm();
    snapshot.depth.add(middle - half, middle + half);
  }
  for (const result::ResolvedJoint& joint : results.problem.joints) {
    const auto parent = static_cast<std::size_t>(joint.parent);
    snapshot.joints.push_back(view * (centres[parent] + rotation[parent] * joint.parent_offset));
  }
  return snapshot;
}

Obstacles obstacles_on_paper(const result::Results& results, const View& view) {
  Obstacles obstacles;
  for (const maneuver::KeepOutSphere& sphere : results.problem.limits.spheres)
    obstacles.spheres.push_back({view * sphere.centre, sphere.radius, towards_eye(view).dot(sphere.centre)});
  for (const maneuver::KeepOutHalfSpace& half : results.problem.limits.half_spaces)
    if (const auto seen = cut(half, view, results.solution.position.front())) obstacles.half_planes.push_back(*seen);
  for (const PassedPoint& passed : passed_points(results)) obstacles.waypoints.emplace_back(view * passed.position);
  return obstacles;
}

// Widens the box towards what lies near it, by no more than a part of its own size, and leaves out what lies further off.
void make_room(Strip& strip) {
  constexpr double most = 0.25;  // of the motion's extent, on each side
  const Eigen::Vector2d low = strip.low, high = strip.high;
  const double room = most * (high - low).maxCoeff(), beside = 0.3 * room;
  const Eigen::Vector2d lowest = low.array() - room, highest = high.array() + room;
  const auto widen = [&](const Eigen::Vector2d& point) {
    strip.low = strip.low.cwiseMin(point.cwiseMax(lowest));
    strip.high = strip.high.cwiseMax(point.cwiseMin(highest));
  };
  Obstacles& all = strip.obstacles;
  std::erase_if(all.spheres, [&](const Obstacles::Circle& circle) {
    const bool beside_in_depth =
        circle.depth + circle.radius < strip.depth.low - room || circle.depth - circle.radius > strip.depth.high + room;
    return beside_in_depth ||
           (circle.centre - circle.centre.cwiseMax(lowest).cwiseMin(highest)).norm() >= circle.radius;
  });
  for (const Obstacles::Circle& circle : all.spheres) {
    widen(circle.centre.array() - circle.radius);
    widen(circle.centre.array() + circle.radius);
  }
  std::erase_if(all.half_planes, [&](const PaperHalfPlane& half) { return !line_in_box(half, lowest, highest); });
  for (const PaperHalfPlane& half :
       all.half_planes) {  // towards its line, where it is beyond the motion, and a little on
    const Eigen::Vector2d middle = 0.5 * (low + high);
    widen(middle + (half.offset - beside - half.normal.dot(middle)) * half.normal);
  }
  for (const Eigen::Vector2d& point : all.waypoints) widen(point);
}

Strip make_strip(const result::Results& results, const View& view) {
  Strip strip;
  const std::vector<int> order = joint_order(results.problem);
  strip.start = view * results.solution.position.front();
  for (const std::size_t node : chosen_nodes(results.solution.time)) {
    strip.snapshots.push_back(draw_node(results, order, node, view));
    strip.depth.add(strip.snapshots.back().depth.low, strip.snapshots.back().depth.high);
    for (const Shape& shape : strip.snapshots.back().shapes) {
      strip.low = strip.low.cwiseMin(shape.outline.centre - shape.outline.half_extent());
      strip.high = strip.high.cwiseMax(shape.outline.centre + shape.outline.half_extent());
    }
  }
  strip.obstacles = obstacles_on_paper(results, view);
  make_room(strip);
  const double margin = 0.04 * (strip.high - strip.low).maxCoeff();
  strip.low.array() -= margin;
  strip.high.array() += margin;
  return strip;
}

double round_length(double length) {
  const double power = std::pow(10.0, std::floor(std::log10(length)));
  for (const double digit : {5.0, 2.0}) {
    if (digit * power <= length) return digit * power;
  }
  return power;
}

/// Where a point of the drawing lies in a cell, px.
struct Paper {
  const Strip& strip;
  double scale;  // px/m
  double x(double metres) const { return scale * (metres - strip.low.x()); }
  double y(double metres) const { return label_height + scale * (strip.high.y() - metres); }
};

/// A line with short strokes towards what is forbidden.
std::string half_plane_drawing(const PaperHalfPlane& half, const Paper& paper) {
  constexpr double every = 7.0, stroke = 6.0;  // px
  const auto ends = line_in_box(half, paper.strip.low, paper.strip.high);
  if (!ends) return "";
  const auto& [from, to] = *ends;
  const double length = (to - from).norm();
  const Eigen::Vector2d along = (to - from) / length,
                        into = stroke / paper.scale * (along - half.normal) / std::numbers::sqrt2;
  std::string path = fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", paper.x(from.x()), paper.y(from.y()), paper.x(to.x()),
                                 paper.y(to.y()));
  for (double done = 0.0; done < length; done += every / paper.scale) {
    const Eigen::Vector2d root = from + done * along, tip = root + into;
    path += fmt::format("M{:.1f} {:.1f}L{:.1f} {:.1f}", paper.x(root.x()), paper.y(root.y()), paper.x(tip.x()),
                        paper.y(tip.y()));
  }
  return fmt::format(R"(<path class="keep-out-face" d="{}" fill="none" stroke-width="1"/>)", path);
}

std::string obstacle_drawings(const Obstacles& obstacles, const Paper& paper) {
  std::string svg;
  for (const Obstacles::Circle& circle : obstacles.spheres)
    svg += fmt::format(R"(<circle class="keep-out" cx="{:.2f}" cy="{:.2f}" r="{:.2f}" fill-opacity="0.25"/>)",
                       paper.x(circle.centre.x()), paper.y(circle.centre.y()), paper.scale * circle.radius);
  for (const PaperHalfPlane& half : obstacles.half_planes) svg += half_plane_drawing(half, paper);
  return svg;
}

std::string waypoint_drawings(const Obstacles& obstacles, const Paper& paper) {
  std::string svg;
  for (const Eigen::Vector2d& point : obstacles.waypoints)
    svg += fmt::format(R"(<path class="waypoint" d="M{:.2f} {:.2f}l3 3l-3 3l-3 -3z" stroke-width="1"/>)",
                       paper.x(point.x()), paper.y(point.y()) - 3.0);
  return svg;
}

std::string scale_bar(const Strip& strip, double width, double scale, double height) {
  const double bar = round_length(0.35 * (strip.high.x() - strip.low.x()));
  return fmt::format(R"(<path class="scale" d="M{0:.2f} {1:.2f}h{2:.2f}" fill="none" stroke-width="1.4"/>)"
                     R"(<text x="{3:.2f}" y="13" font-size="11" text-anchor="end">{4:g} m</text>)",
                     width - 6.0 - scale * bar, std::min(17.0, height - 2.0), scale * bar, width - 6.0, bar);
}

/// The inside of one cell, `width` px wide; the drawing lies below its label.
std::string cell_content(const Strip& strip, const Snapshot& snapshot, double width) {
  const Paper paper{strip, width / (strip.high.x() - strip.low.x())};
  const double height = label_height + paper.scale * (strip.high.y() - strip.low.y());
  std::string svg = obstacle_drawings(strip.obstacles, paper);
  svg += fmt::format(R"(<text x="6" y="13" font-size="11">{:.4g} s</text>)", snapshot.time);
  svg += fmt::format(R"(<path class="start" d="M{0:.2f} {1:.2f}h8m-4 -4v8" fill="none" stroke-width="0.8"/>)",
                     paper.x(strip.start.x()) - 4.0, paper.y(strip.start.y()));
  for (const Shape& shape : snapshot.shapes) {
    const Ellipse& e = shape.outline;
    svg += fmt::format(R"(<ellipse class="body{}" rx="{:.2f}" ry="{:.2f}" fill-opacity="0.5" stroke-width="1" )"
                       R"svg(transform="translate({:.2f} {:.2f}) rotate({:.2f})"/>)svg",
                       shape.body % colours, paper.scale * e.major, paper.scale * e.minor, paper.x(e.centre.x()),
                       paper.y(e.centre.y()), -e.angle * 180.0 / std::numbers::pi);
  }
  for (const Eigen::Vector2d& joint : snapshot.joints) {
    svg += fmt::format(R"(<circle class="joint" cx="{:.2f}" cy="{:.2f}" r="1.6"/>)", paper.x(joint.x()),
                       paper.y(joint.y()));
  }
  svg += waypoint_drawings(strip.obstacles, paper);
  if (&snapshot == &strip.snapshots.front()) svg += scale_bar(strip, width, paper.scale, height);
  return svg;
}

/// What of the pictures is no body.
std::string obstacle_words(const Obstacles& obstacles) {
  std::string words;
  if (!obstacles.spheres.empty() || !obstacles.half_planes.empty()) words += "; red: to keep out of";
  if (!obstacles.waypoints.empty()) words += "; ◆ waypoints of the root’s mass centre";
  return words;
}

double cell_height(const Strip& strip, double width) {
  return label_height + width * (strip.high.y() - strip.low.y()) / (strip.high.x() - strip.low.x());
}

bool is_narrow(const Strip& strip) { return strip.high.x() - strip.low.x() < 1.25 * (strip.high.y() - strip.low.y()); }

std::string figure(const result::Results& results, const View& view, const char* title, const char* axes) {
  const Strip strip = make_strip(results, view);
  const double width = is_narrow(strip) ? 124.0 : 240.0;
  std::string html = fmt::format(
      "<figure class=\"snapshots\"><figcaption>{} <span>{}; + marks where the root’s mass centre "
      "started{}</span></figcaption>"
      "<div class=\"cells{}\">\n",
      title, axes, obstacle_words(strip.obstacles), is_narrow(strip) ? " narrow" : "");
  for (const Snapshot& snapshot : strip.snapshots) {
    html += fmt::format(R"(<svg viewBox="0 0 {0:g} {1:.1f}" role="img" aria-label="{2} at {3:.4g} s">)", width,
                        cell_height(strip, width), title, snapshot.time);
    html += cell_content(strip, snapshot, width) + "</svg>\n";
  }
  return html + "</div></figure>\n";
}

}  // namespace

std::string snapshot_figures(const result::Results& results) {
  ensure_shapes(results);
  const std::string above = figure(results, top_view(), "From above", "e₁ to the right, e₂ up");
  if (planar(results)) return above;  // all the same from behind
  return above + figure(results, back_view(), "From behind", "looking along e₁: e₂ to the left, e₃ up");
}

std::string snapshot_svg(const result::Results& results) {
  ensure_shapes(results);
  const Strip strip = make_strip(results, top_view());
  const int columns = is_narrow(strip) ? 8 : 4;
  const double gap = 8.0, width = (980.0 - gap) / columns - gap, height = cell_height(strip, width);
  const auto rows =
      (strip.snapshots.size() + static_cast<std::size_t>(columns) - 1) / static_cast<std::size_t>(columns);
  const double total = gap + static_cast<double>(rows) * (height + gap);
  std::string svg = fmt::format(
      R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 980 {0:.1f}" width="980" height="{0:.1f}" role="img" )"
      R"(font-family="system-ui, 'DejaVu Sans', sans-serif"><title>{1}: seen from above, e₁ to the right</title><style>)"
      "text{{fill:#5a6472}}.start,.scale{{stroke:#5a6472}}.joint{{fill:#1c2430}}"
      ".keep-out,.keep-out-face{{stroke:#b3261e}}.keep-out{{fill:#b3261e}}.waypoint{{fill:#f0286a;stroke:#1c2430}}"
      ".body0{{fill:#3b7fb5;stroke:#2f6590}}.body1{{fill:#e39a2e;stroke:#b57a22}}.body2{{fill:#2a9d7c;stroke:#217d63}}"
      ".body3{{fill:#b8689a;stroke:#93537b}}.body4{{fill:#6fb1d8;stroke:#588dac}}.body5{{fill:#a8a03a;stroke:#86802e}}"
      ".body6{{fill:#c0563f;stroke:#9a4532}}.body7{{fill:#6a63b8;stroke:#554f93}}.body8{{fill:#8a6a45;stroke:#6e5537}}"
      ".body9{{fill:#7b8791;stroke:#626c74}}"
      "</style><rect width=\"980\" height=\"{0:.1f}\" rx=\"10\" fill=\"#ffffff\"/>\n",
      total, escaped(results.name));
  for (std::size_t k = 0; k < strip.snapshots.size(); ++k) {
    const std::size_t row = k / static_cast<std::size_t>(columns), column = k % static_cast<std::size_t>(columns);
    const double x = gap + static_cast<double>(column) * (width + gap);
    const double y = gap + static_cast<double>(row) * (height + gap);
    svg += fmt::format(
        "<g transform=\"translate({0:.1f} {1:.1f})\"><rect width=\"{2:.1f}\" height=\"{3:.1f}\" rx=\"5\" "
        "fill=\"none\" stroke=\"#dfe2e4\"/><svg width=\"{2:.1f}\" height=\"{3:.1f}\">",
        x, y, width, height);
    svg += cell_content(strip, strip.snapshots[k], width) + "</svg></g>\n";
  }
  return svg + "</svg>\n";
}

}  // namespace lamprey::report
