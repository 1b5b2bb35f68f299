// Files: volumes of κ and μ, single volumes, sessions, pictures. Arrays that are read keep the
// memory they were read into.
#include <algorithm>

#include "capture/session/session.h"
#include "core/file_name.h"
#include "core/image.h"
#include "io/image/exr.h"
#include "io/image/image_file.h"
#include "io/volume/volume_export.h"
#include "io/volume/volume_file.h"
#include "python/bindings/bind.h"
#include "python/bindings/calls.h"

namespace kappamu::python {

namespace {

namespace fs = std::filesystem;
using Volumes = std::vector<Volume<double>>;

py::list take_all(Volumes&& volumes, const GridShape& shape) {
  py::list arrays;
  for (Volume<double>& volume : volumes)
    arrays.append(take(std::move(volume.values()), extents(shape)));
  return arrays;
}

py::dict read_volume(const fs::path& path, std::size_t most_voxels) {
  io::VolumeSet set = [&] {
    const Released released;
    return io::read_volume(io::find_volume(path), most_voxels);
  }();
  const GridShape shape = set.shape();
  py::dict found;
  found["channels"] = set.channels;
  found["voxel_mm"] = shape.voxel_mm;
  found["eta"] = set.eta;
  found["metadata"] = set.metadata;
  py::list kappa, mu;
  for (Medium& medium : set.media) {
    kappa.append(take(std::move(medium.kappa.values()), extents(shape)));
    mu.append(take(std::move(medium.mu.values()), extents(shape)));
  }
  found["kappa"] = kappa;
  found["mu"] = mu;
  found["std_kappa"] = take_all(std::move(set.kappa_std), shape);
  found["std_mu"] = take_all(std::move(set.mu_std), shape);
  found["resolution_kappa"] = take_all(std::move(set.kappa_resolution), shape);
  found["resolution_mu"] = take_all(std::move(set.mu_resolution), shape);
  found["sensitivity"] = take_all(std::move(set.sensitivity), shape);
  return found;
}

Volumes volumes_of(const py::dict& fields, const char* key, const GridShape& shape) {
  Volumes volumes;
  if (!fields.contains(key)) return volumes;
  for (const py::handle& given : fields[key].cast<py::list>()) {
    const auto array = numbers<double>(py::reinterpret_borrow<py::object>(given), key);
    require_shape(array, extents(shape), key, "[z][y][x] of kappa");
    volumes.emplace_back(shape, copy(array));
  }
  return volumes;
}

io::VolumeSet set_from(const py::dict& fields) {
  io::VolumeSet set;
  set.channels = fields["channels"].cast<std::vector<std::string>>();
  const auto first = numbers<double>(fields["kappa"].cast<py::list>()[0], "kappa");
  const GridShape shape = grid_of(first, fields["voxel_mm"].cast<double>(), "kappa");
  Volumes kappa = volumes_of(fields, "kappa", shape), mu = volumes_of(fields, "mu", shape);
  if (kappa.size() != set.channels.size() || mu.size() != set.channels.size())
    throw KeyedError("channels", "channels must name every volume of kappa and of mu");
  for (std::size_t c = 0; c < kappa.size(); ++c)
    set.media.push_back({std::move(kappa[c]), std::move(mu[c])});
  set.kappa_std = volumes_of(fields, "std_kappa", shape);
  set.mu_std = volumes_of(fields, "std_mu", shape);
  set.kappa_resolution = volumes_of(fields, "resolution_kappa", shape);
  set.mu_resolution = volumes_of(fields, "resolution_mu", shape);
  set.sensitivity = volumes_of(fields, "sensitivity", shape);
  set.eta = fields["eta"].cast<std::optional<double>>();
  set.metadata = fields["metadata"].cast<std::map<std::string, std::string>>();
  return set;
}

/// By the name's ending: .vdb or .vti; no ending: a folder, of NumPy arrays or with vol = true for
/// Mitsuba.
py::list write_volume(const fs::path& path, const std::string& format, const py::dict& fields) {
  const io::VolumeSet set = set_from(fields);
  io::ExportResult result;
  {
    const Released released;
    if (format == "vdb") {
      io::write_vdb(path, set);
    } else if (format == "vti") {
      result = io::export_vti(path, set);
    } else if (format == "vol") {
      result = io::export_mitsuba(path, set);
    } else if (format == "npy") {
      io::write_volume_folder(path, set);
    } else {
      throw KeyedError("format", "format is '" + format + "'; it must be vdb, vti, vol or npy");
    }
  }
  for (const std::string& warning : result.warnings)
    py::module_::import("kappamu.errors").attr("warn")(warning);
  py::list files;
  for (const fs::path& file : result.files) files.append(file.string());
  if (result.files.empty()) files.append(path.string());
  return files;
}

template <class T>
py::array_t<T> take_image(Image<T>&& image) {
  const std::vector<py::ssize_t> shape{image.height(), image.width(), image.channels()};
  return take(std::move(image.values()), shape);
}

py::object read_image(const fs::path& file) {
  if (io::is_float_image(file)) {
    Image<float> image = io::read_float_image(file);
    return take_image(std::move(image));
  }
  Image<std::uint16_t> image = io::read_code_image(file);
  return take_image(std::move(image));
}

}  // namespace

void bind_volumes(py::module_& module) {
  module.attr("default_max_voxels") = io::default_most_voxels;
  module.def("read_volume", read_volume);
  module.def("write_volume", write_volume);
  module.def("find_volume", [](const fs::path& path) { return io::find_volume(path).string(); });
  module.def("read_image", read_image);
  module.def("check_session", [](const fs::path& folder) { capture::read_session(folder); });
  module.def("copied_bytes", [] { return copied_bytes.load(); });
}

}  // namespace kappamu::python
