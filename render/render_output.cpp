// The files of a rendered scene (docs/scene.md, Outputs).
#include <nlohmann/json.hpp>

#include "io/atomic_file.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "render/render_scene.h"

namespace kappamu::render {

namespace {

using nlohmann::ordered_json;

ordered_json channel_json(const ChannelReport& channel, const char* name) {
  const forward::ObjectBalance& b = channel.balance;
  return {{"channel", name},
          {"power_in", channel.power_in},
          {"reflected", channel.power_in - b.entering},
          {"entering", b.entering},
          {"unscattered", b.unscattered},
          {"out", b.exiting},
          {"absorbed", b.absorbed},
          {"created", b.created},
          {"meets_object_again", b.reentering},
          {"error", channel.error},
          {"error_estimate", channel.error_estimate},
          {"error_map", {{"mean", channel.mean_error}, {"max", channel.max_error}}},
          {"elements", channel.elements},
          {"iterations", channel.iterations},
          {"converged", channel.converged},
          {"message", channel.message}};
}

ordered_json candidate_json(const forward::ModelCandidate& candidate) {
  ordered_json object{{"model", candidate.model}, {"error", nullptr}, {"seconds", nullptr}};
  if (candidate.error) object["error"] = *candidate.error;
  if (candidate.seconds) object["seconds"] = *candidate.seconds;
  object["reason"] = candidate.reason;
  return object;
}

ordered_json object_json(const ObjectReport& object) {
  ordered_json channels = ordered_json::array();
  constexpr std::array<const char*, 3> names{"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c)
    channels.push_back(channel_json(object.channels[c], names[c]));
  ordered_json entry{{"name", object.name},       {"material", object.material},
                     {"eta", object.eta},         {"first_sample", object.first_sample},
                     {"samples", object.samples}, {"channels", std::move(channels)}};
  if (object.fur) {
    entry["fur"] = {{"hairs_per_tile", object.fur->hairs},
                    {"patches", object.fur->patches},
                    {"stretch", object.fur->stretch},
                    {"extinction_per_mm", object.fur->extinction},
                    {"reaches_skin", object.fur->through}};
  }
  for (const forward::ModelCandidate& candidate : object.candidates) {
    entry["candidates"].push_back(candidate_json(candidate));
  }
  return entry;
}

ordered_json parameters_json(const OptionValues& parameters) {
  ordered_json object = ordered_json::object();
  for (const auto& [name, value] : parameters) {
    std::visit([&, key = name](const auto& own) { object[key] = own; }, value);
  }
  return object;
}

ordered_json summary_json(const RenderResult& result, const Scene& scene,
                          const RenderOptions& options) {
  ordered_json objects = ordered_json::array();
  for (const ObjectReport& object : result.objects) objects.push_back(object_json(object));
  return {{"format", "kappamu-render"},
          {"version", 1},
          {"scene", scene.file.string()},
          {"model", scene.model.name},
          {"parameters", parameters_json(scene.model.parameters)},
          {"tolerance", scene.model.tolerance},
          {"device", options.device},
          {"seed", options.seed},
          {"converged", result.converged},
          {"power_unit", "mm2 times the unit of irradiance"},
          {"objects", std::move(objects)},
          {"picture",
           {{"width", scene.film.width},
            {"height", scene.film.height},
            {"samples", scene.film.samples},
            {"exposure", result.exposure},
            {"standard_error", result.picture.standard_error}}},
          {"seconds",
           {{"scene", result.scene_seconds},
            {"incident_light", result.light_seconds},
            {"model", result.model_seconds},
            {"picture", result.picture_seconds}}},
          {"warnings", result.warnings}};
}

io::ExrImage exr_of(const Picture& picture) {
  io::ExrImage exr;
  exr.width = picture.radiance.width();
  exr.height = picture.radiance.height();
  constexpr std::array<const char*, 3> names{"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<float>& channel = exr.channels[names[c]];
    for (std::size_t i = c; i < picture.radiance.size(); i += 3) {
      channel.push_back(picture.radiance.values()[i]);
    }
  }
  exr.channels["A"] = picture.coverage.values();
  return exr;
}

}  // namespace

std::string write_render(const RenderResult& result, const Scene& scene,
                         const RenderOptions& options, const std::filesystem::path& folder) {
  io::write_exr(folder / "picture.exr", exr_of(result.picture));
  io::write_image(folder / "picture.png", tone_mapped(result.picture.radiance, result.exposure));
  const std::size_t samples = result.exitance[0].size();
  std::vector<float> exitance, error;
  for (std::size_t c = 0; c < 3; ++c) {
    exitance.insert(exitance.end(), result.exitance[c].begin(), result.exitance[c].end());
    for (const ObjectReport& object : result.objects) {
      const std::vector<double>& map = object.channels[c].error_map;
      error.insert(error.end(), map.begin(), map.end());
    }
  }
  io::write_npy(folder / "exitance.npy", {3, samples}, exitance);
  io::write_npy(folder / "error.npy", {3, samples}, error);
  io::write_npy(folder / "surface.npy", {samples, 7}, result.surface);
  const ordered_json summary = summary_json(result, scene, options);
  io::write_text_atomically(folder / "summary.json", summary.dump(2) + "\n");
  return summary.dump();
}

void write_frame(const RenderResult& result, const Scene& scene, const RenderOptions& options,
                 const std::string& inputs, const std::filesystem::path& folder,
                 const std::string& name) {
  io::write_image(folder / (name + ".png"), tone_mapped(result.picture.radiance, result.exposure));
  ordered_json summary = summary_json(result, scene, options);
  summary["inputs"] = inputs;
  io::write_text_atomically(folder / (name + ".json"), summary.dump(2) + "\n");
}

std::optional<double> frame_exposure(const std::filesystem::path& folder, const std::string& name,
                                     const std::string& inputs) {
  try {
    if (!std::filesystem::exists(folder / (name + ".png"))) return std::nullopt;
    const auto summary = ordered_json::parse(io::read_text(folder / (name + ".json")));
    if (summary.at("inputs") != inputs) return std::nullopt;
    return summary.at("picture").at("exposure").get<double>();
  } catch (const std::exception&) {
    return std::nullopt;  // no frame, or none that kappamu wrote
  }
}

}  // namespace kappamu::render
