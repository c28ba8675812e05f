#include "shape/gait_cycles.hpp"

#include "lie/so3.hpp"

namespace lamprey::shape {

namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using maneuver::cayley_between;
using maneuver::Feedback;

// What a cycle does to the whole swimmer, once or several times: x → turn x + shift.
struct Displacement {
  Matrix3d turn = Matrix3d::Identity();
  Vector3d shift = Vector3d::Zero();
  Displacement after(const Displacement& first) const {
    return {lie::exp(lie::log(turn * first.turn)), turn * first.shift + shift};
  }
};

template <class Motion>
Displacement of_one_cycle(const Motion& gait) {
  const Matrix3d turn = gait.rotation.back()[0] * gait.rotation.front()[0].transpose();
  return {turn, gait.position.back() - turn * gait.position.front()};
}

// Deviations [2 n]: turns and angles, the root's shift in the world, their rates in the same order.
MatrixXd turned_gain(const MatrixXd& gain, const Matrix3d& turn) {
  MatrixXd result = gain;
  const Eigen::Index half = gain.cols() / 2;
  for (const Eigen::Index shift : {half - 3, 2 * half - 3})
    result.middleCols<3>(shift) = gain.middleCols<3>(shift) * turn.transpose();
  return result;
}

}  // namespace

Solution repeated(const Solution& gait, int cycles) {
  const Displacement one = of_one_cycle(gait);
  const std::size_t last = gait.time.size() - 1;
  const double period = gait.time.back() - gait.time.front();
  std::vector<Vector3d> meeting;
  for (std::size_t j = 0; j < gait.control.front().size(); ++j)
    meeting.push_back(0.5 * (gait.control.front()[j] + gait.control.back()[j]));
  Solution result;
  Displacement moved;
  for (int cycle = 0; cycle < cycles; ++cycle, moved = one.after(moved)) {
    const bool final = cycle + 1 == cycles;
    for (std::size_t k = 0; k < (final ? last + 1 : last); ++k) {
      result.time.push_back(gait.time[k] + cycle * period);
      result.position.push_back(moved.turn * gait.position[k] + moved.shift);
      result.rotation.emplace_back();
      for (const Matrix3d& R : gait.rotation[k]) result.rotation.back().push_back(moved.turn * R);
      result.control.push_back(k == 0 && cycle > 0 ? meeting : gait.control[k]);
      result.linear_velocity.push_back(gait.linear_velocity[k]);
      result.angular_velocity.push_back(gait.angular_velocity[k]);
    }
    const Feedback& feedback = gait.feedback;
    for (std::size_t m = 0; m + (final ? 0 : 1) < feedback.gain.size(); ++m) {
      result.feedback.time.push_back(feedback.time[m] + cycle * period);
      result.feedback.gain.push_back(turned_gain(feedback.gain[m], moved.turn));
    }
  }
  result.status = gait.status;
  return result;
}

NodePath repeated(const NodePath& gait, int cycles) {
  const Displacement one = of_one_cycle(gait);
  const std::size_t last = gait.rotation.size() - 1;
  NodePath result;
  Displacement moved;
  for (int cycle = 0; cycle < cycles; ++cycle, moved = one.after(moved))
    for (std::size_t k = cycle == 0 ? 0 : 1; k <= last; ++k) {
      result.position.push_back(moved.turn * gait.position[k] + moved.shift);
      result.control.push_back(gait.control[k]);
      mechanics::Rotations& rotation = result.rotation.emplace_back();
      for (const Matrix3d& R : gait.rotation[k]) rotation.push_back(moved.turn * R);
      if (result.rotation.size() > 1)
        cayley_between(result.rotation[result.rotation.size() - 2], rotation, result.cayley.emplace_back());
    }
  return result;
}

LimitMultipliers repeated(const LimitMultipliers& gait, int cycles) {
  LimitMultipliers result = gait;
  const Eigen::Index last = gait.value.cols() - 1;
  if (last < 0) return result;
  result.value.resize(gait.value.rows(), cycles * last + 1);
  result.value.col(0) = gait.value.col(0);  // where most limits do not apply
  for (int cycle = 0; cycle < cycles; ++cycle)
    result.value.middleCols(cycle * last + 1, last) = gait.value.rightCols(last);
  return result;
}

Solution begun_at(const Solution& gait, const Vector3d& position, const Matrix3d& heading) {
  const Matrix3d turn = heading * gait.rotation.front()[0].transpose();
  Solution result = gait;
  for (std::size_t k = 0; k < gait.position.size(); ++k) {
    result.position[k] = position + turn * (gait.position[k] - gait.position.front());
    for (Matrix3d& R : result.rotation[k]) R = turn * R;
  }
  for (MatrixXd& gain : result.feedback.gain) gain = turned_gain(gain, turn);
  return result;
}

}  // namespace lamprey::shape
