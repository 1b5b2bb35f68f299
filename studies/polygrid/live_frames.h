// An object on a polygrid under a light that moves, frame by frame as the window answers it.
#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "forward/live_model.h"
#include "forward/polygrid/polygrid_diffusion.h"
#include "render/light/beam_places.h"
#include "render/scene/world.h"

namespace kappamu::studies::live_frames {

/// [W] Table III: nodes; frames per second of diffusion alone, whole, and whole from the last
/// frame, of a GeForce 8800 GTX.
struct Published {
  const char* model;
  int nodes;
  double diffusion, whole, coherent;
};
inline constexpr Published table_3[] = {{"hole", 62'000, 1e3 / 8.9, 80.0, 160.4},
                                        {"snail", 140'000, 1e3 / 14.0, 53.4, 106.7},
                                        {"bust", 560'000, 1e3 / 19.9, 34.0, 52.7},
                                        {"bunny", 1'040'000, 1e3 / 23.2, 25.9, 34.7},
                                        {"bird", 1'500'000, 1e3 / 48.3, 15.3, 24.0}};

inline constexpr double live_mm = 40.0, degrees_per_frame = 2.0;
/// That count, after those which a moving light's answers come to be like each other in.
inline constexpr int frames = 7, frames_before = 3;
inline constexpr double first_degrees = 20.0,
                        last_degrees =
                            first_degrees + degrees_per_frame * (frames_before + frames - 1);

/// That live frames are held against, and its beams' spacing over theirs.
inline constexpr forward::polygrid::PolygridAccuracy converged{
    .linear_tolerance = 1e-5, .beam_remainder = 1e-6, .most_iterations = 300};
inline constexpr double converged_spacing = 0.25;

/// One object of this mesh.
render::Scene scene_of(const std::string& mesh);
/// Edge of voxels of which the object holds as many as the grid has cells [mm].
double voxel_of(const TriangleMesh& mesh, std::size_t cells);
/// A smooth volume with as many voxels in the object as the grid has cells.
forward::MediaOfChannels volume_of(const TriangleMesh& mesh, std::size_t cells);
/// About so many cells: an eighth, split.
forward::Polygrid grid_of(const render::World& world, int cells);

render::LightSources sun_at(double degrees);

/// One frame's processor time, by what it went to, and its time by the clock [ms]; `media` where
/// its material was edited.
struct Frame {
  double media = 0.0, light = 0.0, diffusion = 0.0, exitance = 0.0;
  double elapsed = 0.0, diffusion_elapsed = 0.0;
  int iterations = 0;

  double whole() const { return media + light + diffusion + exitance; }
};

/// Whether light is refracted and collides inside, or enters all at the surface, as in [W].
enum class Entry { beams, surface };

class Live {
 public:
  Live(const render::World& world, forward::Polygrid grid, const std::string& device);

  std::size_t cells() const { return diffusion_->grid().cell.size(); }
  /// Of the last frame.
  const forward::ExitanceOfChannels& exitance() const { return channels_; }
  std::size_t unknowns() const { return diffusion_->grid().corner.size(); }

  void set(const forward::MediaOfChannels& media);
  /// Of a light at this angle, with another medium where one is given.
  Frame frame(double degrees, Entry entry, const forward::MediaOfChannels* edited = nullptr);
  /// Those of a light that moves which count.
  std::vector<Frame> moved_frames(Entry entry);
  /// The converged answer takes the last frame's place.
  void converge(double degrees, Entry entry);
  /// Of the last frame's exitance, from the converged one: relative 2-norm, and the largest
  /// difference over the largest exitance.
  std::array<double, 2> error_of_last(double degrees, Entry entry);

 private:
  Frame answered(double degrees, Entry entry, const forward::MediaOfChannels* edited,
                 std::span<const render::BeamPlace> places,
                 const forward::polygrid::PolygridAccuracy& accuracy);

  const render::World& world_;
  const render::WorldObject& object_;
  std::vector<render::BeamPlace> places_, converged_places_;
  std::vector<render::BeamPlace> each_triangle_;  ///< of light that enters at the surface
  std::unique_ptr<forward::polygrid::PolygridDiffusion> diffusion_;
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

}  // namespace kappamu::studies::live_frames
