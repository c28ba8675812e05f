#include "task/choices.hpp"

#include <array>
#include <string_view>
#include <utility>

#include "file/words.hpp"
#include "model/input_error.hpp"

namespace lamprey::task {

maneuver::Scheme scheme_named(const std::string& key, const std::string& name) {
  std::string allowed;
  for (const auto& entry : file::schemes) {
    if (entry.text == name) return entry.value;
    allowed += (allowed.empty() ? "" : ", ") + std::string(entry.text);
  }
  throw model::InputError(key, "found \"" + name + "\"; allowed: " + allowed + "; choose one of them");
}

search::Backend backend_named(const std::string& key, const std::string& name) {
  using search::Backend;
  constexpr std::array<std::pair<std::string_view, Backend>, 3> backends = {
      {{"newton", Backend::newton}, {"ipopt", Backend::ipopt}, {"both", Backend::both}}};
  for (const auto& [word, backend] : backends)
    if (word == name) return backend;
  throw model::InputError(key, "found \"" + name + "\"; allowed: newton, ipopt, both; choose one of them");
}

}  // namespace lamprey::task
