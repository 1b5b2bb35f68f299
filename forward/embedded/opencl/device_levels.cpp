#include "forward/embedded/opencl/device_levels.h"

#include <algorithm>
#include <cstdint>

#include "forward/embedded/equations/row_ranges.h"

namespace kappamu::forward::embedded {

device::Buffer uploaded(device::Context& context, const void* data, std::size_t bytes) {
  // OpenCL has no empty buffers.
  const device::Buffer buffer = context.allocate(std::max<std::size_t>(bytes, sizeof(double)));
  if (bytes > 0) context.write(buffer, data, bytes);
  return buffer;
}

LevelStructure::LevelStructure(device::Context& context, const Level& level,
                               std::size_t coarser_cubes)
    : cubes(static_cast<int>(level.space.cubes())),
      unknowns(static_cast<int>(level.space.unknowns())),
      corner(uploaded(context, level.space.corners())),
      masters(uploaded(context, level.space.masters())),
      place(uploaded(context, level.elements.of_cube)) {
  Incidence incidence(level.space);
  start = uploaded(context, incidence.start);
  for (int& slot : incidence.slot) {
    const auto count =
        level.space.parts(static_cast<std::size_t>(slot / 8), static_cast<std::size_t>(slot % 8))
            .size();
    slot = 4 * slot + (count == 1 ? 0 : count == 2 ? 1 : 2);
  }
  part = uploaded(context, incidence.slot);
  if (coarser_cubes == 0) return;
  const std::vector<int> owners = owner_slots(level.space);
  owner = uploaded(context, owners);
  std::vector<std::uint8_t> bits(level.space.cubes(), 0);
  for (const int slot : owners) {
    bits[static_cast<std::size_t>(slot / 8)] |= static_cast<std::uint8_t>(1 << slot % 8);
  }
  owned = uploaded(context, bits);
  parent = uploaded(context, level.coarser.parent);
  octant = uploaded(context, level.coarser.octant);
  std::vector<int> first(coarser_cubes + 1, cubes);
  for (std::size_t k = level.coarser.parent.size(); k-- > 0;) {
    first[static_cast<std::size_t>(level.coarser.parent[k])] = static_cast<int>(k);
  }
  first_child = uploaded(context, first);
}

template <class T>
std::vector<T> packed_elements(const Elements& elements, const Lanes& lanes) {
  const std::size_t media = lanes.media();
  std::vector<T> packed(elements.places() * Element::entries * media, T{0});
  for_row_ranges(elements.places(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t place = begin; place < end; ++place) {
      for (std::size_t m = 0; m < lanes.channels.size(); ++m) {
        const Element& element = elements.element[place * elements.channels + lanes.channels[m]];
        T* to = packed.data() + place * Element::entries * media + m;
        for (std::size_t k = 0; k < Element::entries; ++k) {
          to[k * media] = static_cast<T>(element.entry[k]);
        }
      }
    }
  });
  return packed;
}

template std::vector<float> packed_elements<float>(const Elements& elements, const Lanes& lanes);
template std::vector<double> packed_elements<double>(const Elements& elements, const Lanes& lanes);

LevelNumbers::LevelNumbers(device::Context& context, const Level& level, const Lanes& lanes)
    : element(uploaded(context, packed_elements<float>(level.elements, lanes))) {
  const std::size_t unknowns = level.space.unknowns(), media = lanes.media();
  std::vector<float> scales(unknowns * media, 0.0F);
  for (std::size_t m = 0; m < lanes.channels.size(); ++m) {
    for (std::size_t u = 0; u < unknowns; ++u) {
      scales[u * media + m] = level.inverse_scale[lanes.channels[m]][u];
    }
  }
  inverse_scale = uploaded(context, scales);
  const std::size_t bytes = unknowns * lanes.width * sizeof(float);
  r = context.allocate(bytes);
  x = context.allocate(bytes);
  z = context.allocate(bytes);
  slots = context.allocate(level.space.cubes() * 8 * lanes.width * sizeof(float));
}

}  // namespace kappamu::forward::embedded
