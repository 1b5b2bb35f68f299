#include "forward/linear/opencl/device_lanes.h"

#include <algorithm>

#include "core/parallel.h"

namespace kappamu::forward::linear {

extern const device::KernelSource sums_cl;

namespace {

/// Of sums.cl.
constexpr std::size_t adding_group = 256;

/// Calls use(T) with the type that numbers have.
template <class Use>
auto with_type(bool twofold, const Use& use) {
  return twofold ? use(double{}) : use(float{});
}

}  // namespace

device::Buffer uploaded(device::Context& context, const void* data, std::size_t bytes) {
  const device::Buffer buffer = context.allocate(std::max<std::size_t>(bytes, sizeof(double)));
  if (bytes > 0) context.write(buffer, data, bytes);
  return buffer;
}

DeviceLanes::DeviceLanes(device::Context& context, const Numbers& numbers, const Lanes& lanes,
                         std::size_t rows, std::size_t runs, bool scaled, std::size_t kinds)
    : context_(context),
      numbers_(numbers),
      lanes_(lanes),
      rows_(rows),
      runs_(std::min(rows, runs)),
      partial_(context.allocate(kinds * runs_ * lanes.width * numbers.sum_bytes())),
      given_(context.allocate(kinds * lanes.width * numbers.sum_bytes())),
      scalars_(context.allocate((free_place + kinds) * lanes.width * numbers.sum_bytes())),
      adding_(program(sums_cl, std::string("-DSUM=") + (numbers.double_sums ? "double" : "float") +
                                   " -DSCALED=" + (scaled ? "1" : "0"))) {}

std::string DeviceLanes::build_options() const {
  return "-DWIDTH=" + std::to_string(lanes_.width) + " -DOWN=" + (lanes_.own() ? "1" : "0") +
         " -DINTERLEAVED=" + (numbers_.interleaved ? "1" : "0");
}

void DeviceLanes::write_lanes(const device::Buffer& buffer,
                              const std::vector<const std::vector<double>*>& of_lane,
                              std::size_t rows, std::size_t width) const {
  with_type(numbers_.precision == Precision::twofold, [&]<class T>(T) {
    context_.fill(buffer, rows * width * sizeof(T), [&](void* memory) {
      T* lanes = static_cast<T*>(memory);
      for_ranges(rows, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          for (std::size_t lane = 0; lane < width; ++lane) {
            lanes[i * width + lane] = lane < of_lane.size() && i < of_lane[lane]->size()
                                          ? static_cast<T>((*of_lane[lane])[i])
                                          : T(0);
          }
        }
      });
    });
  });
}

void DeviceLanes::read_lanes(const device::Buffer& buffer,
                             const std::vector<std::vector<double>*>& of_lane) const {
  for (std::vector<double>* field : of_lane) field->resize(rows_);
  with_type(numbers_.precision == Precision::twofold, [&]<class T>(T) {
    context_.look(buffer, rows_ * width() * sizeof(T), [&](const void* memory) {
      const T* lanes = static_cast<const T*>(memory);
      for_ranges(rows_, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          for (std::size_t lane = 0; lane < of_lane.size(); ++lane) {
            (*of_lane[lane])[i] = static_cast<double>(lanes[i * width() + lane]);
          }
        }
      });
    });
  });
}

void DeviceLanes::add_up(Place place, std::size_t count) {
  context_.launch(adding_, "add_runs", {count * adding_group, 1, adding_group, 1},
                  static_cast<int>(runs_), static_cast<int>(place), partial_, scalars_);
}

std::vector<Scalars> DeviceLanes::read(Place place, std::size_t count) const {
  std::vector<Scalars> result(count);
  with_type(numbers_.double_sums, [&]<class T>(T) {
    const std::size_t skipped = static_cast<std::size_t>(place) * width();
    std::vector<T> all(skipped + count * width());
    context_.read(scalars_, all.data(), all.size() * sizeof(T));
    for (std::size_t k = 0; k < count; ++k) {
      const T* const from = all.data() + skipped + k * width();
      result[k].assign(from, from + width());
    }
  });
  return result;
}

CgState DeviceLanes::look() const {
  const std::vector<Scalars> at = read(Place::size, 3);
  return {at[0], at[1], at[2]};
}

void DeviceLanes::write(const std::vector<Scalars>& values) {
  with_type(numbers_.double_sums, [&]<class T>(T) {
    std::vector<T> all;
    for (const Scalars& of_lanes : values) all.insert(all.end(), of_lanes.begin(), of_lanes.end());
    context_.write(given_, all.data(), all.size() * sizeof(T));
  });
}

}  // namespace kappamu::forward::linear
