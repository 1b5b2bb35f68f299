#include "studies/baseline/batch.h"

#include <algorithm>
#include <string>

#include "core/error.h"

namespace kappamu::studies::baseline {

extern const device::KernelSource baseline_cl;

namespace {

std::size_t bytes_of(bool single) {
  return single ? sizeof(float) : sizeof(double);
}

template <class Real>
void write_reals(device::Context& context, const device::Buffer& buffer,
                 const std::vector<Real>& values) {
  context.write(buffer, values.data(), values.size() * sizeof(Real));
}

template <class Real>
std::vector<Real> interleaved(const Lanes& lanes, std::size_t cells,
                              std::span<const double> values) {
  const auto width = static_cast<std::size_t>(lanes.lanes);
  std::vector<Real> packed(cells * width, Real(0));
  for (int m = 0; m < lanes.count; ++m) {
    const double* from = values.data() + static_cast<std::size_t>(lanes.first + m) * cells;
    for (std::size_t i = 0; i < cells; ++i) {
      packed[i * width + static_cast<std::size_t>(m)] = static_cast<Real>(from[i]);
    }
  }
  return packed;
}

template <class Real>
void read_interleaved(device::Context& context, const device::Buffer& field, const Lanes& lanes,
                      std::size_t cells, std::span<double> values) {
  const auto width = static_cast<std::size_t>(lanes.lanes);
  std::vector<Real> packed(cells * width);
  context.read(field, packed.data(), packed.size() * sizeof(Real));
  for (int m = 0; m < lanes.count; ++m) {
    double* to = values.data() + static_cast<std::size_t>(lanes.first + m) * cells;
    for (std::size_t i = 0; i < cells; ++i) {
      to[i] = static_cast<double>(packed[i * width + static_cast<std::size_t>(m)]);
    }
  }
}

}  // namespace

std::vector<Lanes> cut_into_lanes(int patterns) {
  std::vector<Lanes> blocks;
  for (int first = 0; first < patterns;) {
    const int left = patterns - first;
    const int lanes = left > 8 ? 16 : left > 4 ? 8 : left > 1 ? 4 : 1;
    blocks.push_back({first, std::min(left, lanes), lanes});
    first += lanes;
  }
  return blocks;
}

Batch::Batch(device::Context& context, Precision precision, Lanes lanes)
    : context_(context),
      lanes_(lanes),
      gpu_(context.info().kind == device::Kind::gpu),
      single_(precision == Precision::single_precision),
      accurate_(context.info().fp64) {
  if (!single_ && !accurate_) {
    throw InputError("device '" + context.info().name +
                     "' has no double precision; use --precision single or another --device");
  }
  const int width = gpu_ ? std::min(lanes.lanes, 4) : lanes.lanes;
  groups_ = static_cast<std::size_t>(lanes.lanes / width);
  program_ = &context.program(
      baseline_cl, std::string("-DREAL=") + (single_ ? "float" : "double") + " -DACCU=" +
                       (accurate_ ? "double" : "float") + " -DWIDTH=" + std::to_string(width) +
                       " -DGROUPS=" + std::to_string(groups_) +
                       (gpu_ ? " -DSEGMENT=1 -DINTERLEAVED=1" : " -DINTERLEAVED=0"));
}

device::Range Batch::rows(const std::array<int, 3>& n) const {
  const auto row_count = static_cast<std::size_t>(n[1]) * static_cast<std::size_t>(n[2]);
  if (!gpu_) return {groups_, row_count, 1, 1};
  return {groups_ * static_cast<std::size_t>(n[0]), row_count, 64, 1};
}

device::Range Batch::items(std::size_t count) const {
  return {groups_ * count, 1, gpu_ ? std::size_t{64} : std::size_t{1}, 1};
}

device::Buffer Batch::upload(std::span<const double> values) const {
  device::Buffer buffer = context_.allocate(values.size() * bytes_of(single_));
  if (single_) {
    write_reals(context_, buffer, std::vector<float>(values.begin(), values.end()));
  } else {
    context_.write(buffer, values.data(), values.size_bytes());
  }
  return buffer;
}

DeviceStencil Batch::upload(const Stencil& stencil) const {
  return {stencil.n,
          upload(stencil.face[0]),
          upload(stencil.face[1]),
          upload(stencil.face[2]),
          upload(stencil.sink),
          upload(stencil.inverse)};
}

device::Buffer Batch::zeros(std::size_t bytes) const {
  device::Buffer buffer = context_.allocate(bytes);
  context_.zero(buffer, bytes);
  return buffer;
}

device::Buffer Batch::make_field(std::size_t cells) const {
  return zeros(cells * static_cast<std::size_t>(lanes_.lanes) * bytes_of(single_));
}

device::Buffer Batch::make_accurate_field(std::size_t cells) const {
  return zeros(cells * static_cast<std::size_t>(lanes_.lanes) * bytes_of(!accurate_));
}

device::Buffer Batch::make_partial_sums() const {
  return make_accurate_field(static_cast<std::size_t>(runs()));
}

device::Buffer Batch::make_scalars() const {
  return make_accurate_field(1);
}

void Batch::write(const device::Buffer& field, std::size_t cells,
                  std::span<const double> values) const {
  if (single_) {
    write_reals(context_, field, interleaved<float>(lanes_, cells, values));
  } else {
    write_reals(context_, field, interleaved<double>(lanes_, cells, values));
  }
}

void Batch::read(const device::Buffer& field, std::size_t cells, std::span<double> values) const {
  if (single_) {
    read_interleaved<float>(context_, field, lanes_, cells, values);
  } else {
    read_interleaved<double>(context_, field, lanes_, cells, values);
  }
}

void Batch::read_accurate(const device::Buffer& field, std::size_t cells,
                          std::span<double> values) const {
  if (accurate_) {
    read_interleaved<double>(context_, field, lanes_, cells, values);
  } else {
    read_interleaved<float>(context_, field, lanes_, cells, values);
  }
}

void Batch::write_scalars(const device::Buffer& scalars, std::span<const double> values) const {
  if (accurate_) {
    context_.write(scalars, values.data(), values.size_bytes());
  } else {
    write_reals(context_, scalars, std::vector<float>(values.begin(), values.end()));
  }
}

std::vector<double> Batch::sum(const device::Buffer& partial) const {
  const auto lanes = static_cast<std::size_t>(lanes_.lanes);
  const auto count = lanes * static_cast<std::size_t>(runs());
  std::vector<double> values(count);
  if (accurate_) {
    context_.read(partial, values.data(), count * sizeof(double));
  } else {
    std::vector<float> stored(count);
    context_.read(partial, stored.data(), count * sizeof(float));
    std::copy(stored.begin(), stored.end(), values.begin());
  }
  std::vector<double> sums(lanes, 0.0);
  for (std::size_t k = 0; k < count; ++k) sums[k % lanes] += values[k];
  return sums;
}

}  // namespace kappamu::studies::baseline
