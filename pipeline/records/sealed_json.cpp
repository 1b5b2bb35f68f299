#include "pipeline/records/sealed_json.h"

#include <nlohmann/json.hpp>

#include "pipeline/records/fingerprint.h"

namespace kappamu::pipeline {

namespace {

using nlohmann::json;

constexpr const char* field = "checksum";

std::string text_of(const json& object, int indent) {
  return object.dump(indent, ' ', false, json::error_handler_t::replace);
}

}  // namespace

std::string sealed_text(json object, int indent) {
  object[field] = Fingerprint().add(text_of(object, -1)).text();
  return text_of(object, indent) + "\n";
}

bool is_sealed(json object) {
  if (!object.is_object() || !object.contains(field)) return false;
  const json checksum = object[field];
  object.erase(field);
  return checksum == Fingerprint().add(text_of(object, -1)).text();
}

}  // namespace kappamu::pipeline
