// How springs and dampers feel the length of a step. Of h E⁻ and h E⁺ without controls inertia's share knows no time step,
// dampers' grows with h and springs' with h² (equation 8.27): the rate by log h, over h, is dampers' share of E once and
// springs' twice. What a free duration does to a motion with them follows (equations 10.11 and 10.12).
#pragma once

#include "mechanics/joint_moments.hpp"

namespace lamprey::mechanics {

class CompliantTime {
 public:
  explicit CompliantTime(const model::System& system);

  /// Of a step with these ends, updated.
  void evaluate(double time_step, const Interval& interval);

  /// Rates of h E⁻ and h E⁺ by log h, over h, along the freedoms at k and at k + 1; inertia's share left out.
  const Freedoms& minus() const { return timed_.minus; }
  const Freedoms& plus() const { return timed_.plus; }
  /// Dampers' share of E⁻ and E⁺.
  const Freedoms& damped_minus() const { return damped_minus_; }
  const Freedoms& damped_plus() const { return damped_plus_; }

  /// After evaluate, of the same step: gradient of −minus·left + plus·right by both ends, directions constant along the freedoms.
  void differentiate(double time_step, const Interval& interval, const Freedoms& left, const Freedoms& right);
  const Freedoms& by_left() const { return rate_.minus; }
  const Freedoms& by_right() const { return rate_.plus; }

 private:
  // Moments of joints, and along the freedoms what they make.
  struct Shares {
    JointMoments joint_minus, joint_plus;
    Vectors moment, moment_next;  // [bodies] through the joints
    Freedoms minus, plus;
    explicit Shares(int bodies);
    void set_zero();
  };
  void gather_ends(const Interval& interval, Shares& shares) const;

  const model::System& system_;
  Moments no_control_;  // [joints]
  Vectors no_force_;    // [bodies]
  Shares timed_, rate_;
  Freedoms damped_minus_, damped_plus_;
  Vectors turn_, turn_next_;  // [bodies] along a direction
};

}  // namespace lamprey::mechanics
