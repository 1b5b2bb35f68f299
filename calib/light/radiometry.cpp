#include "calib/light/radiometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "calib/light/shared_error.h"
#include "calib/sample/face.h"
#include "core/error.h"
#include "core/numbers/linear_algebra.h"

namespace kappamu::calib {
namespace {

using Terms = Eigen::Matrix<double, FlatField::terms, 1>;

Terms monomials(double x, double y) {
  std::array<double, FlatField::degree + 1> of_x{1.0}, of_y{1.0};
  for (std::size_t n = 1; n < of_x.size(); ++n) {
    of_x[n] = of_x[n - 1] * x;
    of_y[n] = of_y[n - 1] * y;
  }
  Terms terms;
  int k = 0;
  for (std::size_t order = 0; order < of_x.size(); ++order) {
    for (std::size_t j = 0; j <= order; ++j) terms[k++] = of_x[order - j] * of_y[j];
  }
  return terms;
}

/// A pixel whose centre shows a point of the lit face, at x, y in [-1, 1].
struct FacePixel {
  int px = 0;
  int py = 0;
  double x = 0.0;
  double y = 0.0;
};

/// Of a face that has many, those of an even lattice: more add nothing to smooth light.
std::vector<FacePixel> pixels_of_face(const Lens& camera, const Rigid& camera_from_sample,
                                      const GridShape& grid, Face face) {
  const auto corners = face_corners(grid, face);
  std::array<Eigen::Vector2d, 4> outline;
  for (std::size_t k = 0; k < 4; ++k) outline[k] = camera.project(camera_from_sample * corners[k]);
  const Rigid sample_from_camera = camera_from_sample.inverse();
  const Eigen::Vector3d& eye = sample_from_camera.translation;
  const Eigen::Vector3d normal = face_normal(face);
  const Eigen::Vector3d middle = 0.5 * (corners[0] + corners[2]);
  const Eigen::Vector3d half_u = 0.5 * (corners[1] - corners[0]);
  const Eigen::Vector3d half_v = 0.5 * (corners[3] - corners[0]);
  constexpr double most_pixels = 2e6;
  const std::vector<std::array<int, 2>> inside =
      pixels_inside(outline, camera.width, camera.height);
  const int step = static_cast<int>(std::ceil(std::sqrt(inside.size() / most_pixels)));
  std::vector<FacePixel> pixels;
  for (const auto& [px, py] : inside) {
    if (px % step != 0 || py % step != 0) continue;
    const Eigen::Vector3d ray = sample_from_camera.rotation * camera.unproject({px, py});
    const Eigen::Vector3d point = eye + ray * ((middle - eye).dot(normal) / ray.dot(normal));
    const double x = (point - middle).dot(half_u) / half_u.squaredNorm();
    const double y = (point - middle).dot(half_v) / half_v.squaredNorm();
    if (std::abs(x) <= 1.0 && std::abs(y) <= 1.0) pixels.push_back({px, py, x, y});
  }
  return pixels;
}

constexpr std::uint8_t unusable = capture::pixel_saturated | capture::pixel_missing;

/// Means of one channel of two pictures over the voxels of a face, the second perhaps a model.
class FaceMeans {
 public:
  explicit FaceMeans(const FaceShape& shape)
      : shape_(shape), sums_(shape.cells(), Eigen::Array<double, 5, 1>::Zero()) {}

  void add(const FacePixel& p, double first, double first_variance, double second,
           double second_variance) {
    const int u = std::min(shape_.nu - 1, static_cast<int>(0.5 * (p.x + 1.0) * shape_.nu));
    const int v = std::min(shape_.nv - 1, static_cast<int>(0.5 * (p.y + 1.0) * shape_.nv));
    Eigen::Array<double, 5, 1> one;
    one << first, first_variance, second, second_variance, 1.0;
    sums_[static_cast<std::size_t>(v) * shape_.nu + u] += one;
  }

  /// Of first over second, relative to their mean ratio.
  FaceMap ratio() const {
    FaceMap map{shape_, std::vector<double>(shape_.cells(), 0.0),
                std::vector<double>(shape_.cells(), 0.0)};
    double first = 0.0, second = 0.0;
    for (const auto& sum : sums_) {
      first += sum[0];
      second += sum[2];
    }
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const auto& sum = sums_[i];
      if (!(sum[0] > 0.0 && sum[2] > 0.0 && first > 0.0 && second > 0.0)) continue;
      map.relative[i] = sum[0] / sum[2] * (second / first) - 1.0;
      map.variance[i] = sum[1] / (sum[0] * sum[0]) + sum[3] / (sum[2] * sum[2]);
    }
    return map;
  }

 private:
  FaceShape shape_;
  std::vector<Eigen::Array<double, 5, 1>> sums_;
};

/// Mean signal of the good pixels of a quadrilateral; nothing if fewer than half are good.
std::optional<double> mean_signal(const capture::HdrImage& image,
                                  const std::array<Eigen::Vector2d, 4>& corners, int channel) {
  std::array<Eigen::Vector2d, 4> here = corners;
  for (Eigen::Vector2d& corner : here) corner -= Eigen::Vector2d(image.left, image.top);
  const auto pixels = pixels_inside(here, image.radiance.width(), image.radiance.height());
  double sum = 0.0;
  std::size_t good = 0;
  for (const auto& [x, y] : pixels) {
    if ((image.flags(x, y, channel) & unusable) != 0) continue;
    sum += image.radiance(x, y, channel);
    ++good;
  }
  if (good == 0 || 2 * good < pixels.size()) return std::nullopt;
  return sum / static_cast<double>(good);
}

}  // namespace

double FlatField::operator()(double x, double y) const {
  const Terms powers = monomials(x, y);
  double sum = 0.0;
  for (int k = 0; k < terms; ++k) sum += coefficients[k] * powers[k];
  return sum;
}

WhiteReference measure_white(const capture::HdrImage& white,
                             const std::optional<capture::HdrImage>& black, double reflectance,
                             const Lens& camera, const Rigid& camera_from_sample,
                             const GridShape& grid, Face lit_face, const std::string& name) {
  const int channels = white.radiance.channels();
  const std::vector<FacePixel> pixels =
      pixels_of_face(camera.of_part(white.place()), camera_from_sample, grid, lit_face);
  WhiteReference result;
  Terms flat = Terms::Zero();
  double white_sum = 0.0;
  double black_sum = 0.0;
  double shared = 0.0;
  for (int c = 0; c < channels; ++c) {
    Eigen::Matrix<double, FlatField::terms, FlatField::terms> normal;
    normal.setZero();
    Terms right = Terms::Zero();
    std::size_t used = 0;
    for (const FacePixel& p : pixels) {
      if ((white.flags(p.px, p.py, c) & unusable) != 0) continue;
      const Terms terms = monomials(p.x, p.y);
      normal.noalias() += terms * terms.transpose();
      right += terms * static_cast<double>(white.radiance(p.px, p.py, c));
      ++used;
      if (black && (black->flags(p.px, p.py, c) & unusable) == 0) {
        white_sum += white.radiance(p.px, p.py, c);
        black_sum += black->radiance(p.px, p.py, c);
      }
    }
    if (used < std::size_t{4} * FlatField::terms || 2 * used < pixels.size()) {
      throw InputError(name +
                       ": the white target is saturated or out of the picture over most of "
                       "the lit face; add shorter exposures, or move camera or target");
    }
    const Terms fit = solve_symmetric(normal, right);
    double squares = 0.0;
    FaceMeans means(face_shape(grid, lit_face));
    for (const FacePixel& p : pixels) {
      if ((white.flags(p.px, p.py, c) & unusable) != 0) continue;
      const double expected = fit.dot(monomials(p.x, p.y));
      const double residual = static_cast<double>(white.radiance(p.px, p.py, c)) - expected;
      squares += residual * residual;
      means.add(p, white.radiance(p.px, p.py, c), white.variance(p.px, p.py, c), expected, 0.0);
    }
    shared += std::pow(octave_error(means.ratio()), 2) / channels;
    const double centre = fit[0];
    if (!(centre > 0.0)) {
      throw InputError(name +
                       ": the white target is dark at the centre of the lit face; check "
                       "that the projector showed full white");
    }
    result.scale.push_back(centre * std::numbers::pi / reflectance);
    result.residual_rms.push_back(std::sqrt(squares / static_cast<double>(used)) / centre);
    result.pixels = std::max(result.pixels, used);
    flat += fit / centre / channels;
  }
  for (int k = 0; k < FlatField::terms; ++k) result.flat.coefficients[k] = flat[k];
  if (std::isfinite(shared)) result.smooth_error = std::sqrt(shared);
  if (black && white_sum > 0.0) {
    // A projector cannot give less than no light; noise can.
    result.projector_black = std::max(0.0, black_sum / white_sum);
    result.black_measured = true;
  }
  return result;
}

std::vector<FaceMap> ratio_on_face(const capture::HdrImage& other, const capture::HdrImage& picture,
                                   const Lens& camera, const Rigid& camera_from_sample,
                                   const GridShape& grid, Face lit_face) {
  const std::vector<FacePixel> pixels =
      pixels_of_face(camera.of_part(picture.place()), camera_from_sample, grid, lit_face);
  std::vector<FaceMap> maps;
  for (int c = 0; c < picture.radiance.channels(); ++c) {
    FaceMeans means(face_shape(grid, lit_face));
    for (const FacePixel& p : pixels) {
      if (((other.flags(p.px, p.py, c) | picture.flags(p.px, p.py, c)) & unusable) != 0) continue;
      means.add(p, other.radiance(p.px, p.py, c), other.variance(p.px, p.py, c),
                picture.radiance(p.px, p.py, c), picture.variance(p.px, p.py, c));
    }
    maps.push_back(means.ratio());
  }
  return maps;
}

std::vector<double> centre_signal(const capture::HdrImage& target, const FlatField& flat,
                                  const Lens& camera, const Rigid& camera_from_sample,
                                  const GridShape& grid, Face lit_face, const std::string& name) {
  const std::vector<FacePixel> pixels =
      pixels_of_face(camera.of_part(target.place()), camera_from_sample, grid, lit_face);
  std::vector<double> signals;
  for (int c = 0; c < target.radiance.channels(); ++c) {
    double signal = 0.0;
    double light = 0.0;
    for (const FacePixel& p : pixels) {
      if ((target.flags(p.px, p.py, c) & unusable) != 0) continue;
      signal += target.radiance(p.px, p.py, c);
      light += flat(p.x, p.y);
    }
    if (!(light > 0.0)) {
      throw InputError(name +
                       ": the white target is saturated over the whole lit face; add "
                       "shorter exposures");
    }
    signals.push_back(signal / light);
  }
  return signals;
}

ChartReference measure_chart(const capture::HdrImage& chart, const ChartPatches& patches,
                             const capture::HdrImage* white, double white_reflectance,
                             const std::vector<double>& white_scale) {
  constexpr std::size_t first_neutral = 18;
  constexpr double darkest_compared = 0.05;  // glare and the frame's scatter rule below
  const int channels = chart.radiance.channels();
  const std::array<double, 6> published = neutral_reflectances();
  ChartReference result;
  result.patches = patches;
  for (std::size_t k = 0; k < 6; ++k) {
    result.neutrals.push_back({static_cast<int>(first_neutral + k), published[k], {}});
  }
  double squares = 0.0;
  int compared = 0;
  for (int c = 0; c < channels; ++c) {
    // By least squares over the neutrals: signal = scale ρ E / π.
    double numerator = 0.0;
    double denominator = 0.0;
    std::array<std::optional<double>, 6> signal_at_one;
    for (std::size_t k = 0; k < 6; ++k) {
      const auto& middle = patches.middles[first_neutral + k];
      const std::optional<double> signal = mean_signal(chart, middle, c);
      if (!signal) continue;
      double irradiance = 1.0;
      if (white != nullptr) {
        const std::optional<double> white_signal = mean_signal(*white, middle, c);
        if (!white_signal) continue;
        irradiance = *white_signal * std::numbers::pi / (white_reflectance * white_scale[c]);
        constexpr double least_light = 0.1;  // else the target does not reach this patch
        if (irradiance < least_light) continue;
      }
      signal_at_one[k] = *signal / irradiance;
      numerator += *signal_at_one[k] * published[k];
      denominator += published[k] * published[k];
    }
    if (!(numerator > 0.0)) {  // no neutral patch can be used in this channel
      result.scale.clear();
      break;
    }
    result.scale.push_back(numerator / denominator * std::numbers::pi);
    const double reference = white != nullptr ? white_scale[c] : result.scale.back();
    for (std::size_t k = 0; k < 6; ++k) {
      if (!signal_at_one[k]) continue;
      const double measured = *signal_at_one[k] * std::numbers::pi / reference;
      result.neutrals[k].measured.push_back(measured);
      if (published[k] > darkest_compared) {
        squares += std::pow(measured / published[k] - 1.0, 2);
        ++compared;
      }
    }
  }
  // A patch unusable in one channel is left out of the table in all.
  for (NeutralPatch& neutral : result.neutrals) {
    if (static_cast<int>(neutral.measured.size()) != channels) neutral.measured.clear();
  }
  result.residual_rms = compared > 0 ? std::sqrt(squares / compared) : 0.0;
  return result;
}

}  // namespace kappamu::calib
