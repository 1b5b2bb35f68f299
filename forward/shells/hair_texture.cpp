#include "forward/shells/hair_texture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/error.h"
#include "core/random.h"
#include "forward/shells/circle_area.h"

namespace kappamu::forward::shells {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Horizontal cuts per layer, which antialias in height.
constexpr int cuts = 4;

void expect(bool holds, const std::string& sentence) {
  if (!holds) throw InputError("fur: " + sentence);
}

void expect_valid(const HairOptions& options) {
  expect(options.width >= 2 && options.width <= 1024, "width must be 2 to 1024 texels");
  expect(options.layers >= 1 && options.layers <= 256, "layers must be 1 to 256");
  expect(options.layer_height > 0.0 && options.layer_height <= 64.0,
         "layer_height must be above 0 and at most 64 texels");
  expect(!options.coats.empty(), "coats must not be empty");
  for (const HairCoat& coat : options.coats) {
    expect(coat.hairs >= 0 && coat.hairs <= 10'000'000, "hairs must be 0 to 10000000");
    expect(coat.least_radius > 0.0 && coat.most_radius >= coat.least_radius,
           "least_radius must be above 0 and at most most_radius");
    expect(coat.most_radius <= 0.5,
           "most_radius must be at most 0.5 texel: a hair is at most a texel wide; widen the "
           "texture");
    expect(
        coat.least_length > 0.0 && coat.most_length >= coat.least_length && coat.most_length <= 1.0,
        "least_length must be above 0, most_length at least that and at most 1");
    expect(coat.curl >= 0.0 && coat.curl <= 4.0, "curl must be 0 to 4");
  }
}

/// A hair's axis: root + lean·z + curl·(z/height)² ([K] 2.1), and its linear taper.
struct Hair {
  Vector2d root, lean, curl;  ///< [texel], dimensionless, [texel]
  double radius = 0, height = 0, shade = 0;

  Vector2d axis(double z) const { return root + lean * z + curl * (z * z / (height * height)); }
  Vector3d tangent(double z) const {
    const Vector2d slope = lean + curl * (2.0 * z / (height * height));
    return Vector3d(slope.x(), slope.y(), 1.0).normalized();
  }
  double radius_at(double z) const { return radius * (1.0 - z / height); }
};

class Loom {
 public:
  explicit Loom(const HairOptions& options) : options_(options) {
    made_.width = options.width;
    made_.layers = options.layers;
    made_.layer_height = options.layer_height;
    const std::size_t size = static_cast<std::size_t>(options.width) * options.width *
                             static_cast<std::size_t>(options.layers);
    area_.resize(size);
    depth_.resize(size);
    shade_.resize(size);
    tangent_.resize(size, Vector3d::Zero());
  }

  void add(const Hair& hair) {
    const double step = options_.layer_height / cuts;
    for (int cut = 0; cut < cuts * options_.layers; ++cut) {
      const double z = (cut + 0.5) * step;
      if (z >= hair.height) return;
      const double radius = hair.radius_at(z);
      width_ += 2.0 * radius;
      add_disc(hair, z, radius, cut / cuts);
    }
  }

  HairTexture finish() {
    double all = 0.0, lost = 0.0;
    made_.tangent.resize(area_.size());
    for (std::size_t i = 0; i < area_.size(); ++i) {
      const double area = area_[i];
      all += area;
      lost += std::max(0.0, area - 1.0);
      made_.density.push_back(static_cast<float>(std::min(1.0, area)));
      made_.depth.push_back(static_cast<float>(area > 0.0 ? depth_[i] / area : 0.0));
      made_.shade.push_back(static_cast<float>(area > 0.0 ? shade_[i] / area : 0.0));
      const double length = tangent_[i].norm();
      made_.tangent[i] = length > 0.0 ? Eigen::Vector3f((tangent_[i] / length).cast<float>())
                                      : Eigen::Vector3f(Eigen::Vector3f::Zero());
    }
    if (all > 0.0) {
      made_.extinction = width_ / cuts / all;
      made_.overfull = lost / all;
      made_.thin = thin_ / all;
    }
    return std::move(made_);
  }

 private:
  void add_disc(const Hair& hair, double z, double radius, int layer) {
    const Vector2d centre = hair.axis(z);
    const Vector3d tangent = hair.tangent(z);
    const int width = options_.width;
    const auto wrapped = [&](int i) { return ((i % width) + width) % width; };
    const int right = static_cast<int>(std::floor(centre.x() + radius));
    const int bottom = static_cast<int>(std::floor(centre.y() + radius));
    for (int y = static_cast<int>(std::floor(centre.y() - radius)); y <= bottom; ++y) {
      for (int x = static_cast<int>(std::floor(centre.x() - radius)); x <= right; ++x) {
        const double area = disc_in_rectangle(radius, x - centre.x(), y - centre.y(),
                                              x + 1 - centre.x(), y + 1 - centre.y()) /
                            cuts;
        const std::size_t i = made_.texel(wrapped(x), wrapped(y), layer);
        area_[i] += area;
        depth_[i] += area * z / hair.height;
        shade_[i] += area * hair.shade;
        tangent_[i] += area * tangent;
        if (radius < 0.05) thin_ += area;
      }
    }
  }

  const HairOptions& options_;
  HairTexture made_;
  std::vector<double> area_, depth_, shade_;  ///< per texel, the latter two weighted by area
  std::vector<Vector3d> tangent_;
  double width_ = 0.0, thin_ = 0.0;
};

Hair hair_of(const HairCoat& coat, const HairOptions& options, std::uint64_t key) {
  const auto random = [&](std::uint64_t i) { return uniform(key_of({key, i})); };
  Hair hair;
  const double x = random(0), y = random(1), thick = random(2);
  hair.root = Vector2d(x, y) * options.width;
  hair.radius = coat.least_radius + thick * (coat.most_radius - coat.least_radius);
  hair.height = (coat.least_length + thick * (coat.most_length - coat.least_length)) *
                options.layers * options.layer_height;
  const double angle = 2.0 * std::numbers::pi * random(3);
  hair.curl = coat.curl * random(4) * hair.height * Vector2d(std::cos(angle), std::sin(angle));
  hair.lean = options.lean ? options.lean(x, y) : Vector2d(Vector2d::Zero());
  hair.shade = random(5);
  return hair;
}

}  // namespace

HairTexture make_hair_texture(const HairOptions& options) {
  expect_valid(options);
  Loom loom(options);
  for (std::size_t c = 0; c < options.coats.size(); ++c) {
    for (int h = 0; h < options.coats[c].hairs; ++h) {
      loom.add(hair_of(options.coats[c], options,
                       key_of({options.seed, c, static_cast<std::uint64_t>(h)})));
    }
  }
  return loom.finish();
}

}  // namespace kappamu::forward::shells
