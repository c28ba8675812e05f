// Which minima are one. Costs tell them apart, up to the symmetries of a problem; but a gait may begin at any phase, which on a grid
// makes it a little dearer or cheaper.
#pragma once

#include <vector>

#include "maneuver/problem.hpp"
#include "mechanics/tree_motion.hpp"

namespace lamprey::search {

/// What is known of a minimum, that others which are the same have, too.
struct Minimum {
  double cost = 0.0;
  double spent = 0.0;       // of it, beside what a given duration costs whatever the motion
  Eigen::VectorXd turning;  // [joints] rad², N Σ|turn of a step|² of a gait, wherever it begins; else empty
};

/// Of the motion through these nodes, [N + 1][bodies].
Minimum minimum_of(const model::System& system, const maneuver::Problem& problem, double cost,
                   const std::vector<mechanics::Rotations>& rotation);

/// Whether they are one: as dear as each other, or gaits whose costs are near and whose joints turn alike.
bool same_minimum(const Minimum& one, const Minimum& other);

/// Each minimum once.
class DistinctMinima {
 public:
  void add(Minimum minimum);
  int below(double cost) const;

 private:
  std::vector<Minimum> all_;
};

}  // namespace lamprey::search
