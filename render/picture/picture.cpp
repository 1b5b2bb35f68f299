#include "render/picture/picture.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/parallel.h"
#include "core/random.h"
#include "render/linear_image.h"

namespace kappamu::render {

namespace {

constexpr int rows_per_update = 32;

}  // namespace

/// Of one pixel's samples.
struct PictureMaker::Sums {
  Colour radiance = Colour::Zero();
  double luminance = 0.0, luminance_squared = 0.0, covered = 0.0;

  void operator+=(const Sums& more) {
    radiance += more.radiance;
    luminance += more.luminance;
    luminance_squared += more.luminance_squared;
    covered += more.covered;
  }
};

namespace {

template <class Sums>
Sums sample_pixel(const Shading& shading, const LookAt& camera, const Film& film, int x, int y,
                  int first, int end, std::uint64_t seed) {
  const std::uint64_t key =
      key_of({seed, static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(x)});
  Sums sums;
  for (int i = first; i < end; ++i) {
    const auto sample = static_cast<std::uint32_t>(i);
    const auto [u, v] = sobol_point(sample, key);
    const Shading::Seen seen =
        shading.seen(camera.position(),
                     camera.direction((x + u) / film.width, (y + v) / film.height), sample, key);
    sums.radiance += seen.radiance;
    if (!seen.object) continue;
    const double bright = luminance(seen.radiance);
    sums.luminance += bright;
    sums.luminance_squared += bright * bright;
    sums.covered += 1.0;
  }
  return sums;
}

/// Relative root mean square standard error of covered pixels.
template <class Sums>
double standard_error(const std::vector<Sums>& pixels) {
  double variance = 0.0, mean = 0.0;
  std::size_t counted = 0;
  for (const Sums& sums : pixels) {
    if (sums.covered < 2.0) continue;
    const double here = sums.luminance / sums.covered;
    const double spread = std::max(0.0, sums.luminance_squared / sums.covered - here * here);
    variance += spread / (sums.covered - 1.0);
    mean += here;
    ++counted;
  }
  if (counted == 0 || mean <= 0.0) return 0.0;
  const auto count = static_cast<double>(counted);
  return std::sqrt(variance / count) / (mean / count);
}

}  // namespace

double picture_memory(const Film& film) {
  // Sums, the picture, and its copies in the files' forms.
  constexpr double bytes_per_pixel = 6 * sizeof(double) + 12 * sizeof(float);
  return bytes_per_pixel * film.width * film.height;
}

PictureMaker::PictureMaker(const Camera& camera, const Film& film, std::uint64_t seed)
    : look_(camera.position_mm, camera.target_mm, camera.up, camera.fov_deg,
            static_cast<double>(film.width) / film.height),
      film_(film),
      seed_(seed),
      pixels_(static_cast<std::size_t>(film.width) * static_cast<std::size_t>(film.height)) {}

PictureMaker::~PictureMaker() = default;

void PictureMaker::pass(const Shading& shading, Progress& progress) {
  const auto width = static_cast<std::size_t>(film_.width);
  const int end = std::min(film_.samples, std::max(1, 2 * rays_));
  for (int top = 0; top < film_.height; top += rows_per_update) {
    for_rows(std::min(rows_per_update, film_.height - top), [&](int row) {
      for (int x = 0; x < film_.width; ++x) {
        const int y = top + row;
        pixels_[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] +=
            sample_pixel<Sums>(shading, look_, film_, x, y, rays_, end, seed_);
      }
    });
    const double share = std::min(1.0, static_cast<double>(top + rows_per_update) / film_.height);
    progress.update("picture", (rays_ + share * (end - rays_)) / film_.samples, detail_);
  }
  rays_ = end;
  detail_ = std::to_string(end) + " rays per pixel, noise " +
            std::to_string(100.0 * standard_error(pixels_)).substr(0, 4) + " %";
}

Picture PictureMaker::picture() const {
  Picture picture{Image<float>(film_.width, film_.height, 3),
                  Image<float>(film_.width, film_.height, 1), standard_error(pixels_)};
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const Colour mean = (pixels_[i].radiance / rays_).max(0.0);
    for (std::size_t c = 0; c < 3; ++c) {
      picture.radiance.values()[3 * i + c] = static_cast<float>(mean[static_cast<int>(c)]);
    }
    picture.coverage.values()[i] = static_cast<float>(pixels_[i].covered / rays_);
  }
  return picture;
}

Picture render_picture(const Shading& shading, const Camera& camera, const Film& film,
                       std::uint64_t seed, Progress& progress) {
  PictureMaker maker(camera, film, seed);
  while (!maker.done()) maker.pass(shading, progress);
  return maker.picture();
}

double usual_exposure(const Picture& picture) {
  std::vector<double> bright;
  for (std::size_t i = 0; i < picture.coverage.size(); ++i) {
    if (picture.coverage.values()[i] < 1.0F) continue;
    const float* rgb = &picture.radiance.values()[3 * i];
    bright.push_back(luminance({rgb[0], rgb[1], rgb[2]}));
  }
  if (bright.empty()) return 1.0;
  const auto high = bright.begin() + static_cast<std::ptrdiff_t>(0.95 * (bright.size() - 1.0));
  std::nth_element(bright.begin(), high, bright.end());
  return *high > 0.0 ? 0.6 / *high : 1.0;
}

Image<std::uint8_t> tone_mapped(const Image<float>& radiance, double exposure) {
  constexpr double shoulder = 0.6;
  Image<std::uint8_t> image(radiance.width(), radiance.height(), 3);
  for (std::size_t i = 0; i < image.size(); i += 3) {
    const float* rgb = &radiance.values()[i];
    Colour colour = (exposure * Colour(rgb[0], rgb[1], rgb[2])).max(0.0);
    const double brightest = colour.maxCoeff();
    if (brightest > shoulder) {
      const double room = 1.0 - shoulder;
      colour *= (shoulder + room * (1.0 - std::exp(-(brightest - shoulder) / room))) / brightest;
    }
    for (int c = 0; c < 3; ++c) {
      image.values()[i + static_cast<std::size_t>(c)] =
          static_cast<std::uint8_t>(std::lround(255.0 * srgb_encoded(colour[c])));
    }
  }
  return image;
}

}  // namespace kappamu::render
