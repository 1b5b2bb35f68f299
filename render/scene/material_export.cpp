#include "render/scene/material_export.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <ostream>

#include "core/shown_text.h"
#include "io/atomic_file.h"
#include "io/volume/scattering_export.h"
#include "render/material/published_materials.h"
#include "render/material/subsurface.h"
#include "render/scene/object_media.h"

namespace kappamu::render {

namespace {

namespace fs = std::filesystem;

constexpr double usual_index = 1.3;

/// Standard deviation over mean; 0 where all are 0.
double variation(const std::vector<double>& values, double mean) {
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return mean == 0.0 ? 0.0 : std::sqrt(squares / static_cast<double>(values.size())) / mean;
}

HomogeneousMaterial mean_material(const io::VolumeSet& set, double& varies) {
  Colour extinction, absorption;
  for (Eigen::Index c = 0; c < 3; ++c) {
    const Medium& medium = set.media[set.media.size() == 3 ? static_cast<std::size_t>(c) : 0];
    std::vector<double> sigma;
    for (const double kappa : medium.kappa.values()) sigma.push_back(1.0 / (3.0 * kappa));
    const auto mean = [](const std::vector<double>& values) {
      double sum = 0.0;
      for (const double value : values) sum += value;
      return sum / static_cast<double>(values.size());
    };
    extinction[c] = mean(sigma);
    absorption[c] = mean(medium.mu.values());
    varies = std::max(
        {varies, variation(sigma, extinction[c]), variation(medium.mu.values(), absorption[c])});
  }
  return homogeneous_material((extinction - absorption).max(1e-6), absorption);
}

std::string three(const Colour& colour) {
  return io::number_text(colour[0]) + ", " + io::number_text(colour[1]) + ", " +
         io::number_text(colour[2]);
}

void write_materialx(std::ostream& out, const Subsurface& subsurface, double eta) {
  const double radius = subsurface.radius_mm.maxCoeff();
  const auto input = [&](const char* name, const char* type, const std::string& value) {
    out << "    <input name=\"" << name << "\" type=\"" << type << "\" value=\"" << value
        << "\" />\n";
  };
  out << "<?xml version=\"1.0\"?>\n"
         "<materialx version=\"1.39\" distanceunit=\"millimeter\">\n"
         "  <open_pbr_surface name=\"measured_surface\" type=\"surfaceshader\">\n";
  input("subsurface_weight", "float", "1");
  input("subsurface_color", "color3", three(subsurface.colour));
  out << "    <input name=\"subsurface_radius\" type=\"float\" value=\"" << io::number_text(radius)
      << "\" unittype=\"distance\" unit=\"millimeter\" />\n";
  input("subsurface_radius_scale", "color3", three(subsurface.radius_mm / radius));
  input("subsurface_scatter_anisotropy", "float", "0");
  input("specular_ior", "float", io::number_text(eta));
  out << "  </open_pbr_surface>\n"
         "  <surfacematerial name=\"measured\" type=\"material\">\n"
         "    <input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"measured_surface\" "
         "/>\n"
         "  </surfacematerial>\n"
         "</materialx>\n";
}

nlohmann::ordered_json list(const Colour& colour) {
  return {colour[0], colour[1], colour[2]};
}

}  // namespace

io::ExportResult export_material(const fs::path& folder, const io::VolumeSet& set) {
  io::validate(set, folder.string());
  double varies = 0.0;
  const HomogeneousMaterial material = mean_material(colour_channels(set, folder.string()), varies);
  const double eta = set.eta.value_or(usual_index);
  io::ExportResult result;
  constexpr double noticed = 0.01;
  if (varies > noticed) {
    result.warnings.push_back("material.mtlx holds the mean of a volume that varies by " +
                              shown_number(100.0 * varies, "%.0f") +
                              " % (standard deviation); export vdb, vol or pbrt to keep it");
  }
  fs::create_directories(folder);
  io::write_stream_atomically(folder / "material.mtlx", [&](std::ostream& out) {
    write_materialx(out, subsurface_of(material, Subsurface::Convention::openpbr), eta);
  });
  const Subsurface principled = subsurface_of(material, Subsurface::Convention::principled);
  const nlohmann::ordered_json json{{"base_color", list(principled.colour)},
                                    {"subsurface_weight", 1.0},
                                    {"subsurface_radius_mm", list(principled.radius_mm)},
                                    {"subsurface_scale", 1.0},
                                    {"subsurface_anisotropy", 0.0},
                                    {"ior", eta}};
  io::write_stream_atomically(folder / "principled.json",
                              [&](std::ostream& out) { out << json.dump(2) << "\n"; });
  result.files = {folder / "material.mtlx", folder / "principled.json"};
  return result;
}

}  // namespace kappamu::render
