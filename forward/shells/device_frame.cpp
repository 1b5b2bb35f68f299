#include "forward/shells/device_frame.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"

namespace kappamu::forward::shells {

extern const device::KernelSource shells_cl;

using Eigen::Vector3d;

namespace {

constexpr int lanes = 8;        ///< texels or pixels of a work item
constexpr int most_slants = 8;  ///< volumes of premultiplied texels
/// Neighbouring slants: opacity errs by half of that, at most by 1 %.
constexpr double slant_ratio = 1.04;
/// Rays are two pixels apart where a pixel's step over the skin is below this everywhere [texel].
constexpr double least_step = 0.3;

/// Pixels of a row that work items fill.
int padded(int width) {
  constexpr int whole = 2 * lanes;
  return (width + whole - 1) / whole * whole;
}
/// Rays along an axis that are two pixels apart, with one beyond the last pixel.
int halved(int pixels) {
  return (pixels - 1) / 2 + 2;
}

device::Buffer uploaded(device::Context& context, const std::vector<float>& values) {
  device::Buffer buffer = context.allocate(values.size() * sizeof(float));
  context.write(buffer, values.data(), buffer.bytes());
  return buffer;
}

}  // namespace

DeviceFrame::DeviceFrame(device::Context& context, const HairTexture& texture,
                         const Transfer& transfer, const HairColour& colour, int width, int height)
    : context_(context),
      texture_(texture),
      transfer_(transfer),
      colour_(colour),
      width_(width),
      height_(height),
      program_(&context.program(
          shells_cl, "-cl-fast-relaxed-math -DWIDTH=" + std::to_string(texture.width) +
                         " -DLAYERS=" + std::to_string(texture.layers) +
                         " -DCOEFFICIENTS=" + std::to_string(harmonics_in(transfer.bands)))) {
  if (texture.layers > 64) throw InputError("fur: a frame is drawn of at most 64 layers");
  const std::size_t slice = static_cast<std::size_t>(texture.width + 1) * (texture.width + 1);
  const std::size_t bytes = slice * texture.layers * most_slants * 4 * sizeof(std::uint16_t);
  texels_ = context.allocate(bytes);
  context.zero(texels_, bytes);
  filled_ = context.allocate(static_cast<std::size_t>(texture.width) * texture.width *
                             sizeof(std::uint64_t));
  constexpr std::size_t pixel = 4 * sizeof(std::uint16_t);
  seen_ = context.allocate(static_cast<std::size_t>(padded(width)) * height * pixel);
  // `spread` reads one ray beyond the last.
  rays_ = context.allocate(
      (static_cast<std::size_t>(padded(halved(width))) * halved(height) + lanes) * pixel);
  upload_hair();
}

void DeviceFrame::upload_hair() {
  for (std::size_t i = 0; i < texture_.size(); ++i) {
    if (texture_.density[i] > 0.0F) texel_.push_back(i);
  }
  if (texel_.empty()) texel_.push_back(0);
  while (texel_.size() % lanes != 0) texel_.push_back(texel_.back());
  items_ = static_cast<int>(texel_.size()) / lanes;
  const auto coefficients = static_cast<std::size_t>(harmonics_in(transfer_.bands));
  std::vector<float> hair(texel_.size() * 6), values(texel_.size() * coefficients),
      depth(texel_.size());
  std::vector<int> place(texel_.size());
  const int width = texture_.width, stride = width + 1;
  for (std::size_t k = 0; k < texel_.size(); ++k) {
    const std::size_t i = texel_[k], item = k / lanes, lane = k % lanes;
    const Eigen::Array3d own = colour_.at(texture_.depth[i], texture_.shade[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      hair[(6 * item + c) * lanes + lane] = static_cast<float>(own[static_cast<int>(c)]);
      hair[(6 * item + 3 + c) * lanes + lane] = texture_.tangent[i][static_cast<int>(c)];
    }
    for (std::size_t c = 0; c < coefficients; ++c) {
      values[(coefficients * item + c) * lanes + lane] = transfer_.values[i * coefficients + c];
    }
    depth[k] = static_cast<float>(transfer_.r * texture_.layer_height) * texture_.density[i];
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width % width;
    place[k] = (static_cast<int>(i) / width / width * stride + y) * stride + x;
  }
  hair_ = uploaded(context_, hair);
  transfer_values_ = uploaded(context_, values);
  depth_ = uploaded(context_, depth);
  lit_ = context_.allocate(3 * texel_.size() * sizeof(float));
  place_ = context_.allocate(place.size() * sizeof(int));
  context_.write(place_, place.data(), place_.bytes());
}

/// Layers with hair among the four texels of a group's pixels, whose first one lies there and whose
/// last one is so many texels away.
void DeviceFrame::mark_filled(const Eigen::Array2d& group) {
  const int width = texture_.width;
  const auto reach = [&](double texels) {
    return std::min(static_cast<int>(std::ceil(std::max(0.0, texels))), width - 1);
  };
  const std::array<int, 4> marks{reach(-group.x()), reach(group.x()) + 1, reach(-group.y()),
                                 reach(group.y()) + 1};
  if (marks == marked_) return;
  marked_ = marks;
  const auto size = static_cast<std::size_t>(width);
  std::vector<std::uint64_t> own(size * size), along(size * size), all(size * size);
  for (std::size_t i = 0; i < texture_.size(); ++i) {
    if (texture_.density[i] > 0.0F) own[i % (size * size)] |= std::uint64_t{1} << i / size / size;
  }
  for (int y = 0; y < width; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int d = -marks[0]; d <= marks[1]; ++d) {
        along[static_cast<std::size_t>(y * width + x)] |=
            own[static_cast<std::size_t>(y * width + (x + d + width) % width)];
      }
    }
  }
  for (int y = 0; y < width; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int d = -marks[2]; d <= marks[3]; ++d) {
        all[static_cast<std::size_t>(y * width + x)] |=
            along[static_cast<std::size_t>((y + d + width) % width * width + x)];
      }
    }
  }
  context_.write(filled_, all.data(), filled_.bytes());
}

void DeviceFrame::light(const PlaceLight& light, const Vector3d& eye,
                        const HairReflectance& reflectance) {
  if (reflectance.model() == HairModel::kajiya_kay) {
    const auto size = static_cast<std::size_t>(harmonics_in(transfer_.bands));
    std::vector<float> sky, lamps, norm;
    for (std::size_t k = 0; k < size; ++k) {
      for (int c = 0; c < 3; ++c) {
        sky.push_back(static_cast<float>(light.coefficients(static_cast<Eigen::Index>(k), c)));
      }
    }
    for (std::size_t i = 0; i < light.lamps.size(); ++i) {
      for (int c = 0; c < 3; ++c) lamps.push_back(static_cast<float>(light.lamps[i].direction[c]));
      for (int c = 0; c < 3; ++c) lamps.push_back(static_cast<float>(light.lamps[i].irradiance[c]));
      for (std::size_t k = 0; k < size; ++k) {
        lamps.push_back(static_cast<float>(
            light.coefficients(static_cast<Eigen::Index>(k), 3 + static_cast<Eigen::Index>(i))));
      }
    }
    if (lamps.empty()) lamps.push_back(0.0F);
    for (const double value : reflectance.norms()) norm.push_back(static_cast<float>(value));
    context_.launch(*program_, "light", device::Range{static_cast<std::size_t>(items_), 1, 64, 1},
                    items_, hair_, transfer_values_, uploaded(context_, sky),
                    static_cast<int>(light.lamps.size()), uploaded(context_, lamps),
                    static_cast<float>(eye.x()), static_cast<float>(eye.y()),
                    static_cast<float>(eye.z()), static_cast<float>(reflectance.shine()),
                    uploaded(context_, norm), lit_);
  } else {
    const LitHair hair{texture_, transfer_, colour_, reflectance};
    std::vector<float> lit(3 * texel_.size());
    for (std::size_t k = 0; k < texel_.size(); ++k) {
      const Eigen::Array3d radiance = hair.radiance(texel_[k], light, eye);
      for (std::size_t c = 0; c < 3; ++c) {
        lit[(3 * (k / lanes) + c) * lanes + k % lanes] =
            static_cast<float>(radiance[static_cast<int>(c)]);
      }
    }
    context_.write(lit_, lit.data(), lit_.bytes());
  }
  context_.look(lit_, lit_.bytes(), [&](const void* memory) {
    const Eigen::Map<const Eigen::ArrayXf> values(static_cast<const float*>(memory),
                                                  static_cast<Eigen::Index>(3 * texel_.size()));
    white_ = std::max(static_cast<double>(values.maxCoeff()), 1e-30);
  });
}

void DeviceFrame::draw(const Vector3d& eye, const Vector3d& target, double fov_deg,
                       bool every_pixel) {
  const Vector3d forward = (target - eye).normalized();
  const double half = std::tan(0.5 * fov_deg * std::numbers::pi / 180.0);
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized() * half * width_ / height_;
  const Vector3d up = right.normalized().cross(forward) * half;
  const double tile = texture_.width, high = texture_.layer_height;
  std::vector<float> shape{static_cast<float>((eye.x() - 0.5) / tile),
                           static_cast<float>((eye.y() - 0.5) / tile),
                           static_cast<float>(eye.z() / high - (texture_.layers - 0.5))};
  for (const Vector3d& v : {forward, right, up}) {
    shape.push_back(static_cast<float>(v.x() / tile));
    shape.push_back(static_cast<float>(v.y() / tile));
    shape.push_back(static_cast<float>(v.z() / high));
  }
  // A row's rays have one z, so that a pixel's step over a shell is along `right`.
  double least = 1e30, most = 1.0, farthest = 0.0, widest = 0.0;
  for (double u = -1.0; u <= 1.0; u += 0.125) {
    for (double v = -1.0; v <= 1.0; v += 0.125) {
      const Vector3d d = forward + u * right + v * up;
      const double slant = d.z() < -1e-3 ? -d.norm() / d.z() : 1e3;
      least = std::min(least, slant);
      most = std::max(most, slant);
      if (d.z() >= -1e-3) continue;
      const double way = -eye.z() / d.z();
      const Vector3d down = way * (up - up.z() / d.z() * d);
      farthest = std::max(farthest, way);
      widest = std::max({widest, 2.0 * way * right.norm() / width_, 2.0 * down.norm() / height_});
    }
  }
  apart_ = every_pixel || widest > least_step ? 1 : 2;
  const double range = std::log2(most / least);
  const int slants =
      std::clamp(static_cast<int>(std::ceil(range / std::log2(slant_ratio))) + 1, 1, most_slants);
  std::vector<float> slant;
  const double step = slants > 1 ? range / (slants - 1) : 1.0;
  for (int k = 0; k < slants; ++k) {
    slant.push_back(static_cast<float>(least * std::exp2(k * step)));
  }
  mark_filled((lanes - 1) * apart_ * 2.0 / width_ * farthest * right.head<2>().array());
  context_.launch(*program_, "pack", device::Range{static_cast<std::size_t>(items_), 1, 64, 1},
                  items_, depth_, place_, lit_, static_cast<float>(1.0 / white_), slants,
                  uploaded(context_, slant), texels_);
  const std::vector<float> slant_of{static_cast<float>(std::log2(least)),
                                    static_cast<float>(1.0 / step), static_cast<float>(slants - 1),
                                    static_cast<float>(high / tile)};
  const int columns = apart_ == 1 ? width_ : halved(width_),
            rows = apart_ == 1 ? height_ : halved(height_), stride = padded(columns);
  const auto items = [](int pixels, int each) { return static_cast<std::size_t>(pixels / each); };
  context_.launch(*program_, "blend",
                  device::Range{items(stride, lanes), static_cast<std::size_t>(rows), 4, 4}, width_,
                  height_, apart_, stride, uploaded(context_, shape), uploaded(context_, slant_of),
                  texels_, filled_, apart_ == 1 ? seen_ : rays_);
  if (apart_ == 2) {
    context_.launch(
        *program_, "spread",
        device::Range{items(padded(width_), 2 * lanes), static_cast<std::size_t>(height_), 4, 4},
        height_, stride, rays_, padded(width_), seen_);
  }
  context_.finish();
}

Image<float> DeviceFrame::picture() {
  Image<float> picture(width_, height_, 3);
  const auto row = static_cast<std::size_t>(4 * padded(width_));
  look([&](const void* memory) {
    const auto* seen = static_cast<const std::uint16_t*>(memory);
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) {
        for (int c = 0; c < 3; ++c) {
          picture(x, y, c) = static_cast<float>(
              white_ / 65535.0 *
              seen[static_cast<std::size_t>(y) * row + static_cast<std::size_t>(4 * x + c)]);
        }
      }
    }
  });
  return picture;
}

}  // namespace kappamu::forward::shells
