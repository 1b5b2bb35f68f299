// A scene rendered: light on its objects, a model's answer for each, a picture.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/progress.h"
#include "forward/object_model.h"
#include "render/fur/furry_object.h"
#include "render/picture/picture.h"
#include "render/scene/scene.h"

namespace kappamu::render {

struct RenderOptions {
  std::string device = "auto";
  std::uint64_t seed = 1;
  forward::MachineCosts costs{};  ///< for a model that chooses
};

/// A model's answer for one object and channel, its exitance apart.
struct ChannelReport {
  double power_in = 0.0;  ///< that arrives, before Fresnel [mm²]
  forward::ObjectBalance balance;
  double error = 0.0;             ///< relative 2-norm over the surface, all that is known
  double error_estimate = 0.0;    ///< of it, what numerics or noise make
  std::vector<double> error_map;  ///< per sample, relative (forward/model_error.h)
  double mean_error = 0.0, max_error = 0.0;  ///< of the map; the mean by the light that leaves
  std::size_t elements = 0;
  int iterations = 0;
  bool converged = false;
  std::string message;
};

struct ObjectReport {
  std::string name, material;  ///< the material's file or citation
  double eta = 1.0;
  std::size_t first_sample = 0;  ///< of the object in `exitance` and `surface`
  std::size_t samples = 0;       ///< one per triangle
  std::array<ChannelReport, 3> channels;
  std::vector<forward::ModelCandidate> candidates;  ///< of model `auto`, the one taken first
  std::optional<FurReport> fur;
};

struct RenderResult {
  Picture picture;
  double exposure = 1.0;
  std::array<std::vector<float>, 3> exitance;  ///< R, G, B of every sample of every object
  /// Position [mm], outward normal, area [mm²] of each sample, in the world's frame.
  std::vector<float> surface;
  std::vector<ObjectReport> objects;
  double scene_seconds = 0.0, light_seconds = 0.0, model_seconds = 0.0, picture_seconds = 0.0;
  bool converged = true;  ///< the model met its tolerance everywhere
  std::vector<std::string> warnings;
};

/// Throws InputError naming what in the scene is wrong. Equal scenes, seeds and devices give equal
/// bits. Channels of equal coefficients are solved together, those of equal light once.
RenderResult render_scene(const Scene& scene, forward::ObjectModel& model,
                          const RenderOptions& options, Progress& progress);

/// picture.exr (linear R, G, B; A: coverage), picture.png (tone-mapped), exitance.npy and error.npy
/// [3][sample], surface.npy [sample][7], and last summary.json, whose text is returned.
std::string write_render(const RenderResult& result, const Scene& scene,
                         const RenderOptions& options, const std::filesystem::path& folder);

/// One frame of several: `name`.png, and last its summary `name`.json, with a fingerprint of all
/// that the frame depends on.
void write_frame(const RenderResult& result, const Scene& scene, const RenderOptions& options,
                 const std::string& inputs, const std::filesystem::path& folder,
                 const std::string& name);

/// The exposure of a frame that write_frame() wrote of these inputs; nothing where there is none.
std::optional<double> frame_exposure(const std::filesystem::path& folder, const std::string& name,
                                     const std::string& inputs);

}  // namespace kappamu::render
