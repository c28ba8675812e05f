#include "shape/single_angle.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include "maneuver/end_rows.hpp"
#include "model/input_error.hpp"
#include "shape/curve_of_hinge.hpp"

namespace lamprey::shape {

namespace {

using Eigen::VectorXd;
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
constexpr int steps_of_turn = 2;      // at least: two bodies may turn by a quarter each, against each other
constexpr int first_shapes = 100;     // of a gait, in a whole turn
constexpr int most_steps_of_gait = 10'000;  // beyond, so many turns from so many shapes take too long

// The hinge that alone bends the swimmer, and how far it may, rad from its zero angle.
struct Hinge {
  int joint;
  double least, most;
};

std::optional<Hinge> single_hinge(const System& system, const Maneuver& maneuver, const maneuver::Limits& limits,
                                  int steps) {
  constexpr double endless = std::numeric_limits<double>::infinity();
  if (maneuver::has_momentum(system, maneuver.start)) return std::nullopt;
  if (maneuver.periodic && steps > most_steps_of_gait) return std::nullopt;
  std::optional<Hinge> hinge;
  for (int j = 0; j < system.joint_count(); ++j) {
    const model::Joint& joint = system.joint(j);
    if (joint.kind == model::JointKind::fixed) continue;
    const auto bounds = limits.angle.find(joint.name);
    if (hinge || joint.kind != model::JointKind::hinge) return std::nullopt;
    if (bounds == limits.angle.end() ? !maneuver.whole_turns : maneuver.periodic) return std::nullopt;
    hinge = bounds == limits.angle.end() ? Hinge{j, -endless, endless}
                                         : Hinge{j, bounds->second[0][0], bounds->second[0][1]};
  }
  return hinge;
}

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
  VectorXd missed;            // there, in the rows' units
  double angle;               // rad
  CurveOfHinge::Place begun;  // where the best piece begins
  double piece = 0.0;         // rad, how long it is; 0: nothing is nearer than the curve's own beginning
};

// Follows so many pieces of the curve from a place on.
void look_along(CurveOfHinge& curve, const CurveOfHinge::Place& from, double piece, Nearest& nearest) {
  curve.go_to(from);
  VectorXd before = curve.missed();
  for (int n = 0; n < pieces; ++n) {
    const CurveOfHinge::Place begun = curve.now();
    curve.bend(piece);
    const VectorXd now = curve.missed();
    if (const VectorXd between = nearest_between(before, now); between.norm() < nearest.missed.norm())
      nearest = {between, curve.now().angle, begun, piece};
    before = now;
  }
}

Nearest nearest_end(CurveOfHinge& curve, const Hinge& hinge) {
  const CurveOfHinge::Place start = curve.now();
  Nearest nearest{curve.missed(), start.angle, start};
  for (const double end : {hinge.least, hinge.most}) look_along(curve, start, (end - start.angle) / pieces, nearest);
  if (nearest.piece == 0.0) return nearest;
  const double piece = nearest.piece;  // within which a small stroke bends
  curve.go_to(nearest.begun);
  nearest = {curve.missed(), curve.now().angle, curve.now()};
  look_along(curve, CurveOfHinge::Place(nearest.begun), piece / pieces, nearest);
  return nearest;
}

constexpr const char* to_change_that =
    "; a second joint or axis would change that, or a goal that leaves more of it \"free\"";

// Where whole turns end.
struct End {
  VectorXd missed;    // in the rows' units
  Vector3d position;  // m
};

// Of so many first shapes, the swimmer's own first, where each number of whole turns from −most to most ends, by curves in so many pieces.
std::vector<std::vector<End>> ends_of_turns(CurveOfHinge& curve, int shapes, int pieces_of_turn, int most) {
  const CurveOfHinge::Place start = curve.now();
  std::vector<CurveOfHinge::Place> places = {start};
  for (int n = 0; n < (shapes > 1 ? 2 : 1) * pieces_of_turn; ++n) {
    curve.bend(2.0 * std::numbers::pi / pieces_of_turn);
    places.push_back(curve.now());
  }
  std::vector<std::vector<End>> ends(at(shapes), std::vector<End>(at(2 * most + 1)));
  for (int shape = 0; shape < shapes; ++shape) {
    const int piece = static_cast<int>(std::int64_t{pieces_of_turn} * shape / shapes);
    const CurveOfHinge::Place &first = places[at(piece)], &turned = places[at(piece + pieces_of_turn)];
    for (const auto& [from, to, sign] : {std::tuple(first, turned, 1), std::tuple(turned, first, -1)}) {
      curve.go_to(start);
      for (int n = 0; n <= most; ++n) {
        if (n > 0) curve.move_as(from, to, n);
        ends[at(shape)][at(most + sign * n)] = {curve.missed(), curve.now().position};
      }
    }
  }
  curve.go_to(start);
  return ends;
}

// Whole turns that end in the first shape, each of which moves the swimmer as the one before it did; of gaits whose first shape is free
// from many of them.
class WholeTurns {
 public:
  WholeTurns(CurveOfHinge& curve, const Maneuver& maneuver, int steps)
      : most_(std::max(1, steps / steps_of_turn)),
        shapes_(maneuver.periodic && maneuver.free_shape ? first_shapes : 1),
        coarse_(ends_of_turns(curve, shapes_, pieces, most_)),
        fine_(ends_of_turns(curve, shapes_, 2 * pieces, most_)) {}

  int most() const { return most_; }
  int shapes() const { return shapes_; }
  const End& end(int shape, int turns) const { return fine_[at(shape)][at(most_ + turns)]; }

  // By how much an end may be off, by the curve's pieces and from one first shape to the next: in the rows' units, and its position, m.
  double unsure(int shape, int turns) const {
    return apart(end(shape, turns), roughly(shape, turns)) +
           apart(end(shape, turns), end((shape + 1) % shapes_, turns));
  }
  double unsure_way(int shape, int turns) const {
    return (end(shape, turns).position - roughly(shape, turns).position).norm();
  }
  bool meets(int shape, int turns) const { return end(shape, turns).missed.norm() <= settled + unsure(shape, turns); }

 private:
  // Attitudes beyond half a turn jump, and are far from what is asked.
  static double apart(const End& one, const End& other) {
    const double apart = (one.missed - other.missed).norm();
    return apart > jump ? 0.0 : apart;
  }
  const End& roughly(int shape, int turns) const { return coarse_[at(shape)][at(most_ + turns)]; }

  int most_, shapes_;
  std::vector<std::vector<End>> coarse_, fine_;
};

std::string beyond_whole_turns(const System& system, const CurveOfHinge& curve, const WholeTurns& turns, int steps) {
  VectorXd nearest = turns.end(0, 0).missed;
  int nearest_by = 0;
  for (int shape = 0; shape < turns.shapes(); ++shape)
    for (int n = 1; n <= turns.most(); ++n)
      for (const int by : {n, -n}) {
        if (turns.meets(shape, by)) return "";
        const VectorXd& missed = turns.end(shape, by).missed;
        if (missed.norm() >= (1.0 - alike) * nearest.norm()) continue;  // of turns that end alike the fewest
        nearest = missed;
        nearest_by = by;
      }
  Eigen::Index worst = 0;
  const double missed = nearest.cwiseAbs().maxCoeff(&worst);
  return "where a single joint angle ends in its first shape it has made whole turns, each of which moves the swimmer "
         "alike; " +
         std::to_string(steps) + " steps show no more than " + std::to_string(turns.most()) +
         " either way (more steps show more), and by none of these is the goal met. It comes nearest " +
         (nearest_by == 0 ? "without any, where " : "by " + std::to_string(nearest_by) + ", after which ") +
         end_row_in_words(system, curve.rows()[static_cast<std::size_t>(worst)], missed) + to_change_that;
}

}  // namespace

std::string beyond_single_angle(const System& system, const Maneuver& maneuver, const maneuver::Limits& limits,
                                int steps) {
  const std::optional<Hinge> hinge = single_hinge(system, maneuver, limits, steps);
  if (!hinge) return "";
  CurveOfHinge curve(system, maneuver, hinge->joint);
  if (curve.rows().empty()) return "";
  const double asked = curve.missed().norm();
  if (asked < least_asked) return "";
  if (std::isinf(hinge->most)) return beyond_whole_turns(system, curve, WholeTurns(curve, maneuver, steps), steps);
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

void refuse_price_of_no_whole_turn(const System& system, const Maneuver& maneuver, const maneuver::Limits& limits,
                                   int steps) {
  const maneuver::CostWeights& weights = maneuver.cost_weights;
  const bool by_metre = weights.transport > 0.0 && !asks_to_move(system, maneuver);
  const std::optional<Hinge> hinge = single_hinge(system, maneuver, limits, steps);
  if (!hinge || !std::isinf(hinge->most) || !(weights.of_displacement() || by_metre)) return;
  CurveOfHinge curve(system, maneuver, hinge->joint);
  const WholeTurns turns(curve, maneuver, steps);
  const double still = settled * system.length_unit();
  for (int shape = 0; shape < turns.shapes(); ++shape)
    for (int by = -turns.most(); by <= turns.most(); ++by) {
      const Vector3d way = turns.end(shape, by).position - maneuver.start.position;
      const double wins = by_metre ? way.norm() : std::abs(way.dot(weights.displacement.normalized()));
      if (by != 0 && turns.meets(shape, by) && wins > still + turns.unsure_way(shape, by)) return;
    }
  throw model::InputError(by_metre ? "cost.transport" : "cost.displacement",
                          std::string("found a price of ") + (by_metre ? "each metre" : "displacement") +
                              ", but a single joint angle that ends in its first shape has made whole turns, and none "
                              "of up to " +
                              std::to_string(turns.most()) + " either way, all that " + std::to_string(steps) +
                              " steps show, meets the goal and moves the swimmer so; leave it out, or add a second "
                              "joint or axis");
}

}  // namespace lamprey::shape
