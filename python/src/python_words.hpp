// Messages that name options of the command line, in Python's words.
#pragma once

#include <string>

namespace lamprey::python {

/// "lamprey solve --resolve" is lamprey.solve(resolve=True), "--duration 2" is duration=2, and so on. What is no option stays.
std::string in_python_words(const std::string& message);

}  // namespace lamprey::python
