// What `kappamu forward` writes: maps of every face and summary.json.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "forward/forward_model.h"

namespace kappamu::app {

/// What a summary tells besides the result.
struct ForwardRun {
  std::string method;
  forward::GridSetup setup;
  forward::ForwardOptions options;
  int patterns = 1;
  forward::LightGeometry light{};
};

enum class FluenceFormat { npy, vti, vdb };

/// fluence.npy [M][z][y][x], or fluence.vti or fluence.vdb with a volume phi_<m> for each pattern;
/// beside them, where the model has it, standard_error_fluence.npy or standard_error_phi_<m>.
void write_fluence(const std::filesystem::path& folder, FluenceFormat format, const ForwardRun& run,
                   const forward::ForwardResult& result);

/// exitance_<face>.npy and, where the model has them, standard_error_<face>.npy.
void write_maps(const std::filesystem::path& folder, const ForwardRun& run,
                const forward::ForwardResult& result);

/// The content of summary.json.
nlohmann::ordered_json forward_summary(const ForwardRun& run, const forward::ForwardResult& result);

/// Names of all files that write_maps(), write_fluence() and the command may write.
std::vector<std::string> forward_outputs();

}  // namespace kappamu::app
