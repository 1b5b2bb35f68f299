#include "render/scene/object_media.h"

#include <algorithm>

#include "core/error.h"
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

ObjectMedia homogeneous(const HomogeneousMaterial& material) {
  ObjectMedia media;
  media.eta = material.eta;
  media.source = material.source;
  for (int c = 0; c < 3; ++c) {
    const Coefficients here{material.kappa_mm[c], material.mu_per_mm[c]};
    for (int before = 0; before < c; ++before) {
      if (material.kappa_mm[before] == here.kappa && material.mu_per_mm[before] == here.mu) {
        media.channels[static_cast<std::size_t>(c)] =
            media.channels[static_cast<std::size_t>(before)];
      }
    }
    if (!media.channels[static_cast<std::size_t>(c)]) {
      media.channels[static_cast<std::size_t>(c)] = std::make_shared<const ObjectMedium>(here);
    }
  }
  return media;
}

/// `set` placed in the object.
ObjectMedia placed(const io::VolumeSet& set, const Affine3d& volume_from_object, Wrap wrap,
                   const std::string& source) {
  ObjectMedia media;
  media.source = source;
  media.eta = set.eta;
  const std::array<std::size_t, 3> indices = channel_indices(set, source);
  for (std::size_t c = 0; c < 3; ++c) {
    if (c > 0 && indices[c] == indices[0]) {
      media.channels[c] = media.channels[0];
      continue;
    }
    media.channels[c] = std::make_shared<const ObjectMedium>(
        std::make_shared<const Medium>(set.media[indices[c]]), volume_from_object, wrap);
  }
  return media;
}

}  // namespace

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

ObjectMedia media_of(const io::VolumeSet& set, const SceneObject& object, const Vector3d& box,
                     const std::string& source) {
  const auto& material = std::get<VolumeMaterial>(object.material);
  const GridShape& shape = set.shape();
  if (material.placement != VolumeMaterial::Placement::stretch && box.maxCoeff() < shape.voxel_mm) {
    throw InputError("object '" + object.name + "' is smaller than a voxel of " + source +
                     "; make size_mm larger or write \"placement\": \"stretch\"");
  }
  return placed(set, object_from_volume(material, shape, box).inverse(),
                wrap_of(material.placement), source);
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

ObjectMedia make_object_media(const SceneObject& object, const TriangleMesh& mesh,
                              std::vector<std::string>& warnings) {
  if (const auto* alike = std::get_if<HomogeneousMaterial>(&object.material))
    return homogeneous(*alike);
  const auto* volume = std::get_if<VolumeMaterial>(&object.material);
  if (volume != nullptr && volume->placement != VolumeMaterial::Placement::shell) {
    const std::filesystem::path file = io::find_volume(volume->volume);
    return media_of(io::read_volume(file), object, bounding_box(mesh).sizes(), file.string());
  }
  try {
    const NamedField made = make_field(object.material, mesh);
    std::vector<std::string> notes;
    Baked voxels = baked(*made.field, mesh, notes);
    for (const std::string& note : notes)
      warnings.push_back("object '" + object.name + "': " + note);
    voxels.set.eta = made.eta;
    return placed(voxels.set, Affine3d(Eigen::Translation3d(-voxels.corner_mm)), Wrap::clamp,
                  made.source);
  } catch (const InputError& error) {
    throw InputError("object '" + object.name + "': its material: " + error.what());
  }
}

}  // namespace kappamu::render
