#include "guess/whole_turns.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "algebra/row_space.hpp"
#include "shape/shape_program.hpp"

namespace lamprey::guess {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using model::at;
using shape::ShapeProgram;
using shape::Steps;

constexpr double full_turn = 2.0 * std::numbers::pi;
constexpr double least_turn = 1e-3;      // rad, of a goal that turns count for
constexpr double spread = 0.7;           // of the logarithms of how much joints take part
constexpr double slight = 0.02;          // rad
constexpr double half_the_way = 0.5;     // that what was drawn may be off
constexpr double most_beside = 2.0;      // rad, that a goal without a turn leaves to strokes
constexpr double slight_damping = 1e-6;  // of the largest effect

// What joints that turn round do to where a body's rotation ends.
class EndTurns {
 public:
  EndTurns(const System& system, const Maneuver& maneuver, const ShapeCoordinates& coordinates,
           const std::vector<EndRow>& rows)
      : system_(system), maneuver_(maneuver), program_(system, maneuver_, coordinates, rows, {}, Steps::rough) {
    for (std::size_t i = maneuver.end_rotation.size(); i-- > 0;)
      if (maneuver.end_rotation[i]) body_ = static_cast<int>(i);
  }

  bool asked() const { return body_ >= 0; }
  const Matrix3d& goal() const { return *maneuver_.end_rotation[at(body_)]; }

  // Where the body ends, body → world.
  std::optional<Matrix3d> end(const WholeTurns& turns) {
    const auto to_and_fro = [&](int j, double s) -> Vector3d {  // which wins nothing: the still motion is singular
      return slight * std::pow(std::sin(std::numbers::pi * s), 2) * system_.joint(j).actuation.rowwise().sum();
    };
    if (!program_.go_to(swung(system_, maneuver_, to_and_fro, turns))) return std::nullopt;
    return program_.path().rotation.back()[at(body_)];
  }

 private:
  const System& system_;
  const Maneuver& maneuver_;
  ShapeProgram program_;
  int body_ = -1;
};

// A whole number near x, the nearer the likelier.
double drawn_near(double x, Random& random) { return std::floor(x + random.uniform()); }

// One turn of each joint along a direction drawn, and by how much it turns the body whose end is asked for, [3][joints] rad.
struct OneTurnEach {
  WholeTurns along;
  MatrixXd effect;
};

OneTurnEach drawn_directions(const System& system, const std::vector<int>& joints, EndTurns& ends,
                             const Matrix3d& still, Random& random) {
  const WholeTurns none(at(system.joint_count()), Vector3d::Zero());
  OneTurnEach drawn{none, MatrixXd::Zero(3, static_cast<Eigen::Index>(joints.size()))};
  for (std::size_t n = 0; n < joints.size(); ++n) {
    const MatrixXd& actuation = system.joint(joints[n]).actuation;
    const auto direction = static_cast<Eigen::Index>(random.uniform() * static_cast<double>(actuation.cols()));
    WholeTurns one = none;
    one[at(joints[n])] = drawn.along[at(joints[n])] = full_turn * actuation.col(direction).normalized();
    if (const std::optional<Matrix3d> end = ends.end(one))
      drawn.effect.col(static_cast<Eigen::Index>(n)) = lie::log(*end * still.transpose());
  }
  return drawn;
}

// Numbers of turns of each joint that add up to `way`, rad; joints take part in them by shares drawn.
VectorXd numbers_of_turns(const MatrixXd& effect, const Vector3d& way, Random& random) {
  const Eigen::Index count = effect.cols();
  VectorXd part(count);
  for (double& entry : part) entry = std::exp(spread * random.normal());
  MatrixXd rows(3 + count, count);
  rows.topRows(3) = effect * part.asDiagonal();
  const double largest = rows.topRows(3).colwise().norm().maxCoeff();
  rows.bottomRows(count) = slight_damping * largest * MatrixXd::Identity(count, count);
  VectorXd values = VectorXd::Zero(3 + count);
  values.head(3) = way;
  if (!(largest > 0.0)) return VectorXd::Zero(count);
  return part.cwiseProduct(VectorXd(algebra::least_squares(rows, values)));
}

}  // namespace

std::vector<int> joints_that_turn_round(const System& system, const Problem& problem) {
  std::vector<int> joints;
  for (int j = 0; j < system.joint_count(); ++j)
    if (system.joint(j).actuation.cols() > 0 && maneuver::may_turn_round(system.joint(j), problem.limits))
      joints.push_back(j);
  return joints;
}

std::optional<WholeTurns> whole_turns_to_goal(const System& system, const Maneuver& maneuver,
                                              const ShapeCoordinates& coordinates, const std::vector<EndRow>& rows,
                                              const std::vector<int>& joints, double share_of_way, int most,
                                              Random& random) {
  EndTurns ends(system, maneuver, coordinates, rows);
  if (!ends.asked() || joints.empty()) return std::nullopt;
  WholeTurns turns(at(system.joint_count()), Vector3d::Zero());
  const std::optional<Matrix3d> still = ends.end(turns);
  if (!still) return std::nullopt;
  Vector3d way =
      lie::log(ends.goal() * still->transpose());  // or the other way round, the likelier the less that is longer
  if (random.uniform() < way.norm() / full_turn) way -= full_turn * way.normalized();
  const OneTurnEach one = drawn_directions(system, joints, ends, *still, random);
  const bool turned = way.norm() >= least_turn;
  VectorXd numbers = VectorXd::Zero(one.effect.cols());
  if (turned) numbers = numbers_of_turns(one.effect, share_of_way * way, random);
  for (double& number : numbers)
    number = turned ? std::clamp(drawn_near(number, random), -1.0 * most, 1.0 * most)
                    : std::floor(3.0 * random.uniform()) - 1.0;
  for (std::size_t n = 0; n < joints.size(); ++n)
    turns[at(joints[n])] = numbers[static_cast<Eigen::Index>(n)] * one.along[at(joints[n])];
  const double off = (share_of_way * way - one.effect * numbers).norm();
  if (numbers.isZero(0.0) || !(off <= (turned ? half_the_way * way.norm() : most_beside))) return std::nullopt;
  return turns;
}

}  // namespace lamprey::guess
