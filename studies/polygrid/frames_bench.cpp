#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/mesh/surface_norm.h"
#include "core/numbers/median.h"
#include "core/process_memory.h"
#include "core/processor_time.h"
#include "forward/polygrid/live_polygrid.h"
#include "forward/polygrid/polygrid_diffusion.h"
#include "forward/polygrid/shape/make_polygrid.h"
#include "forward/polygrid/split_polygrid.h"
#include "render/light/beam_places.h"
#include "render/live/lit_corners.h"
#include "render/scene/edited_object.h"
#include "studies/polygrid/polygrid_bench.h"

namespace kappamu::studies {

namespace {

using Eigen::Vector3d;
using forward::polygrid::PolygridDiffusion;

/// That live frames are held against, and its beams' spacing over theirs.
constexpr forward::polygrid::PolygridAccuracy converged{
    .linear_tolerance = 1e-5, .beam_remainder = 1e-6, .most_iterations = 300};
constexpr double converged_spacing = 0.25;
constexpr double live_mm = 40.0, degrees_per_frame = 2.0;
/// That count, after those which a moving light's answers come to be like each other in.
constexpr int frames = 7, frames_before = 3;
constexpr double first_degrees = 20.0,
                 last_degrees = first_degrees + degrees_per_frame * (frames_before + frames - 1);
/// Voxels of a stroke, and its factor on μ.
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
  render::HomogeneousMaterial material;
  material.kappa_mm = 0.3;
  material.mu_per_mm = 0.003;  // a stroke multiplies it
  object.material = material;
  scene.objects.push_back(object);
  scene.camera.position_mm = 10.0 * live_mm * Vector3d::UnitZ();
  return scene;
}

/// Edge of voxels of which the object holds as many as the grid has cells [mm].
double voxel_of(const TriangleMesh& mesh, std::size_t cells) {
  return std::cbrt(enclosed_volume(mesh) / static_cast<double>(cells));
}

/// A smooth volume with as many voxels in the object as the grid has cells.
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

/// One frame's processor time, by what it went to, and its time by the clock [ms]; `media` where
/// its material was edited.
struct Frame {
  double media = 0.0, light = 0.0, diffusion = 0.0, exitance = 0.0;
  double elapsed = 0.0, diffusion_elapsed = 0.0;
  int iterations = 0;

  double whole() const { return media + light + diffusion + exitance; }
};

render::LightSources sun_at(double degrees) {
  render::DirectionalLight sun;
  const double angle = degrees * M_PI / 180.0;
  sun.direction = Vector3d(-std::sin(angle), -0.5, -std::cos(angle)).normalized();
  return render::make_light_sources({sun});
}

/// What a graphics card draws of an answer: reflections, light scattered once and the rest, at all
/// corners.
class Drawing {
 public:
  explicit Drawing(const render::World& world) : world_(world), corners_(world) {
    corners_.geometry();
    albedo_ = std::make_shared<const std::vector<render::Colour>>(
        render::albedo_below(world.objects()[0]));
  }

  /// Processor time [ms].
  double draw(const forward::ExitanceOfChannels& exitance, double degrees) const {
    const double start = processor_seconds();
    const render::LightSources sources = sun_at(degrees);
    const render::WorldObject& object = world_.objects()[0];
    render::LiveAnswer answer;
    answer.exitance = {{exitance, {}}};
    answer.surface = {
        {object.boundary, object.roughness, albedo_, render::arriving_on(world_, 0, sources)}};
    Eigen::Vector4d towards = Eigen::Vector4d::Zero();
    towards.head<3>() = -sources[0]->at(Vector3d::Zero()).direction;
    answer.sources = {towards};
    corners_.light(answer);
    return 1e3 * (processor_seconds() - start);
  }

 private:
  const render::World& world_;
  render::LitCorners corners_;
  std::shared_ptr<const std::vector<render::Colour>> albedo_;
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

/// Whether light is refracted and collides inside, or enters all at the surface, as in [W].
enum class Entry { beams, surface };

void enter_at_surface(forward::ObjectLight& light, const Surface& surface) {
  light.diffuse.assign(surface.size(), 0.0);
  for (const forward::Beam& beam : light.beams) {
    const auto triangle = static_cast<std::size_t>(beam.triangle);
    light.diffuse[triangle] += beam.power / surface.area[triangle];
  }
  light.beams.clear();
}

class Live {
 public:
  Live(const render::World& world, int cells, const std::string& device)
      : world_(world), object_(world.objects()[0]) {
    Progress silent;
    forward::PolygridOptions options;
    options.cells = cells / 8;
    forward::Polygrid grid = forward::polygrid::split(
        forward::make_polygrid(object_.mesh, options, silent).grid, object_.mesh);
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

  std::size_t cells() const { return diffusion_->grid().cell.size(); }
  /// Of the last frame.
  const forward::ExitanceOfChannels& exitance() const { return channels_; }
  std::size_t unknowns() const { return diffusion_->grid().corner.size(); }

  void set(const forward::MediaOfChannels& media) {
    media_ = media;
    diffusion_->set_media(
        std::array<const ObjectMedium*, 3>{media[0].get(), media[1].get(), media[2].get()});
  }

  /// Of a light at this angle, with another medium where one is given.
  Frame frame(double degrees, Entry entry, const forward::MediaOfChannels* edited = nullptr) {
    return answered(degrees, entry, edited, entry == Entry::beams ? places_ : each_triangle_,
                    forward::LivePolygrid::accuracy);
  }

  /// Of the last frame's exitance, from the converged one: relative 2-norm, and the largest
  /// difference over the largest exitance.
  std::array<double, 2> error_of_last(double degrees, Entry entry) {
    const std::vector<double> live = exitance_;
    answered(degrees, entry, nullptr, entry == Entry::beams ? converged_places_ : each_triangle_,
             converged);
    double largest = 0.0, most = 0.0;
    for (std::size_t t = 0; t < live.size(); ++t) {
      largest = std::max(largest, std::abs(live[t] - exitance_[t]));
      most = std::max(most, exitance_[t]);
    }
    return {surface_difference(object_.surface, live, exitance_) /
                surface_norm(object_.surface, exitance_),
            largest / most};
  }

 private:
  Frame answered(double degrees, Entry entry, const forward::MediaOfChannels* edited,
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

  const render::World& world_;
  const render::WorldObject& object_;
  std::vector<render::BeamPlace> places_, converged_places_;
  std::vector<render::BeamPlace> each_triangle_;  ///< of light that enters at the surface
  std::unique_ptr<PolygridDiffusion> diffusion_;
  forward::MediaOfChannels media_;
  forward::ExitanceOfChannels channels_;
  std::vector<double> exitance_;  ///< of the G channel in the last frame
};

/// The frame whose processor time is the median.
template <class AnyFrame>
AnyFrame median_of(std::vector<AnyFrame> of) {
  const auto middle = of.begin() + static_cast<std::ptrdiff_t>(of.size() / 2);
  std::nth_element(of.begin(), middle, of.end(),
                   [](const AnyFrame& a, const AnyFrame& b) { return a.whole() < b.whole(); });
  return *middle;
}

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

Frame moved_frame(Live& live, Entry entry) {
  std::vector<Frame> counted;
  for (int k = 0; k < frames_before + frames; ++k) {
    const Frame frame = live.frame(first_degrees + degrees_per_frame * k, entry);
    if (k >= frames_before) counted.push_back(frame);
  }
  return median_of(std::move(counted));
}

Json measured(const Published& paper, const render::Scene& scene, const render::World& world,
              const std::string& device) {
  Live live(world, paper.nodes, device);
  const TriangleMesh& mesh = world.objects()[0].mesh;
  live.set(volume_of(mesh, live.cells()));
  const Frame first = live.frame(first_degrees, Entry::beams),
              moved = moved_frame(live, Entry::beams);
  const Drawing drawing(world);
  std::vector<double> drawn;
  for (int k = 0; k < frames; ++k) drawn.push_back(drawing.draw(live.exitance(), last_degrees));
  const double drawing_ms = upper_median(std::move(drawn));
  const auto error = live.error_of_last(last_degrees, Entry::beams);
  const Frame at_surface = moved_frame(live, Entry::surface);
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
