// Lights and views that fur's measurements share, and [K]'s figures.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/parallel.h"
#include "core/random.h"
#include "forward/shells/frame.h"
#include "io/image/image_file.h"
#include "render/look_at.h"
#include "render/picture/picture.h"
#include "studies/shells/shells_bench.h"

namespace kappamu::studies {

using namespace forward::shells;
using Eigen::Array3d;
using Eigen::Vector3d;
using std::numbers::pi;

std::vector<SkyLight> four_lights() {
  const auto lobe = [](double degrees, double power) {
    const double angle = degrees * pi / 180.0;
    // Beside no axis of symmetry of the texture.
    const Vector3d axis(std::sin(angle) * std::cos(0.7), std::sin(angle) * std::sin(0.7),
                        std::cos(angle));
    return [axis, power](const Vector3d& d) { return std::pow(std::max(0.0, d.dot(axis)), power); };
  };
  return {{"even sky", [](const Vector3d&) { return 1.0; }},
          {"lobe at 45 deg", lobe(45.0, 4.0)},
          {"lobe at 75 deg", lobe(75.0, 4.0)},
          {"small lobe at 45 deg", lobe(45.0, 64.0)}};
}

Eigen::MatrixXd projected(const SkyLight& light, int bands) {
  const std::vector<Vector3d> directions = even_directions(65'536);
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(harmonics_in(bands), 1);
  for (const Vector3d& d : directions) {
    coefficients +=
        4.0 * pi / static_cast<double>(directions.size()) * light.radiance(d) * harmonics(bands, d);
  }
  return coefficients;
}

Image<float> flat_picture(const FlatView& view, const SeenAlong& seen) {
  const render::LookAt look(view.eye, view.target, Vector3d::UnitZ(), view.fov_deg,
                            static_cast<double>(view.width) / view.height);
  Image<float> picture(view.width, view.height, 3);
  for_rows(view.height, [&](int y) {
    for (int x = 0; x < view.width; ++x) {
      Array3d sum = Array3d::Zero();
      const std::uint64_t key =
          key_of({static_cast<std::uint64_t>(y), static_cast<std::uint64_t>(x)});
      for (int s = 0; s < view.samples; ++s) {
        const auto [u, v] = sobol_point(static_cast<std::uint32_t>(s), key);
        const Vector3d d = look.direction((x + u) / view.width, (y + v) / view.height);
        if (d.z() < 0.0) sum += seen(view.eye, d).radiance;
      }
      for (int c = 0; c < 3; ++c) picture(x, y, c) = static_cast<float>(sum[c] / view.samples);
    }
  });
  return picture;
}

namespace {

void write(const std::filesystem::path& file, Image<float> picture) {
  // The brightest per cent of pixels may bend towards white.
  std::vector<float> values = picture.values();
  const auto high = values.begin() + static_cast<std::ptrdiff_t>(0.97 * values.size());
  std::nth_element(values.begin(), high, values.end());
  io::write_image(file, render::tone_mapped(picture, *high > 0.0F ? 0.8 / *high : 1.0));
}

class Figures {
 public:
  Figures(const Request& request, Progress& progress)
      : request_(request), quick_(request.size == Size::quick) {
    if (quick_) {
      options_.width = options_.layers = 16;
      options_.coats = {{800, 0.04, 0.10, 0.1, 0.45, 0.3}, {120, 0.10, 0.22, 0.5, 1.0, 0.3}};
    }
    options_.seed = request.seed;
    texture_ = make_hair_texture(options_);
    transfer_ = make_transfer(texture_, {5, quick_ ? 64 : 1024, 0.0}, progress);
    const double tile = options_.width;
    view_ = {{0.5 * tile, -1.3 * tile, 2.0 * tile},
             {0.5 * tile, 0.5 * tile, 0.0},
             30.0,
             quick_ ? 40 : 800,
             quick_ ? 32 : 640,
             quick_ ? 1 : 4};
  }

  /// Every texel is lit once, for the view's middle; four rays a pixel.
  void draw(const std::string& name, const TexelRadiance& radiance) const {
    FrameDrawer::Texels lit(texture_.size(), Eigen::Array4f::Zero());
    for_pieces(lit.size(), 4096, [&](std::size_t, std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const float density = texture_.density[i];
        if (density <= 0.0F) continue;
        lit[i].head<3>() = density * radiance(i).cast<float>();
        lit[i][3] = density;
      }
    });
    const FrameDrawer drawer(texture_, transfer_, colour_, 2 * view_.width, 2 * view_.height);
    const Image<float> fine = drawer.drawn(lit, view_.eye, view_.target, view_.fov_deg);
    Image<float> picture(view_.width, view_.height, 3);
    for (int y = 0; y < 2 * view_.height; ++y) {
      for (int x = 0; x < 2 * view_.width; ++x) {
        for (int c = 0; c < 3; ++c) picture(x / 2, y / 2, c) += 0.25F * fine(x, y, c);
      }
    }
    write(request_.folder / (name + ".png"), picture);
  }

  /// Colour by depth, no light.
  TexelRadiance by_depth() const {
    return [this](std::size_t texel) -> Array3d {
      const double z = centre_of(texture_, texel).z() / texture_.height();
      return Array3d(0.95, 0.72, 0.45) * z;
    };
  }
  TexelRadiance lit(const Eigen::MatrixXd& light) const {
    return [this, light](std::size_t texel) -> Array3d {
      const double arriving = std::max(0.0, transfer_.lit(texel, light)[0]);
      return colour_.at(texture_.depth[texel], texture_.shade[texel]) * arriving;
    };
  }
  TexelRadiance marschner(const Lamp& lamp) const {
    return [this, light = light_of(5, {lamp})](std::size_t texel) -> Array3d {
      const Vector3d eye = (view_.eye - view_.target).normalized();
      return LitHair{texture_, transfer_, colour_, marschner_}.radiance(texel, light, eye);
    };
  }
  /// A few hairs, close by, in a texture of their own.
  void close_up(const std::string& name) const {
    HairOptions options = options_;
    options.coats = {{14, 0.3, 0.5, 0.6, 1.0, 0.6}};
    const HairTexture texture = make_hair_texture(options);
    FlatView view = view_;
    view.fov_deg = 24.0;
    write(request_.folder / (name + ".png"),
          flat_picture(view, [&](const Vector3d& origin, const Vector3d& direction) {
            return seen_by_shells(texture, texture.extinction, origin, direction,
                                  [&](std::size_t texel) -> Array3d {
                                    return colour_.at(texture.depth[texel], texture.shade[texel]);
                                  });
          }));
  }

 private:
  const Request& request_;
  bool quick_;
  HairOptions options_;
  HairTexture texture_;
  Transfer transfer_;
  HairColour colour_;
  HairReflectance marschner_{HairModel::marschner, 0.6};
  FlatView view_;
};

}  // namespace

void fur_figures(const Request& request, Progress& progress, const Save& save) {
  const Figures figures(request, progress);
  Json rows = Json::array();
  const auto add = [&](const std::string& name, const std::string& shows) {
    rows.push_back({{"picture", name}, {"shows", shows}});
    save({{"rows", rows}});
  };
  const auto lights = four_lights();
  figures.draw("fur-figure1-unlit", figures.by_depth());
  add("fur-figure1-unlit", "colour by depth, no light");
  figures.draw("fur-figure1-lit", figures.lit(projected(lights[1], 5)));
  add("fur-figure1-lit", "one lobe of light");
  figures.close_up("fur-figure3");
  add("fur-figure3", "a few hairs");
  int panel = 0;
  for (const auto& [l, m] : {std::pair{0, 0}, {1, 0}, {2, 1}, {4, -3}}) {
    Eigen::MatrixXd one = Eigen::MatrixXd::Zero(25, 1);
    one(l * (l + 1) + m) = 1.0;
    const std::string name = "fur-figure4-" + std::to_string(++panel);
    figures.draw(name, figures.lit(one));
    add(name, "light of Y(" + std::to_string(l) + ", " + std::to_string(m) + "), where positive");
  }
  panel = 0;
  for (const double angle : {-1.2, -0.5, 0.3, 1.0}) {
    const Vector3d towards = Vector3d(std::sin(angle), -0.6, 0.3 + 0.3 * panel).normalized();
    const std::string name = "fur-figure5-" + std::to_string(++panel);
    figures.draw(name, figures.marschner({towards, Array3d::Constant(3.0)}));
    add(name, "one lamp turned, Marschner's hair");
  }
}

}  // namespace kappamu::studies
