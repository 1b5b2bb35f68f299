// Mitsuba 3 grid volumes, format version 3 (mitsuba3, src/render/volumegrid.cpp), little-endian:
//   0 "VOL", 3 version 3, 4 int32 1 (float32), 8 int32 nx ny nz, 20 int32 channels,
//   24 float32 xmin ymin zmin xmax ymax zmax, 48 float32 data[((z ny + y) nx + x) channels + c].
#include <algorithm>
#include <cmath>
#include <ostream>

#include "io/atomic_file.h"
#include "io/volume/scattering_export.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

void write_vol(const fs::path& file, const std::vector<const Volume<double>*>& channels) {
  const GridShape& s = channels.front()->shape();
  const std::int32_t counts[] = {1, s.nx, s.ny, s.nz, static_cast<std::int32_t>(channels.size())};
  const float box[] = {0.0F,
                       0.0F,
                       0.0F,
                       static_cast<float>(s.nx * s.voxel_mm),
                       static_cast<float>(s.ny * s.voxel_mm),
                       static_cast<float>(s.nz * s.voxel_mm)};
  std::vector<float> data;
  data.reserve(s.cells() * channels.size());
  for (std::size_t i = 0; i < s.cells(); ++i) {
    for (const Volume<double>* channel : channels) {
      data.push_back(static_cast<float>((*channel)[i]));
    }
  }
  write_stream_atomically(file, [&](std::ostream& out) {
    out << "VOL" << '\x03';
    out.write(reinterpret_cast<const char*>(counts), sizeof counts);
    out.write(reinterpret_cast<const char*>(box), sizeof box);
    out.write(reinterpret_cast<const char*>(data.data()),
              static_cast<std::streamsize>(data.size() * sizeof(float)));
  });
}

std::string volume_xml(const std::string& name, const std::string& file) {
  return "      <volume type=\"gridvolume\" name=\"" + name +
         "\">\n"
         "        <string name=\"filename\" value=\"" +
         file +
         "\"/>\n"
         "        <boolean name=\"use_grid_bbox\" value=\"true\"/>\n"
         "        <boolean name=\"raw\" value=\"true\"/>\n"
         "      </volume>\n";
}

/// The block on a light table before black: an even area light behind z-, seen from beyond z+,
/// upright (docs/conventions.md).
std::string scene_xml(const VolumeSet& set, const std::string& suffix) {
  const GridShape& s = set.shape();
  const double size[] = {s.nx * s.voxel_mm, s.ny * s.voxel_mm, s.nz * s.voxel_mm};
  const auto vector = [](double x, double y, double z) {
    return number_text(x) + ", " + number_text(y) + ", " + number_text(z);
  };
  const auto attributes = [](double x, double y, double z) {
    return "x=\"" + number_text(x) + "\" y=\"" + number_text(y) + "\" z=\"" + number_text(z) + "\"";
  };
  const double x = size[0] / 2;
  const double y = size[1] / 2;
  constexpr double light_table = 0.9;  // of the face: none of its light passes beside the block
  const double longest = std::max({size[0], size[1], size[2]});
  const double distance = 3.0 * longest;
  // The film is 1.33 times the longest edge wide, at the block's distance.
  const double height = std::round(192.0 * (size[1] + 0.33 * longest) / (1.33 * longest));
  std::string xml =
      "<!-- Scene unit: mm. sigma_t in 1/mm (reduced extinction 1/(3 kappa)), albedo "
      "1 - 3 kappa mu,\n     isotropic phase function by similarity theory. Render with: mitsuba "
      "-m scalar_rgb scene.xml -->\n"
      "<scene version=\"3.0.0\">\n"
      "  <integrator type=\"volpathmis\">\n"
      "    <integer name=\"max_depth\" value=\"1000\"/>\n"
      "    <integer name=\"rr_depth\" value=\"200\"/>\n"
      "  </integrator>\n"
      "  <sensor type=\"perspective\">\n"
      "    <float name=\"fov\" value=\"25\"/>\n"
      "    <transform name=\"to_world\">\n"
      "      <lookat origin=\"" +
      vector(x, y, size[2] + distance) + "\" target=\"" + vector(x, y, size[2]) +
      "\" up=\"0, -1, 0\"/>\n"
      "    </transform>\n"
      "    <film type=\"hdrfilm\">\n"
      "      <integer name=\"width\" value=\"192\"/>\n"
      "      <integer name=\"height\" value=\"" +
      number_text(height) +
      "\"/>\n"
      "    </film>\n"
      "    <sampler type=\"independent\">\n"
      "      <integer name=\"sample_count\" value=\"32\"/>\n"
      "    </sampler>\n"
      "  </sensor>\n"
      "  <shape type=\"rectangle\">\n"
      "    <transform name=\"to_world\">\n"
      "      <scale " +
      attributes(light_table * x, light_table * y, 1.0) + "/>\n      <translate " +
      attributes(x, y, -0.25 * size[2]) +
      "/>\n    </transform>\n"
      "    <emitter type=\"area\"><rgb name=\"radiance\" value=\"2\"/></emitter>\n"
      "  </shape>\n"
      "  <shape type=\"cube\">\n"
      "    <transform name=\"to_world\">\n"
      "      <scale " +
      attributes(size[0] / 2, size[1] / 2, size[2] / 2) + "/>\n      <translate " +
      attributes(x, y, size[2] / 2) + "/>\n    </transform>\n";
  if (set.eta) {
    xml +=
        "    <bsdf type=\"dielectric\">\n"
        "      <float name=\"int_ior\" value=\"" +
        number_text(*set.eta) +
        "\"/>\n"
        "      <float name=\"ext_ior\" value=\"1\"/>\n"
        "    </bsdf>\n";
  } else {
    xml += "    <bsdf type=\"null\"/>\n";
  }
  return xml +
         "    <medium type=\"heterogeneous\" name=\"interior\">\n"
         "      <float name=\"scale\" value=\"1\"/>\n" +
         volume_xml("sigma_t", "sigma_t" + suffix + ".vol") +
         volume_xml("albedo", "albedo" + suffix + ".vol") +
         "      <phase type=\"isotropic\"/>\n"
         "    </medium>\n"
         "  </shape>\n"
         "</scene>\n";
}

}  // namespace

ExportResult export_mitsuba(const fs::path& folder, const VolumeSet& set) {
  validate(set, folder.string());
  ExportResult result;
  const std::vector<ScatteringVolumes> scattering = scattering_with_warnings(set, result);
  const auto write = [&](const std::string& suffix, std::size_t first, std::size_t count) {
    std::vector<const Volume<double>*> sigma_t;
    std::vector<const Volume<double>*> albedo;
    for (std::size_t c = first; c < first + count; ++c) {
      sigma_t.push_back(&scattering[c].sigma_t);
      albedo.push_back(&scattering[c].albedo);
    }
    result.files.push_back(folder / ("sigma_t" + suffix + ".vol"));
    write_vol(result.files.back(), sigma_t);
    result.files.push_back(folder / ("albedo" + suffix + ".vol"));
    write_vol(result.files.back(), albedo);
  };
  const std::size_t count = set.channels.size();
  // gridvolume takes one or three channels; other numbers come as single channels only.
  const bool together = count == 1 || count == 3;
  if (together) write("", 0, count);
  if (count > 1) {
    for (std::size_t c = 0; c < count; ++c) write("_" + set.channels[c], c, 1);
  }
  if (!together) {
    result.warnings.push_back("scene.xml shows channel " + set.channels.front() +
                              " alone, since Mitsuba takes one or three channels at once");
  }
  if (!set.eta) {
    result.warnings.push_back(
        "the volume does not say its refractive index; scene.xml has no refracting surface");
  }
  result.files.push_back(folder / "scene.xml");
  write_text_atomically(result.files.back(),
                        scene_xml(set, together ? "" : "_" + set.channels.front()));
  return result;
}

}  // namespace kappamu::io
