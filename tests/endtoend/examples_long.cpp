// Every maneuver example as it is, at full resolution: minutes, so ./dev test leaves them to ./dev test-all.
#include <gtest/gtest.h>

#include "solved_example.hpp"

namespace lamprey::tests {
namespace {

class FullExamples : public ::testing::TestWithParam<Example> {};
TEST_P(FullExamples, solves_and_is_proven) { expect_solved(GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Long, FullExamples,
    ::testing::Values(close_to("translation", "translation", {}, 243152.7, 1e-6, true),
                      Example{"translation_in_space", "translation_in_space", {}, 42500, 0, true},
                      close_to("rotation", "rotation", {}, 13241.50, 1e-6, true),
                      Example{"rotation_by_whole_turns", "rotation_by_whole_turns", {}, 13000, 0, true},
                      Example{"rotation_with_clearance", "rotation_with_clearance", {}, 16000, 0, true},
                      Example{"translation_with_clearance", "translation_with_clearance", {}, 62000, 0, true},
                      Example{"as_printed_translation", "as_printed/translation", {}, 271000, 0, true},
                      Example{"paper_scheme_rotation", "paper_scheme/rotation", {}, 17000, 0, false},
                      Example{"as_printed_rotation", "as_printed/rotation", {}, 20000, 0, false},
                      close_to("paper_scheme_11_points", "paper_scheme/translation", {{"points", "11"}}, 244005, 5e-4),
                      close_to("paper_scheme_21_points", "paper_scheme/translation", {}, 243884, 5e-4),
                      close_to("paper_scheme_41_points", "paper_scheme/translation", {{"points", "41"}}, 243851, 5e-4)),
    [](const auto& instance) { return instance.param.label; });

}  // namespace
}  // namespace lamprey::tests
