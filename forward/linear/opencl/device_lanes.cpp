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
                         std::size_t rows, std::size_t runs, std::size_t kinds)
    : context_(context),
      numbers_(numbers),
      lanes_(lanes),
      rows_(rows),
      runs_(std::min(rows, runs)),
      partial_(context.allocate(kinds * runs_ * lanes.width * numbers.sum_bytes())),
      scalars_(context.allocate(kinds * lanes.width * numbers.sum_bytes())) {
  if (!numbers.interleaved) return;
  adding_ = &program(sums_cl, std::string("-DSUM=") + (numbers.double_sums ? "double" : "float"));
  sum_ = context.allocate(scalars_.bytes());
}

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

std::vector<Scalars> DeviceLanes::read_sums(std::size_t count) const {
  std::vector<Scalars> total(count, Scalars(width(), 0.0));
  const std::size_t parts_of_kind = adding_ != nullptr ? 1 : runs_;
  if (adding_ != nullptr) {
    context_.launch(*adding_, "add_runs", {count * adding_group, 1, adding_group, 1},
                    static_cast<int>(runs_), partial_, sum_);
  }
  with_type(numbers_.double_sums, [&]<class T>(T) {
    std::vector<T> parts(count * parts_of_kind * width());
    context_.read(adding_ != nullptr ? sum_ : partial_, parts.data(), parts.size() * sizeof(T));
    for (std::size_t k = 0; k < parts.size(); ++k) {
      total[k / (parts_of_kind * width())][k % width()] += static_cast<double>(parts[k]);
    }
  });
  return total;
}

void DeviceLanes::write(const std::vector<Scalars>& values) {
  with_type(numbers_.double_sums, [&]<class T>(T) {
    std::vector<T> all;
    for (const Scalars& of_lanes : values) all.insert(all.end(), of_lanes.begin(), of_lanes.end());
    context_.write(scalars_, all.data(), all.size() * sizeof(T));
  });
}

}  // namespace kappamu::forward::linear
