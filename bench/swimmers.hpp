// The swimmers, marches and maneuvers that are measured: the paper's chain, and longer chains of its outer body.
#pragma once

#include <vector>

#include "integrator/step.hpp"
#include "maneuver/problem.hpp"
#include "maneuver/solution.hpp"
#include "model/system.hpp"

namespace lamprey::bench {

/// The paper's three bodies, M and J as it prints them, bodies that do not overlap; planar: moments about e_3 alone.
model::SwimmerDescription paper_chain(bool planar = false);

/// A chain of so many of the paper's outer bodies, joint to joint, the first of them the root.
model::SwimmerDescription outer_body_chain(int bodies);

/// Goals of examples/translation.toml, in the plane or in space, and examples/rotation.toml, from one start, marched by the trapezoid.
maneuver::Problem translation(int steps, bool planar = true);
maneuver::Problem rotation(int steps);

/// The start of the paper's chain, R_2 = exp(π/4 e_3), or of any other, straight; at rest.
integrator::State rest(const model::System& system);

/// A motion of `steps` steps of 1 ms from rest under smooth moments, as large as those of the paper's maneuvers.
struct March {
  model::System system;
  mechanics::DiscreteLagrangian lagrangian;
  integrator::State start;
  std::vector<mechanics::Moments> moments;   // [N+1] N m
  static constexpr double time_step = 1e-3;  // s

  March(const model::SwimmerDescription& swimmer, mechanics::DiscreteLagrangian lagrangian, int steps = 1000);
  int steps() const { return static_cast<int>(moments.size()) - 1; }
};

/// The march of the rotation maneuver under the moments that a search from one start finds for it; it takes seconds.
March rotation_march();

/// The rotation maneuver marched, not solved, as if a solver had returned it: what certify() reads.
maneuver::Solution marched(const model::System& system, const maneuver::Problem& problem);

}  // namespace lamprey::bench
