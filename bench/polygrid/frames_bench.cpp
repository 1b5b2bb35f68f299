#include "bench/polygrid/frames_bench.h"

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/processor_time.h"
#include "forward/polygrid/polygrid_diffusion.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "forward/polygrid/split_polygrid.h"
#include "render/light/incident_light.h"
#include "render/live/live_object.h"

namespace kappamu::bench {

namespace {

using Eigen::Vector3d;
using forward::polygrid::PolygridDiffusion;

/// As LivePolygrid has it.
constexpr forward::polygrid::PolygridAccuracy accuracy{
    .linear_tolerance = 1e-2, .beam_remainder = 1e-3, .most_iterations = 100};
constexpr double live_mm = 40.0, degrees_per_frame = 2.0;
constexpr int frames = 4;
/// Voxels of an edit, and its factor on μ.
constexpr double edited_voxels = 10'000.0, edited_mu = 4.0;

/// [W] Table III: nodes; frames per second of diffusion alone, whole, and whole from the last
/// frame.
struct Published {
  const char* model;
  int nodes;
  double diffusion, whole, coherent;
};
constexpr Published table_3[] = {{"hole", 62'000, 1e3 / 8.9, 80.0, 160.4},
                                 {"snail", 140'000, 1e3 / 14.0, 53.4, 106.7},
                                 {"bust", 560'000, 1e3 / 19.9, 34.0, 52.7},
                                 {"bunny", 1'040'000, 1e3 / 23.2, 25.9, 34.7},
                                 {"bird", 1'500'000, 1e3 / 48.3, 15.3, 24.0}};

render::Scene scene_of(const std::string& mesh) {
  render::Scene scene;
  render::SceneObject object;
  object.name = "object";
  object.shape = std::filesystem::absolute(mesh);
  object.size_mm = live_mm;
  object.material = render::HomogeneousMaterial{};
  scene.objects.push_back(object);
  scene.camera.position_mm = 10.0 * live_mm * Vector3d::UnitZ();
  return scene;
}

/// A smooth volume with as many voxels in the object as the grid has cells; `edited` in a ball.
render::MediaOfChannels volume_of(const TriangleMesh& mesh, std::size_t cells, bool edited) {
  render::MediaOfChannels media;
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const double h = std::cbrt(enclosed_volume(mesh) / static_cast<double>(cells));
  const Eigen::Array3i n = (box.sizes() / h).array().ceil().cast<int>();
  const GridShape shape{n[0], n[1], n[2], h};
  const double radius = std::cbrt(0.75 * edited_voxels / M_PI);
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
          const Vector3d off(x - 0.5 * shape.nx, y - 0.6 * shape.ny, z - 0.7 * shape.nz);
          if (edited && off.norm() < radius) medium->mu[i] *= edited_mu;
        }
      }
    }
    const Eigen::Affine3d place(Eigen::Translation3d(-box.min()));
    media[c] = std::make_shared<ObjectMedium>(medium, place, Wrap::clamp);
  }
  return media;
}

/// One frame's processor time, by what it went to [ms].
struct Frame {
  double light = 0.0, diffusion = 0.0, exitance = 0.0, elapsed = 0.0;
  int iterations = 0;

  double whole() const { return light + diffusion + exitance; }
};

class Live {
 public:
  Live(const render::World& world, int cells, const std::string& device)
      : world_(world), object_(world.objects()[0]) {
    Progress silent;
    forward::PolygridOptions options;
    options.cells = cells / 8;
    forward::Polygrid grid = forward::polygrid::split(
        forward::make_polygrid(object_.mesh, options, silent).grid, object_.mesh);
    double area = 0.0;
    for (const double of_side : grid.area) area += of_side;
    spacing_ = 0.5 * std::sqrt(area / static_cast<double>(grid.area.size()));
    diffusion_ = std::make_unique<PolygridDiffusion>(std::move(grid), object_.mesh, object_.surface,
                                                     object_.boundary.eta, device, true);
  }

  std::size_t cells() const { return diffusion_->grid().cell.size(); }
  std::size_t unknowns() const { return diffusion_->grid().corner.size(); }

  /// Milliseconds of processor time.
  double set(const render::MediaOfChannels& media) {
    media_ = media;
    diffusion_->set_media(
        std::array<const ObjectMedium*, 3>{media[0].get(), media[1].get(), media[2].get()});
    return 1e3 * diffusion_->seconds().media;
  }

  Frame frame(double degrees) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    const double before = processor_seconds();
    Progress silent;
    render::DirectionalLight sun;
    const double angle = degrees * M_PI / 180.0;
    sun.direction = Vector3d(-std::sin(angle), -0.5, -std::cos(angle)).normalized();
    const render::LightSources sources = render::make_light_sources({sun});
    const render::LightOfChannels light =
        render::incident_light(world_, 0, sources, nullptr, 1, silent, spacing_).channels;
    const double incident = processor_seconds() - before;
    std::array<std::vector<forward::ObjectLight>, 3> lights;
    std::vector<forward::ObjectProblem> problems;
    for (std::size_t c = 0; c < 3; ++c) {
      lights[c] = {light[c]};
      problems.push_back({object_.mesh, object_.surface, *object_.rays, *media_[c],
                          object_.boundary.eta, lights[c]});
    }
    diffusion_->solve(problems, accuracy);
    const auto& seconds = diffusion_->seconds();
    return {1e3 * (incident + seconds.beams), 1e3 * seconds.solving, 1e3 * seconds.exitance,
            std::chrono::duration<double, std::milli>(Clock::now() - start).count(),
            diffusion_->report().iterations};
  }

 private:
  const render::World& world_;
  const render::WorldObject& object_;
  double spacing_ = 0.0;
  std::unique_ptr<PolygridDiffusion> diffusion_;
  render::MediaOfChannels media_;
};

/// The frame of least processor time of several whose light moves on.
Frame best_moved(Live& live) {
  Frame best;
  for (int k = 1; k <= frames; ++k) {
    const Frame frame = live.frame(20.0 + degrees_per_frame * k);
    if (k == 1 || frame.whole() < best.whole()) best = frame;
  }
  return best;
}

Json measured(const Published& paper, const render::World& world, const std::string& device) {
  Live live(world, paper.nodes, device);
  const TriangleMesh& mesh = world.objects()[0].mesh;
  const auto plain = volume_of(mesh, live.cells(), false),
             edited = volume_of(mesh, live.cells(), true);
  live.set(plain);
  const Frame first = live.frame(20.0), moved = best_moved(live);
  const double still = 20.0 + degrees_per_frame * frames;
  double media = 0.0;
  Frame edit;
  for (int k = 0; k < frames; ++k) {
    const double made = live.set(k % 2 == 0 ? edited : plain);
    const Frame frame = live.frame(still);
    if (k == 0 || made + frame.whole() < media + edit.whole()) {
      media = made;
      edit = frame;
    }
  }
  return {{"paper", paper.model},
          {"cells", live.cells()},
          {"unknowns", live.unknowns()},
          {"first_diffusion_ms", first.diffusion},
          {"first_iterations", first.iterations},
          {"light_ms", moved.light},
          {"diffusion_ms", moved.diffusion},
          {"exitance_ms", moved.exitance},
          {"frame_ms", moved.whole()},
          {"frame_elapsed_ms", moved.elapsed},
          {"iterations", moved.iterations},
          {"edit_media_ms", media},
          {"edit_light_ms", edit.light},
          {"edit_diffusion_ms", edit.diffusion},
          {"edit_ms", media + edit.whole()},
          {"edit_iterations", edit.iterations},
          {"paper_diffusion_fps", paper.diffusion},
          {"paper_fps", paper.whole},
          {"paper_coherent_fps", paper.coherent}};
}

}  // namespace

void measure_frames(const Request& request, Progress& progress, const Save& save) {
  const std::vector<std::string> files = request.words("files");
  std::vector<std::string> warnings;
  const render::World world(scene_of(files.empty() ? "scenes/meshes/spot.ply" : files.front()),
                            warnings);
  constexpr int toy = 8'000;
  std::vector<Published> table(std::begin(table_3), std::end(table_3));
  if (request.size == Size::small) table.resize(2);
  if (request.size == Size::quick) table = {{"hole", toy, 1e3 / 8.9, 80.0, 160.4}};
  // Kernels are compiled once, before the first frame that counts.
  measured({"none", toy, 1.0, 1.0, 1.0}, world, request.device);
  Json rows = Json::array();
  for (const Published& paper : table) {
    progress.update("bench polygrid frames",
                    static_cast<double>(rows.size()) / static_cast<double>(table.size()),
                    std::to_string(paper.nodes) + " cells");
    rows.push_back(measured(paper, world, request.device));
    save({{"size_mm", live_mm}, {"degrees_per_frame", degrees_per_frame}, {"rows", rows}});
  }
}

}  // namespace kappamu::bench
