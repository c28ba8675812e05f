#include "optimality/cost_order.hpp"

#include "evidence/control_space.hpp"
#include "optimality/cost_gradient.hpp"
#include "optimality/gait_ends.hpp"

namespace lamprey::optimality {

namespace {

using model::at;
using model::Joint;
using model::System;

constexpr double inside_lens = 1e-5;      // of slopes of the work
constexpr double vanishing_power = 1e-5;  // of the drive's largest, where it has to
constexpr double no_power = 1e-8;         // likewise, where it need not
constexpr double vanishing = 1e-5;        // of the drive's largest moment, or rate
constexpr double least_scale = 1e-6;      // of the swimmer's largest moment or rate, that a drive's is measured by
constexpr double power_penalty = 1e6;     // of powers that are held, against the cost and the moments' weight
constexpr double same_moments = 1e-9;     // of the moments at both ends of a gait
constexpr double turn_difference = 5e-3;  // rad; differences of order four

// Turns of all joints over a step along the actuation, by the freedoms at its two nodes.
struct TurnForm {
  MatrixXd slope;      // [controls][2 turns]
  MatrixXd curvature;  // [2 turns]² of pull · turn
};

// Freedoms at one node that a free joint's attitude depends on.
std::vector<Eigen::Index> attitude_freedoms(const System& system, const Joint& joint) {
  std::vector<Eigen::Index> freedoms;
  const auto add = [&](int body) {
    for (int f = 0; f < system.body(body).freedoms; ++f) freedoms.push_back(system.body(body).velocity_offset + f);
  };
  add(joint.child);
  int body = joint.parent;
  for (; system.body(body).freedoms < 3; body = system.body(body).parent) add(body);
  add(body);
  return freedoms;
}

TurnForm turn_form(const StoredMotion& motion, int step, const mechanics::Vectors& pull) {
  const System& system = motion.system;
  const Eigen::Index turns = system.velocity_count() - 3;
  const mechanics::Rotations &left = motion.solution.rotation[at(step)],
                             &right = motion.solution.rotation[at(step + 1)];
  TurnForm form{MatrixXd::Zero(system.control_count(), 2 * turns), MatrixXd::Zero(2 * turns, 2 * turns)};
  for (int j = 0; j < system.joint_count(); ++j) {
    const Joint& joint = system.joint(j);
    const Eigen::Index own = joint.actuation.cols(), first = joint.first_control;
    if (own == 0) continue;
    if (!joint.free()) {  // angles
      const model::Body& child = system.body(joint.child);
      const MatrixXd along = joint.actuation.transpose().leftCols(child.freedoms);
      form.slope.block(first, child.velocity_offset, own, child.freedoms) = -along;
      form.slope.block(first, turns + child.velocity_offset, own, child.freedoms) = along;
      continue;
    }
    std::vector<Eigen::Index> places = attitude_freedoms(system, joint);
    for (std::size_t n = 0, count = places.size(); n < count; ++n) places.push_back(turns + places[n]);
    const auto turn = [&](const VectorXd& z) {
      return evidence::turn_between(joint, evidence::turned_along(system, left, z.head(turns)),
                                    evidence::turned_along(system, right, z.tail(turns)));
    };
    const Vector3d here = turn(VectorXd::Zero(2 * turns));
    const auto along = [&](const VectorXd& direction) {
      const double step_size = turn_difference;
      const Vector3d near = turn(step_size * direction), near_back = turn(-step_size * direction);
      const Vector3d far = turn(2.0 * step_size * direction), far_back = turn(-2.0 * step_size * direction);
      return std::pair(
          Vector3d((8.0 * (near - near_back) - (far - far_back)) / (12.0 * step_size)),
          pull[at(j)].dot(16.0 * (near + near_back) - (far + far_back) - 30.0 * here) / (12.0 * step_size * step_size));
    };
    MatrixXd own_curvature = MatrixXd::Zero(2 * turns, 2 * turns);
    for (Eigen::Index a : places) {
      const auto [slope, curvature] = along(VectorXd::Unit(2 * turns, a));
      form.slope.block(first, a, own, 1) = joint.actuation.transpose() * slope;
      own_curvature(a, a) = curvature;
    }
    if (pull[at(j)].isZero(0.0)) continue;
    for (Eigen::Index a : places)
      for (Eigen::Index b : places) {
        if (b >= a) continue;
        const double both = along(VectorXd::Unit(2 * turns, a) + VectorXd::Unit(2 * turns, b)).second;
        own_curvature(a, b) = own_curvature(b, a) = 0.5 * (both - own_curvature(a, a) - own_curvature(b, b));
      }
    form.curvature += own_curvature;
  }
  return form;
}

// Columns of the states that costs add: turns over the step before, those over a gait's first step, rad; moments at the node before and
// work so far, in the largest moment and what it does over a radian. −1: none.
struct CostColumns {
  Eigen::Index turn, first_turn = -1, moment = -1, work = -1, count;
};

CostColumns columns_after(const StoredMotion& motion, Eigen::Index states) {
  const Eigen::Index controls = motion.system.control_count();
  const maneuver::CostWeights& weights = motion.problem.cost_weights;
  CostColumns columns{states, -1, -1, -1, states + controls};
  const auto take = [&](Eigen::Index& column, Eigen::Index width) {
    column = columns.count;
    columns.count += width;
  };
  if (evidence::periodic(motion)) take(columns.first_turn, controls);
  if (weights.smoothness > 0.0) take(columns.moment, controls);
  if (weights.transport > 0.0 && !motion.problem.goal->distance()) take(columns.work, 1);
  return columns;
}

// N m, of the motion; J over a radian.
double moment_unit(const StoredMotion& motion) {
  double largest = 0.0;
  for (int k = 0; k <= motion.steps; ++k)
    largest = std::max(largest, evidence::moments_at(motion, k).lpNorm<Eigen::Infinity>());
  return largest > 0.0 ? largest : 1.0;
}

// a bᵀ + b aᵀ of rows.
MatrixXd both_ways(const MatrixXd& a, const MatrixXd& b) {
  const MatrixXd product = a.transpose() * b;
  return product + product.transpose();
}

// A part of the cost that falls with exp(−rate τ) where impulses are held: what τ adds to its second derivative.
void add_time_change(double rate, double value, const MatrixXd& slope, const MatrixXd& time, MatrixXd& form) {
  form += -rate * both_ways(time, slope) + rate * rate * value * time.transpose() * time;
}

// Work so far over the distance at the end (equation 13.16).
void add_transport(const StoredMotion& motion, const EffortChain& effort, const evidence::Powers& powers, double work,
                   double work_unit, Eigen::Index work_column, Chain& chain) {
  const Eigen::Index states = chain.end_form.rows(), reached = effort.basis.back().cols();
  const Eigen::Index place = motion.system.velocity_count() - 3;
  const Vector3d way = motion.solution.position.back() - motion.solution.position.front();
  const double D = powers.distance, weight = motion.problem.cost_weights.transport;
  MatrixXd shift = MatrixXd::Zero(3, states), by_work = MatrixXd::Zero(1, states);
  shift.leftCols(reached) =
      effort.tangents.scale.segment<3>(place).asDiagonal() * effort.basis.back().middleRows(place, 3);
  by_work(0, work_column) = work_unit;
  const MatrixXd farther = way.transpose() / D * shift;
  const MatrixXd bent = (shift.transpose() * shift - farther.transpose() * farther) / D;
  chain.end_form +=
      weight / (D * D) * (-both_ways(by_work, farther) + 2.0 * work / D * farther.transpose() * farther - work * bent);
}

// What a power changes by, [1][all]: with the moments, and with the rates that they work at.
struct WorkRows {
  MatrixXd by_moment, by_rate;
};

// A part of a power, and what it changes by, [1][all].
struct PowerPart {
  double power;
  MatrixXd rows;
};

// Takes the costs node by node into a chain that has been widened by their states.
class CostStages {
 public:
  CostStages(const StoredMotion& motion, const EffortChain& effort, const Kinks& kinks,
             std::optional<Eigen::Index> duration, Chain& chain)
      : motion_(motion),
        effort_(effort),
        kinks_(kinks),
        chain_(chain),
        powers_(evidence::powers_of(motion)),
        pulls_(pulls_on_turns(motion, powers_)),
        spent_(evidence::spent(motion, evidence::check_cost(motion).cost)),
        columns_(columns_after(motion, chain.end_form.rows())),
        unit_(moment_unit(motion)),
        timed_(duration.has_value()),
        turns_(motion.system.velocity_count() - 3),
        controls_(motion.system.control_count()),
        reached_(effort.basis.back().cols()),
        states_(columns_.count),
        all_(states_ + controls_),
        time_(MatrixXd::Zero(1, all_)),
        inputs_(MatrixXd::Zero(controls_, all_)) {
    widen(chain, states_);
    if (duration) time_(0, *duration) = 1.0;
    inputs_.rightCols(controls_).setIdentity();
  }

  void add() {
    for (int k = 0; k <= motion_.steps; ++k) add_node(k);
    if (columns_.work >= 0) add_transport(motion_, effort_, powers_, work_, unit_, columns_.work, chain_);
  }

 private:
  ChainStage& stage(int k) { return chain_.stage[effort_.first + at(k)]; }

  void add_node(int k) {
    MatrixXd form = MatrixXd::Zero(all_, all_), worked = MatrixXd::Zero(1, all_);
    const MatrixXd turned = turns_after(k, form);
    add_powers(k, turned, form, worked);
    add_smoothness(k, form);
    stage(k).Q += form.topLeftCorner(states_, states_);
    stage(k).S += form.bottomLeftCorner(controls_, states_);
    stage(k).R += form.bottomRightCorner(controls_, controls_);
    pass_on(k, turned, worked);
  }

  // Turns of the joints over the step after a node, a gait's first step after the last, [controls][all]; their curvature
  // goes into the form.
  MatrixXd turns_after(int k, MatrixXd& form) {
    if (k == motion_.steps)
      return columns_.first_turn >= 0 ? carried(columns_.first_turn) : MatrixXd(MatrixXd::Zero(controls_, all_));
    const TurnForm turn = turn_form(motion_, k, pulls_[at(k)]);
    MatrixXd map = MatrixXd::Zero(2 * turns_, all_);
    if (effort_.basis[at(k)].size() > 0) map.topLeftCorner(turns_, reached_) = turned_by(k);
    const MatrixXd there = turned_by(k + 1);
    map.bottomLeftCorner(turns_, states_) = there * stage(k).A.topRows(reached_);
    map.bottomRightCorner(turns_, controls_) = there * stage(k).B.topRows(reached_);
    form += map.transpose() * turn.curvature * map;
    MatrixXd turned = turn.slope * map;
    add_angular_velocity(k, turned, form);
    return turned;
  }

  // ½|ψ|²/h of the joints' turns over the step after a node, which change so.
  void add_angular_velocity(int k, const MatrixXd& turned, MatrixXd& form) const {
    const double stiff = motion_.problem.cost_weights.angular_velocity / motion_.time_step;
    if (stiff == 0.0) return;
    const VectorXd turn = mechanics::along_actuation(motion_.system, powers_.turn[at(k)]);
    form += stiff * turned.transpose() * turned;
    if (timed_) add_time_change(1.0, 0.5 * stiff * turn.squaredNorm(), stiff * turn.transpose() * turned, time_, form);
  }

  MatrixXd turned_by(int node) const {
    return effort_.tangents.scale.head(turns_).asDiagonal() * effort_.basis[at(node)].topRows(turns_);
  }

  MatrixXd carried(Eigen::Index column) const {
    MatrixXd rows = MatrixXd::Zero(controls_, all_);
    rows.middleCols(column, controls_).setIdentity();
    return rows;
  }

  // Work and squared power of each drive, and what the node works.
  void add_powers(int k, const MatrixXd& turned, MatrixXd& form, MatrixXd& worked) {
    const maneuver::CostWeights& weights = motion_.problem.cost_weights;
    const double half = 0.5 / motion_.time_step, weight = evidence::weight_of_work(motion_, powers_),
                 t = powers_.time[k];
    MatrixXd rate = half * turned, swing = rate;
    if (k > 0) {
      rate += half * carried(columns_.turn);
      swing -= half * carried(columns_.turn);
    }
    const VectorXd moments = evidence::moments_at(motion_, k);
    for (int d = 0; d < motion_.system.drive_count(); ++d) {
      const model::Drive& drive = motion_.system.drive(d);
      const int j = drive.joint, first = drive.first_control, own = drive.controls;
      if (own == 0 || t == 0.0) continue;
      const model::Axes actuation = evidence::axes_of(motion_.system, drive);
      const auto acting = inputs_.middleRows(first, own);
      const auto worked_at = [&](const Vector3d& at_rate, const MatrixXd& turning) -> WorkRows {
        return {-(actuation.transpose() * at_rate).transpose() * acting,
                -moments.segment(first, own).transpose() * turning.middleRows(first, own)};
      };
      const double value = powers_.value(d, k), change = powers_.change(d, k);
      const evidence::WorkSlopes slopes = evidence::work_slopes(motion_, powers_, d, k);
      const WorkRows mean = worked_at(powers_.rate[at(k)][at(j)], rate);
      const WorkRows half_change = worked_at(powers_.swing[at(k)][at(j)], swing);
      const MatrixXd by_value = mean.by_moment + mean.by_rate, by_change = half_change.by_moment + half_change.by_rate;
      const MatrixXd size = slopes.by_value * by_value + slopes.by_change * by_change;
      form -=
          t * both_ways(acting, (weight * slopes.by_value + 2.0 * weights.power * value) * rate.middleRows(first, own) +
                                    (weight * slopes.by_change + 2.0 / 3.0 * weights.power * change) *
                                        swing.middleRows(first, own));
      form +=
          2.0 * t * weights.power * (by_value.transpose() * by_value + 1.0 / 3.0 * by_change.transpose() * by_change);
      work_ += t * evidence::mean_size(value, change);
      const PowerPart given = given_power(k, value, change, by_value, by_change);
      const double given_work = (slopes.by_value - slopes.by_change) * given.power;
      worked += t * (size - (2.0 * evidence::mean_size(value, change) - given_work) * time_);
      if (timed_) {
        const MatrixXd given_size = (slopes.by_value - slopes.by_change) * given.rows;
        add_time_change(1.0, t * weight * given_work, t * weight * given_size, time_, form);
        add_time_change(2.0, t * weight * (evidence::mean_size(value, change) - given_work),
                        t * weight * (size - given_size), time_, form);
        add_time_of_squares(t * weights.power, given, {value - given.power, by_value - given.rows},
                            {change + given.power, by_change + given.rows}, form);
      }
      if (kinks_.held(d, k) != Held::no) {
        hold(k, moving(kinks_.held(d, k), mean), moving(kinks_.held(d, k), half_change), form);
      } else if (kinks_.turns(d, k)) {
        const MatrixXd across =
            by_value - value / change * by_change + (timed_ ? given.power * (1.0 + value / change) : 0.0) * time_;
        form += t * weight / std::abs(change) * across.transpose() * across;
      }
    }
  }

  // Of the first node's powers: u·ω/2 at the rates of the start, which are given, so that with impulses held it falls as
  // exp(−2τ) and not, as powers at rates of steps do, as exp(−3τ). It is part of the mean, and of the change with the other sign.
  PowerPart given_power(int k, double value, double change, const MatrixXd& by_value, const MatrixXd& by_change) const {
    if (k > 0) return {0.0, MatrixXd::Zero(1, all_)};
    return {0.5 * (value - change), 0.5 * (by_value - by_change)};
  }

  // Of the squares of mean and change, given in these parts.
  void add_time_of_squares(double factor, const PowerPart& given, const PowerPart& mean, const PowerPart& change,
                           MatrixXd& form) const {
    const double a = given.power, both = mean.power - change.power / 3.0;
    const MatrixXd by_both = mean.rows - change.rows / 3.0;
    add_time_change(3.0, factor * 4.0 / 3.0 * a * a, factor * 8.0 / 3.0 * a * given.rows, time_, form);
    add_time_change(4.0, factor * 2.0 * a * both, factor * 2.0 * (both * given.rows + a * by_both), time_, form);
    add_time_change(5.0, factor * (mean.power * mean.power + change.power * change.power / 3.0),
                    factor * 2.0 * (mean.power * mean.rows + change.power / 3.0 * change.rows), time_, form);
  }

  // What a power that is held changes by: what it does by a moment or a rate that vanishes is round-off.
  MatrixXd moving(Held held, const WorkRows& rows) const {
    MatrixXd change = MatrixXd::Zero(1, all_);
    if (held != Held::rate) change += rows.by_moment;
    if (held != Held::moment) change += rows.by_rate;
    return change;
  }

  // Keeps both rows where they are; of the shorter one what is not along the other, unless that is round-off.
  void hold(int k, MatrixXd longer, MatrixXd shorter, MatrixXd& form) {
    const auto product = [&](const MatrixXd& a, const MatrixXd& b) {
      return a.row(0).head(states_).dot(b.row(0).head(states_)) / spent_ +
             a.row(0).tail(controls_).dot(b.row(0).tail(controls_)) / stage(k).weight;
    };
    if (product(shorter, shorter) > product(longer, longer)) std::swap(longer, shorter);
    const double length = product(longer, longer);
    if (!(length > 0.0)) return;
    shorter -= product(longer, shorter) / length * longer;
    const double left = product(shorter, shorter);
    form += power_penalty / length * longer.transpose() * longer;
    if (left > vanishing * vanishing * length) form += power_penalty / left * shorter.transpose() * shorter;
  }

  void add_smoothness(int k, MatrixXd& form) const {
    if (columns_.moment < 0 || k == 0) return;
    const VectorXd step = evidence::moments_at(motion_, k) - evidence::moments_at(motion_, k - 1);
    const MatrixXd change = inputs_ - unit_ * carried(columns_.moment);
    const double stiff = motion_.problem.cost_weights.smoothness / motion_.time_step;
    form += stiff * change.transpose() * change;
    if (timed_) add_time_change(5.0, 0.5 * stiff * step.squaredNorm(), stiff * step.transpose() * change, time_, form);
  }

  // What the next node has to know.
  void pass_on(int k, const MatrixXd& turned, MatrixXd& worked) {
    const auto pass = [&](Eigen::Index column, const MatrixXd& rows) {
      stage(k).A.middleRows(column, rows.rows()) = rows.leftCols(states_);
      stage(k).B.middleRows(column, rows.rows()) = rows.rightCols(controls_);
    };
    pass(columns_.turn, turned);
    if (columns_.first_turn >= 0) pass(columns_.first_turn, k == 0 ? turned : carried(columns_.first_turn));
    if (columns_.moment >= 0) pass(columns_.moment, inputs_ / unit_);
    if (columns_.work < 0) return;
    if (k > 0) worked(0, columns_.work) += unit_;
    pass(columns_.work, worked / unit_);
  }

  const StoredMotion& motion_;
  const EffortChain& effort_;
  const Kinks& kinks_;
  Chain& chain_;
  evidence::Powers powers_;
  std::vector<mechanics::Vectors> pulls_;  // [N][joints] of the turns over the steps
  double spent_;                           // (N m)² s, before what the displacement takes off
  CostColumns columns_;
  double unit_;  // N m, J
  bool timed_;
  Eigen::Index turns_, controls_, reached_, states_, all_;
  MatrixXd time_, inputs_;  // [1][all], [controls][all] the duration's logarithm and the moments
  double work_ = 0.0;       // J so far
};

// Where powers must not leave 0, and why.
class HeldPowers {
 public:
  HeldPowers(const StoredMotion& motion, const evidence::Powers& powers)
      : motion_(motion),
        powers_(powers),
        moment_(largest([&](int d, int k) { return moment(d, k).norm(); })),
        rate_(largest([&](int d, int k) { return rates(d, k); })) {}

  // Slopes are inside of what the work can have, or, where a drive's one moment vanishes, of what they can be worth along it.
  // Where moment and rates vanish no row says what is held.
  Held at_node(int drive, int node) const {
    const evidence::WorkSlopes slopes = evidence::work_slopes(motion_, powers_, drive, node);
    const bool still = rates(drive, node) <= vanishing * rate_[drive];
    const bool idle = moment(drive, node).norm() <= vanishing * moment_[drive];
    if (still && idle) return Held::no;
    if (evidence::room_of(slopes) > inside_lens) return idle ? Held::moment : still ? Held::rate : Held::both;
    if (!idle || motion_.system.drive(drive).controls != 1) return Held::no;
    const double rate = along(drive, powers_.rate[at(node)])[0], swing = along(drive, powers_.swing[at(node)])[0];
    const double worth = slopes.by_value * rate + slopes.by_change * swing;
    return std::abs(worth) < (1.0 - inside_lens) * evidence::mean_size(rate, swing) ? Held::moment : Held::no;
  }

 private:
  VectorXd along(int drive, const mechanics::Vectors& by_joint) const {
    const model::Drive& own = motion_.system.drive(drive);
    return evidence::axes_of(motion_.system, own).transpose() * by_joint[at(own.joint)];
  }
  VectorXd moment(int drive, int node) const { return along(drive, motion_.control[at(node)]); }
  double rates(int drive, int node) const {
    return along(drive, powers_.rate[at(node)]).norm() + along(drive, powers_.swing[at(node)]).norm();
  }
  // Of each drive over all nodes, none of them less than round-off leaves of the swimmer's.
  template <typename Size>
  VectorXd largest(Size size) const {
    VectorXd all = VectorXd::Zero(motion_.system.drive_count());
    for (int d = 0; d < all.size(); ++d)
      for (int k = 0; k <= motion_.steps; ++k) all[d] = std::max(all[d], size(d, k));
    return all.cwiseMax(least_scale * all.maxCoeff());
  }

  const StoredMotion& motion_;
  const evidence::Powers& powers_;
  VectorXd moment_, rate_;  // [drives] N m, rad/s
};

}  // namespace

Kinks kinks_of(const StoredMotion& motion, const evidence::Powers& powers) {
  const System& system = motion.system;
  Kinks kinks;
  kinks.held.setConstant(system.drive_count(), motion.steps + 1, Held::no);
  kinks.turns.setConstant(system.drive_count(), motion.steps + 1, false);
  if (evidence::weight_of_work(motion, powers) == 0.0) return kinks;
  const HeldPowers held(motion, powers);
  const VectorXd largest = evidence::largest_powers(motion, powers);
  for (int k = evidence::periodic(motion) ? 1 : 0; k <= motion.steps; ++k)
    for (int d = 0; d < system.drive_count(); ++d) {
      if (system.drive(d).controls == 0) continue;
      const double value = powers.value(d, k), change = powers.change(d, k), size = evidence::mean_size(value, change);
      kinks.held(d, k) = held.at_node(d, k);
      if (kinks.held(d, k) != Held::no) {
        kinks.known = kinks.known && size <= vanishing_power * largest[d];
      } else if (size <= no_power * largest[d]) {
        kinks.weak = true;
      } else {
        kinks.turns(d, k) = std::abs(value) < std::abs(change);
      }
    }
  return kinks;
}

bool ends_fit_costs(const StoredMotion& motion) {
  if (!motion.problem.cost_weights.any() || !evidence::periodic(motion)) return true;
  const VectorXd first = evidence::moments_at(motion, 0), last = evidence::moments_at(motion, motion.steps);
  return (first - last).norm() <= same_moments * (first + last).norm();
}

void add_costs(const StoredMotion& motion, const EffortChain& effort, const Kinks& kinks,
               std::optional<Eigen::Index> duration, Chain& chain) {
  CostStages(motion, effort, kinks, duration, chain).add();
}

}  // namespace lamprey::optimality
