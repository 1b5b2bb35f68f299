#include "io/json_fields.h"

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "io/json_reason.h"

namespace kappamu::io {

using Json = nlohmann::ordered_json;

FieldWriter::FieldWriter() : value_(std::make_unique<Json>()) {}
FieldWriter::FieldWriter(FieldWriter&& other) noexcept = default;
FieldWriter& FieldWriter::operator=(FieldWriter&& other) noexcept = default;
FieldWriter::~FieldWriter() = default;

FieldWriter::FieldWriter(int value) : value_(std::make_unique<Json>(value)) {}
FieldWriter::FieldWriter(double value) : value_(std::make_unique<Json>(value)) {}
FieldWriter::FieldWriter(std::uint64_t value) : value_(std::make_unique<Json>(value)) {}
FieldWriter::FieldWriter(const std::string& value) : value_(std::make_unique<Json>(value)) {}

void FieldWriter::set(const char* name, FieldWriter value) {
  (*value_)[name] = std::move(*value.value_);
}

void FieldWriter::append(FieldWriter value) {
  value_->push_back(std::move(*value.value_));
}

std::string FieldWriter::text(const std::filesystem::path& file) const {
  try {
    return value_->dump(2) + "\n";
  } catch (const Json::exception& error) {
    throw InputError(file.string() + ": a name is not valid UTF-8; rename it (" +
                     json_reason(error) + ").");
  }
}

}  // namespace kappamu::io
