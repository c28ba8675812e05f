// The loop of shapes that a planar motion goes along, over the height functions of its swimmer.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mechanics/height_functions.hpp"
#include "result/results.hpp"

namespace lamprey::report {

struct ShapeLoop {
  /// Of two angles these are the variables; of more, s₁ and s₂ in the plane that lies nearest to all shapes of the motion.
  std::array<std::string, 2> variable;
  std::array<std::vector<double>, 2> run;  // [N + 1] rad, the variables along the motion
  /// Of more than two angles: what they are called, what each turns by for a unit of s₁ and s₂, and how far the shapes are from
  /// the plane at most.
  struct Modes {
    std::vector<std::string> angle;  // [angles]
    Eigen::MatrixX2d direction;      // [angles][2] orthonormal
    double beside = 0.0;             // rad
  };
  std::optional<Modes> modes;
  mechanics::HeightFunctions heights;
  /// Of a loop that closes while nothing moves the swimmer but its shape: m, m, rad by the frame of the heights; what it moved as
  /// a twist, the mean of those of all shapes at which the loop may begin.
  struct Displacement {
    mechanics::Planar by_volume, moved;
  };
  std::optional<Displacement> displacement;
  std::string lacking;  // why there is none
};

/// Nothing where the motion turns fewer angles than two, by more than nine radians, or leaves a plane of the root's axes, and of
/// more than 100 bodies.
std::optional<ShapeLoop> shape_loop(const result::Results& results);

}  // namespace lamprey::report
