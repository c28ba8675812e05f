// How near a motion comes to each of its limits, and for how long it is there.
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "evidence/bounds.hpp"

namespace lamprey::evidence {

/// Of what a margin is large or small beside: no more than that is left where a limit is reached.
inline constexpr double at_the_limit = 1e-3;

/// How near a motion comes to limits of one key; of keep-outs to one of them.
struct LimitReach {
  std::string key;  // of the problem file
  Bound::Kind kind;
  int which = -1;          // of limits.sphere and limits.half_space, from 0
  double bound = 0.0;      // of the tightest place, in the unit of the problem file; of keep-outs 0
  double margin = 0.0;     // there, in that unit; negative: broken
  double time = 0.0;       // s, of that place
  double violation = 0.0;  // there, as LimitCheck counts it; not above 0: kept
  double share = 0.0;      // of the nodes, at which a limit of this key is reached or broken
  bool reached() const { return share > 0.0; }
};

/// Gathers the margins of a motion's limits, those of one key together.
class LimitReaches {
 public:
  void add(const StoredMotion& motion, const Bound& bound, int node, double margin);
  /// The tightest margin of a bound's key so far, in its own unit; infinite: none yet.
  double tightest(const Bound& bound) const;
  /// In the order in which they were added; of a motion of so many steps.
  std::vector<LimitReach> finished(int steps) const;

 private:
  struct Gathered {
    LimitReach reach;
    std::set<int> nodes;  // at which the limit is reached
  };
  std::map<std::pair<std::string, int>, std::size_t> place_;
  std::vector<Gathered> gathered_;
};

/// What margins of clearance are at least, by balls around the bodies: most pairs need no closer look.
class BallMargins {
 public:
  BallMargins(const StoredMotion& motion, const std::vector<Bound>& bounds);
  /// m; minus infinity of other bounds.
  double least(const Bound& bound, int node) const;

 private:
  const StoredMotion& motion_;
  std::vector<std::vector<Vector3d>> centre_;  // [N + 1][bodies] m; empty where no clearance is asked for
};

}  // namespace lamprey::evidence
