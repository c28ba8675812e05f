// Eigen's decompositions of matrices whose sizes are known only at run time, compiled once (decompositions.cpp).
#pragma once

#include "algebra/operators.hpp"

#include <Eigen/Dense>

#define LAMPREY_DECOMPOSITIONS(EACH)                                                                                  \
  EACH void Eigen::PartialPivLU<Eigen::MatrixXd>::compute();                                                          \
  EACH void Eigen::HouseholderQR<Eigen::MatrixXd>::computeInPlace();                                                  \
  EACH void Eigen::ColPivHouseholderQR<Eigen::MatrixXd>::computeInPlace();                                            \
  EACH Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>&                                                     \
  Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>::compute(const Eigen::MatrixXd&, const Eigen::MatrixXd&,  \
                                                                     int);                                            \
  EACH Eigen::LLT<Eigen::MatrixXd>& Eigen::LLT<Eigen::MatrixXd>::compute(const Eigen::EigenBase<Eigen::MatrixXd>&);   \
  EACH Eigen::LDLT<Eigen::MatrixXd>& Eigen::LDLT<Eigen::MatrixXd>::compute(const Eigen::EigenBase<Eigen::MatrixXd>&); \
  EACH Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>& Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>::compute(       \
      const Eigen::EigenBase<Eigen::MatrixXd>&, int);                                                                 \
  EACH Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>&                                                                \
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>::computeFromTridiagonal(const Eigen::VectorXd&,                      \
                                                                         const Eigen::VectorXd&, int);

LAMPREY_DECOMPOSITIONS(extern template)
