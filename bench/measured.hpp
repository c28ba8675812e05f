// Registration of a benchmark whose table line is its least and its median time.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

namespace lamprey::bench {

template <typename Function, typename... Arguments>
benchmark::internal::Benchmark* measured(const std::string& name, benchmark::TimeUnit unit, Function&& function,
                                         Arguments&&... arguments) {
  const auto least = [](const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); };
  return benchmark::RegisterBenchmark(name.c_str(), std::forward<Function>(function),
                                      std::forward<Arguments>(arguments)...)
      ->ComputeStatistics("min", least)
      ->Unit(unit);
}

}  // namespace lamprey::bench
