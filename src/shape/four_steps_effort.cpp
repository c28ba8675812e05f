// What moments cost by the shapes that ask for them, four nodes at once (equation 9.20).
#include "shape/four_steps.hpp"
#include "shape/step_lanes.hpp"

namespace lamprey::shape {

namespace {

using Eigen::Index;
using mechanics::Four;
using mechanics::Four3;
using mechanics::Four33;
using model::at;

}  // namespace

// Inverse dynamics to first order, from the leaves: h G u = E⁻ − E⁺, G u of a body being what the joints before and behind it
// exert on it.
void FourSteps::find_moments(const ForFour<const NodeEffort*>& node, bool first) {
  const int s = shapes(), width = 3 * s;
  const Four rate{1.0 / node[0]->impulse_time, 1.0 / node[1]->impulse_time, 1.0 / node[2]->impulse_time,
                  1.0 / node[3]->impulse_time};
  // a lane later: what the step before has at its end
  const auto before = [first](const Four33& old, const Four33& now) {
    const auto moved = [first](const Four& a, const Four& b) {
      return __builtin_shufflevector(first ? Four{} : a, b, 3, 4, 5, 6);
    };
    const auto column = [&](const Four3& a, const Four3& b) {
      return Four3{moved(a.x, b.x), moved(a.y, b.y), moved(a.z, b.z)};
    };
    return Four33{column(old.x, now.x), column(old.y, now.y), column(old.z, now.z)};
  };
  const int count = 2 * s;
  const std::vector<int>& order = system_.root_to_leaves();
  for (auto i = order.rbegin(); i != order.rend(); ++i) {
    if (*i == 0) continue;
    const model::Body& body = system_.body(*i);
    const Matrix3d to_axes = system_.joint(body.joint).actuation.transpose();
    const int r = *i - 1;
    const Four33 to_parent = transposed(left_[at(body.parent)]) * left_[at(*i)];
    for (int c = 0; c < width; ++c) {
      Four33 needed = Four33::zero();  // E⁻ − E⁺
      if (c >= s) needed = -1.0 * form_[at(r * count + c - s)];
      if (c < count) {
        const Four33& now = form_[at((s + r) * count + c)];
        needed = needed - before(plus_[at(r * count + c)], now);
      }
      Four33 moment = -rate * needed;
      for (int child : body.children) moment += weighed_[at((child - 1) * width + c)];
      moment = to_parent * moment;
      weighed_[at(r * width + c)] = moment;
      moment_[at(body.joint * width + c)] = to_axes * moment;
    }
  }
  for (int r = 0; r < s; ++r)
    for (int c = 0; c < count; ++c) plus_[at(r * count + c)] = form_[at((s + r) * count + c)];
}

// ½ w |u|² and, with it, how moments pull as the node's own shape turns.
void FourSteps::weigh_moments(const ForFour<const NodeEffort*>& node) {
  const int s = shapes(), width = 3 * s;
  const Four weight{node[0]->weight, node[1]->weight, node[2]->weight, node[3]->weight};
  for (int r = 0; r < s; ++r)
    for (int c = 0; c < s; ++c)
      by_control_[at(r * s + c)] = matrices_of_lanes(
          [&](std::size_t l) -> Matrix3d { return node[l]->control_by_shape.block<3, 3>(3 * r, 3 * c); });
  for (int r = 0; r < s; ++r)
    for (int c = 0; c < width; ++c) {
      Four33& weighed = weighed_[at(r * width + c)];
      weighed = weight * moment_[at(r * width + c)];
      if (c >= s && c < 2 * s) weighed += by_control_[at(r * s + c - s)];
    }
  for (int c = 0; c < width; ++c)
    for (int r = c; r < width; ++r) {
      Four33 form = Four33::zero();
      for (int i = 0; i < s; ++i) form += transposed(moment_[at(i * width + r)]) * weighed_[at(i * width + c)];
      if (r >= s && r < 2 * s)
        for (int i = 0; i < s; ++i) form += transposed(by_control_[at(i * s + r - s)]) * moment_[at(i * width + c)];
      moment_form_[at(r * width + c)] = form;
      if (r > c) moment_form_[at(c * width + r)] = transposed(form);
    }
}

void FourSteps::add_effort(const ForFour<const NodeEffort*>& node, int count, const ForFour<optimizer::Stage*>& stage) {
  using optimizer::Stage;
  const int s = shapes(), width = 3 * s;
  weigh_moments(node);
  const auto of = [&](MatrixXd Stage::*part) {
    return ForFour<MatrixXd*>{&(stage[0]->*part), &(stage[1]->*part), &(stage[2]->*part), &(stage[3]->*part)};
  };
  write_blocks(moment_, width, 0, s, 0, 2 * s, count, of(&Stage::measured_by_state), false);
  write_blocks(moment_, width, 0, s, 2 * s, s, count, of(&Stage::measured_by_input), false);
  write_blocks(moment_form_, width, 2 * s, s, 0, 2 * s, count, of(&Stage::S), false);
  write_blocks(moment_form_, width, 2 * s, s, 2 * s, s, count, of(&Stage::R), false);
  write_blocks(moment_form_, width, 0, 2 * s, 0, 2 * s, count, of(&Stage::Q), true);
  write_gradient(node, count, stage);
}

void FourSteps::add_effort(const ForFour<const NodeEffort*>& node, int count,
                           const ForFour<optimizer::StageSlopes::Slope*>& stage) {
  write_gradient(node, count, stage);
}

template <typename Slopes>
void FourSteps::write_gradient(const ForFour<const NodeEffort*>& node, int count, const ForFour<Slopes*>& stage) {
  const int s = shapes(), width = 3 * s;
  for (int c = 0; c < s; ++c)
    shape_vector_[at(c)] = vectors_of_lanes(
        [&](std::size_t l) -> Vector3d { return node[l]->weight * node[l]->moment.segment<3>(3 * c); });
  for (int c = 0; c < width; ++c) {
    Four3 sum = Four3::zero();
    for (int i = 0; i < s; ++i) sum += transposed(moment_[at(i * width + c)]) * shape_vector_[at(i)];
    for (int l = 0; l < count; ++l) {
      const std::size_t lane = at(l);
      const Vector3d one(sum.x[lane], sum.y[lane], sum.z[lane]);
      if (c < 2 * s)
        stage[lane]->q.template segment<3>(3 * c) += one;
      else
        stage[lane]->r.template segment<3>(3 * (c - 2 * s)) = one;
    }
  }
}

// Some of the blocks into the first rows and columns of a matrix of each step.
void FourSteps::write_blocks(const std::vector<Four33>& blocks, int width, int row, int rows, int column, int columns,
                             int count, const ForFour<MatrixXd*>& to, bool add) const {
  for (int c = 0; c < columns; ++c)
    for (int r = 0; r < rows; ++r) {
      Four33 block = blocks[at((row + r) * width + column + c)];
      algebra::transpose(block.x.x, block.x.y, block.x.z, block.y.x);
      algebra::transpose(block.y.y, block.y.z, block.z.x, block.z.y);
      const Four first[4] = {block.x.x, block.x.y, block.x.z, block.y.x};
      const Four second[4] = {block.y.y, block.y.z, block.z.x, block.z.y};
      for (int l = 0; l < count; ++l) {
        const std::size_t lane = at(l);
        const Index stride = to[lane]->rows();
        double* place = to[lane]->data() + 3 * c * stride + 3 * r;
        const Four &a = first[lane], &b = second[lane];
        const double one[9] = {a[0], a[1], a[2], a[3], b[0], b[1], b[2], b[3], block.z.z[lane]};
        for (int j = 0; j < 3; ++j, place += stride)
          for (int i = 0; i < 3; ++i) place[i] = add ? place[i] + one[3 * j + i] : one[3 * j + i];
      }
    }
}

}  // namespace lamprey::shape
