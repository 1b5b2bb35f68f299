// The commands by their own descriptions (python/bindings/call.h).
#include <nlohmann/json.hpp>
#include <optional>

#include "python/bindings/bind.h"
#include "python/bindings/call.h"
#include "python/bindings/listener.h"

namespace kappamu::python {

namespace {

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Keeps the result and hands progress on.
class PythonCaller : public app::Caller {
 public:
  PythonCaller(std::shared_ptr<Mail> mail, std::string& found)
      : mail_(std::move(mail)), found_(found) {}
  std::unique_ptr<Progress> progress() override { return std::make_unique<MailProgress>(mail_); }
  void result(const nlohmann::ordered_json& object) override { found_ = text_of(object); }

 private:
  std::shared_ptr<Mail> mail_;
  std::string& found_;
};

}  // namespace

void bind_commands(py::module_& module) {
  module.def("describe_commands", [] { return text_of(describe_commands()); });
  // The result, also of a command that then fails, is appended to `found`.
  module.def("call_command", [](const std::string& name, const CommandValues& values,
                                const py::object& progress, py::list found) {
    std::string result;
    int exit_code = 0;
    try {
      listen(progress, [&](const std::shared_ptr<Mail>& mail) {
        PythonCaller caller(mail, result);
        exit_code = call_command(name, values, caller);
      });
    } catch (const InputError&) {
      if (!result.empty()) found.append(result);
      throw;
    }
    if (!result.empty()) found.append(result);
    return exit_code;
  });
}

}  // namespace kappamu::python
