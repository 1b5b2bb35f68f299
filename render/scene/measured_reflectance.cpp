#include "render/scene/measured_reflectance.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/volume/volume_file.h"
#include "render/linear_image.h"
#include "render/material/shell_field.h"
#include "render/scene/object_media.h"

namespace kappamu::render {

namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// Cosines between the surface's normal and the face's, from none to all.
constexpr double least_facing = 0.2, full_facing = 0.6;

fs::path picture_of(const fs::path& folder, bool plus) {
  return folder / (plus ? "reflectance_z+.exr" : "reflectance_z-.exr");
}

/// Of one face of a block, by its voxels' u and v.
class FacePicture {
 public:
  explicit FacePicture(const fs::path& volume) : volume_(volume) {
    const auto file = measured_reflectance_file(volume);
    if (!file) {
      throw InputError(volume.string() +
                       ": no reflectance_z-.exr lies beside the volume; fit a session whose lit "
                       "face is photographed too, or remove 'measured'");
    }
    file_ = *file;
    plus_ = file_ == picture_of(file_.parent_path(), true);
    image_ = read_linear_image(file_);
  }
  bool plus() const { return plus_; }
  const fs::path& file() const { return file_; }

  void expect_face_of(const GridShape& shape) const {
    if (image_.width() == shape.nx && image_.height() == shape.ny) return;
    throw InputError(file_.string() + " has " + std::to_string(image_.width()) + " x " +
                     std::to_string(image_.height()) + " pixels, and the face of " +
                     volume_.string() + " " + std::to_string(shape.nx) + " x " +
                     std::to_string(shape.ny) + " voxels; fit the volume again");
  }
  /// Between the voxels' middles, held beyond the outermost.
  Colour at(const Vector2d& voxel) const {
    const double x = std::clamp(voxel.x() - 0.5, 0.0, image_.width() - 1.0);
    const double y = std::clamp(image_.height() - 0.5 - voxel.y(), 0.0, image_.height() - 1.0);
    const int left = std::min(static_cast<int>(x), std::max(0, image_.width() - 2));
    const int top = std::min(static_cast<int>(y), std::max(0, image_.height() - 2));
    const int right = std::min(left + 1, image_.width() - 1);
    const int below = std::min(top + 1, image_.height() - 1);
    const double s = x - left, t = y - top;
    return (1.0 - t) * ((1.0 - s) * pixel(image_, left, top) + s * pixel(image_, right, top)) +
           t * ((1.0 - s) * pixel(image_, left, below) + s * pixel(image_, right, below));
  }

 private:
  fs::path volume_, file_;
  bool plus_ = false;
  Image<float> image_;
};

/// A voxel coordinate of a volume that goes on beyond its own box.
double wrapped(double at, int count, Wrap wrap) {
  if (wrap == Wrap::clamp) return at;
  const double turns = std::floor(at / count), within = at - turns * count;
  const bool back = wrap == Wrap::mirror && std::fmod(std::abs(turns), 2.0) == 1.0;
  return back ? count - within : within;
}

class SolidReflectance : public PlacedReflectance {
 public:
  SolidReflectance(FacePicture picture, const GridShape& shape, const Placing& placing)
      : picture_(std::move(picture)),
        shape_(shape),
        wrap_(placing.wrap),
        volume_from_object_(placing.object_from_volume.inverse()),
        outward_(
            (placing.object_from_volume.linear() * Vector3d(0.0, 0.0, picture_.plus() ? 1.0 : -1.0))
                .normalized()) {}

  Colour at(const SurfacePlace& place) const override {
    const double share = std::clamp(
        (place.normal.dot(outward_) - least_facing) / (full_facing - least_facing), 0.0, 1.0);
    if (share == 0.0) return Colour::Zero();
    const Vector3d voxel = volume_from_object_ * place.point / shape_.voxel_mm;
    return share * share * (3.0 - 2.0 * share) *
           picture_.at(
               {wrapped(voxel.x(), shape_.nx, wrap_), wrapped(voxel.y(), shape_.ny, wrap_)});
  }

 private:
  FacePicture picture_;
  GridShape shape_;
  Wrap wrap_;
  Eigen::Affine3d volume_from_object_;
  Vector3d outward_;  ///< of the face, in the object's frame
};

class ShellReflectance : public PlacedReflectance {
 public:
  ShellReflectance(FacePicture picture, const io::VolumeSet& block, const Shell& shell,
                   const TriangleMesh& mesh)
      : picture_(std::move(picture)),
        width_(block.shape().nx),
        mesh_(mesh),
        field_(block, shell, mesh_) {}
  ShellReflectance(const ShellReflectance&) = delete;
  ShellReflectance& operator=(const ShellReflectance&) = delete;

  Colour at(const SurfacePlace& place) const override {
    Place on;
    on.point = on.surface = place.point;
    on.normal = place.normal;
    on.triangle = static_cast<int>(place.triangle);
    on.weights = {1.0 - place.u - place.v, place.u, place.v};
    Colour sum = Colour::Zero();
    double weights = 0.0;
    const FacePlaces places = field_.on_face(on);
    for (const FacePlace& one : places.all()) {
      Vector2d voxel = one.at_mm / field_.voxel_mm();
      if (!picture_.plus()) voxel.x() = width_ - voxel.x();  // the block is turned about y
      sum += one.weight * picture_.at(voxel);
      weights += one.weight;
    }
    return weights > 0.0 ? Colour(sum / weights) : sum;
  }

 private:
  FacePicture picture_;
  int width_;
  TriangleMesh mesh_;
  ShellField field_;
};

}  // namespace

std::optional<fs::path> measured_reflectance_file(const fs::path& volume) {
  const fs::path found = io::find_volume(volume);
  const fs::path folder = fs::is_directory(found) ? found : found.parent_path();
  for (const bool plus : {false, true}) {
    if (fs::exists(picture_of(folder, plus))) return picture_of(folder, plus);
  }
  return std::nullopt;
}

std::shared_ptr<const PlacedReflectance> measured_reflectance(const Material& material,
                                                              const TriangleMesh& rest,
                                                              const TriangleMesh& mesh) {
  const auto* volume = std::get_if<VolumeMaterial>(&material);
  if (volume == nullptr) {
    throw InputError(
        "surface.reflectance.measured: the material is not a volume; remove it, or state an "
        "'image'");
  }
  FacePicture picture(volume->volume);
  const fs::path file = io::find_volume(volume->volume);
  const io::VolumeSet set = io::read_volume(file);
  picture.expect_face_of(set.shape());
  if (volume->placement != VolumeMaterial::Placement::shell) {
    const Eigen::Vector3d box = bounding_box(rest).sizes();
    return std::make_shared<const SolidReflectance>(
        std::move(picture), set.shape(), placing_of(*volume, set.shape(), box, file.string()));
  }
  if (picture.plus() != (volume->shell.outside == Shell::Outside::z_plus)) {
    const std::string face = picture.plus() ? "z+" : "z-";
    throw InputError(picture.file().string() + " is of the face " + face +
                     ", which lies inside; write \"face\": \"" + face + "\" in the material");
  }
  return std::make_shared<const ShellReflectance>(
      std::move(picture), colour_channels(set, file.string()), volume->shell, mesh);
}

}  // namespace kappamu::render
