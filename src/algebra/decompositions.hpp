// Eigen's decompositions of matrices whose sizes are known only at run time, compiled once (decompositions.cpp).
#pragma once

#include "algebra/operators.hpp"

#include <Eigen/Dense>

#define LAMPREY_DECOMPOSITIONS(EACH)                                                                                  \
  EACH class Eigen::PartialPivLU<Eigen::MatrixXd>;                                                                    \
  EACH class Eigen::HouseholderQR<Eigen::MatrixXd>;                                                                   \
  EACH class Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;                                                             \
  EACH class Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>;                                               \
  EACH Eigen::LLT<Eigen::MatrixXd>& Eigen::LLT<Eigen::MatrixXd>::compute(const Eigen::EigenBase<Eigen::MatrixXd>&);   \
  EACH Eigen::LDLT<Eigen::MatrixXd>& Eigen::LDLT<Eigen::MatrixXd>::compute(const Eigen::EigenBase<Eigen::MatrixXd>&); \
  EACH Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>& Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>::compute(       \
      const Eigen::EigenBase<Eigen::MatrixXd>&, int);                                                                 \
  EACH Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>&                                                                \
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>::computeFromTridiagonal(const Eigen::VectorXd&,                      \
                                                                         const Eigen::VectorXd&, int);

LAMPREY_DECOMPOSITIONS(extern template)
