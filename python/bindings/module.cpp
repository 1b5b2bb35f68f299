// The module kappamu._core: what the package kappamu is made of. Python files beside it give it the
// shape that people use.
#include <cstdio>

#include "core/error.h"
#include "device/kernel_cache.h"
#include "python/bindings/bind.h"
#include "python/bindings/call.h"
#include "python/bindings/calls.h"

namespace kappamu::python {

namespace {

/// kappamu.InputError (python/kappamu/errors.py), with the option's key where it is known.
void raise_input_error(const char* sentence, const std::string& key) {
  const py::object type = py::module_::import("kappamu.errors").attr("InputError");
  PyErr_SetObject(type.ptr(), type(sentence, key).ptr());
}

void translate(std::exception_ptr exception) {
  try {
    if (exception) std::rethrow_exception(exception);
  } catch (const InputError& error) {
    raise_input_error(error.what(), error.options().empty() ? "" : error.options().front().key);
  } catch (const Cancelled& error) {
    PyErr_SetString(PyExc_KeyboardInterrupt, error.what());
  }
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  py::register_exception_translator(translate);
  device::on_notice(
      [](const std::string& sentence) { std::fprintf(stderr, "kappamu: %s\n", sentence.c_str()); });
  py::module_::import("atexit").attr("register")(py::cpp_function(end_calls));
  bind_commands(module);
  bind_fit(module);
  bind_forward(module);
  bind_operator(module);
  bind_volumes(module);
}

}  // namespace kappamu::python
