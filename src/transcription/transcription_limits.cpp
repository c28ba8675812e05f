// Limits and waypoints as rows of the transcription, at each node or at one. Rows with kinks are rounded: for
// v = bound − |y| stands (bound² − y²)/(2 bound) = v − v²/(2 bound), the same to first order where the limit holds.
#include <algorithm>
#include <limits>

#include "maneuver/step_chart.hpp"
#include "transcription/transcription.hpp"

namespace lamprey::transcription {

namespace {

using maneuver::counted_time;
using maneuver::limit_derivatives;
using maneuver::limit_value;
using maneuver::quaternion_curvature;
using Kind = LimitRow::Kind;
using model::at;

constexpr double everything = std::numeric_limits<double>::infinity();

// Bodies whose rotations at the node a row depends on.
std::vector<int> bodies_of(const model::System& system, const LimitRow& row) {
  std::vector<int> bodies;
  if (row.joint >= 0) return {system.joint(row.joint).parent, system.joint(row.joint).child};
  if (row.kind == Kind::pass_turn) return {row.body};
  for (int end : {row.body, row.other_body})
    for (int i = end; i >= 0; i = system.body(i).parent) bodies.push_back(i);
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  return bodies;
}

bool sees_position(const LimitRow& row) {
  return row.kind == Kind::sphere || row.kind == Kind::half_space || row.kind == Kind::pass_position;
}

// What a row of |τ| is rounded by: its value where τ = 0; 0 of rows without kinks.
double kink(const LimitRow& row) { return row.kind == Kind::twist ? row.bound / row.unit : 0.0; }

double rounded(const LimitRow& row, double value) {
  return kink(row) > 0.0 ? value - 0.5 * value * value / kink(row) : value;
}

double rounded_slope(const LimitRow& row, double value) { return kink(row) > 0.0 ? 1.0 - value / kink(row) : 1.0; }

}  // namespace

Transcription::Seen::Seen(const Transcription& from, int k)
    : rotation(from.rotations(k)),
      before(k > 0 ? from.rotations(k - 1) : rotation),
      position(from.position(k)),
      moment(from.controls(k)),
      node{rotation, before, position, moment, from.stretch() * from.h_, from.stretch() * from.maneuver_.duration} {}

// Moments of a torque row: where they begin among the controls, and how many.
std::pair<int, int> Transcription::limited_moments(const LimitRow& row) const {
  const int first = system_.joint(row.joint).first_control;
  if (row.kind == Kind::torque_component) return {first + row.component, 1};
  return {first, static_cast<int>(system_.joint(row.joint).actuation.cols())};
}

double Transcription::value_of(const Limited& limited) const {
  const LimitRow& row = limits_[limited.row];
  if (row.of_moments()) {
    const auto [first, count] = limited_moments(row);
    const double size = controls(limited.node).segment(first, count).squaredNorm() / (row.bound * row.bound);
    return 0.5 * (1.0 - size) / row.unit;
  }
  return rounded(row, limit_value(system_, row, Seen(*this, limited.node).node, everything));
}

// Gradient and Hessian of a row that is not of moments, by the body coordinates.
void Transcription::expand_limit(const Limited& limited, VectorXd& gradient, MatrixXd& hessian) const {
  const LimitRow& row = limits_[limited.row];
  const Seen seen(*this, limited.node);
  limit_derivatives(system_, row, seen.node, gradient, hessian);
  if (kink(row) == 0.0) return;
  const double slope = rounded_slope(row, limit_value(system_, row, seen.node, everything));
  hessian = slope * hessian - gradient * gradient.transpose() / kink(row);
  gradient *= slope;
}

// Which variables move the body coordinates of a row, and how.
std::vector<Transcription::Charted> Transcription::charted(const Limited& limited) const {
  const LimitRow& row = limits_[limited.row];
  std::vector<Charted> all;
  const auto add_turn = [&](int node, int body, Eigen::Index coordinate) {
    const int variable = quaternion_variable(node, body);
    if (variable >= 0)
      all.push_back({variable, coordinate, lie::quaternion_tangent(quaternion(node, body)), node, body});
  };
  if (!row.of_duration() && row.kind != Kind::pass_position)
    for (int body : bodies_of(system_, row)) add_turn(limited.node, body, 3 * body);
  if (sees_position(row)) all.push_back({position_variable(limited.node), 3 * bodies_, Matrix3d::Identity(), -1, -1});
  if (row.of_rate())
    for (int body : bodies_of(system_, row)) add_turn(limited.node - 1, body, 3 * (bodies_ + 1 + body));
  if (stretch_variable_ >= 0 && (row.of_rate() || row.of_duration()))
    all.push_back({stretch_variable_, 6 * bodies_ + 3, MatrixXd::Ones(1, 1), -1, -1});
  return all;
}

void Transcription::emit_charted(int row, const VectorXd& gradient, const std::vector<Charted>& charts,
                                 BlockSink& sink) {
  for (const Charted& chart : charts)
    sink.add(row, chart.variable,
             gradient.segment(chart.coordinate, chart.by_variable.rows()).transpose() * chart.by_variable);
}

void Transcription::emit_charted(double factor, const VectorXd& gradient, const MatrixXd& hessian,
                                 const std::vector<Charted>& charts, BlockSink& sink) const {
  for (std::size_t a = 0; a < charts.size(); ++a)
    for (std::size_t b = 0; b <= a; ++b) {
      const Charted &one = charts[a], &other = charts[b];
      MatrixXd block =
          factor * (one.by_variable.transpose() *
                    hessian.block(one.coordinate, other.coordinate, one.by_variable.rows(), other.by_variable.rows()) *
                    other.by_variable);
      if (a == b && one.body >= 0)
        block += factor * quaternion_curvature(quaternion(one.node, one.body), gradient.segment<3>(one.coordinate));
      sink.add_symmetric(one.variable, other.variable, block);
    }
}

void Transcription::emit_limit_jacobian(BlockSink& sink) const {
  VectorXd gradient;
  MatrixXd unused;
  for (std::size_t l = 0; l < limited_.size(); ++l) {
    const Limited& limited = limited_[l];
    const LimitRow& row = limits_[limited.row];
    const int constraint = limit_row() + static_cast<int>(l);
    if (row.of_moments()) {
      const auto [first, count] = limited_moments(row);
      const VectorXd u = controls(limited.node).segment(first, count);
      const double scale = 1.0 / (row.bound * row.bound * row.unit),
                   by_variable = control_unit() / (stretch() * stretch());
      sink.add(constraint, control_variable(limited.node) + first, -scale * by_variable * u.transpose());
      if (stretch_variable_ >= 0)
        sink.add(constraint, stretch_variable_, MatrixXd::Constant(1, 1, 2.0 * scale * u.squaredNorm()));
      continue;
    }
    expand_limit(limited, gradient, unused);
    emit_charted(constraint, gradient, charted(limited), sink);
  }
}

void Transcription::emit_limit_hessian(const VectorXd& multiplier, BlockSink& sink) const {
  VectorXd gradient;
  MatrixXd hessian;
  for (std::size_t l = 0; l < limited_.size(); ++l) {
    const Limited& limited = limited_[l];
    const LimitRow& row = limits_[limited.row];
    const double lambda = multiplier[limit_row() + static_cast<int>(l)];
    if (row.of_moments()) {
      const auto [first, count] = limited_moments(row);
      const VectorXd u = controls(limited.node).segment(first, count);
      const double scale = lambda / (row.bound * row.bound * row.unit),
                   by_variable = control_unit() / (stretch() * stretch());
      const int variable = control_variable(limited.node) + first;
      for (int m = 0; m < count; ++m)
        sink.add(variable + m, variable + m, MatrixXd::Constant(1, 1, -scale * by_variable * by_variable));
      if (stretch_variable_ < 0) continue;
      sink.add(stretch_variable_, variable, 4.0 * scale * by_variable * u.transpose());
      sink.add(stretch_variable_, stretch_variable_, MatrixXd::Constant(1, 1, -8.0 * scale * u.squaredNorm()));
      continue;
    }
    expand_limit(limited, gradient, hessian);
    emit_charted(lambda, gradient, hessian, charted(limited), sink);
  }
}

// Ipopt's multipliers belong to the cost in units of cost_unit, and are negative where a lower bound holds.
LimitMultipliers Transcription::limit_multipliers(const VectorXd& x, const VectorXd& multiplier) {
  move_to(x);
  LimitMultipliers result;
  result.value.setZero(static_cast<Eigen::Index>(limits_.size()), steps_ + 1);
  for (std::size_t l = 0; l < limited_.size(); ++l) {
    const Limited& limited = limited_[l];
    const LimitRow& row = limits_[limited.row];
    double& value = result.value(static_cast<Eigen::Index>(limited.row), limited.node);
    value = -cost_unit() * multiplier[limit_row() + static_cast<int>(l)] /
            counted_time(row, limited.node, steps_, maneuver_.duration);
    if (kink(row) > 0.0)
      value *= rounded_slope(row, limit_value(system_, row, Seen(*this, limited.node).node, everything));
    if (!row.equality()) value = std::max(value, 0.0);
  }
  return result;
}

}  // namespace lamprey::transcription
