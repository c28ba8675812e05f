// The world's axes as people read them.
#pragma once

#include <array>

namespace lamprey::model {

inline constexpr std::array world_axes{"e₁", "e₂", "e₃"};

}  // namespace lamprey::model
