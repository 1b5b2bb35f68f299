// The levels of a cut mesh in a device's memory, with the work space of a V-cycle on them.
#pragma once

#include <span>
#include <vector>

#include "device/context.h"
#include "forward/embedded/equations/levels.h"
#include "forward/embedded/opencl/lanes.h"

namespace kappamu::forward::embedded {

/// Cubes, unknowns and transfers of a level, whatever the medium.
struct LevelStructure {
  int cubes = 0, unknowns = 0;
  device::Buffer corner;          ///< [cube][8] unknown, or ~(place in masters) where it hangs
  device::Buffer masters;         ///< count, then as many unknowns
  device::Buffer place;           ///< [cube] of its element
  device::Buffer start, part;     ///< embedded.cl, collected()
  device::Buffer owner, owned;    ///< [unknown] 8·cube + corner; [cube] a bit per corner
  device::Buffer parent, octant;  ///< [cube]; none on the coarsest
  device::Buffer first_child;     ///< [coarser cube], and the end of the last

  LevelStructure(device::Context& context, const Level& level, std::size_t coarser_cubes);
};

/// What depends on media and lanes.
struct LevelNumbers {
  device::Buffer element;         ///< [place][36][medium] float
  device::Buffer inverse_scale;   ///< [unknown][medium]
  device::Buffer r, x, z, slots;  ///< [unknown][lane], slots [cube][8][lane]

  LevelNumbers(device::Context& context, const Level& level, const Lanes& lanes);
};

/// [place][36][medium] of a level's elements, in float or double.
template <class T>
std::vector<T> packed_elements(const Elements& elements, const Lanes& lanes);

device::Buffer uploaded(device::Context& context, const void* data, std::size_t bytes);
template <class T>
device::Buffer uploaded(device::Context& context, const std::vector<T>& values) {
  return uploaded(context, values.data(), values.size() * sizeof(T));
}

}  // namespace kappamu::forward::embedded
