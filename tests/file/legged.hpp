#pragma once

#include <string>

namespace lamprey::tests {

/// A hull with a hinge, a universal and a fixed joint, all with reference rotations; the last leg hangs on the first, which comes later.
inline std::string legged(const std::string& start, const std::string& goal = "") {
  std::string text = "schema = 1\n[fluid]\ndensity = 1000.0\n";
  for (const char* body : {"hull", "tip", "arm", "leg", "pod"})
    text += std::string("[[body]]\nname = \"") + body + "\"\nsemi_axes = [0.3, 0.1, 0.08]\n";
  const auto joint = [&](const char* parent, const char* child, const char* more) {
    text += std::string("[[joint]]\nparent = \"") + parent + "\"\nchild = \"" + child +
            "\"\nparent_offset = [0.4, 0.1, 0.0]\nchild_offset = [-0.4, 0.0, 0.1]\n" + more;
  };
  joint("leg", "tip", "kind = \"hinge\"\naxis = [0.0, 2.0, 0.0]\nreference_rotation = [0.0, 0.3, 0.4]\n");
  joint("hull", "arm",
        "kind = \"universal\"\naxes = [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0]]\nreference_rotation = [0.0, 0.0, 0.7]\n");
  joint("hull", "leg",
        "kind = \"hinge\"\nname = \"hip\"\naxis = [0.0, 0.0, 1.0]\nreference_rotation = [0.5, 0.0, 0.0]\n");
  joint("hull", "pod", "kind = \"fixed\"\nreference_rotation = [0.0, 0.3, 0.0]\n");
  return text + "[start]\n" + start + goal + "[time]\nduration = 1.0\nsteps = 10\n";
}

}  // namespace lamprey::tests
