// VTK XML image data, version 1.0:
// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
#include <ostream>

#include "io/atomic_file.h"
#include "io/volume/scattering_export.h"
#include "io/xml_text.h"

namespace kappamu::io {

namespace {

/// A FieldData string: VTK's text form of it is the character codes, ended by 0.
std::string field_text(const std::string& name, const std::string& text) {
  std::string result = "      <DataArray type=\"String\" Name=\"" + xml_escaped(name) +
                       "\" NumberOfTuples=\"1\" format=\"ascii\">";
  for (const char c : text) {
    result.append(std::to_string(static_cast<unsigned char>(c))).append(" ");
  }
  return result + "0</DataArray>\n";
}

std::string header_text(const GridShape& s, const std::vector<NamedVolume>& volumes,
                        const std::string& fields) {
  const std::string h = number_text(s.voxel_mm);
  // Values belong to cells: points lie on voxel corners, so nothing is shifted by half a voxel.
  const std::string extent =
      "0 " + std::to_string(s.nx) + " 0 " + std::to_string(s.ny) + " 0 " + std::to_string(s.nz);
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "  <ImageData WholeExtent=\"" +
      extent + "\" Origin=\"0 0 0\" Spacing=\"" + h + " " + h + " " + h + "\">\n    <FieldData>\n";
  std::string units;
  for (const NamedVolume& volume : volumes) {
    units.append(volume.name).append(" [").append(volume.unit).append("] ");
  }
  text += field_text("units", units + "lengths [mm]");
  text += fields + "    </FieldData>\n    <Piece Extent=\"" + extent +
          "\">\n      <CellData Scalars=\"" + volumes.front().name + "\">\n";
  const std::uint64_t block = sizeof(std::uint64_t) + s.cells() * sizeof(float);
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    text += "        <DataArray type=\"Float32\" Name=\"" + volumes[i].name +
            "\" format=\"appended\" offset=\"" + std::to_string(i * block) + "\"/>\n";
  }
  return text +
         "      </CellData>\n    </Piece>\n  </ImageData>\n  <AppendedData encoding=\"raw\">\n   _";
}

void write_vti(const std::filesystem::path& file, const std::vector<NamedVolume>& volumes,
               const std::string& fields) {
  const GridShape& shape = volumes.front().volume->shape();
  write_stream_atomically(file, [&](std::ostream& out) {
    out << header_text(shape, volumes, fields);
    const std::uint64_t size = shape.cells() * sizeof(float);
    for (const NamedVolume& named : volumes) {
      const auto& values = named.volume->values();
      const std::vector<float> floats(values.begin(), values.end());
      out.write(reinterpret_cast<const char*>(&size), sizeof size);
      out.write(reinterpret_cast<const char*>(floats.data()), static_cast<std::streamsize>(size));
    }
    out << "\n  </AppendedData>\n</VTKFile>\n";
  });
}

}  // namespace

void export_vti(const std::filesystem::path& file, const std::vector<NamedVolume>& volumes) {
  write_vti(file, volumes, "");
}

ExportResult export_vti(const std::filesystem::path& file, const VolumeSet& set) {
  validate(set, file.string());
  ExportResult result;
  std::vector<NamedVolume> volumes = named_volumes(set);
  const std::vector<ScatteringVolumes> scattering = scattering_with_warnings(set, result);
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    volumes.push_back({"sigma_t_" + set.channels[c], "1/mm", &scattering[c].sigma_t});
    volumes.push_back({"albedo_" + set.channels[c], "1", &scattering[c].albedo});
  }
  std::string fields;
  if (set.eta) fields += field_text("eta", number_text(*set.eta));
  for (const auto& [name, value] : set.metadata) fields += field_text("provenance_" + name, value);
  write_vti(file, volumes, fields);
  result.files.push_back(file);
  return result;
}

}  // namespace kappamu::io
