#include "shape/shape_turns.hpp"

namespace lamprey::shape {

namespace {

using maneuver::shape_offset;

}  // namespace

using mechanics::Rotations;
using model::at;

ShapeTurns::ShapeTurns(const model::System& system, const MatrixXd& shape_basis)
    : system_(system),
      shape_basis_(shape_basis),
      changes_(at(system.body_count())),
      by_freedoms_(3, system.velocity_count() - 3),
      of_body_(3, shape_basis.cols()),
      curvature_(shape_basis.rows(), shape_basis.rows()),
      half_(shape_basis) {
  const mechanics::Vectors none(at(system.body_count()), Vector3d::Zero());
  for (int i = 1; i < system.body_count(); ++i)
    for (int c = 0; c < system.body(i).freedoms; ++c) {
      unit_.push_back(none);
      unit_.back()[at(i)][c] = 1.0;
      turns_.push_back(none);
    }
}

const MatrixXd& ShapeTurns::of_body(const Rotations& R, int body) {
  of_body_.setZero();
  if (body == 0) return of_body_;
  if (system_.body(body).freedoms == 3) {
    of_body_ = shape_basis_.middleRows<3>(shape_offset(system_.body(body)));
    return of_body_;
  }
  mechanics::set_turn_by_freedoms(system_, R, body, by_freedoms_);
  algebra::set_product(by_freedoms_.rightCols(shape_basis_.rows()), shape_basis_, of_body_);
  return of_body_;
}

void ShapeTurns::add_curvature(
    const Rotations& R, const Eigen::Ref<const VectorXd>& pull,
    Eigen::Ref<MatrixXd> to) {  // NOLINT(performance-unnecessary-value-param): written through
  if (system_.only_free_joints()) return;
  for (std::size_t a = 0; a < unit_.size(); ++a) mechanics::body_turns(system_, R, unit_[a], turns_[a]);
  for (std::size_t a = 0; a < unit_.size(); ++a)
    for (std::size_t b = 0; b < unit_.size(); ++b) {
      mechanics::body_turn_changes(system_, R, unit_[a], turns_[a], unit_[b], changes_);
      double sum = 0.0;
      for (std::size_t i = 0; i < changes_.size(); ++i)
        sum += changes_[i].dot(pull.segment<3>(static_cast<Eigen::Index>(3 * i)));
      curvature_(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)) = sum;
    }
  for (Eigen::Index b = 0; b < curvature_.cols(); ++b)
    for (Eigen::Index a = 0; a < b; ++a)
      curvature_(a, b) = curvature_(b, a) = 0.5 * (curvature_(a, b) + curvature_(b, a));
  algebra::set_product(curvature_, shape_basis_, half_);
  algebra::add_product(1.0, shape_basis_.transpose(), half_, to);
}

}  // namespace lamprey::shape
