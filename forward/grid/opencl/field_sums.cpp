#include "forward/grid/opencl/field_sums.h"

#include "core/error.h"
#include "core/parallel.h"
#include "forward/grid/opencl/face_index.h"
#include "forward/grid/opencl/multigrid/cg_steps.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"

namespace kappamu::forward {

FieldSums::FieldSums(device::Context& context, const Format& format, const GridSetup& setup,
                     TrustedKernels& kernels, device::BufferPool& pool)
    : context_(context), format_(format), setup_(setup), kernels_(kernels), pool_(pool) {}

device::Buffer FieldSums::zeros() const {
  const std::size_t bytes = setup_.shape.cells() * format_.accu_bytes();
  device::Buffer buffer = pool_.take(bytes);
  context_.zero(buffer, bytes);
  return buffer;
}

std::vector<double> FieldSums::read(const device::Buffer& sums) const {
  std::vector<double> values(setup_.shape.cells());
  if (format_.accurate_sums) {
    context_.read(sums, values.data(), values.size() * sizeof(double));
    return values;
  }
  std::vector<float> rounded(values.size());
  context_.read(sums, rounded.data(), rounded.size() * sizeof(float));
  for_pieces(values.size(), [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) values[i] = rounded[i];
  });
  return values;
}

std::array<device::Buffer, 4> FieldSums::products(const OpenclField& lambda,
                                                  const OpenclField& phi) const {
  check(lambda.total == phi.total, "pair_products: fields of different batches");
  const GridShape& s = setup_.shape;
  std::array<device::Buffer, 4> sums{zeros(), zeros(), zeros(), zeros()};
  for (std::size_t i = 0; i < lambda.blocks.size(); ++i) {
    context_.launch(kernels_(lambda.blocks[i].lanes).common(), "pair_products",
                    kernels_(lambda.blocks[i].lanes).scalar_rows(s), s.nx, s.ny, s.nz,
                    lambda.blocks[i].values, phi.blocks[i].values, sums[0], sums[1], sums[2],
                    sums[3]);
  }
  return sums;
}

PairProducts FieldSums::pair_products(const OpenclField& lambda, const OpenclField& phi) const {
  const std::array<device::Buffer, 4> sums = products(lambda, phi);
  return {read(sums[0]), read(sums[1]), read(sums[2]), read(sums[3])};
}

device::Buffer FieldSums::columns(const OpenclField& lambda, const SamplesOf& light) const {
  const GridShape& s = setup_.shape;
  const std::array<int, 3> a = column_strides(s, setup_.lit_face);
  const device::Buffer sum = zeros();
  for (const Block& block : lambda.blocks) {
    context_.launch(kernels_(block.lanes).common(), "column_products",
                    kernels_(block.lanes).scalar_rows(s), s.nx, s.ny, s.nz, a[0], a[1], a[2],
                    block.values, light(block), sum);
  }
  return sum;
}

std::vector<double> FieldSums::column_products(const OpenclField& lambda,
                                               const SamplesOf& light) const {
  return read(columns(lambda, light));
}

std::vector<double> FieldSums::weighted_sums(const OpenclField& phi,
                                             std::span<const double> weight) const {
  const GridShape& s = setup_.shape;
  check(weight.size() == s.cells(), "weighted_sums: the weight does not fit the grid");
  const device::Buffer w = uploaded(context_, format_, weight);
  std::vector<double> result;
  for (const Block& block : phi.blocks) {
    const LaneKernels& kernels = kernels_(block.lanes);
    const std::size_t sum_bytes = static_cast<std::size_t>(block.lanes) * format_.accu_bytes();
    const device::Buffer partial = context_.allocate(rows_of(s) * sum_bytes);
    const device::Buffer sum = context_.allocate(sum_bytes);
    context_.launch(kernels.common(), "weighted_rows", kernels.items(rows_of(s)), s.nx,
                    static_cast<int>(rows_of(s)), w, block.values, partial);
    LaneSums sums(context_, format_);
    sums.add_up(kernels, partial, rows_of(s), sum);
    const LaneScalars lanes = sums.read(kernels, sum);
    result.insert(result.end(), lanes.begin(), lanes.begin() + block.count);
  }
  return result;
}

}  // namespace kappamu::forward
