#include "studies/polygrid/live_frames.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/surface_norm.h"
#include "core/processor_time.h"
#include "forward/polygrid/live_polygrid.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "forward/polygrid/split_polygrid.h"

namespace kappamu::studies::live_frames {

using Eigen::Vector3d;
using forward::polygrid::PolygridDiffusion;

render::Scene scene_of(const std::string& mesh) {
  render::Scene scene;
  render::SceneObject object;
  object.name = "object";
  object.shape = std::filesystem::absolute(mesh);
  object.size_mm = live_mm;
  render::HomogeneousMaterial material;
  material.kappa_mm = 0.3;
  material.mu_per_mm = 0.003;  // a stroke multiplies it
  object.material = material;
  scene.objects.push_back(object);
  scene.camera.position_mm = 10.0 * live_mm * Vector3d::UnitZ();
  return scene;
}

double voxel_of(const TriangleMesh& mesh, std::size_t cells) {
  return std::cbrt(enclosed_volume(mesh) / static_cast<double>(cells));
}

forward::MediaOfChannels volume_of(const TriangleMesh& mesh, std::size_t cells) {
  forward::MediaOfChannels media;
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const double h = voxel_of(mesh, cells);
  const Eigen::Array3i n = (box.sizes() / h).array().ceil().cast<int>();
  const GridShape shape{n[0], n[1], n[2], h};
  for (std::size_t c = 0; c < 3; ++c) {
    const double channel = static_cast<double>(c);
    auto medium = std::make_shared<Medium>(Medium{Volume<double>(shape, 0.3 - 0.05 * channel),
                                                  Volume<double>(shape, 0.003 * (1 + channel))});
    for (int z = 0; z < shape.nz; ++z) {
      for (int y = 0; y < shape.ny; ++y) {
        for (int x = 0; x < shape.nx; ++x) {
          const std::size_t i = shape.index(x, y, z);
          const double factor =
              1.0 + 0.5 * std::sin(0.3 * x) * std::sin(0.2 * y) * std::cos(0.25 * z);
          medium->kappa[i] *= factor;
          medium->mu[i] *= factor;
        }
      }
    }
    const Eigen::Affine3d place(Eigen::Translation3d(-box.min()));
    media[c] = std::make_shared<ObjectMedium>(medium, place, Wrap::clamp);
  }
  return media;
}

forward::Polygrid grid_of(const render::World& world, int cells) {
  const TriangleMesh& mesh = world.objects()[0].mesh;
  Progress silent;
  forward::PolygridOptions options;
  options.cells = cells / 8;
  return forward::polygrid::split(forward::make_polygrid(mesh, options, silent).grid, mesh);
}

render::LightSources sun_at(double degrees) {
  render::DirectionalLight sun;
  const double angle = degrees * M_PI / 180.0;
  sun.direction = Vector3d(-std::sin(angle), -0.5, -std::cos(angle)).normalized();
  return render::make_light_sources({sun});
}

namespace {

void enter_at_surface(forward::ObjectLight& light, const Surface& surface) {
  light.diffuse.assign(surface.size(), 0.0);
  for (const forward::Beam& beam : light.beams) {
    const auto triangle = static_cast<std::size_t>(beam.triangle);
    light.diffuse[triangle] += beam.power / surface.area[triangle];
  }
  light.beams.clear();
}

}  // namespace

Live::Live(const render::World& world, forward::Polygrid grid, const std::string& device)
    : world_(world), object_(world.objects()[0]) {
  const double spacing = forward::LivePolygrid::beam_spacing_mm(object_.surface);
  places_ = render::beam_places(object_, {spacing, spacing});
  converged_places_ =
      render::beam_places(object_, {converged_spacing * spacing, converged_spacing * spacing});
  for (std::size_t t = 0; t < object_.surface.size(); ++t) {
    each_triangle_.push_back({static_cast<int>(t), object_.surface.position[t],
                              object_.surface.area[t] * object_.surface.normal[t]});
  }
  diffusion_ = std::make_unique<PolygridDiffusion>(std::move(grid), object_.mesh, object_.surface,
                                                   object_.boundary.eta, device,
                                                   forward::polygrid::Lights::moving);
}

void Live::set(const forward::MediaOfChannels& media) {
  media_ = media;
  diffusion_->set_media(
      std::array<const ObjectMedium*, 3>{media[0].get(), media[1].get(), media[2].get()});
}

Frame Live::frame(double degrees, Entry entry, const forward::MediaOfChannels* edited) {
  return answered(degrees, entry, edited, entry == Entry::beams ? places_ : each_triangle_,
                  forward::LivePolygrid::accuracy);
}

std::vector<Frame> Live::moved_frames(Entry entry) {
  std::vector<Frame> counted;
  for (int k = 0; k < frames_before + frames; ++k) {
    const Frame one = frame(first_degrees + degrees_per_frame * k, entry);
    if (k >= frames_before) counted.push_back(one);
  }
  return counted;
}

void Live::converge(double degrees, Entry entry) {
  answered(degrees, entry, nullptr, entry == Entry::beams ? converged_places_ : each_triangle_,
           converged);
}

std::array<double, 2> Live::error_of_last(double degrees, Entry entry) {
  const std::vector<double> live = exitance_;
  converge(degrees, entry);
  double largest = 0.0, most = 0.0;
  for (std::size_t t = 0; t < live.size(); ++t) {
    largest = std::max(largest, std::abs(live[t] - exitance_[t]));
    most = std::max(most, exitance_[t]);
  }
  return {surface_difference(object_.surface, live, exitance_) /
              surface_norm(object_.surface, exitance_),
          largest / most};
}

Frame Live::answered(double degrees, Entry entry, const forward::MediaOfChannels* edited,
                     std::span<const render::BeamPlace> places,
                     const forward::polygrid::PolygridAccuracy& accuracy) {
  const Stopwatch watch;
  const double before = processor_seconds();
  if (edited != nullptr) set(*edited);
  const double media = edited != nullptr ? processor_seconds() - before : 0.0;
  const render::LightSources sources = sun_at(degrees);
  const forward::LightOfChannels light = render::beams_at(world_, 0, sources, places);
  std::array<std::vector<forward::ObjectLight>, 3> lights;
  std::vector<forward::ObjectProblem> problems;
  for (std::size_t c = 0; c < 3; ++c) {
    lights[c] = {light[c]};
    if (entry == Entry::surface) enter_at_surface(lights[c][0], object_.surface);
    problems.push_back({object_.mesh, object_.surface, *object_.rays, *media_[c],
                        object_.boundary.eta, lights[c]});
  }
  const double incident = processor_seconds() - before - media;
  std::vector<forward::polygrid::PolygridAnswer> solved = diffusion_->solve(problems, accuracy);
  for (std::size_t c = 0; c < 3; ++c) channels_[c] = std::move(solved[c].exitance);
  exitance_ = channels_[1];
  const auto& seconds = diffusion_->seconds();
  return {1e3 * media,
          1e3 * (incident + seconds.beams),
          1e3 * seconds.solving,
          1e3 * seconds.exitance,
          watch.milliseconds(),
          1e3 * seconds.solving_elapsed,
          diffusion_->report().iterations};
}

}  // namespace kappamu::studies::live_frames
