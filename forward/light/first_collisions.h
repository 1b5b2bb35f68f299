// First collisions of beams in the cells of a grid: the one march of a beam. What a grid gives is
// its cells, one by one along a chord, and where the power in a cell goes.
//
// In each cell (σs'/σt')(e^(−τ_in) − e^(−τ_out)) of the power is scattered for the first time,
// shared among the cell's corners by the mean of their trilinear functions over what collides. All
// is exact for coefficients constant in each cell and a chord straight in its own coordinates, and
// the shares sum to the power. Up to beam_lanes channels are marched at once.
#pragma once

#include <array>
#include <span>

#include "forward/light/beam_path.h"

namespace kappamu::forward {

inline constexpr std::size_t beam_lanes = 4;
using OfChannels = std::array<double, beam_lanes>;

/// A beam's way through a cell.
struct CellStep {
  int cell = -1;        ///< −1: none, nothing collides
  bool ends = false;    ///< it ends at the surface
  float leaves = 0.0F;  ///< there, of what arrives
  double length = 0.0;  ///< [mm]
  /// In the cell's own coordinates, 0 to 1: where it comes in, and how far it goes.
  Eigen::Vector3f from = Eigen::Vector3f::Zero(), along = Eigen::Vector3f::Zero();
};

struct CellOptics {
  OfChannels sigma_t{};    ///< σt' [1/mm]
  OfChannels scattered{};  ///< share of what collides
};
/// Sets channel `lane`.
void set_lane(const Coefficients& coefficients, std::size_t lane, CellOptics& optics);

/// A beam's powers [mm²].
struct BeamLight {
  OfChannels left{};                                  ///< on its way; at first what has entered
  OfChannels least{};                                 ///< what is left then collides at once
  OfChannels scattered{}, absorbed{}, unscattered{};  ///< so far
};
/// `power` before Fresnel.
BeamLight entering(const BeamPath& path, const OfChannels& power, double remainder);

using CornerShares = std::array<OfChannels, 8>;  ///< x fastest

/// What collides in a step. False: nothing is left.
bool collide(const CellStep& step, const CellOptics& optics, BeamLight& light,
             CornerShares& shares);
/// At a surface. False: nothing is left inside.
bool leave(double share, BeamLight& light, OfChannels& leaves);

/// Where a beam's path is walked to.
struct PathPlace {
  std::size_t chords = 0;             ///< begun
  double length = 0.0, walked = 0.0;  ///< of the last [mm]
  double leaves = 0.0;
  bool on_chord = false;
};

/// The path's next step; `cells` has start(chord) and step(most), the next cell along the chord, at
/// most so far [mm]. False: there is none.
template <class Cells>
bool next_step(BeamPath& path, const Walls& walls, PathPlace& place, Cells& cells, CellStep& step) {
  if (!place.on_chord) {
    const Chord* chord = path.chord(place.chords, walls);
    if (chord == nullptr) return false;
    place = {place.chords + 1, chord->length, 0.0, chord->leaves, true};
    cells.start(*chord);
  }
  const double most = place.length - place.walked;
  step = cells.step(most);
  place.walked += step.length;
  place.on_chord = step.length < most;
  step.ends = !place.on_chord;
  step.leaves = step.ends ? static_cast<float>(place.leaves) : 0.0F;
  return true;
}

/// Marches a beam. `next` gives the next step or none; `grid` has optics(cell), deposit(cell,
/// shares), what is scattered there, and leave(k, power), what goes out at the end of chord `k`.
template <class Next, class Grid>
void march(Next&& next, BeamLight& light, Grid&& grid) {
  CornerShares shares{};
  OfChannels out{};
  std::size_t chord = 0;
  bool any = true;
  while (any) {
    const CellStep* step = next();
    if (step == nullptr) break;
    if (step->cell >= 0) {
      any = collide(*step, grid.optics(step->cell), light, shares);
      grid.deposit(step->cell, shares);
    }
    if (any && step->ends) {
      any = leave(static_cast<double>(step->leaves), light, out);
      grid.leave(chord++, out);
    }
  }
  leave(1.0, light, out);
}

}  // namespace kappamu::forward
