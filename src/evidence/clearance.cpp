#include "evidence/clearance.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <unordered_map>

#include "fluid/gap.hpp"

namespace lamprey::evidence {

namespace {

using model::at;

// Finds the least gap of a sequence of placements. Pairs that bounds show to be no nearer than the nearest yet are not
// computed: bounding balls, and the planes across the line of centres or across the direction of the pair's last gap.
class NearestPair {
 public:
  explicit NearestPair(const model::System& system) : system_(system), order_(at(system.body_count())) {
    for (const model::Body& body : system.bodies()) radius_.push_back(body.semi_axes.maxCoeff());
    std::iota(order_.begin(), order_.end(), 0);
    least_.gap = infinite;
  }

  void look(const Placement& placed, double time) {
    if (least_.gap == infinite)  // joined bodies are near: what they leave is soon the mark for all others
      for (const model::Joint& joint : system_.joints())
        look_at_pair(placed, std::min(joint.parent, joint.child), std::max(joint.parent, joint.child), time);
    sweep(placed, time);
  }

  const Clearance& least() const { return least_; }

 private:
  // Bodies by where they begin along the axis in which they are spread most.
  void sweep(const Placement& placed, double time) {
    Vector3d low = placed.position.front(), high = low;
    for (const Vector3d& x : placed.position) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    Eigen::Index axis = 0;
    (high - low).maxCoeff(&axis);
    const auto begin = [&](int i) { return placed.position[at(i)][axis] - radius_[at(i)]; };
    const auto end = [&](int i) { return placed.position[at(i)][axis] + radius_[at(i)]; };
    std::sort(order_.begin(), order_.end(), [&](int i, int j) { return begin(i) < begin(j); });
    for (std::size_t m = 0; m < order_.size(); ++m)
      for (std::size_t n = m + 1; n < order_.size() && begin(order_[n]) - end(order_[m]) < least_.gap; ++n)
        look_at_pair(placed, std::min(order_[m], order_[n]), std::max(order_[m], order_[n]), time);
  }

  void look_at_pair(const Placement& placed, int i, int j, double time) {
    if (system_.move_as_one(i, j)) return;
    const Vector3d offset = placed.position[at(j)] - placed.position[at(i)];
    const double distance = offset.norm();
    if (distance - radius_[at(i)] - radius_[at(j)] >= least_.gap) return;
    const Matrix3d& R = placed.rotation[at(i)];
    const fluid::EllipsoidPair pair{system_.body(i).gap_axes(), system_.body(j).gap_axes(), R, placed.rotation[at(j)],
                                    offset};
    if (distance > 0.0 && fluid::separation_along(pair, offset.stableNormalized()) >= least_.gap) return;
    const auto number = static_cast<std::uint64_t>(i) * at(system_.body_count()) + at(j);
    const auto [last, is_new] = direction_.try_emplace(number, Vector3d::Zero());
    const Vector3d near = R * last->second;
    if (!is_new && fluid::separation_along(pair, near) >= least_.gap) return;
    fluid::Gap gap = is_new ? fluid::gap(pair) : fluid::gap(pair, near);
    if (!is_new && gap.value < least_.gap && gap.value < 0.0) gap = fluid::gap(pair);  // there may be a shorter way out
    last->second = R.transpose() * gap.direction;
    if (gap.value < least_.gap) least_ = {gap.value, time, i, j};
  }

  static constexpr double infinite = std::numeric_limits<double>::infinity();
  const model::System& system_;
  std::vector<double> radius_;                             // m, of bounding spheres
  std::vector<int> order_;                                 // of the sweep before: nearly that of this one
  std::unordered_map<std::uint64_t, Vector3d> direction_;  // of a pair's last gap, frame of its first body
  Clearance least_;
};

bool finite(const Placement& placed) {
  return std::all_of(placed.rotation.begin(), placed.rotation.end(), [](const Matrix3d& R) { return R.allFinite(); }) &&
         std::all_of(placed.position.begin(), placed.position.end(), [](const Vector3d& x) { return x.allFinite(); });
}

}  // namespace

int parts_of_step(int steps, int bodies) {
  const double most = 1e7 / (static_cast<double>(steps) * bodies);
  return static_cast<int>(std::clamp(most, 1.0, 10.0));
}

StepPath::StepPath(const StoredMotion& motion, int k)
    : system_(motion.system),
      position_(motion.solution.position[model::at(k)]),
      shift_(motion.solution.position[model::at(k + 1)] - position_),
      relative_(motion.solution.rotation[model::at(k)]) {
  const mechanics::Rotations& R = motion.solution.rotation[model::at(k)];
  const mechanics::Rotations& R_next = motion.solution.rotation[model::at(k + 1)];
  turn_.resize(R.size());
  for (std::size_t i = 0; i < R.size(); ++i) {
    const int parent = system_.bodies()[i].parent;
    if (parent >= 0) relative_[i] = R[model::at(parent)].transpose() * R[i];
    const Matrix3d next = parent < 0 ? R_next[i] : Matrix3d(R_next[model::at(parent)].transpose() * R_next[i]);
    turn_[i] = lie::log(relative_[i].transpose() * next);
  }
}

Placement StepPath::at(double fraction) const {
  Placement placed{relative_, {}};
  for (const int i : system_.root_to_leaves()) {
    Matrix3d& R = placed.rotation[model::at(i)];
    R = relative_[model::at(i)] * lie::exp(fraction * turn_[model::at(i)]);
    const int parent = system_.body(i).parent;
    if (parent >= 0) R = placed.rotation[model::at(parent)] * R;
  }
  placed.position = system_.mass_centres(placed.rotation, position_ + fraction * shift_);
  return placed;
}

std::optional<Clearance> clearance(const StoredMotion& motion) {
  if (motion.system.body_count() < 2) return std::nullopt;
  NearestPair nearest(motion.system);
  const int parts = parts_of_step(motion.steps, motion.system.body_count());
  for (int k = 0; k < motion.steps; ++k) {
    const StepPath path(motion, k);
    const double begin = motion.solution.time[at(k)], length = motion.solution.time[at(k + 1)] - begin;
    for (int part = 0; part < parts + (k == motion.steps - 1); ++part) {
      const double fraction = static_cast<double>(part) / parts;
      const Placement placed = path.at(fraction);
      if (!finite(placed)) return Clearance{};
      nearest.look(placed, begin + fraction * length);
    }
  }
  return std::isfinite(nearest.least().gap) ? std::optional(nearest.least()) : std::nullopt;
}

double gap_at(const StoredMotion& motion, const Clearance& place) {
  const std::vector<double>& time = motion.solution.time;
  if (!(place.time >= time.front() && place.time <= time.back())) return unset;
  const auto after = std::upper_bound(time.begin(), time.end(), place.time);
  const int k = std::clamp(static_cast<int>(after - time.begin()) - 1, 0, motion.steps - 1);
  const double begin = time[at(k)], fraction = (place.time - begin) / (time[at(k + 1)] - begin);
  const Placement placed = StepPath(motion, k).at(fraction);
  if (!finite(placed)) return unset;
  const std::size_t i = at(place.first), j = at(place.second);
  return fluid::gap({motion.system.body(place.first).gap_axes(), motion.system.body(place.second).gap_axes(),
                     placed.rotation[i], placed.rotation[j], placed.position[j] - placed.position[i]})
      .value;
}

}  // namespace lamprey::evidence
