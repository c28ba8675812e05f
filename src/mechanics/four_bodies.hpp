// What every body does on its own in a step, for four bodies at once: one lane of the processor's vectors for each.
#pragma once

#include <algorithm>
#include <type_traits>

#include "mechanics/plain_share.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::mechanics {

/// A lane from each.
inline Four3 four_of(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return {Four{a.x(), b.x(), c.x(), d.x()}, Four{a.y(), b.y(), c.y(), d.y()}, Four{a.z(), b.z(), c.z(), d.z()}};
}
inline Four33 four_of(const Matrix3d& a, const Matrix3d& b, const Matrix3d& c, const Matrix3d& d) {
  using algebra::load;
  Four33 m{{load<Four>(a.data()), load<Four>(b.data()), load<Four>(c.data())},
           {load<Four>(d.data()), load<Four>(a.data() + 4), load<Four>(b.data() + 4)},
           {load<Four>(c.data() + 4), load<Four>(d.data() + 4), Four{a(8), b(8), c(8), d(8)}}};
  algebra::transpose(m.x.x, m.x.y, m.x.z, m.y.x);
  algebra::transpose(m.y.y, m.y.z, m.z.x, m.z.y);
  return m;
}
/// And back.
inline void write_four(Four33 m, Matrix3d& a, Matrix3d& b, Matrix3d& c, Matrix3d& d) {
  using algebra::store;
  algebra::transpose(m.x.x, m.x.y, m.x.z, m.y.x);
  algebra::transpose(m.y.y, m.y.z, m.z.x, m.z.y);
  store(m.x.x, a.data()), store(m.y.y, a.data() + 4), a(8) = m.z.z[0];
  store(m.x.y, b.data()), store(m.y.z, b.data() + 4), b(8) = m.z.z[1];
  store(m.x.z, c.data()), store(m.z.x, c.data() + 4), c(8) = m.z.z[2];
  store(m.y.x, d.data()), store(m.z.y, d.data() + 4), d(8) = m.z.z[3];
}

/// Bodies whose numbers follow one another. Lanes beyond the last body repeat it.
class FourBodies {
 public:
  FourBodies(std::size_t first, std::size_t bodies)
      : lane_{first, std::min(first + 1, bodies - 1), std::min(first + 2, bodies - 1),
              std::min(first + 3, bodies - 1)} {}

  std::size_t body(std::size_t lane) const { return lane_[lane]; }

  Four33 read(const Rotations& all) const {
    return four_of(all[lane_[0]], all[lane_[1]], all[lane_[2]], all[lane_[3]]);
  }
  template <typename Owner>
  Four33 read(const std::vector<Owner>& all, Matrix3d Owner::*member) const {
    return four_of(all[lane_[0]].*member, all[lane_[1]].*member, all[lane_[2]].*member, all[lane_[3]].*member);
  }
  /// `of` gives the vector of a body.
  template <typename Of>
  requires std::is_invocable_v<Of, std::size_t> Four3 read(const Of& of)
  const { return four_of(of(lane_[0]), of(lane_[1]), of(lane_[2]), of(lane_[3])); }
  Four3 read(const Vectors& all) const { return four_of(all[lane_[0]], all[lane_[1]], all[lane_[2]], all[lane_[3]]); }
  TurnAndShift<Four3> read(const std::vector<TurnAndShift<Vector3d>>& all) const {
    const TurnAndShift<Vector3d>&a = all[lane_[0]], &b = all[lane_[1]], &c = all[lane_[2]], &d = all[lane_[3]];
    return {four_of(a.turn, b.turn, c.turn, d.turn), four_of(a.shift, b.shift, c.shift, d.shift)};
  }

  void write(const Four33& m, Rotations& all) const {
    write_four(m, all[lane_[0]], all[lane_[1]], all[lane_[2]], all[lane_[3]]);
  }
  template <typename Owner>
  void write(const Four33& m, std::vector<Owner>& all, Matrix3d Owner::*member) const {
    write_four(m, all[lane_[0]].*member, all[lane_[1]].*member, all[lane_[2]].*member, all[lane_[3]].*member);
  }
  template <typename Owner, typename Part>
  Four33 read(const std::vector<Owner>& all, Part Owner::*part, Matrix3d Part::*member) const {
    return four_of(all[lane_[0]].*part.*member, all[lane_[1]].*part.*member, all[lane_[2]].*part.*member,
                   all[lane_[3]].*part.*member);
  }
  template <typename Owner, typename Part>
  void write(const Four33& m, std::vector<Owner>& all, Part Owner::*part, Matrix3d Part::*member) const {
    write_four(m, all[lane_[0]].*part.*member, all[lane_[1]].*part.*member, all[lane_[2]].*part.*member,
               all[lane_[3]].*part.*member);
  }
  void write(const Four3& v, Vectors& all) const {
    for (std::size_t l = 0; l < 4; ++l) all[lane_[l]] = Vector3d(v.x[l], v.y[l], v.z[l]);
  }

 private:
  std::size_t lane_[4];
};

/// Calls f with FourBodies until all bodies have been met.
template <typename Function>
void for_each_four(std::size_t bodies, const Function& f) {
  for (std::size_t first = 0; first < bodies; first += 4) f(FourBodies(first, bodies));
}

}  // namespace lamprey::mechanics
