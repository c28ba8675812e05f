#include "mechanics/height_functions.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>

namespace lamprey::mechanics {

namespace {

using Eigen::Vector2d;
using model::at;
using model::System;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double in_plane = 1e-9;  // of what moves, beside which the rest is round-off
constexpr double held = 1e-10;     // of the diagonal: holds what no rate depends on, the frame's mean

Vector2d quarter_turned(const Vector2d& v) { return {-v.y(), v.x()}; }

// Shapes of the rectangle, and the connection there in the plane.
class Shapes {
 public:
  Shapes(const System& system, const ShapePlane& plane) : system_(system), plane_(plane) {
    for (int j = 0, column = 0; j < system.joint_count(); ++j) {
      for (std::size_t n = 0; n < 2; ++n)
        if (plane.angle[n].joint == j) column_[n] = column + plane.angle[n].axis;
      column += system.body(system.joint(j).child).freedoms;
    }
  }

  Rotations at_angles(double first, double second) const {
    Vectors turn(at(system_.joint_count()), Vector3d::Zero());
    turn[at(plane_.angle[0].joint)][plane_.angle[0].axis] += first;
    turn[at(plane_.angle[1].joint)][plane_.angle[1].axis] += second;
    Rotations R(at(system_.body_count()), Matrix3d::Identity());
    for (int i : system_.root_to_leaves()) {
      const model::Body& body = system_.body(i);
      if (body.parent >= 0)
        R[at(i)] = R[at(body.parent)] * rotation_at_turn(system_.joint(body.joint), turn[at(body.joint)]);
    }
    return R;
  }

  /// Rates by the two angles, as turn and shift of the root.
  Eigen::Matrix<double, 6, 2> rates(double first, double second) const {
    const LocalConnection connection = local_connection(system_, at_angles(first, second));
    Eigen::Matrix<double, 6, 2> rates;
    for (Eigen::Index n = 0; n < 2; ++n) {
      rates.col(n).head<3>() = connection.turn.col(column_[at(static_cast<int>(n))]);
      rates.col(n).tail<3>() = connection.shift.col(column_[at(static_cast<int>(n))]);
    }
    return rates;
  }

  Planar curvature(double first, double second, int normal) const {
    const ConnectionCurvature curvature = connection_curvature(system_, at_angles(first, second));
    const auto of = [&](const std::array<MatrixXd, 3>& parts, int k) { return parts[at(k)](column_[0], column_[1]); };
    return {of(curvature.shift, (normal + 1) % 3), of(curvature.shift, (normal + 2) % 3), of(curvature.turn, normal)};
  }

 private:
  const System& system_;
  const ShapePlane& plane_;
  std::array<Eigen::Index, 2> column_{};
};

Planar in_the_plane(const Eigen::Matrix<double, 6, 2>& rates, Eigen::Index angle, int normal) {
  return {rates(3 + (normal + 1) % 3, angle), rates(3 + (normal + 2) % 3, angle), rates(normal, angle)};
}

// The axis about which alone the root turns and along which it does not move, at all of these rates; −1 if none.
int normal_of(const std::vector<Eigen::Matrix<double, 6, 2>>& all) {
  Eigen::Matrix<double, 6, 1> largest = Eigen::Matrix<double, 6, 1>::Zero();
  for (const auto& rates : all) largest = largest.cwiseMax(rates.cwiseAbs().rowwise().maxCoeff());
  const double turn = largest.head<3>().maxCoeff(), shift = largest.tail<3>().maxCoeff();
  for (int n : {2, 1, 0})
    if (largest[(n + 1) % 3] <= in_plane * turn && largest[(n + 2) % 3] <= in_plane * turn &&
        largest[3 + n] <= in_plane * shift)
      return n;
  return -1;
}

// Two neighbouring nodes and the rates by the angle between them, half way.
struct Edge {
  Eigen::Index from, to;
  double length;  // rad
  Planar rate;
};

// The frame's heading: least squares of (β_to − β_from)/length + ω over all edges.
VectorXd least_turn(Eigen::Index nodes, const std::vector<Edge>& edges) {
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd right = VectorXd::Zero(nodes);
  for (const Edge& edge : edges) {
    const double w = 1.0 / edge.length;
    for (const auto& [row, sign] : {std::pair(edge.from, -1.0), std::pair(edge.to, 1.0)}) {
      entries.emplace_back(row, edge.from, -sign * w * w);
      entries.emplace_back(row, edge.to, sign * w * w);
      right[row] -= sign * w * edge.rate[2];
    }
  }
  Sparse normal(nodes, nodes);
  normal.setFromTriplets(entries.begin(), entries.end());
  normal.diagonal() *= 1.0 + held;
  return Eigen::SimplicialLDLT<Sparse>(normal).solve(right);
}

// Its place: least squares of (β_to − β_from)/length + v + ω ẑ × (β_from + β_to)/2, [2 nodes].
VectorXd least_shift(Eigen::Index nodes, const std::vector<Edge>& edges) {
  std::vector<Eigen::Triplet<double>> entries;
  VectorXd right = VectorXd::Zero(2 * nodes);
  for (const Edge& edge : edges) {
    Eigen::Matrix<double, 2, 4> by;
    by.leftCols<2>() << -1.0 / edge.length, -0.5 * edge.rate[2], 0.5 * edge.rate[2], -1.0 / edge.length;
    by.rightCols<2>() << 1.0 / edge.length, -0.5 * edge.rate[2], 0.5 * edge.rate[2], 1.0 / edge.length;
    const Eigen::Matrix4d square = by.transpose() * by;
    const Eigen::Vector4d pull = by.transpose() * edge.rate.head<2>();
    const std::array<Eigen::Index, 4> place{2 * edge.from, 2 * edge.from + 1, 2 * edge.to, 2 * edge.to + 1};
    for (Eigen::Index r = 0; r < 4; ++r) {
      right[place[static_cast<std::size_t>(r)]] -= pull[r];
      for (Eigen::Index c = 0; c < 4; ++c)
        entries.emplace_back(place[static_cast<std::size_t>(r)], place[static_cast<std::size_t>(c)], square(r, c));
    }
  }
  Sparse normal(2 * nodes, 2 * nodes);
  normal.setFromTriplets(entries.begin(), entries.end());
  normal.diagonal() *= 1.0 + held;
  return Eigen::SimplicialLDLT<Sparse>(normal).solve(right);
}

// A curvature as a frame sees it that stands at `frame` in the root's.
Planar seen_from(const Planar& frame, const Planar& of_root) {
  const Vector2d shift = of_root.head<2>() + of_root[2] * quarter_turned(frame.head<2>());
  Planar seen;
  seen << Eigen::Rotation2Dd(-frame[2]) * shift, of_root[2];
  return seen;
}

// Where an angle lies among the nodes: a node and the share of the way to the next, none beyond the ends.
struct Place {
  Eigen::Index node;
  double share;
};

Place place_of(const std::vector<double>& angles, double angle) {
  const double step = angles[1] - angles[0];
  const auto last = static_cast<double>(angles.size() - 2);
  const double node = std::clamp(std::floor((angle - angles[0]) / step), 0.0, last);
  return {static_cast<Eigen::Index>(node), std::clamp((angle - angles[0]) / step - node, 0.0, 1.0)};
}

}  // namespace

std::optional<HeightFunctions> height_functions(const System& system, const ShapePlane& plane) {
  const Shapes shapes(system, plane);
  HeightFunctions heights;
  const Eigen::Index n = plane.points;
  for (std::size_t a = 0; a < 2; ++a)
    for (int k = 0; k < plane.points; ++k)
      heights.angle[a].push_back(plane.angle[a].low +
                                 k * (plane.angle[a].high - plane.angle[a].low) / (plane.points - 1));
  const auto &first = heights.angle[0], &second = heights.angle[1];
  std::vector<Edge> edges;
  std::vector<Eigen::Index> along;  // the angle that changes over each edge
  std::vector<Eigen::Matrix<double, 6, 2>> rates;
  const auto add_edge = [&](Eigen::Index i, Eigen::Index j, Eigen::Index angle) {
    const auto next_i = i + (angle == 0 ? 1 : 0), next_j = j + (angle == 1 ? 1 : 0);
    if (next_i >= n || next_j >= n) return;
    const auto middle = [](const std::vector<double>& angles, Eigen::Index from, Eigen::Index to) {
      return 0.5 * (angles[static_cast<std::size_t>(from)] + angles[static_cast<std::size_t>(to)]);
    };
    rates.push_back(shapes.rates(middle(first, i, next_i), middle(second, j, next_j)));
    along.push_back(angle);
    const std::vector<double>& changed = heights.angle[static_cast<std::size_t>(angle)];
    edges.push_back({i * n + j, next_i * n + next_j, changed[1] - changed[0], Planar::Zero()});
  };
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index angle : {0, 1}) add_edge(i, j, angle);
  heights.normal = normal_of(rates);
  if (heights.normal < 0) return std::nullopt;
  for (std::size_t e = 0; e < edges.size(); ++e) edges[e].rate = in_the_plane(rates[e], along[e], heights.normal);

  const VectorXd turn = least_turn(n * n, edges), shift = least_shift(n * n, edges);
  heights.height.fill(MatrixXd(n, n));
  heights.frame.fill(MatrixXd(n, n));
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const Planar frame(shift[2 * (i * n + j)], shift[2 * (i * n + j) + 1], turn[i * n + j]);
      const Planar height = seen_from(frame, shapes.curvature(first[static_cast<std::size_t>(i)],
                                                              second[static_cast<std::size_t>(j)], heights.normal));
      for (Eigen::Index k = 0; k < 3; ++k) {
        heights.height[static_cast<std::size_t>(k)](i, j) = height[k];
        heights.frame[static_cast<std::size_t>(k)](i, j) = frame[k];
      }
    }
  return heights;
}

Planar frame_at(const HeightFunctions& heights, double first, double second) {
  const Place i = place_of(heights.angle[0], first), j = place_of(heights.angle[1], second);
  Planar frame;
  for (Eigen::Index k = 0; k < 3; ++k) {
    const MatrixXd& values = heights.frame[static_cast<std::size_t>(k)];
    frame[k] = (1.0 - i.share) * ((1.0 - j.share) * values(i.node, j.node) + j.share * values(i.node, j.node + 1)) +
               i.share * ((1.0 - j.share) * values(i.node + 1, j.node) + j.share * values(i.node + 1, j.node + 1));
  }
  return frame;
}

Planar volume_over(const HeightFunctions& heights, const std::vector<std::array<double, 2>>& loop) {
  const double step = heights.angle[0][1] - heights.angle[0][0];
  // ∫ of height k from the first angle's lowest value to a place, the heights linear between nodes
  const auto up_to = [&](const MatrixXd& height, const Place& i, const Place& j) {
    const VectorXd row = (1.0 - j.share) * height.col(j.node) + j.share * height.col(j.node + 1);
    double sum = 0.0;
    for (Eigen::Index m = 0; m < i.node; ++m) sum += 0.5 * step * (row[m] + row[m + 1]);
    const double here = (1.0 - i.share) * row[i.node] + i.share * row[i.node + 1];
    return sum + 0.5 * i.share * step * (row[i.node] + here);
  };
  Planar volume = Planar::Zero();
  for (std::size_t n = 0; n < loop.size(); ++n) {  // Green: ∬ F dr₁dr₂ = ∮ (∫ F dr₁) dr₂
    const auto &from = loop[n], &to = loop[(n + 1) % loop.size()];
    const Place i = place_of(heights.angle[0], 0.5 * (from[0] + to[0]));
    const Place j = place_of(heights.angle[1], 0.5 * (from[1] + to[1]));
    for (std::size_t k = 0; k < 3; ++k)
      volume[static_cast<Eigen::Index>(k)] += (to[1] - from[1]) * up_to(heights.height[k], i, j);
  }
  return volume;
}

Planar displacement_of_frame(const Planar& frame, const Planar& root) {
  // (R, x) of the root, (B, b) of the frame in it: B⁻¹ (R b + x − b)
  const double turn = root[2];
  const Vector2d b = frame.head<2>();
  const Vector2d moved = Eigen::Rotation2Dd(-frame[2]) * (Eigen::Rotation2Dd(turn) * b + root.head<2>() - b);
  // the twist v with moved = (sin φ/φ + (1 − cos φ)/φ ẑ×) v
  const double even = std::abs(turn) < 1e-8 ? 1.0 : std::sin(turn) / turn;
  const double odd = std::abs(turn) < 1e-8 ? 0.5 * turn : (1.0 - std::cos(turn)) / turn;
  const Vector2d twist = (even * moved - odd * quarter_turned(moved)) / (even * even + odd * odd);
  return {twist.x(), twist.y(), turn};
}

}  // namespace lamprey::mechanics
