// Frames by OpenCL against frames by C++, in one run; fewer shells against all of them.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/processor_time.h"
#include "forward/shells/detail.h"
#include "forward/shells/device_frame.h"
#include "render/look_at.h"
#include "studies/record.h"
#include "studies/shells/shells_bench.h"

namespace kappamu::studies {

using namespace forward::shells;
using Eigen::Array3d;
using Eigen::Vector3d;

namespace {

struct Cost {
  std::vector<double> wall, processor;
  void add(const std::function<void()>& work) {
    const Stopwatch watch;
    const double before = processor_seconds();
    work();
    wall.push_back(watch.seconds());
    processor.push_back(processor_seconds() - before);
  }
  Json row(const std::string& step) const {
    // Other work on the machine only adds: the least is the step's own.
    const double least = *std::min_element(processor.begin(), processor.end());
    return {{"step", step},
            {"median seconds", median(wall)},
            {"least processor seconds", least},
            {"frames a second by two idle cores", 2.0 / least}};
  }
};

/// Per ray of a frame, until a hundredth of the skin's light is left: shells passed, and those with
/// hair among the four texels of a lookup, which are fetched.
struct Fetched {
  double passed = 0.0, with_hair = 0.0;
};
Fetched fetched(const HairTexture& texture, double r, const FlatView& view) {
  const render::LookAt look(view.eye, view.target, Vector3d::UnitZ(), view.fov_deg,
                            static_cast<double>(view.width) / view.height);
  constexpr int across = 128, down = 96;
  Fetched sum;
  for (int i = 0; i < across * down; ++i) {
    const Vector3d d =
        look.direction((i % across + 0.5) / across, (i / across + 0.5) / down).normalized();
    double left = 1.0;
    for (int layer = texture.layers - 1; layer >= 0 && left > 0.01; --layer) {
      const Vector3d at =
          view.eye + ((layer + 0.5) * texture.layer_height - view.eye.z()) / d.z() * d;
      const ShellTexels met = on_shell(texture, at.x(), at.y(), layer);
      sum.passed += 1.0 / (across * down);
      if (met.density > 0.0) sum.with_hair += 1.0 / (across * down);
      left *= 1.0 - opacity(texture, r, met.density, -d.z());
    }
  }
  return sum;
}

/// Mean |a − b| over mean b, and the largest |a − b| over the largest b.
struct Apart {
  double mean = 0.0, largest = 0.0;
};
Apart apart(const Image<float>& a, const Image<float>& b) {
  double difference = 0.0, sum = 0.0, most = 0.0, brightest = 0.0;
  for (std::size_t p = 0; p < b.values().size(); ++p) {
    const auto here = static_cast<double>(b.values()[p]);
    const double off = std::abs(static_cast<double>(a.values()[p]) - here);
    difference += off;
    sum += here;
    most = std::max(most, off);
    brightest = std::max(brightest, here);
  }
  return {difference / sum, most / brightest};
}

}  // namespace

void fur_speed(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  HairOptions options;
  options.seed = request.seed;
  if (quick) options.coats = {{5000, 0.10, 0.22, 0.5, 1.0, 0.3}};
  HairTexture texture;
  Transfer transfer;
  Cost loom, march, lit, drawn, device_lit, device_every, device_drawn;
  const TransferOptions rays{5, quick ? 16 : 64, 0.0};
  loom.add([&] { texture = make_hair_texture(options); });
  march.add([&] { transfer = make_transfer(texture, rays, progress); });
  constexpr int width = 1280, height = 1024;
  const HairColour colour;
  const FrameDrawer drawer(texture, transfer, colour, width, height);
  device::Context& context = device::Context::chosen(request.device);
  DeviceFrame frame(context, texture, transfer, colour, width, height);
  const HairReflectance reflectance(HairModel::kajiya_kay);
  const Vector3d eye(32.0, -70.0, 110.0), target(32.0, 32.0, 0.0);
  const Vector3d towards = (eye - target).normalized();
  const FlatView view{eye, target, 35.0, width, height, 1};
  Apart lookups, between;
  for (int i = 0; i < (quick ? 2 : 10); ++i) {
    const double angle = 0.4 * i;
    const PlaceLight light = light_of(
        5,
        {{Vector3d(std::cos(angle), std::sin(angle), 1.0).normalized(), Array3d::Constant(3.0)}});
    FrameDrawer::Texels texels;
    lit.add([&] { texels = drawer.lit(light, towards, reflectance); });
    Image<float> host;
    drawn.add([&] { host = drawer.drawn(texels, eye, target, 35.0); });
    device_lit.add([&] { frame.light(light, towards, reflectance); });
    device_every.add([&] { frame.draw(eye, target, 35.0, true); });
    const Image<float> every = frame.picture();
    device_drawn.add([&] { frame.draw(eye, target, 35.0); });
    lookups = apart(every, host);
    between = apart(frame.picture(), every);
  }
  const Fetched per_ray = fetched(texture, transfer.r, view);
  Json rows = Json::array({loom.row("texture"),
                           march.row("transfer, " + std::to_string(rays.rays) + " rays"),
                           lit.row("light all texels, C++"), drawn.row("draw 1280 x 1024, C++"),
                           device_lit.row("light all texels, OpenCL"),
                           device_every.row("draw 1280 x 1024, OpenCL, a ray per pixel"),
                           device_drawn.row("draw 1280 x 1024, OpenCL")});
  save({{"rows", rows},
        {"device", context.info().name},
        {"rays are apart [pixel]", frame.rays_apart()},
        {"shells that a ray passes", per_ray.passed},
        {"shells with hair, of which four texels are fetched", per_ray.with_hair},
        {"mean difference of OpenCL and C++, by their lookups", lookups.mean},
        {"mean difference by pixels between rays", between.mean},
        {"largest difference by pixels between rays, of the brightest", between.largest}});
}

void fur_detail(const Request& request, Progress& progress, const Save& save) {
  const bool quick = request.size == Size::quick;
  HairOptions options;
  options.seed = request.seed;
  if (quick) {
    options.width = options.layers = 16;
    options.coats = {{800, 0.04, 0.10, 0.1, 0.45, 0.3}, {120, 0.10, 0.22, 0.5, 1.0, 0.3}};
  }
  const HairTexture texture = make_hair_texture(options);
  const Transfer transfer = make_transfer(texture, {5, quick ? 16 : 64, 0.0}, progress);
  const Eigen::MatrixXd light = projected(four_lights()[1], 5);
  const HairColour colour;
  const LitLevels lit = lit_levels(texture, transfer.r, [&](std::size_t texel) -> Array3d {
    return colour.at(texture.depth[texel], texture.shade[texel]) *
           std::max(0.0, transfer.lit(texel, light)[0]);
  });
  const double tile = options.width;
  Json rows = Json::array();
  const auto view_of = [&](bool grazing, int samples) {
    const Vector3d eye = grazing ? Vector3d(0.5 * tile, -3.0 * tile, 0.9 * tile)
                                 : Vector3d(0.5 * tile, -1.3 * tile, 2.5 * tile);
    return FlatView{eye,
                    {0.5 * tile, 0.5 * tile, 0.0},
                    20.0,
                    quick ? 16 : 64,
                    quick ? 16 : 48,
                    quick ? 2 : samples};
  };
  const auto picture = [&](const FlatView& view, const ShellDetail& detail) {
    return flat_picture(view, [&](const Vector3d& from, const Vector3d& d) {
      return seen_by_detail(lit, detail, from, d);
    });
  };
  // The mean of one view by the shells of distances 1 % apart: what changes is their number alone.
  const auto popping = [&](bool grazing) {
    double before = 0.0, largest = 0.0;
    for (double texels = 1.0; texels < (quick ? 1.2 : 10.0); texels *= 1.01) {
      const Image<float> seen =
          picture(view_of(grazing, 4), ShellDetail::of(texture.layers, texture.height() / texels));
      double mean = 0.0;
      for (const float value : seen.values()) mean += static_cast<double>(value);
      if (before > 0.0) largest = std::max(largest, std::abs(mean - before) / before);
      before = mean;
    }
    return largest;
  };
  const double pops_above = popping(false), pops_grazing = popping(true);
  for (const bool grazing : {false, true}) {
    for (const double texels_per_pixel : {1.0, 1.5, 2.0, 3.0, 4.0, 8.0}) {
      FlatView view = view_of(grazing, 16);
      // As far away as makes a pixel that wide.
      const Vector3d arm = view.eye - view.target;
      const double pixel =
          2.0 * arm.norm() * std::tan(view.fov_deg * std::numbers::pi / 360.0) / view.height;
      view.eye = view.target + texels_per_pixel / pixel * arm;
      const ShellDetail all{texture.layers, 0.0},
          fewer = ShellDetail::of(texture.layers, texture.height() / texels_per_pixel);
      const Image<float> truth = picture(view, all), seen = picture(view, fewer);
      double difference = 0.0, total = 0.0, mean = 0.0;
      for (std::size_t p = 0; p < truth.values().size(); ++p) {
        const auto t = static_cast<double>(truth.values()[p]);
        difference += std::abs(static_cast<double>(seen.values()[p]) - t);
        mean += static_cast<double>(seen.values()[p]) - t;
        total += t;
      }
      rows.push_back({{"view", grazing ? "grazing" : "above"},
                      {"texels per pixel", texels_per_pixel},
                      {"shells", fewer.drawn()},
                      {"error of pixels", difference / total},
                      {"error of the mean", mean / total}});
      save({{"rows", rows},
            {"largest change of the mean by 1 % of distance, from above", pops_above},
            {"the same, grazing", pops_grazing}});
    }
  }
}

}  // namespace kappamu::studies
