// lamprey._core: the rooms of src/ as Python sees them. python/lamprey/__init__.py is the front door.
#include "module.hpp"

NB_MODULE(_core, module) {
  using namespace lamprey::python;
  module.doc() = "Compiled part of lamprey; import lamprey instead.";
  bind_model(module);
  bind_fluid(module);
  bind_file(module);
  bind_mechanics(module);
  bind_result(module);
  bind_task(module);
  bind_search(module);
}
