#include "pipeline/surface_reflectance.h"

#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/image.h"
#include "core/optics.h"
#include "inverse/problem/lit_face.h"
#include "io/image/image_file.h"

namespace kappamu::pipeline {

namespace {

using Eigen::Vector3d;

constexpr double least_measured = 0.5;  // share of the face
constexpr double least_light = 0.2;     // of the face's mean

/// Of the lit face, towards the camera, at the middle of each pixel.
std::vector<double> cosines(const SurfaceMeasurements& m, const std::optional<Rigid>& camera) {
  const FaceShape face = m.lit_shape();
  std::vector<double> cosine(face.cells(), 1.0);
  if (!camera) return cosine;
  const int axis = axis_of(m.lit_face);
  const auto [along, across] = face_axes(m.lit_face);
  const double h = m.grid.voxel_mm;
  const std::array<int, 3> voxels{m.grid.nx, m.grid.ny, m.grid.nz};
  const Vector3d eye = camera->inverse().translation;
  for (int v = 0; v < face.nv; ++v) {
    for (int u = 0; u < face.nu; ++u) {
      Vector3d at;
      at[along] = (u + 0.5) * h;
      at[across] = (v + 0.5) * h;
      at[axis] = is_plus(m.lit_face) ? voxels[static_cast<std::size_t>(axis)] * h : 0.0;
      const double outward = is_plus(m.lit_face) ? 1.0 : -1.0;
      cosine[static_cast<std::size_t>(v) * face.nu + u] = outward * (eye - at).normalized()[axis];
    }
  }
  return cosine;
}

/// Of all pictures of the lit face together.
class EvenPicture {
 public:
  explicit EvenPicture(const SurfaceMeasurements& m)
      : m_(m), cells_(m.lit_shape().cells()), irradiance_(cells_, 0.0) {
    for (int p = 0; p < m.patterns; ++p) {
      if (m.seen_on(p) != m.lit_face) continue;
      pictures_.push_back(static_cast<std::size_t>(p));
      for (std::size_t i = 0; i < cells_; ++i) {
        irradiance_[i] += m.irradiance[static_cast<std::size_t>(p) * cells_ + i];
      }
    }
    for (const double light : irradiance_) mean_light_ += light / static_cast<double>(cells_);
  }

  bool even() const {
    return !pictures_.empty() &&
           inverse::varies_slowly(m_.lit_shape(), m_.grid.voxel_mm, irradiance_);
  }
  double irradiance(std::size_t pixel) const { return irradiance_[pixel]; }

  bool measured(int channel, std::size_t pixel) const {
    if (irradiance_[pixel] < least_light * mean_light_) return false;
    for (const std::size_t p : pictures_) {
      const std::size_t i = index(channel, p, pixel);
      const bool used = m_.mask.empty() || m_.mask[i] != 0;
      if (!used && (m_.lit.empty() || m_.lit[i] == 0)) return false;
    }
    return true;
  }
  double excess(int channel, std::size_t pixel, std::span<const float> prediction) const {
    double sum = 0.0;
    for (const std::size_t p : pictures_) {
      sum += m_.value[index(channel, p, pixel)] - prediction[p * cells_ + pixel];
    }
    return sum;
  }
  double variance(int channel, std::size_t pixel) const {
    double sum = 0.0;
    for (const std::size_t p : pictures_) sum += m_.variance[index(channel, p, pixel)];
    return sum;
  }

 private:
  std::size_t index(int channel, std::size_t pattern, std::size_t pixel) const {
    return (static_cast<std::size_t>(channel) * static_cast<std::size_t>(m_.patterns) + pattern) *
               cells_ +
           pixel;
  }

  const SurfaceMeasurements& m_;
  std::size_t cells_;
  std::vector<std::size_t> pictures_;
  std::vector<double> irradiance_;
  double mean_light_ = 0.0;
};

}  // namespace

std::optional<SurfaceReflectance> surface_reflectance(
    const SurfaceMeasurements& m, std::span<const int> channels, std::span<const float> prediction,
    const std::optional<Rigid>& camera_from_sample) {
  if (!m.lit_is_seen()) return std::nullopt;
  const EvenPicture picture(m);
  if (!picture.even()) return std::nullopt;
  const FaceShape face = m.lit_shape();
  const std::size_t cells = face.cells(), of_channel = cells * static_cast<std::size_t>(m.patterns);
  check(prediction.size() == channels.size() * of_channel, "every pattern is predicted");

  std::vector<char> measured(cells, 1);
  std::size_t count = 0;
  for (std::size_t i = 0; i < cells; ++i) {
    for (const int c : channels) measured[i] = measured[i] != 0 && picture.measured(c, i) ? 1 : 0;
    count += static_cast<std::size_t>(measured[i]);
  }
  SurfaceReflectance result{.face = m.lit_face,
                            .shape = face,
                            .measured = static_cast<double>(count) / static_cast<double>(cells),
                            .value = std::vector<float>(channels.size() * cells),
                            .channels = {}};
  if (result.measured < least_measured) return std::nullopt;

  // The camera's radiance of a value; a diffuse surface sends ρE/π.
  const BoundaryConstants optics = boundary_constants(m.eta);
  std::vector<double> radiance = cosines(m, camera_from_sample);
  for (double& of : radiance) {
    of = m.quantity == Quantity::exitance ? radiance_per_exitance(optics, of) : 1.0;
  }
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const int c = channels[k];
    SurfaceReflectance::Channel channel{.name = m.channels[static_cast<std::size_t>(c)]};
    float* const value = &result.value[k * cells];
    for (std::size_t i = 0; i < cells; ++i) {
      if (measured[i] == 0) continue;
      const double factor = std::numbers::pi * radiance[i] / picture.irradiance(i);
      const double here =
          factor * picture.excess(c, i, prediction.subspan(k * of_channel, of_channel));
      channel.mean += here;
      channel.noise += factor * std::sqrt(picture.variance(c, i));
      channel.negative += here < 0.0 ? 1.0 : 0.0;
      value[i] = static_cast<float>(std::max(0.0, here));
    }
    for (double* of : {&channel.mean, &channel.noise, &channel.negative}) {
      *of /= static_cast<double>(count);
    }
    for (std::size_t i = 0; i < cells; ++i) {
      if (measured[i] == 0) value[i] = static_cast<float>(std::max(0.0, channel.mean));
    }
    result.channels.push_back(std::move(channel));
  }
  return result;
}

std::string write_surface_reflectance(const std::filesystem::path& folder,
                                      const SurfaceReflectance& r) {
  if (r.channels.size() != 1 && r.channels.size() != 3) {
    throw InputError("a picture of reflectance has one channel or three, not " +
                     std::to_string(r.channels.size()));
  }
  Image<float> image(r.shape.nu, r.shape.nv, static_cast<int>(r.channels.size()));
  for (int c = 0; c < image.channels(); ++c) {
    for (int v = 0; v < r.shape.nv; ++v) {
      for (int u = 0; u < r.shape.nu; ++u) {
        image(u, r.shape.nv - 1 - v, c) =
            r.value[(static_cast<std::size_t>(c) * r.shape.nv + v) * r.shape.nu + u];
      }
    }
  }
  const std::string name = reflectance_name(r.face);
  io::write_float_image(folder / name, image);
  return name;
}

}  // namespace kappamu::pipeline
