#include "render/scene/object_media.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"
#include "core/shown_text.h"
#include "io/volume/volume_file.h"
#include "render/material/baked_field.h"
#include "render/scene/composed_field.h"
#include "render/scene/object_shape.h"

namespace kappamu::render {

namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

Vector3d box_of(const GridShape& shape) {
  return shape.voxel_mm * Vector3d(shape.nx, shape.ny, shape.nz);
}

/// Of R, G, B in the volume's channels.
std::array<std::size_t, 3> channel_indices(const io::VolumeSet& set, const std::string& file) {
  if (set.channels.size() == 1) return {0, 0, 0};
  std::array<std::size_t, 3> indices{};
  constexpr std::array<const char*, 3> names{"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto found = std::find(set.channels.begin(), set.channels.end(), names[c]);
    if (found == set.channels.end()) {
      throw InputError(file + ": has no channel " + names[c] +
                       "; a picture needs R, G and B, or a volume of one channel for all three");
    }
    indices[c] = static_cast<std::size_t>(found - set.channels.begin());
  }
  return indices;
}

Wrap wrap_of(VolumeMaterial::Placement placement) {
  switch (placement) {
    case VolumeMaterial::Placement::repeat:
      return Wrap::repeat;
    case VolumeMaterial::Placement::mirror:
      return Wrap::mirror;
    case VolumeMaterial::Placement::stretch:
    case VolumeMaterial::Placement::shell:
      break;
  }
  return Wrap::clamp;
}

Affine3d object_from_volume(const VolumeMaterial& material, const GridShape& shape,
                            const Vector3d& box) {
  const Vector3d volume_box = box_of(shape);
  const Eigen::Matrix3d turn = turn_matrix(material.turn_deg);
  Vector3d scale = Vector3d::Ones();
  if (material.placement == VolumeMaterial::Placement::stretch) {
    // The turned volume's extents that hold the object's box: |Rᵀ| applied to it.
    const Vector3d extents = turn.transpose().cwiseAbs() * box;
    scale = extents.cwiseQuotient(volume_box);
  }
  Affine3d result = Affine3d::Identity();
  result.translate(material.offset_mm).rotate(turn).scale(scale).translate(-0.5 * volume_box);
  return result;
}

}  // namespace

Placing placing_of(const VolumeMaterial& material, const GridShape& shape, const Vector3d& box,
                   const std::string& source) {
  return {object_from_volume(material, shape, box), wrap_of(material.placement), source};
}

namespace {

PlacedVolume measured(const SceneObject& object, const VolumeMaterial& material,
                      const TriangleMesh& rest) {
  const std::filesystem::path file = io::find_shown_volume(material.volume);
  PlacedVolume placed{io::read_volume(file), {}};
  const Vector3d box = bounding_box(rest).sizes();
  const GridShape& shape = placed.set.shape();
  if (material.placement != VolumeMaterial::Placement::stretch && box.maxCoeff() < shape.voxel_mm) {
    throw InputError("object '" + object.name + "' is smaller than a voxel of " + file.string() +
                     "; make size_mm larger or write \"placement\": \"stretch\"");
  }
  placed.placing = placing_of(material, shape, box, file.string());
  return placed;
}

/// Of a shell and of composed materials.
PlacedVolume of_field(const Material& material, const std::string& object, const TriangleMesh& mesh,
                      std::vector<std::string>& warnings) {
  const NamedField made = make_field(material, mesh);
  std::vector<std::string> notes;
  Baked voxels = baked(*made.field, mesh, notes);
  for (const std::string& note : notes) warnings.push_back("object '" + object + "': " + note);
  voxels.set.eta = made.eta;
  return {std::move(voxels.set),
          {Affine3d(Eigen::Translation3d(voxels.corner_mm)), Wrap::clamp, made.source}};
}

/// Two million voxels fill it [mm].
double smallest_voxel(const Vector3d& box) {
  constexpr double most_voxels = 2e6;
  return std::cbrt(box.prod() / most_voxels);
}

/// Voxels of this edge that fill a box, into which they are then stretched.
GridShape voxels_of(const Vector3d& box, double voxel_mm) {
  constexpr double channels = 3.0, largest_extent = 65536.0;
  const Eigen::Array3d n = (box / voxel_mm).array().ceil().max(1.0);
  if (n.maxCoeff() > largest_extent ||
      2.0 * channels * n.prod() > static_cast<double>(io::default_most_voxels)) {
    throw InputError("voxels of " + shown_number(voxel_mm) + " mm are too many for it (" +
                     shown_number(n.prod()) + "); write a larger voxel_mm");
  }
  return {static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2]), voxel_mm};
}

PlacedVolume filled(const HomogeneousMaterial& material, const TriangleMesh& mesh,
                    std::optional<double> voxel_mm) {
  constexpr double voxels_per_size = 64.0;
  const Vector3d box = bounding_box(mesh).sizes();
  const double fine =
      std::min(3.0 * material.kappa_mm.minCoeff(), box.maxCoeff() / voxels_per_size);
  const GridShape shape = voxels_of(box, voxel_mm.value_or(std::max(fine, smallest_voxel(box))));
  PlacedVolume placed{one_voxel(material), placing_of({}, shape, box, material.source)};
  for (Medium& medium : placed.set.media) {
    medium = {Volume<double>(shape, medium.kappa[0]), Volume<double>(shape, medium.mu[0])};
  }
  return placed;
}

}  // namespace

io::VolumeSet one_voxel(const HomogeneousMaterial& material) {
  const GridShape shape{1, 1, 1, 1.0};
  io::VolumeSet set;
  set.channels = {"R", "G", "B"};
  set.eta = material.eta;
  for (Eigen::Index c = 0; c < 3; ++c) {
    set.media.push_back({Volume<double>(shape, material.kappa_mm[c]),
                         Volume<double>(shape, material.mu_per_mm[c])});
  }
  return set;
}

PlacedVolume placed_volume(const SceneObject& object, const TriangleMesh& rest,
                           const TriangleMesh& mesh, std::optional<double> voxel_mm,
                           std::vector<std::string>& warnings) {
  if (const auto* volume = std::get_if<VolumeMaterial>(&object.material);
      volume != nullptr && volume->placement != VolumeMaterial::Placement::shell) {
    return measured(object, *volume, rest);
  }
  const auto* alike = std::get_if<HomogeneousMaterial>(&object.material);
  try {
    return alike != nullptr ? filled(*alike, rest, voxel_mm)
                            : of_field(object.material, object.name, mesh, warnings);
  } catch (const InputError& error) {
    throw InputError("object '" + object.name + "': its material: " + error.what());
  }
}

io::VolumeSet colour_channels(const io::VolumeSet& set, const std::string& file) {
  io::VolumeSet colours;
  colours.eta = set.eta;
  const std::array<std::size_t, 3> indices = channel_indices(set, file);
  for (std::size_t c = 0; c < std::min<std::size_t>(3, set.channels.size()); ++c) {
    colours.channels.push_back(set.channels[indices[c]]);
    colours.media.push_back(set.media[indices[c]]);
  }
  return colours;
}

ObjectMedia media_of(const io::VolumeSet& voxel, const std::string& source) {
  ObjectMedia media;
  media.eta = voxel.eta;
  media.source = source;
  for (std::size_t c = 0; c < 3; ++c) {
    const Coefficients here{voxel.media[c].kappa[0], voxel.media[c].mu[0]};
    for (std::size_t before = 0; before < c; ++before) {
      const Coefficients there = media.channels[before]->smallest();
      if (there.kappa == here.kappa && there.mu == here.mu) {
        media.channels[c] = media.channels[before];
      }
    }
    if (!media.channels[c]) media.channels[c] = std::make_shared<const ObjectMedium>(here);
  }
  return media;
}

namespace {

/// `medium(index)`: one of the set's media, copied or moved.
template <class MediumOf>
ObjectMedia placed_media(const io::VolumeSet& set, const Placing& placing, const MediumOf& medium) {
  ObjectMedia media;
  media.source = placing.source;
  media.eta = set.eta;
  const std::array<std::size_t, 3> indices = channel_indices(set, placing.source);
  const bool grey = indices[1] == indices[0];
  for_rows(grey ? 1 : 3, [&](int row) {
    const auto c = static_cast<std::size_t>(row);
    media.channels[c] =
        std::make_shared<const ObjectMedium>(std::make_shared<const Medium>(medium(indices[c])),
                                             placing.object_from_volume.inverse(), placing.wrap);
  });
  if (grey) media.channels[1] = media.channels[2] = media.channels[0];
  return media;
}

}  // namespace

ObjectMedia media_of(const io::VolumeSet& set, const Placing& placing) {
  return placed_media(set, placing, [&](std::size_t i) { return set.media[i]; });
}

ObjectMedia media_of(io::VolumeSet&& set, const Placing& placing) {
  return placed_media(set, placing, [&](std::size_t i) { return std::move(set.media[i]); });
}

ObjectMedia make_object_media(const SceneObject& object, const TriangleMesh& rest,
                              const TriangleMesh& mesh, std::vector<std::string>& warnings) {
  if (const auto* alike = std::get_if<HomogeneousMaterial>(&object.material)) {
    return media_of(one_voxel(*alike), alike->source);
  }
  PlacedVolume placed = placed_volume(object, rest, mesh, std::nullopt, warnings);
  return media_of(std::move(placed.set), placed.placing);
}

}  // namespace kappamu::render
