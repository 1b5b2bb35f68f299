// The commands by their own descriptions (app/call.h).
#include <nlohmann/json.hpp>
#include <optional>

#include "app/call.h"
#include "python/bindings/bind.h"
#include "python/bindings/listener.h"

namespace kappamu::python {

namespace {

std::string text_of(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// Keeps the result and hands progress on.
class PythonCaller : public app::Caller {
 public:
  explicit PythonCaller(std::shared_ptr<Mail> mail) : mail_(std::move(mail)) {}
  std::unique_ptr<Progress> progress() override { return std::make_unique<MailProgress>(mail_); }
  void result(const nlohmann::ordered_json& object) override { result_ = text_of(object); }
  const std::string& found() const { return result_; }

 private:
  std::shared_ptr<Mail> mail_;
  std::string result_ = "{}";
};

}  // namespace

void bind_commands(py::module_& module) {
  module.def("describe_commands", [] { return text_of(app::describe_commands()); });
  module.def("call_command", [](const std::string& name, const app::CommandValues& values,
                                const py::object& progress) {
    std::string result = "{}";
    int exit_code = 0;
    listen(progress, [&](const std::shared_ptr<Mail>& mail) {
      PythonCaller caller(mail);
      exit_code = app::call_command(name, values, caller);
      result = caller.found();
    });
    return py::make_tuple(result, exit_code);
  });
}

}  // namespace kappamu::python
