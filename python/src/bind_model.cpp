// model: InputError, and document's IoError as OSError.
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <cerrno>

#include "bound.hpp"
#include "document/io_error.hpp"
#include "model/input_error.hpp"
#include "module.hpp"
#include "python_words.hpp"

namespace lamprey::python {

namespace nb = nanobind;

namespace {

nb::object* input_error = nullptr;  // lives as long as the module

// Text that a problem made in Python was written to has lines that nobody saw; options of the command line are arguments here.
model::InputError for_people(const model::InputError& error) {
  const std::string key = error.key.starts_with("--") ? error.key.substr(2) : error.key;
  const std::string message = in_python_words(error.message);
  if (error.file.empty() || error.file == made_in_python) return {key, message};
  if (error.line == 0) return {error.file, key, message};
  return {error.file, error.line, error.column, key, message};
}

void raise_input_error(const model::InputError& thrown) {
  const model::InputError error = for_people(thrown);
  nb::object raised = (*input_error)(error.what());
  raised.attr("file") = error.file.empty() ? nb::none() : nb::cast(error.file);
  raised.attr("line") = error.line > 0 ? nb::cast(error.line) : nb::none();
  raised.attr("column") = error.column > 0 ? nb::cast(error.column) : nb::none();
  raised.attr("key") = error.key;
  raised.attr("message") = error.message;
  PyErr_SetObject(input_error->ptr(), raised.ptr());
}

void raise_io_error(const document::IoError& error) {
  PyErr_SetString(error.cause == ENOENT                           ? PyExc_FileNotFoundError
                  : error.cause == EACCES || error.cause == EPERM ? PyExc_PermissionError
                                                                  : PyExc_OSError,
                  error.what());
}

}  // namespace

void bind_model(nb::module_& module) {
  input_error = new nb::object(nb::module_::import_("lamprey.errors").attr("InputError"));
  module.attr("InputError") = *input_error;
  nb::register_exception_translator([](const std::exception_ptr& thrown, void*) {
    try {
      std::rethrow_exception(thrown);
    } catch (const model::InputError& error) {
      raise_input_error(error);
    } catch (const document::IoError& error) {
      raise_io_error(error);
    }
  });
}

}  // namespace lamprey::python
