// Second and third derivatives of four steps at once (chapter 9, equations 9.14 to 9.19 and 9.26).
#include <optional>

#include "shape/four_steps.hpp"
#include "shape/step_lanes.hpp"

namespace lamprey::shape {

namespace {

using algebra::DualFour;
using Eigen::Index;
using maneuver::shape_offset;
using mechanics::Four;
using mechanics::Four3;
using mechanics::Four33;
using mechanics::four_of;
using mechanics::Moments;
using mechanics::Three;
using mechanics::ThreeByThree;
using model::at;

ThreeByThree<DualFour> with_rate(const Four33& A, const Four33& rate) {
  const auto column = [](const Four3& v, const Four3& r) {
    return Three<DualFour>{{v.x, r.x}, {v.y, r.y}, {v.z, r.z}};
  };
  return {column(A.x, rate.x), column(A.y, rate.y), column(A.z, rate.z)};
}

Four33 rate_of(const ThreeByThree<DualFour>& A) {
  const auto column = [](const Three<DualFour>& v) { return Four3{v.x.rate, v.y.rate, v.z.rate}; };
  return {column(A.x), column(A.y), column(A.z)};
}

}  // namespace

template <typename S>
void FourSteps::lay_shifts(const Three<S>& of_root, Hessian<S>& hessian) const {
  for (int i : system_.root_to_leaves()) {
    Body<S>& body = hessian.body[at(i)];
    body.shift = of_root;
    if (i == 0) continue;
    const Body<S>& parent = hessian.body[at(system_.body(i).parent)];
    body.shift = parent.shift + (parent.right - parent.left) * parent_offset(system_, i) -
                 (body.right - body.left) * child_offset(system_, i);
  }
}

// Translation by the trapezoid: by the body's turns at both ends and its shift.
template <typename S>
void FourSteps::translate_at_ends(int i, Body<S>& body) const {
  const Matrix3d& M = system_.body(i).mass_matrix;
  const double half = 0.5 / time_step_;
  const ThreeByThree<S> Lt = transposed(body.left), Rt = transposed(body.right);
  const Three<S> w = Lt * body.shift, w_next = Rt * body.shift;
  const Three<S> Mw = M * w, Mw_next = M * w_next;
  const ThreeByThree<S> Mw_hat = times_hat(M, w), Mw_hat_next = times_hat(M, w_next);
  body.force = half * (body.left * Mw + body.right * Mw_next);
  body.force_by_shift = half * (body.left * (M * Lt) + body.right * (M * Rt));
  body.left_pull = half * plus_hat(Mw_hat, -Mw);
  body.right_pull = half * plus_hat(Mw_hat_next, -Mw_next);
  const auto of_shift = [](const Three<S>& v, const Three<S>& Mv, const ThreeByThree<S>& Mv_hat) {
    return minus_diagonal(dyad(v, Mv), dot(v, Mv)) - hat_times(v, Mv_hat);
  };
  body.by_left = half * of_shift(w, Mw, Mw_hat);
  body.by_right = half * of_shift(w_next, Mw_next, Mw_hat_next);
}

// Likewise by the midpoint.
template <typename S>
void FourSteps::translate_half_way(int i, Body<S>& body) const {
  const Matrix3d& M = system_.body(i).mass_matrix;
  const double rate = 1.0 / time_step_;
  const HalfWay<S> half_way(M, body.left, body.right, body.shift);
  const typename HalfWay<S>::Second second = half_way.second(M);
  body.force = rate * half_way.by_shift();
  body.force_by_shift = rate * second.shift_shift;
  body.left_pull = rate * second.shift_left;
  body.right_pull = rate * second.shift_right;
  body.by_left = rate * second.left_left;
  body.by_right = rate * second.right_right;
  body.by_both = rate * second.left_right;
}

// What a body's own Lagrangian has to do with its turns at both ends and its shift.
template <typename S>
void FourSteps::differentiate_body(int i, Body<S>& body) const {
  const Matrix3d& weight = system_.body(i).trace_weight;
  const double rate = 1.0 / time_step_;
  const ThreeByThree<S> F = transposed(body.left) * body.right;
  const ThreeByThree<S> X = F * weight;
  const S sum = trace(X);
  const ThreeByThree<S> by_turn = minus_diagonal(X, sum);
  if (at_half_way_) {
    translate_half_way(i, body);
    body.by_both += rate * (by_turn * F);
  } else {
    translate_at_ends(i, body);
    body.by_both = rate * (by_turn * F);
  }
  body.subtree_by_shift = body.force_by_shift;
  body.by_left = body.by_left - rate * by_turn;
  body.by_right = body.by_right - rate * minus_diagonal(transposed(weight * F), sum);
}

// Blocks of body j by itself, by the bodies before it and by the root's shift: the bodies behind it follow its turns.
template <typename S>
void FourSteps::add_up_tree(int j, Hessian<S>& hessian) const {
  const Body<S>& body = hessian.body[at(j)];
  const ThreeByThree<S> Lt = transposed(body.left), Rt = transposed(body.right);
  const Vector3d b = child_offset(system_, j);
  // forces by its turns, and what they do to it
  ThreeByThree<S> by_left = -1.0 * times_hat(body.force_by_shift * body.left, b) + body.left * body.left_pull;
  ThreeByThree<S> by_right = times_hat(body.force_by_shift * body.right, b) + body.right * body.right_pull;
  ThreeByThree<S> left = body.by_left - times_hat(transposed(body.left_pull), b) + dyad_less_dot(Lt * body.force, b);
  ThreeByThree<S> right = body.by_right + times_hat(transposed(body.right_pull), b) - dyad_less_dot(Rt * body.force, b);
  ThreeByThree<S> both = body.by_both + times_hat(transposed(body.left_pull) * (Lt * body.right), b);
  for (int c : system_.body(j).children) {
    const Body<S>& child = hessian.body[at(c)];
    const Vector3d& a = parent_offset(system_, c);
    const ThreeByThree<S> K = times_hat(child.subtree_by_shift * body.left, Vector3d(a - b));
    const ThreeByThree<S> K_next = -1.0 * times_hat(child.subtree_by_shift * body.right, Vector3d(a - b));
    by_left += K;
    by_right += K_next;
    right += hat_times(a, Rt * K_next) + dyad_less_dot(Rt * child.force, a);
    if (j == 0) continue;
    left = left - hat_times(a, Lt * K) - dyad_less_dot(Lt * child.force, a);
    both = both - hat_times(a, Lt * K_next);
  }
  const auto set = [&](int row, int column, const ThreeByThree<S>& value) {
    hessian.block[place(row, column)] = value;
    if (row != column) hessian.block[place(column, row)] = transposed(value);
  };
  set(at_shift(), at_right(j), by_right);
  if (j == 0) return set(at_right(0), at_right(0), right);
  set(at_shift(), at_left(j), by_left);
  set(at_right(j), at_right(j), right - hat_times(b, Rt * by_right));
  set(at_left(j), at_left(j), left + hat_times(b, Lt * by_left));
  set(at_left(j), at_right(j), both + hat_times(b, Lt * by_right));
  for (int c = j, k = system_.body(j).parent; k >= 0; c = k, k = system_.body(k).parent) {
    const Body<S>& before = hessian.body[at(k)];
    const Vector3d o = parent_offset(system_, c) - child_offset(system_, k);
    const ThreeByThree<S> Bt = transposed(before.right);
    set(at_right(k), at_right(j), hat_times(o, Bt * by_right));
    set(at_right(k), at_left(j), hat_times(o, Bt * by_left));
    if (k == 0) break;
    const ThreeByThree<S> At = transposed(before.left);
    set(at_left(k), at_right(j), -1.0 * hat_times(o, At * by_right));
    set(at_left(k), at_left(j), -1.0 * hat_times(o, At * by_left));
  }
}

// From the root's turn alone to the turn of all with it: R'_i = F_0 Q'_i.
template <typename S>
void FourSteps::turn_all_with_root(Hessian<S>& hessian) const {
  const int turn = at_right(0);
  const auto add_others = [&](int row) {
    ThreeByThree<S> whole = hessian.block[place(row, turn)];
    for (int j = 1; j < system_.body_count(); ++j)
      whole += hessian.block[place(row, at_right(j))] * transposed(hessian.body[at(j)].shape);
    hessian.block[place(row, turn)] = whole;
  };
  for (int row = 0; row < blocks(); ++row) add_others(row);
  ThreeByThree<S> twice = hessian.block[place(turn, turn)];
  for (int j = 1; j < system_.body_count(); ++j)
    twice += hessian.body[at(j)].shape * hessian.block[place(at_right(j), turn)];
  hessian.block[place(turn, turn)] = twice;
  for (int row = 0; row < blocks(); ++row)
    if (row != turn) hessian.block[place(turn, row)] = transposed(hessian.block[place(row, turn)]);
}

template <typename S>
void FourSteps::differentiate(Hessian<S>& hessian) const {
  for (int i = 0; i < system_.body_count(); ++i) differentiate_body(i, hessian.body[at(i)]);
  const std::vector<int>& order = system_.root_to_leaves();
  for (auto i = order.rbegin(); i != order.rend() && *i != 0; ++i) {
    Body<S>& parent = hessian.body[at(system_.body(*i).parent)];
    parent.force += hessian.body[at(*i)].force;
    parent.subtree_by_shift += hessian.body[at(*i)].subtree_by_shift;
  }
  for (int i = 0; i < system_.body_count(); ++i) add_up_tree(i, hessian);
  hessian.block[place(at_shift(), at_shift())] = hessian.body[0].subtree_by_shift;
  turn_all_with_root(hessian);
}

// Second derivatives of V: the root's motion follows the shapes.
void FourSteps::eliminate_root() {
  const int turn = at_right(0), shift = at_shift(), count = 2 * shapes();
  const auto& H = second_.block;
  root_.shift_by_turn = H[place(shift, turn)];
  root_.shift_inverse = inverse(H[place(shift, shift)]);
  root_.turn_inverse =
      inverse(H[place(turn, turn)] - transposed(root_.shift_by_turn) * (root_.shift_inverse * root_.shift_by_turn));
  for (int c = 0; c < count; ++c) {
    const Four33 seen = root_.shift_inverse * H[place(shift, c)];
    answer_turn_[at(c)] = root_.turn_inverse * (transposed(root_.shift_by_turn) * seen - H[place(turn, c)]);
    answer_shift_[at(c)] = -1.0 * (seen + root_.shift_inverse * (root_.shift_by_turn * answer_turn_[at(c)]));
  }
  for (int c = 0; c < count; ++c)
    for (int r = c; r < count; ++r) {
      const Four33 value =
          H[place(r, c)] + H[place(r, turn)] * answer_turn_[at(c)] + H[place(r, shift)] * answer_shift_[at(c)];
      form_[at(r * count + c)] = value;
      if (r > c) form_[at(c * count + r)] = transposed(value);
    }
  symmetric_ = form_;
  for (int c = 0; c < count; ++c) {
    Four33& block = symmetric_[at(c * (count + 1))];
    block = symmetric_part(block);
  }
}

// Calls add with each ball joint's moment, the rotation that takes it to the child, and the places of child and parent in the
// form; the root has none. Along axes moments do the same in every shape.
template <typename Add>
void FourSteps::for_moments_of_ball_joints(const ForFour<const Moments*>& control, bool right, const Add& add) const {
  const std::vector<Four33>& Q = right ? right_ : left_;
  for (int j = 0; j < system_.joint_count(); ++j) {
    const model::Joint& joint = system_.joint(j);
    if (!joint.free()) continue;
    const Four3 u = vectors_of_lanes([&](std::size_t l) -> const Vector3d& { return (*control[l])[at(j)]; });
    const int child = right ? at_right(joint.child) : at_left(joint.child);
    std::optional<int> parent;
    if (joint.parent != 0) parent = right ? at_right(joint.parent) : at_left(joint.parent);
    add(u, transposed(Q[at(joint.child)]) * Q[at(joint.parent)], child, parent);
  }
}

// Moments are held while the shapes turn: half of each acts in either step beside its node.
void FourSteps::add_moments(const ForFour<const Moments*>& control, bool right) {
  const double half = 0.5 * time_step_;
  const int count = 2 * shapes();
  for_moments_of_ball_joints(control, right, [&](const Four3& u, const Four33& to_child, int c, std::optional<int> p) {
    Four33& own = form_[at(c * (count + 1))];
    own = plus_hat(own, -half * (to_child * u));
    if (p) form_[at(c * count + *p)] += half * times_hat(to_child, u);
  });
}

// Likewise in the Hessian along the multipliers.
void FourSteps::add_moment_curvature(const ForFour<const Moments*>& control, bool right) {
  const double half = 0.5 * time_step_;
  const int count = 2 * shapes();
  for_moments_of_ball_joints(control, right, [&](const Four3& u, const Four33& to_child, int c, std::optional<int> p) {
    const Four3& m = shape_vector_[at(c)];
    form_[at(c * (count + 1))] += -half * second_turn(m, to_child * u);
    if (!p) return;
    form_[at(*p * (count + 1))] += -half * second_turn(transposed(to_child) * m, u);
    const Four33 mixed = half * hat_times(m, times_hat(to_child, u));
    form_[at(c * count + *p)] += mixed;
    form_[at(*p * count + c)] += transposed(mixed);
  });
}

void FourSteps::tangent(const ForFour<const ShapeStep*>& step, const ForFour<const Moments*>& control,
                        const ForFour<const Moments*>& control_next, const ForFour<ShapeTangent*>& tangent) {
  take_root(step);
  for (int i = 0; i < system_.body_count(); ++i) {
    Body<Four>& body = second_.body[at(i)];
    body.left = left_[at(i)];
    body.shape = right_[at(i)];
    body.right = i == 0 ? turn_ : turn_ * body.shape;
  }
  lay_shifts(shift_, second_);
  differentiate(second_);
  eliminate_root();
  add_moments(control, false);
  add_moments(control_next, true);
  if (led_left_.any()) bend_tangent(control, control_next);
  write_tangents(step, tangent);
}

void FourSteps::curvature(const ForFour<const ShapeStep*>& step, const ForFour<const Moments*>& control,
                          const ForFour<const Moments*>& control_next,
                          const ForFour<const ShapeMultipliers*>& multipliers, const ForFour<MatrixXd*>& hessian) {
  const int turn = at_right(0), shift = at_shift(), count = 2 * shapes();
  // the multipliers as one direction, the root following it and pulled by the goal
  Four3 of_turn = vectors_of_lanes(
      [&](std::size_t l) -> Vector3d { return step[l]->interval.next_rotation[0].transpose() * multipliers[l]->turn; });
  Four3 of_shift = vectors_of_lanes(
      [&](std::size_t l) -> Vector3d { return step[l]->interval.rotation[0].transpose() * multipliers[l]->shift; });
  root_.apply(of_turn, of_shift);
  of_turn = -of_turn;
  of_shift = -of_shift;
  if (led_left_.any()) spread_multipliers(multipliers);
  for (int j = 0; j < shapes() && !led_left_.any(); ++j) {
    const Index offset = shape_offset(system_.body(j + 1));
    const auto along = [&](const VectorXd& values) -> Vector3d {
      if (all_coordinates_) return values.segment<3>(offset);
      Vector3d sum = Vector3d::Zero();
      for (Index c = 0; c < values.size(); ++c) sum += values[c] * coordinates_.col(c).segment<3>(offset);
      return sum;
    };
    shape_vector_[at(j)] = -vectors_of_lanes([&](std::size_t l) { return along(multipliers[l]->minus); });
    shape_vector_[at(shapes() + j)] = -vectors_of_lanes([&](std::size_t l) { return along(multipliers[l]->plus); });
  }
  for (int c = 0; c < count; ++c) {
    of_turn += answer_turn_[at(c)] * shape_vector_[at(c)];
    of_shift += answer_shift_[at(c)] * shape_vector_[at(c)];
  }
  for (int i = 0; i < system_.body_count(); ++i) {
    const Body<Four>& now = second_.body[at(i)];
    Body<DualFour>& body = third_.body[at(i)];
    const Four3 none = Four3::zero();
    const Four3& by_left = i == 0 ? none : shape_vector_[at(at_left(i))];
    const Four3& by_right = i == 0 ? none : shape_vector_[at(at_right(i))];
    body.left = with_rate(now.left, times_hat(now.left, by_left));
    body.shape = with_rate(now.shape, times_hat(now.shape, by_right));
    body.right = with_rate(now.right, times_hat(now.right, by_right + transposed(now.shape) * of_turn));
  }
  const Three<DualFour> of_root{{shift_.x, of_shift.x}, {shift_.y, of_shift.y}, {shift_.z, of_shift.z}};
  lay_shifts(of_root, third_);
  differentiate(third_);

  // contracted with how the root follows the shapes
  const auto T = [&](int row, int column) { return rate_of(third_.block[place(row, column)]); };
  const Four33 by_turn = 0.5 * symmetric_part(T(turn, turn)), by_shift = 0.5 * T(shift, shift);
  const Four33 mixed = 0.5 * T(shift, turn);
  for (int c = 0; c < count; ++c) {
    const Four33 &z = answer_turn_[at(c)], &d = answer_shift_[at(c)];
    half_turn_[at(c)] = T(turn, c) + by_turn * z + transposed(mixed) * d;
    half_shift_[at(c)] = T(shift, c) + mixed * z + by_shift * d;
  }
  for (int c = 0; c < count; ++c)
    for (int r = c; r < count; ++r) {
      Four33 value = transposed(answer_turn_[at(r)]) * half_turn_[at(c)] +
                     transposed(answer_shift_[at(r)]) * half_shift_[at(c)] +
                     transposed(half_turn_[at(r)]) * answer_turn_[at(c)] +
                     transposed(half_shift_[at(r)]) * answer_shift_[at(c)] + T(r, c);
      // the fields along which shapes move do not commute with the multipliers'
      const Four33& V = symmetric_[at(r * count + c)];
      if (!led_left_.any()) value += hat_times(shape_vector_[at(r)], V) - times_hat(V, shape_vector_[at(c)]);
      form_[at(r * count + c)] = r == c ? symmetric_part(value) : value;
      if (r > c) form_[at(c * count + r)] = transposed(value);
    }
  add_moment_curvature(control, false);
  add_moment_curvature(control_next, true);
  if (led_left_.any()) {
    find_gradient_change(of_turn, of_shift);
    bend_curvature(control, control_next);
  }
  add_pose(step, multipliers, hessian);
  flatten_form();
  const Index f = coordinates_.cols();
  write(2 * f, 0, 2 * f, 1.0, {hessian[0]->data(), hessian[1]->data(), hessian[2]->data(), hessian[3]->data()},
        hessian[0]->rows());
}

// The world's view: with P what shapes add to the root's turn, the turn at the beginning is ρ' − Pθ (equation 9.9).
void FourSteps::add_pose(const ForFour<const ShapeStep*>& step, const ForFour<const ShapeMultipliers*>& multipliers,
                         const ForFour<MatrixXd*>& hessian) {
  const int count = 2 * shapes();
  Matrix3d twice[4];
  for (std::size_t l = 0; l < 4; ++l)
    twice[l] = lie::double_cross(multipliers[l]->shift, step[l]->interval.displacement);
  const Four33 half = 0.5 * four_of(twice[0], twice[1], twice[2], twice[3]);
  const Four3 turn = 0.5 * vectors_of_lanes([&](std::size_t l) -> const Vector3d& { return multipliers[l]->turn; });
  const Four3 shift = vectors_of_lanes([&](std::size_t l) -> const Vector3d& { return multipliers[l]->shift; });
  for (int c = 0; c < count; ++c)
    by_turn_[at(c)] = times_hat(transposed(pose_turn_[at(c)]), turn) +
                      times_hat(transposed(pose_shift_[at(c)]), shift) - transposed(pose_turn_[at(c)]) * half;
  for (int c = 0; c < count; ++c)
    for (int r = c; r < count; ++r) {
      Four33& block = form_[at(r * count + c)];
      block = block - by_turn_[at(r)] * pose_turn_[at(c)] - transposed(by_turn_[at(c)] * pose_turn_[at(r)]);
      if (r > c) form_[at(c * count + r)] = transposed(block);
    }
  for (int c = 0; c < count; ++c) {
    by_turn_[at(c)] = transposed(by_turn_[at(c)] - transposed(pose_turn_[at(c)]) * half);
    half_shift_[at(c)] = Four33::zero();
  }
  flatten_answers(by_turn_, half_shift_);
  const Index ends = 2 * coordinates_.cols();
  const auto corner = [&](std::size_t l) { return hessian[l]->data() + ends; };
  write(6, 0, 3, 1.0, {corner(0), corner(1), corner(2), corner(3)}, hessian[0]->rows());
  for (std::size_t l = 0; l < 4; ++l) {
    hessian[l]->block(0, ends, ends, 3) = hessian[l]->block(ends, 0, 3, ends).transpose();
    hessian[l]->block<3, 3>(ends, ends) = twice[l];
  }
}

// Entry by entry, column after column.
void FourSteps::lay(const std::vector<Four33>& form, std::vector<Four>& flat) const {
  const int count = 2 * shapes(), size = 3 * count;
  for (int c = 0; c < count; ++c)
    for (int r = 0; r < count; ++r) {
      const Four33& block = form[at(r * count + c)];
      Four* to = flat.data() + 3 * c * size + 3 * r;
      for (const Four3* column : {&block.x, &block.y, &block.z}) {
        to[0] = column->x;
        to[1] = column->y;
        to[2] = column->z;
        to += size;
      }
    }
}

// form_ along the coordinates, column after column.
void FourSteps::flatten_form() {
  lay(form_, flat_);
  if (led_left_.any()) {
    project_form(flat_, flat_);
    for (std::size_t place = 0; place < bend_.size(); ++place) flat_[place] += bend_[place];
  }
  if (all_coordinates_) return;
  const int n = static_cast<int>(coordinates_.rows()), f = static_cast<int>(coordinates_.cols()), size = 2 * n;
  for (int row = 0; row < size; ++row)
    for (int c = 0; c < 2 * f; ++c) {
      Four sum{};
      const int from = c < f ? 0 : n;
      for (int a = 0; a < n; ++a) sum += coordinates_(a, c % f) * flat_[at((from + a) * size + row)];
      half_[at(c * size + row)] = sum;
    }
  for (int c = 0; c < 2 * f; ++c)
    for (int r = 0; r < 2 * f; ++r) {
      Four sum{};
      const int from = r < f ? 0 : n;
      for (int a = 0; a < n; ++a) sum += coordinates_(a, r % f) * half_[at(c * size + from + a)];
      flat_[at(c * 2 * f + r)] = sum;
    }
}

// Rows of what is flattened, [all rows][columns], into a matrix of each step.
void FourSteps::write(Index all_rows, Index first, Index rows, double factor, const ForFour<double*>& to,
                      Index stride) const {
  const Index columns = 2 * coordinates_.cols();
  for (Index c = 0; c < columns; ++c) {
    const Four* from = flat_.data() + c * all_rows + first;
    Index r = 0;
    for (; r + 4 <= rows; r += 4) {
      Four a = factor * from[r], b = factor * from[r + 1], d = factor * from[r + 2], e = factor * from[r + 3];
      algebra::transpose(a, b, d, e);
      const Index place = c * stride + r;
      algebra::store(a, to[0] + place);
      algebra::store(b, to[1] + place);
      algebra::store(d, to[2] + place);
      algebra::store(e, to[3] + place);
    }
    for (; r < rows; ++r)
      for (std::size_t l = 0; l < 4; ++l) to[l][c * stride + r] = factor * from[r][l];
  }
}

void FourSteps::write_tangents(const ForFour<const ShapeStep*>& step, const ForFour<ShapeTangent*>& tangent) {
  const Index f = coordinates_.cols();
  const auto data = [&](MatrixXd ShapeTangent::*part, Index rows) {
    ForFour<double*> to;
    for (std::size_t l = 0; l < 4; ++l) {
      (tangent[l]->*part).resize(rows, 2 * f);
      to[l] = (tangent[l]->*part).data();
    }
    return to;
  };
  flatten_form();
  write(2 * f, 0, f, -1.0, data(&ShapeTangent::minus, f), f);
  write(2 * f, f, f, 1.0, data(&ShapeTangent::plus, f), f);
  const Four33 R = matrices_of_lanes([&](std::size_t l) -> const Matrix3d& { return step[l]->interval.rotation[0]; });
  const Four33 R_next =
      matrices_of_lanes([&](std::size_t l) -> const Matrix3d& { return step[l]->interval.next_rotation[0]; });
  for (std::size_t c = 0; c < answer_turn_.size(); ++c) {
    pose_turn_[c] = R_next * answer_turn_[c];
    pose_shift_[c] = R * answer_shift_[c];
  }
  flatten_answers(pose_turn_, pose_shift_);
  write(6, 0, 6, 1.0, data(&ShapeTangent::pose, 6), 6);
}

void FourSteps::flatten_answers(const std::vector<Four33>& turn, const std::vector<Four33>& shift) {
  const int count = 2 * shapes();
  const bool led = led_left_.any();
  std::vector<Four>& to = all_coordinates_ || led ? flat_ : half_;
  for (int c = 0; c < count; ++c) {
    Four* place = to.data() + 18 * c;
    const Four33 &t = turn[at(c)], &s = shift[at(c)];
    for (const auto& [v, w] : {std::pair(&t.x, &s.x), std::pair(&t.y, &s.y), std::pair(&t.z, &s.z)}) {
      place[0] = v->x, place[1] = v->y, place[2] = v->z;
      place[3] = w->x, place[4] = w->y, place[5] = w->z;
      place += 6;
    }
  }
  if (led) {
    project_ends(6, flat_, half_);
    if (all_coordinates_) flat_.swap(half_);
  }
  if (all_coordinates_) return;
  const int n = static_cast<int>(coordinates_.rows()), f = static_cast<int>(coordinates_.cols());
  for (int c = 0; c < 2 * f; ++c)
    for (int r = 0; r < 6; ++r) {
      Four sum{};
      const int from = c < f ? 0 : n;
      for (int a = 0; a < n; ++a) sum += coordinates_(a, c % f) * half_[at((from + a) * 6 + r)];
      flat_[at(c * 6 + r)] = sum;
    }
}

}  // namespace lamprey::shape
