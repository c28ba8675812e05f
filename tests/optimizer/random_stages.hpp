// Random linear-quadratic models along a chain of stages.
#pragma once

#include <random>

#include "optimizer/stage_program.hpp"

namespace lamprey::tests {

class Numbers {
 public:
  explicit Numbers(unsigned seed) : engine_(seed) {}
  Eigen::MatrixXd matrix(Eigen::Index rows, Eigen::Index columns) {
    Eigen::MatrixXd m(rows, columns);
    for (double& entry : m.reshaped()) entry = normal_(engine_);
    return m;
  }
  Eigen::MatrixXd symmetric(Eigen::Index size) {
    const Eigen::MatrixXd m = matrix(size, size);
    return m + m.transpose();
  }

 private:
  std::mt19937 engine_;
  std::normal_distribution<double> normal_;
};

// `bent`: how much of the Hessian is indefinite.
inline optimizer::StageModel random_model(const optimizer::StageSizes& sizes, unsigned seed, double bent) {
  Numbers numbers(seed);
  optimizer::StageModel model(sizes);
  for (optimizer::Stage& stage : model.stage) {
    stage.A = 0.5 * numbers.matrix(sizes.states, sizes.states);
    stage.B = numbers.matrix(sizes.states, sizes.inputs);
    stage.gap = numbers.matrix(sizes.states, 1);
    stage.Q = bent * numbers.symmetric(sizes.states);
    stage.S = bent * numbers.matrix(sizes.inputs, sizes.states);
    stage.R = 3.0 * Eigen::MatrixXd::Identity(sizes.inputs, sizes.inputs);
    stage.q = numbers.matrix(sizes.states, 1);
    stage.r = numbers.matrix(sizes.inputs, 1);
    stage.metric.setIdentity();
  }
  model.Q_end = bent * numbers.symmetric(sizes.states);
  model.metric_end.setIdentity();
  model.q_end = numbers.matrix(sizes.states, 1);
  model.C = numbers.matrix(sizes.end_rows, sizes.states);
  model.c = numbers.matrix(sizes.end_rows, 1);
  return model;
}

// Makes the first states of each node the next ones of the node before, `shifted` in number, and the next ones the inputs where
// these are placed; `said` to the model, or hidden from it.
inline void place(optimizer::StageModel& model, int shifted, bool placed, bool said) {
  for (optimizer::Stage& stage : model.stage) {
    const Eigen::Index inputs = stage.B.cols(), given = shifted + (placed ? inputs : 0);
    stage.A.topRows(given).setZero();
    stage.A.block(0, shifted, shifted, shifted).setIdentity();
    stage.B.topRows(given).setZero();
    if (placed) {
      stage.B.middleRows(shifted, inputs).setIdentity();
      stage.A.bottomLeftCorner(stage.A.rows() - given, shifted).setZero();
    }
    stage.shifted = said ? shifted : 0;
    stage.placed = said && placed ? static_cast<int>(inputs) : 0;
  }
}

}  // namespace lamprey::tests
