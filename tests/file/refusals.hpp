// What refusals of files say.
#pragma once

#include <string>

#include <gtest/gtest.h>

namespace lamprey::tests {

inline void expect_begins(const std::string& text, const std::string& with) {
  EXPECT_EQ(text.rfind(with, 0), 0U) << text << "\ndoes not begin with " << with;
}

}  // namespace lamprey::tests
