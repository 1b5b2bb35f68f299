// What goes in and out of a block through its faces. Values of a face, [pattern][sample] in double,
// are the host's or in the device's memory; kernels have them by [sample][lane] in their own
// numbers.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "device/buffer_pool.h"
#include "device/context.h"
#include "forward/grid/grid_solver.h"
#include "forward/grid/opencl/multigrid/grid_hierarchy.h"
#include "forward/grid/opencl/opencl_field.h"
#include "forward/grid/opencl/trusted_kernels.h"

namespace kappamu::forward {

/// The values of one face among those of an array [pattern][face][sample] in double on the device.
struct FaceOnDevice {
  device::Buffer values;
  std::size_t first;   ///< of pattern 0
  std::size_t stride;  ///< from one pattern to the next
  std::size_t first_of(const Block& block) const {
    return first + stride * static_cast<std::size_t>(block.first);
  }
};

/// What to do with them.
using TakeSamples = std::function<void(const Block& block, const device::Buffer& samples)>;

class OpenclFaces {
 public:
  /// All must outlive this.
  OpenclFaces(device::Context& context, const Format& format, const GridSetup& setup,
              const BoundaryConstants& constants, TrustedKernels& kernels,
              const std::optional<Hierarchy>& hierarchy, device::BufferPool& pool);

  /// Each value times `factor`, in double.
  SamplesOf samples(Face face, std::span<const double> values, double factor = 1.0) const;
  SamplesOf samples(Face face, const FaceOnDevice& values, double factor = 1.0) const;
  TakeSamples to_host(Face face, std::span<double> values) const;
  TakeSamples to_device(Face face, const FaceOnDevice& values) const;

  void zero(const OpenclField& b) const;
  /// Adds GridSolver::exitance_adjoint() to b.
  void add_seen(Face face, const SamplesOf& weights, const OpenclField& b) const;
  /// GridSolver::light_source() of light times light_factor(); `deposit`: the fractions of first
  /// collisions, where these are the source.
  void light_source(const SamplesOf& light, const device::Buffer& deposit,
                    const OpenclField& b) const;
  double light_factor() const;
  /// GridSolver::exitance().
  void exitance(const OpenclField& phi, Face face, const SamplesOf& light,
                const TakeSamples& take) const;
  /// Whether the exitance of a face needs the light on it.
  bool needs_light(Face face) const;

 private:
  std::size_t count(Face face) const { return face_shape(setup_.shape, face).cells(); }
  double area() const { return setup_.shape.voxel_mm * setup_.shape.voxel_mm; }
  std::size_t bytes(Face face, const Block& block) const;
  device::Buffer dark(Face face, const Block& block) const;
  /// b += scale G_b values on the face's cells.
  void add_on_face(Face face, const SamplesOf& values, double scale, const OpenclField& b) const;
  template <class F, class... T>
  void with_reals(F f, T... values) const;
  template <class F>
  void on_face(Face face, F launch) const;

  device::Context& context_;
  Format format_;
  const GridSetup& setup_;
  const BoundaryConstants& constants_;
  TrustedKernels& kernels_;
  const std::optional<Hierarchy>& hierarchy_;
  device::BufferPool& pool_;
};

}  // namespace kappamu::forward
