// A pbrt-v4 medium (pbrt, src/pbrt/media.cpp, RGBGridMedium): sigma_a and sigma_s [1/mm] as R, G, B
// of cell-centred values, x fastest, over the box p0 ... p1 [mm].
#include <array>
#include <charconv>
#include <ostream>

#include "io/atomic_file.h"
#include "io/volume/scattering_export.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

/// One number of each of R, G, B per voxel; a lone channel stands for all three.
template <class Number>
void write_rgb(std::ostream& out, const char* name, std::size_t cells, const Number& number) {
  out << "  \"rgb " << name << "\" [";
  for (std::size_t i = 0; i < cells; ++i) {
    out << (i % 4 == 0 ? "\n   " : "");
    for (std::size_t c = 0; c < 3; ++c) {
      std::array<char, 32> text{};
      const auto value = static_cast<float>(number(i, c));
      const char* end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
      out << ' ' << std::string_view(text.data(), static_cast<std::size_t>(end - text.data()));
    }
  }
  out << " ]\n";
}

}  // namespace

ExportResult export_pbrt(const fs::path& file, const VolumeSet& set) {
  validate(set, file.string());
  ExportResult result;
  const std::vector<ScatteringVolumes> scattering = scattering_with_warnings(set, result);
  const std::size_t count = set.channels.size();
  if (count != 1 && count != 3) {
    result.warnings.push_back(file.filename().string() + " has channel " + set.channels.front() +
                              " alone, since pbrt takes one or three channels");
  }
  const auto channel = [&](std::size_t c) -> const ScatteringVolumes& {
    return scattering[count == 3 ? c : 0];
  };
  const GridShape& s = set.shape();
  write_stream_atomically(file, [&](std::ostream& out) {
    out << "# Scene unit: mm. sigma_a = mu, sigma_s = 1/(3 kappa) - mu [1/mm], isotropic\n"
           "MakeNamedMedium \"block\" \"string type\" \"rgbgrid\"\n"
           "  \"integer nx\" "
        << s.nx << " \"integer ny\" " << s.ny << " \"integer nz\" " << s.nz
        << "\n  \"point3 p0\" [ 0 0 0 ] \"point3 p1\" [ " << number_text(s.nx * s.voxel_mm) << ' '
        << number_text(s.ny * s.voxel_mm) << ' ' << number_text(s.nz * s.voxel_mm)
        << " ]\n  \"float scale\" 1 \"float g\" 0\n";
    write_rgb(out, "sigma_a", s.cells(), [&](std::size_t i, std::size_t c) {
      return channel(c).sigma_t[i] * (1.0 - channel(c).albedo[i]);
    });
    write_rgb(out, "sigma_s", s.cells(), [&](std::size_t i, std::size_t c) {
      return channel(c).sigma_t[i] * channel(c).albedo[i];
    });
  });
  result.files.push_back(file);
  return result;
}

}  // namespace kappamu::io
