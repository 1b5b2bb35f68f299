// A JSON record that tells when it is no longer as kappamu wrote it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace kappamu::pipeline {

/// The text of `object` with "checksum" added: that of everything else in it, whatever the spaces
/// and the order of keys. What is not UTF-8 is replaced.
std::string sealed_text(nlohmann::json object, int indent);

/// Whether "checksum" is that of the rest.
bool is_sealed(nlohmann::json object);

}  // namespace kappamu::pipeline
