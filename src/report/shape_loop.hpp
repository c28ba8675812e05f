// The loop of shapes that a motion by two angles goes along, over the height functions of its swimmer.
#pragma once

#include <array>
#include <optional>

#include "file/results.hpp"
#include "mechanics/height_functions.hpp"

namespace lamprey::report {

struct ShapeLoop {
  struct Angle {
    std::size_t joint = 0;
    int axis = 0;
  };
  std::array<Angle, 2> angle;
  mechanics::HeightFunctions heights;
  /// Where the shape ends as it began and nothing moves the swimmer but its shape: m, m, rad in the frame of the heights.
  struct Displacement {
    mechanics::Planar by_volume, moved;
  };
  std::optional<Displacement> displacement;
};

/// Nothing where the motion turns more or fewer angles than two, or leaves a plane.
std::optional<ShapeLoop> shape_loop(const file::Results& results);

}  // namespace lamprey::report
