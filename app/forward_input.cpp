#include "app/forward_input.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "core/error.h"
#include "core/file_name.h"
#include "core/numbers/coefficient_bounds.h"
#include "io/npy.h"
#include "io/volume/npy_volume.h"
#include "io/volume/volume_file.h"
#include "pipeline/verify.h"

namespace kappamu::app {

namespace {

Volume<double> from_npy(const std::string& file, const ForwardFiles& files) {
  if (!files.voxel)
    throw InputError(file + ": --voxel is missing; .npy files do not hold the voxel edge");
  return io::read_npy_volume(file, *files.voxel, files.most_voxels);
}

Medium from_vdb(const std::string& file, const ForwardFiles& files) {
  io::VolumeSet set = io::read_vdb(file, files.most_voxels);
  if (!files.channel && set.channels.size() > 1) {
    throw InputError(file + ": has several channels; choose one with --channel");
  }
  const std::string wanted = files.channel.value_or(set.channels.front());
  const auto found = std::find(set.channels.begin(), set.channels.end(), wanted);
  if (found == set.channels.end()) throw InputError(file + ": has no channel '" + wanted + "'");
  Medium medium = std::move(set.media[static_cast<std::size_t>(found - set.channels.begin())]);
  const double voxel = medium.kappa.shape().voxel_mm;
  if (files.voxel && std::abs(*files.voxel - voxel) > 1e-6 * voxel) {
    throw InputError(file + ": its voxel edge is " + std::to_string(voxel) + " mm, not " +
                     std::to_string(*files.voxel) + "; leave --voxel out");
  }
  return medium;
}

/// `member`: the one of a VDB file's two.
Volume<double> read_volume(const std::string& file, const ForwardFiles& files,
                           Volume<double> Medium::*member) {
  pipeline::require_as_written(file);
  if (lower_extension(file) != ".vdb") return from_npy(file, files);
  return std::move(from_vdb(file, files).*member);
}

std::string extents(const GridShape& s) {
  return io::shape_to_string({static_cast<std::size_t>(s.nz), static_cast<std::size_t>(s.ny),
                              static_cast<std::size_t>(s.nx)});
}

}  // namespace

Medium read_medium(const ForwardFiles& files) {
  Medium medium{read_volume(files.kappa, files, &Medium::kappa),
                read_volume(files.mu, files, &Medium::mu)};
  const GridShape shape = medium.kappa.shape();
  if (!(shape == medium.mu.shape())) {
    throw InputError(files.kappa + " has shape " + extents(shape) + " and " + files.mu +
                     " has shape " + extents(medium.mu.shape()) +
                     "; kappa and mu must share one grid");
  }
  // One at a time beside a single valid voxel, so that the sentence names the right file.
  const GridShape voxel{1, 1, 1, shape.voxel_mm};
  Medium kappa_alone{std::move(medium.kappa), Volume<double>(voxel, 0.0)};
  validate(kappa_alone, files.kappa);
  Medium mu_alone{Volume<double>(voxel, 1.0), std::move(medium.mu)};
  validate(mu_alone, files.mu);
  return {std::move(kappa_alone.kappa), std::move(mu_alone.mu)};
}

Irradiance read_irradiance(const ForwardFiles& files, const GridShape& grid, Face lit_face) {
  if (files.irradiance.empty()) return {};
  const FaceShape face = face_shape(grid, lit_face);
  const std::vector<std::size_t> wanted{static_cast<std::size_t>(face.nv),
                                        static_cast<std::size_t>(face.nu)};
  std::vector<std::size_t> shape;
  const io::NpyArray array =
      io::read_npy(files.irradiance, [&](const std::vector<std::size_t>& found) {
        constexpr std::size_t most_patterns = 1 << 16;
        shape = found;
        if (shape.size() == 2) shape.insert(shape.begin(), 1);
        if (shape.size() == 3 && shape[0] >= 1 && shape[0] <= most_patterns &&
            shape[1] == wanted[0] && shape[2] == wanted[1]) {
          return;
        }
        throw InputError(files.irradiance + " has shape " + io::shape_to_string(found) + " but " +
                         files.kappa + " makes face " + to_string(lit_face) + " " +
                         io::shape_to_string(wanted) + "; irradiance must be [M]" +
                         io::shape_to_string(wanted));
      });
  const auto bad = std::find_if(array.values.begin(), array.values.end(),
                                [](float e) { return !(std::isfinite(e) && e >= 0.0F); });
  if (bad != array.values.end()) {
    const auto i = static_cast<std::size_t>(bad - array.values.begin());
    throw InputError(
        files.irradiance + ": irradiance is " + std::to_string(*bad) + " at pattern " +
        std::to_string(i / face.cells()) + ", v=" + std::to_string(i % face.cells() / wanted[1]) +
        " u=" + std::to_string(i % wanted[1]) + "; it must be finite and not negative");
  }
  require_usual_light(*std::max_element(array.values.begin(), array.values.end()),
                      files.irradiance);
  return {static_cast<int>(shape[0]), {array.values.begin(), array.values.end()}};
}

}  // namespace kappamu::app
