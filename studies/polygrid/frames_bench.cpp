#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/numbers/median.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "render/live/lit_corners.h"
#include "render/scene/edited_object.h"
#include "studies/polygrid/live_frames.h"
#include "studies/polygrid/polygrid_bench.h"

namespace kappamu::studies {

namespace {

using namespace live_frames;
using Eigen::Vector3d;

/// Voxels of a stroke, and its factor on μ.
constexpr double edited_voxels = 10'000.0, edited_mu = 4.0;

/// What a graphics card draws of an answer: reflections, light scattered once and the rest, at all
/// corners.
class Drawing {
 public:
  explicit Drawing(const render::World& world) : world_(world), corners_(world) {
    corners_.geometry();
    below_ =
        std::make_shared<const render::BelowSurface>(render::below_surface(world.objects()[0]));
  }

  /// Processor time [ms].
  double draw(const forward::ExitanceOfChannels& exitance, double degrees) const {
    const double start = processor_seconds();
    const render::LightSources sources = sun_at(degrees);
    const render::WorldObject& object = world_.objects()[0];
    render::LiveAnswer answer;
    answer.exitance = {{exitance, {}}};
    answer.surface = {
        {object.boundary, object.roughness, below_, render::arriving_on(world_, 0, sources)}};
    Eigen::Vector4d towards = Eigen::Vector4d::Zero();
    towards.head<3>() = -sources[0]->at(Vector3d::Zero()).direction;
    answer.sources = {towards};
    corners_.light(answer);
    return 1e3 * (processor_seconds() - start);
  }

 private:
  const render::World& world_;
  render::LitCorners corners_;
  std::shared_ptr<const render::BelowSurface> below_;
};

/// From a stroke of the brush to the corrected picture, processor time by what it went to and time
/// by the clock [ms].
struct StrokeFrame {
  double volume = 0.0;   ///< the voxels, and the media made of them
  Frame frame;           ///< equations, light, diffusion, exitance
  double picture = 0.0;  ///< the light of all corners, as a graphics card draws it
  double elapsed = 0.0;
  std::size_t voxels = 0;

  double whole() const { return volume + frame.whole() + picture; }
};

/// The object as the window edits it: strokes at several places, each kept.
class Strokes {
 public:
  Strokes(const render::Scene& scene, const render::World& world, Live& live)
      : world_(world),
        live_(live),
        voxel_mm_(voxel_of(world.objects()[0].mesh, live.cells())),
        edited_(scene.objects[0], world.objects()[0].rest, world.objects()[0].mesh,
                *world.objects()[0].rays, voxel_mm_),
        drawing_(world) {
    // Boxes of other coefficients, so that the volume is no homogeneous one.
    const Eigen::AlignedBox3d box = bounding_box(world.objects()[0].mesh);
    for (int octant = 0; octant < 8; ++octant) {
      render::Edit edit;
      edit.kappa = {1.0 + 0.1 * octant};
      edit.mu = {1.5 - 0.1 * octant};
      render::BoxSelection part{box.center(), box.center(), render::Frame::object};
      const Vector3d far = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(octant));
      part.from_mm = part.from_mm.cwiseMin(far);
      part.to_mm = part.to_mm.cwiseMax(far);
      edit.where = part;
      done(edit);
    }
    live_.set(media());
    live_.frame(first_degrees, Entry::beams);
  }

  StrokeFrame stroke(std::size_t triangle) {
    const Surface& surface = world_.objects()[0].surface;
    render::BrushSelection where;
    where.frame = render::Frame::object;
    where.strokes = {{{surface.position[triangle]}, {-surface.normal[triangle]}}};
    where.radius_mm = voxel_mm_ * std::cbrt(edited_voxels / (2.0 * M_PI));
    where.depth_mm = 2.0 * where.radius_mm;
    where.hardness = 1.0;
    render::Edit edit;
    edit.mu = {edited_mu};
    edit.where = where;
    StrokeFrame result;
    const Stopwatch watch;
    const double start = processor_seconds();
    result.voxels = done(edit);
    const forward::MediaOfChannels edited = media();
    result.volume = 1e3 * (processor_seconds() - start);
    result.frame = live_.frame(first_degrees, Entry::beams, &edited);
    result.picture = drawing_.draw(live_.exitance(), first_degrees);
    result.elapsed = watch.milliseconds();
    return result;
  }

 private:
  std::size_t done(const render::Edit& edit) {
    const std::size_t voxels = edited_.history().try_edit(edit);
    edited_.history().commit();
    return voxels;
  }
  forward::MediaOfChannels media() const { return edited_.media().channels; }

  const render::World& world_;
  Live& live_;
  double voxel_mm_;
  render::EditedObject edited_;
  Drawing drawing_;
};

Json measured(const Published& paper, const render::Scene& scene, const render::World& world,
              const std::string& device) {
  Live live(world, grid_of(world, paper.nodes), device);
  const TriangleMesh& mesh = world.objects()[0].mesh;
  live.set(volume_of(mesh, live.cells()));
  const Frame first = live.frame(first_degrees, Entry::beams),
              moved = median_of(live.moved_frames(Entry::beams));
  const Drawing drawing(world);
  std::vector<double> drawn;
  for (int k = 0; k < frames; ++k) drawn.push_back(drawing.draw(live.exitance(), last_degrees));
  const double drawing_ms = upper_median(std::move(drawn));
  const auto error = live.error_of_last(last_degrees, Entry::beams);
  const Frame at_surface = median_of(live.moved_frames(Entry::surface));
  const auto surface_error = live.error_of_last(last_degrees, Entry::surface);
  Strokes strokes(scene, world, live);
  std::vector<StrokeFrame> edits;
  for (std::size_t k = 0; k < frames; ++k) {
    edits.push_back(strokes.stroke((2 * k + 1) * mesh.triangles.size() / (2 * frames)));
  }
  const StrokeFrame edit = median_of(std::move(edits));
  return {{"paper", paper.model},
          {"cells", live.cells()},
          {"unknowns", live.unknowns()},
          {"first_diffusion_ms", first.diffusion},
          {"first_iterations", first.iterations},
          {"light_ms", moved.light},
          {"diffusion_ms", moved.diffusion},
          {"exitance_ms", moved.exitance},
          {"frame_ms", moved.whole()},
          {"drawing_ms", drawing_ms},
          {"reflecting_frame_ms", moved.whole() + drawing_ms},
          {"peak_memory_bytes", peak_memory()},
          {"iterations", moved.iterations},
          {"diffusion_elapsed_ms", moved.diffusion_elapsed},
          {"frame_elapsed_ms", moved.elapsed},
          {"error", error[0]},
          {"largest_error", error[1]},
          {"surface_error", surface_error[0]},
          {"surface_light_ms", at_surface.light},
          {"surface_diffusion_ms", at_surface.diffusion},
          {"surface_exitance_ms", at_surface.exitance},
          {"surface_frame_ms", at_surface.whole()},
          {"surface_iterations", at_surface.iterations},
          {"surface_diffusion_elapsed_ms", at_surface.diffusion_elapsed},
          {"surface_frame_elapsed_ms", at_surface.elapsed},
          {"edit_voxels", edit.voxels},
          {"edit_volume_ms", edit.volume},
          {"edit_media_ms", edit.frame.media},
          {"edit_light_ms", edit.frame.light},
          {"edit_diffusion_ms", edit.frame.diffusion},
          {"edit_exitance_ms", edit.frame.exitance},
          {"edit_picture_ms", edit.picture},
          {"edit_ms", edit.whole()},
          {"edit_elapsed_ms", edit.elapsed},
          {"edit_iterations", edit.frame.iterations},
          {"paper_diffusion_fps", paper.diffusion},
          {"paper_fps", paper.whole},
          {"paper_coherent_fps", paper.coherent}};
}

}  // namespace

void measure_frames(const Request& request, Progress& progress, const Save& save) {
  const std::vector<std::string> files = request.words("files");
  std::vector<std::string> warnings;
  const render::Scene scene = scene_of(files.empty() ? "scenes/meshes/spot.ply" : files.front());
  const render::World world(scene, warnings);
  constexpr int toy = 8'000;
  std::vector<Published> table(std::begin(table_3), std::end(table_3));
  if (request.size == Size::small) table.resize(2);
  if (request.has("cells")) table = {{"edit", request.count("cells", 0), 1e3, 1e3, 1e3}};
  if (request.size == Size::quick) table = {{"hole", toy, 1e3 / 8.9, 80.0, 160.4}};
  // Kernels are compiled once, before the first frame that counts.
  measured({"none", toy, 1.0, 1.0, 1.0}, scene, world, request.device);
  Json rows = Json::array();
  for (const Published& paper : table) {
    progress.update("bench polygrid frames",
                    static_cast<double>(rows.size()) / static_cast<double>(table.size()),
                    std::to_string(paper.nodes) + " cells");
    rows.push_back(measured(paper, scene, world, request.device));
    save({{"size_mm", live_mm}, {"degrees_per_frame", degrees_per_frame}, {"rows", rows}});
  }
}

}  // namespace kappamu::studies
