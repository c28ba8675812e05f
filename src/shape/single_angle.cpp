#include "shape/single_angle.hpp"

#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "lie/so3.hpp"
#include "maneuver/end_rows.hpp"
#include "mechanics/connection.hpp"

namespace lamprey::shape {

namespace {

using Eigen::VectorXd;
using maneuver::EndRow;
using maneuver::in_words;
using maneuver::Maneuver;
using model::at;
using model::System;

constexpr int pieces = 1000;          // of the curve, from where it begins to either end, and of the best of them
constexpr double near_enough = 1e-3;  // of what is asked for
constexpr double jump = 1.0;          // rad: no row changes by so much in a piece, but attitudes beyond half a turn
constexpr double settled = 1e-5;      // units of the end rows, beside what other pieces of the curve make of it
constexpr double alike = 1e-3;        // of what is missed
constexpr double least_asked = 1e-6;  // units of the end rows: less is met by staying
constexpr int steps_of_turn = 4;      // that a whole turn takes at least
constexpr double whole_turn = 2.0 * std::numbers::pi;

// The hinge that alone bends the swimmer, and how far it may, rad from its zero angle.
struct Hinge {
  int joint;
  double least, most;
};

std::optional<Hinge> single_hinge(const System& system, const Maneuver& maneuver, const maneuver::Limits& limits) {
  constexpr double endless = std::numeric_limits<double>::infinity();
  if (maneuver.periodic || maneuver::has_momentum(system, maneuver.start)) return std::nullopt;
  std::optional<Hinge> hinge;
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    if (joint.kind == model::JointKind::fixed) continue;
    const auto bounds = limits.angle.find(joint.name);
    if (hinge || joint.kind != model::JointKind::hinge) return std::nullopt;
    if (bounds == limits.angle.end() && !maneuver.whole_turns) return std::nullopt;
    hinge = bounds == limits.angle.end() ? Hinge{j, -endless, endless}
                                         : Hinge{j, bounds->second[0][0], bounds->second[0][1]};
  }
  return hinge;
}

// A swimmer along its curve.
class Curve {
 public:
  struct Place {
    mechanics::Rotations rotation;
    Vector3d position;   // m
    double angle = 0.0;  // rad
  };

  Curve(const System& system, const Maneuver& maneuver, int joint)
      : system_(system),
        maneuver_(maneuver),
        joint_(joint),
        rows_(stated_end_rows(system, maneuver, {})),
        derivative_(maneuver::shape_size(system) + 6),
        rate_(at(system.joint_count()), Vector3d::Zero()) {
    rate_[at(joint)] = Vector3d::UnitX();
    now_.rotation = maneuver_.start.rotation;
    now_.position = maneuver_.start.position;
    now_.angle = mechanics::joint_angles(system_.joint(joint_),
                                         mechanics::child_to_parent(now_.rotation, system_.joint(joint_)))[0];
  }

  // The joint bends by so much, the root moved as it is half way.
  void bend(double by) {
    const Matrix3d root = now_.rotation[0];
    place(root, now_.angle + 0.5 * by);
    const mechanics::Twist moved = by * mechanics::moved_root(system_, now_.rotation, rate_);
    now_.position += root * lie::exp(Vector3d(0.5 * moved.head<3>())) * moved.tail<3>();
    now_.angle += by;
    place(root * lie::exp(Vector3d(moved.head<3>())), now_.angle);
  }

  // The whole has moved from where the curve begins as it did on the way from a place with the same angle to another one, so many times;
  // from where it has moved so once less.
  void move_as(const Place& from, const Place& to, int times) {
    const mechanics::Rotations& start = maneuver_.start.rotation;
    const Vector3d turn = lie::log(from.rotation[0].transpose() * to.rotation[0]);
    now_.position += now_.rotation[0] * from.rotation[0].transpose() * (to.position - from.position);
    const Matrix3d whole = start[0] * lie::exp(times * turn) * start[0].transpose();
    for (std::size_t i = 0; i < start.size(); ++i) now_.rotation[i] = whole * start[i];
  }

  const Place& now() const { return now_; }
  void go_to(const Place& there) { now_ = there; }
  const std::vector<EndRow>& rows() const { return rows_; }

  // What the goal is missed by there, in the rows' units.
  VectorXd missed() {
    VectorXd values(static_cast<Eigen::Index>(rows_.size()));
    for (std::size_t r = 0; r < rows_.size(); ++r)
      values[static_cast<Eigen::Index>(r)] =
          end_row(system_, maneuver_, rows_[r], now_.rotation, now_.position, derivative_);
    return values;
  }

 private:
  void place(const Matrix3d& root, double angle) {
    const mechanics::Rotations before = now_.rotation;
    for (int i : system_.root_to_leaves()) {
      const model::Body& body = system_.body(i);
      if (body.parent < 0) {
        now_.rotation[0] = root;
        continue;
      }
      const model::Joint& joint = system_.joint(body.joint);
      now_.rotation[at(i)] = now_.rotation[at(body.parent)] *
                             (body.joint == joint_ ? mechanics::rotation_at_turn(joint, Vector3d(angle, 0.0, 0.0))
                                                   : mechanics::child_to_parent(before, joint));
    }
  }

  const System& system_;
  const Maneuver& maneuver_;
  int joint_;
  std::vector<EndRow> rows_;
  Eigen::RowVectorXd derivative_;
  mechanics::Vectors rate_;
  Place now_;
};

// Where on the line from one to the other the origin is nearest; where attitudes jump, at the nearer end.
VectorXd nearest_between(const VectorXd& from, const VectorXd& to) {
  const VectorXd along = to - from;
  if (along.lpNorm<Eigen::Infinity>() > jump) return from.norm() < to.norm() ? from : to;
  const double square = along.squaredNorm();
  const double share = square > 0.0 ? std::clamp(-from.dot(along) / square, 0.0, 1.0) : 0.0;
  return from + share * along;
}

// Of a curve, where its pieces come nearest to the goal.
struct Nearest {
  VectorXd missed;     // there, in the rows' units
  double angle;        // rad
  Curve::Place begun;  // where the best piece begins
  double piece = 0.0;  // rad, how long it is; 0: nothing is nearer than the curve's own beginning
};

// Follows so many pieces of the curve from a place on.
void look_along(Curve& curve, const Curve::Place& from, double piece, Nearest& nearest) {
  curve.go_to(from);
  VectorXd before = curve.missed();
  for (int n = 0; n < pieces; ++n) {
    const Curve::Place begun = curve.now();
    curve.bend(piece);
    const VectorXd now = curve.missed();
    if (const VectorXd between = nearest_between(before, now); between.norm() < nearest.missed.norm())
      nearest = {between, curve.now().angle, begun, piece};
    before = now;
  }
}

Nearest nearest_end(Curve& curve, const Hinge& hinge) {
  const Curve::Place start = curve.now();
  Nearest nearest{curve.missed(), start.angle, start};
  for (const double end : {hinge.least, hinge.most}) look_along(curve, start, (end - start.angle) / pieces, nearest);
  if (nearest.piece == 0.0) return nearest;
  const double piece = nearest.piece;  // within which a small stroke bends
  curve.go_to(nearest.begun);
  nearest = {curve.missed(), curve.now().angle, curve.now()};
  look_along(curve, Curve::Place(nearest.begun), piece / pieces, nearest);
  return nearest;
}

constexpr const char* to_change_that =
    "; a second joint or axis would change that, or a goal that leaves more of it \"free\"";

// What the goal is missed by after each number of whole turns from −most to most, of curves in so many pieces.
std::vector<VectorXd> missed_after_turns(Curve& curve, int pieces_of_turn, int most) {
  const Curve::Place start = curve.now();
  for (int n = 0; n < pieces_of_turn; ++n) curve.bend(whole_turn / pieces_of_turn);
  const Curve::Place turned = curve.now();
  std::vector<VectorXd> missed(at(2 * most + 1));
  for (const auto& [from, to, sign] : {std::tuple(start, turned, 1), std::tuple(turned, start, -1)}) {
    curve.go_to(start);
    missed[at(most)] = curve.missed();
    for (int n = 1; n <= most; ++n) {
      curve.move_as(from, to, n);
      missed[at(most + sign * n)] = curve.missed();
    }
  }
  curve.go_to(start);
  return missed;
}

// Ends in the first shape: whole turns, each of which moves the swimmer as the one before it did.
std::string beyond_whole_turns(const System& system, Curve& curve, double asked, int steps) {
  const int most = std::max(1, steps / steps_of_turn);
  const std::vector<VectorXd> coarse = missed_after_turns(curve, pieces, most),
                              fine = missed_after_turns(curve, 2 * pieces, most);
  VectorXd nearest = VectorXd::Constant(static_cast<Eigen::Index>(curve.rows().size()), asked);
  int turns = 0;  // nearest by so many
  for (int n = 1; n <= most; ++n)
    for (const int by : {n, -n}) {
      const VectorXd &missed = fine[at(most + by)], &roughly = coarse[at(most + by)];
      if (missed.norm() <= settled + (missed - roughly).norm()) return "";
      if (missed.norm() >= (1.0 - alike) * nearest.norm()) continue;  // of turns that end alike the fewest
      nearest = missed;
      turns = by;
    }
  const std::string number = std::to_string(most);
  const std::string opening =
      "where a single joint angle ends in its first shape it has made whole turns, each of which moves the swimmer "
      "alike, "
      "and by none of up to " +
      number + " either way, the most that " + std::to_string(steps) + " steps show, is the goal met";
  if (turns == 0) return opening + to_change_that;
  Eigen::Index worst = 0;
  const double missed = nearest.cwiseAbs().maxCoeff(&worst);
  return opening + ". It comes nearest by " + std::to_string(turns) + ", after which " +
         end_row_in_words(system, curve.rows()[static_cast<std::size_t>(worst)], missed) + to_change_that;
}

}  // namespace

std::string beyond_single_angle(const System& system, const Maneuver& maneuver, const maneuver::Limits& limits,
                                int steps) {
  const std::optional<Hinge> hinge = single_hinge(system, maneuver, limits);
  if (!hinge) return "";
  Curve curve(system, maneuver, hinge->joint);
  if (curve.rows().empty()) return "";
  const double asked = curve.missed().norm();
  if (asked < least_asked) return "";
  if (std::isinf(hinge->most)) return beyond_whole_turns(system, curve, asked, steps);
  const Nearest nearest = nearest_end(curve, *hinge);
  if (nearest.missed.norm() <= near_enough * asked) return "";
  Eigen::Index worst = 0;
  const double missed = nearest.missed.cwiseAbs().maxCoeff(&worst);
  return "a single joint angle within limits goes back the way it came: where the swimmer is follows from the angle "
         "alone "
         "(scallop theorem), and at none from " +
         in_words(hinge->least) + " to " + in_words(hinge->most) + " rad is the goal met. It comes nearest at " +
         in_words(nearest.angle) + " rad, where " +
         end_row_in_words(system, curve.rows()[static_cast<std::size_t>(worst)], missed) + to_change_that;
}

}  // namespace lamprey::shape
