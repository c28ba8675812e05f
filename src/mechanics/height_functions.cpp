#include "mechanics/height_functions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/SparseCholesky>

namespace lamprey::mechanics {

namespace {

using Eigen::Vector2d;
using model::at;
using model::System;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double in_plane = 1e-9;  // of what moves, beside which the rest is round-off

Vector2d quarter_turned(const Vector2d& v) { return {-v.y(), v.x()}; }

// Shapes of the rectangle, and the connection there in the plane.
class Shapes {
 public:
  Shapes(const System& system, const ShapePlane& plane) : system_(system), plane_(plane) {}

  /// Whether the directions are rates of the joints everywhere.
  bool straight() const {
    for (int j = 0; j < system_.joint_count(); ++j) {
      Vector3d turned = plane_.middle[at(j)].cwiseAbs();
      for (const Vectors& direction : plane_.direction) turned += direction[at(j)].cwiseAbs();
      if (system_.joint(j).free() && (turned.array() > 0.0).count() > 1) return false;
    }
    return true;
  }

  Rotations shape(double first, double second) const {
    Vectors turn = plane_.middle;
    for (std::size_t j = 0; j < turn.size(); ++j)
      turn[j] += first * plane_.direction[0][j] + second * plane_.direction[1][j];
    return shape_at_turns(system_, turn);
  }

  /// What a variable moves the root by, and what a small loop of both does.
  Twist moved(double first, double second, std::size_t variable) const {
    return moved_root(system_, shape(first, second), plane_.direction[variable]);
  }
  Twist moved_by_both(double first, double second) const {
    return moved_by_loop(system_, shape(first, second), plane_.direction[0], plane_.direction[1]);
  }

 private:
  const System& system_;
  const ShapePlane& plane_;
};

Planar in_the_plane(const Twist& moved, int normal) {
  return {moved[3 + (normal + 1) % 3], moved[3 + (normal + 2) % 3], moved[normal]};
}

// Two neighbouring nodes of the rectangle and the rates between them, half way, by the variable that changes.
struct Edge {
  Eigen::Index from, to;
  double length;  // of the variable
  double weight;  // its share of the rectangle's area, over that of edges inside: ½ along the boundary
  Twist moved;
  Planar rate;  // the same in the plane
};

// Of a sum over the nodes of one variable that stands for an integral: the trapezoidal rule's.
double share_beside(Eigen::Index node, Eigen::Index nodes) { return node == 0 || node + 1 == nodes ? 0.5 : 1.0; }

std::vector<Edge> edges_of(const Shapes& shapes, const std::array<std::vector<double>, 2>& nodes) {
  const auto n = static_cast<Eigen::Index>(nodes[0].size());
  std::vector<Edge> edges;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      for (std::size_t variable : {std::size_t{0}, std::size_t{1}}) {
        const Eigen::Index next_i = variable == 0 ? i + 1 : i, next_j = variable == 1 ? j + 1 : j;
        if (next_i == n || next_j == n) continue;
        const auto half_way = [](const std::vector<double>& values, Eigen::Index from, Eigen::Index to) {
          return 0.5 * (values[static_cast<std::size_t>(from)] + values[static_cast<std::size_t>(to)]);
        };
        const Eigen::Index beside = variable == 0 ? j : i;
        edges.push_back(
            {i * n + j, next_i * n + next_j, nodes[variable][1] - nodes[variable][0], share_beside(beside, n),
             shapes.moved(half_way(nodes[0], i, next_i), half_way(nodes[1], j, next_j), variable), Planar::Zero()});
      }
  return edges;
}

// The axis about which alone the root turns and along which it does not move, at all of these rates; −1 if none.
int normal_of(const std::vector<Edge>& edges) {
  Twist largest = Twist::Zero();
  for (const Edge& edge : edges) largest = largest.cwiseMax(edge.moved.cwiseAbs());
  const double turn = largest.head<3>().maxCoeff(), shift = largest.tail<3>().maxCoeff();
  for (int n : {2, 1, 0})
    if (largest[(n + 1) % 3] <= in_plane * turn && largest[(n + 2) % 3] <= in_plane * turn &&
        largest[3 + n] <= in_plane * shift)
      return n;
  return -1;
}

// Whether the nodes are apart by more than round-off.
bool wide_enough(const ShapePlane& plane) {
  constexpr double least_width = 1e-6;  // beside where the rectangle lies
  for (std::size_t n = 0; n < 2; ++n) {
    const double width = plane.high[n] - plane.low[n],
                 place = std::max(std::abs(plane.low[n]), std::abs(plane.high[n]));
    if (!(width > least_width * std::max(place, 1.0)) || !std::isfinite(width)) return false;
  }
  return plane.points >= 4;
}

// Solves what is positive definite, or leaves no number.
VectorXd solved(const Sparse& matrix, const VectorXd& right) {
  const Eigen::SimplicialLDLT<Sparse> factors(matrix);
  if (factors.info() != Eigen::Success)
    return VectorXd::Constant(right.size(), std::numeric_limits<double>::quiet_NaN());
  return factors.solve(right);
}

// The frame's heading: weighted least squares of (β_to − β_from)/length + ω over all edges, zero on the average, which no rate depends
// on. There are n nodes along each variable.
VectorXd least_turn(Eigen::Index n, const std::vector<Edge>& edges) {
  const Eigen::Index nodes = n * n;
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd right = VectorXd::Zero(nodes);
  for (const Edge& edge : edges) {
    const double w = 1.0 / edge.length;
    for (const auto& [row, sign] : {std::pair(edge.from, -1.0), std::pair(edge.to, 1.0)}) {
      entries.emplace_back(row, edge.from, -sign * edge.weight * w * w);
      entries.emplace_back(row, edge.to, sign * edge.weight * w * w);
      right[row] -= sign * edge.weight * w * edge.rate[2];
    }
  }
  entries.emplace_back(nodes / 2, nodes / 2, std::pow(1.0 / edges.front().length, 2));  // held there, then shifted
  Sparse normal(nodes, nodes);
  normal.setFromTriplets(entries.begin(), entries.end());
  VectorXd turn = solved(normal, right);
  double sum = 0.0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) sum += share_beside(i, n) * share_beside(j, n) * turn[i * n + j];
  turn.array() -= sum / static_cast<double>((n - 1) * (n - 1));
  return turn;
}

// Its place: weighted least squares of (β_to − β_from)/length + v + ω ẑ × (β_from + β_to)/2, [2 nodes]. What fixes the whole of it is the
// turn that the heading leaves; where that is none it lies anywhere, and is held at the middle.
VectorXd least_shift(Eigen::Index nodes, const std::vector<Edge>& edges, const VectorXd& turn) {
  constexpr double held = 1e-9, least_held = 1e-14;  // of what fixes it, of what makes it smooth
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd right = VectorXd::Zero(2 * nodes);
  double left = 0.0;
  for (const Edge& edge : edges) {
    left += edge.weight * std::pow(edge.rate[2] + (turn[edge.to] - turn[edge.from]) / edge.length, 2);
    Eigen::Matrix<double, 2, 4> by;
    by.leftCols<2>() << -1.0 / edge.length, -0.5 * edge.rate[2], 0.5 * edge.rate[2], -1.0 / edge.length;
    by.rightCols<2>() << 1.0 / edge.length, -0.5 * edge.rate[2], 0.5 * edge.rate[2], 1.0 / edge.length;
    const Eigen::Matrix4d square = edge.weight * by.transpose() * by;
    const Eigen::Vector4d pull = edge.weight * by.transpose() * edge.rate.head<2>();
    const std::array<Eigen::Index, 4> place{2 * edge.from, 2 * edge.from + 1, 2 * edge.to, 2 * edge.to + 1};
    for (Eigen::Index r = 0; r < 4; ++r) {
      right[place[static_cast<std::size_t>(r)]] -= pull[r];
      for (Eigen::Index c = 0; c < 4; ++c)
        entries.emplace_back(place[static_cast<std::size_t>(r)], place[static_cast<std::size_t>(c)], square(r, c));
    }
  }
  const double hold = std::max(held * left, least_held * std::pow(1.0 / edges.front().length, 2));
  for (const Eigen::Index c : {0, 1}) entries.emplace_back(2 * (nodes / 2) + c, 2 * (nodes / 2) + c, hold);
  Sparse normal(2 * nodes, 2 * nodes);
  normal.setFromTriplets(entries.begin(), entries.end());
  return solved(normal, right);
}

// A curvature as a frame sees it that stands at `frame` in the root's.
Planar seen_from(const Planar& frame, const Planar& of_root) {
  const Vector2d shift = of_root.head<2>() + of_root[2] * quarter_turned(frame.head<2>());
  Planar seen;
  seen << Eigen::Rotation2Dd(-frame[2]) * shift, of_root[2];
  return seen;
}

// The four nodes next to a value, and their weights in the cubic through them.
struct Cubic {
  Eigen::Index first;
  Eigen::Vector4d weight;
};

Eigen::Vector4d cubic_weights(double place) {  // among the nodes 0, 1, 2, 3
  const double a = place, b = place - 1.0, c = place - 2.0, d = place - 3.0;
  return {-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0};
}

Cubic cubic_at(const std::vector<double>& nodes, double value) {
  const double place = (value - nodes.front()) / (nodes[1] - nodes[0]);
  const double first = std::clamp(std::floor(place) - 1.0, 0.0, static_cast<double>(nodes.size() - 4));
  return {static_cast<Eigen::Index>(first), cubic_weights(place - first)};
}

// ∫ along each column from the first node to a place, of cubics between the nodes.
class RunningSum {
 public:
  RunningSum(const std::vector<double>& nodes, const MatrixXd& height)
      : nodes_(nodes), height_(height), sum_(MatrixXd::Zero(height.rows(), height.cols())) {
    for (Eigen::Index i = 0; i + 1 < height.rows(); ++i)
      sum_.row(i + 1) = sum_.row(i) + part(i, nodes[static_cast<std::size_t>(i + 1)]);
  }

  Eigen::RowVectorXd up_to(double value) const {
    const double place = (value - nodes_.front()) / (nodes_[1] - nodes_[0]);
    const auto i =
        static_cast<Eigen::Index>(std::clamp(std::floor(place), 0.0, static_cast<double>(nodes_.size() - 2)));
    return sum_.row(i) + part(i, value);
  }

 private:
  // From a node on, by Gauss' two points: exact for cubics.
  Eigen::RowVectorXd part(Eigen::Index node, double value) const {
    const double from = nodes_[static_cast<std::size_t>(node)], half = 0.5 * (value - from),
                 off = half / std::sqrt(3.0);
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(height_.cols());
    for (const double at_point : {from + half - off, from + half + off}) {
      const Cubic cubic = cubic_at(nodes_, at_point);
      sum += half * cubic.weight.transpose() * height_.middleRows<4>(cubic.first);
    }
    return sum;
  }

  const std::vector<double>& nodes_;
  const MatrixXd& height_;
  MatrixXd sum_;  // up to each node
};

}  // namespace

std::optional<HeightFunctions> height_functions(const System& system, const ShapePlane& plane) {
  const Shapes shapes(system, plane);
  if (!shapes.straight() || !wide_enough(plane)) return std::nullopt;
  HeightFunctions heights;
  for (std::size_t a = 0; a < 2; ++a)
    for (int k = 0; k < plane.points; ++k)
      heights.at[a].push_back(plane.low[a] + k * (plane.high[a] - plane.low[a]) / (plane.points - 1));
  std::vector<Edge> edges = edges_of(shapes, heights.at);
  heights.normal = normal_of(edges);
  if (heights.normal < 0) return std::nullopt;
  for (Edge& edge : edges) edge.rate = in_the_plane(edge.moved, heights.normal);

  const Eigen::Index n = plane.points;
  const VectorXd turn = least_turn(n, edges), shift = least_shift(n * n, edges, turn);
  heights.height.fill(MatrixXd(n, n));
  heights.frame.fill(MatrixXd(n, n));
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index node = i * n + j;
      const Planar frame(shift[2 * node], shift[2 * node + 1], turn[node]);
      const Twist moved =
          shapes.moved_by_both(heights.at[0][static_cast<std::size_t>(i)], heights.at[1][static_cast<std::size_t>(j)]);
      const Planar height = seen_from(frame, in_the_plane(moved, heights.normal));
      for (Eigen::Index k = 0; k < 3; ++k) {
        heights.height[static_cast<std::size_t>(k)](i, j) = height[k];
        heights.frame[static_cast<std::size_t>(k)](i, j) = frame[k];
      }
    }
  for (const auto* parts : {&heights.height, &heights.frame})
    for (const MatrixXd& part : *parts)
      if (!part.allFinite()) return std::nullopt;
  return heights;
}

Planar frame_at(const HeightFunctions& heights, double first, double second) {
  const Cubic i = cubic_at(heights.at[0], first), j = cubic_at(heights.at[1], second);
  Planar frame;
  for (std::size_t k = 0; k < 3; ++k)
    frame[static_cast<Eigen::Index>(k)] =
        i.weight.dot(Eigen::Vector4d(heights.frame[k].block<4, 4>(i.first, j.first) * j.weight));
  return frame;
}

Planar volume_over(const HeightFunctions& heights, const std::vector<std::array<double, 2>>& loop) {
  Planar volume = Planar::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const RunningSum sum(heights.at[0], heights.height[k]);
    for (std::size_t n = 0; n < loop.size(); ++n) {  // Green: ∬ F ds₁ds₂ = ∮ (∫ F ds₁) ds₂
      const auto &from = loop[n], &to = loop[(n + 1) % loop.size()];
      const Cubic j = cubic_at(heights.at[1], 0.5 * (from[1] + to[1]));
      volume[static_cast<Eigen::Index>(k)] +=
          (to[1] - from[1]) * sum.up_to(0.5 * (from[0] + to[0])).segment<4>(j.first).transpose().dot(j.weight);
    }
  }
  return volume;
}

Planar twist_of_frame(const Planar& frame, const Planar& root) {
  const double turn = root[2];
  const Vector2d moved = frame_moved(frame, root, frame).head<2>();
  // the twist v with moved = (sin φ/φ + (1 − cos φ)/φ ẑ×) v
  const double even = std::abs(turn) < 1e-8 ? 1.0 : std::sin(turn) / turn;
  const double odd = std::abs(turn) < 1e-8 ? 0.5 * turn : (1.0 - std::cos(turn)) / turn;
  const Vector2d twist = (even * moved - odd * quarter_turned(moved)) / (even * even + odd * odd);
  return {twist.x(), twist.y(), turn};
}

Planar seen_along(const Planar& twist, const Planar& moved) {
  Planar seen;
  seen << Eigen::Rotation2Dd(-moved[2]) * (twist.head<2>() + twist[2] * quarter_turned(moved.head<2>())), twist[2];
  return seen;
}

Planar frame_moved(const Planar& from, const Planar& root, const Planar& to) {
  Planar moved;
  moved << Eigen::Rotation2Dd(-from[2]) *
               (Eigen::Rotation2Dd(root[2]) * to.head<2>() + root.head<2>() - from.head<2>()),
      root[2] + to[2] - from[2];
  return moved;
}

}  // namespace lamprey::mechanics
