// Lanes of right-hand sides in a device's memory: fields [row][lane], scalars [lane], sums. The
// scalars of conjugate gradients stay there: the kernel that adds a sum up makes of it what the
// next kernel takes (sums.cl), and no iteration waits for the host.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "device/context.h"
#include "forward/linear/conjugate_gradients.h"

namespace kappamu::forward::linear {

/// Of fields and matrix.
enum class Precision { single, twofold };

/// How numbers are kept and sums are made.
struct Numbers {
  Precision precision = Precision::single;
  bool double_sums = true;
  bool interleaved = false;  ///< as GPUs go through rows: side by side, in work-groups

  std::size_t real_bytes() const { return precision == Precision::single ? 4 : 8; }
  std::size_t sum_bytes() const { return double_sums ? 8 : 4; }
};

/// A buffer with `data`; OpenCL has no empty ones.
device::Buffer uploaded(device::Context& context, const void* data, std::size_t bytes);
template <class T>
device::Buffer uploaded(device::Context& context, const std::vector<T>& values) {
  return uploaded(context, values.data(), values.size() * sizeof(T));
}

/// Where the scalars of a batch stand, [place][lane]: CG_SIZE, … in lanes_prelude.cl.
enum class Place : int { size, r_z, before, along, step, length, free };

/// What the work of a batch on a device is made of.
class DeviceLanes {
 public:
  /// Sums of up to `kinds` kinds in a fixed order, of `runs` stretches each (lanes_prelude.cl).
  /// `scaled`: residuals are preconditioned with length one.
  DeviceLanes(device::Context& context, const Numbers& numbers, const Lanes& lanes,
              std::size_t rows, std::size_t runs, bool scaled, std::size_t kinds = 2);

 protected:
  const Lanes& lanes() const { return lanes_; }
  std::size_t width() const { return lanes_.width; }
  std::size_t rows() const { return rows_; }
  const device::Buffer& scalars() const { return scalars_; }
  const device::Buffer& given() const { return given_; }  ///< scalars that the host has written
  device::Program& program(const device::KernelSource& source, const std::string& options) {
    return context_.program(source, options + " " + build_options());
  }

  /// Writes `of_lane` beside each other, [row][width]; lanes without are zero, and fields that are
  /// shorter than others end in zeros.
  void write_lanes(const device::Buffer& buffer,
                   const std::vector<const std::vector<double>*>& of_lane, std::size_t rows,
                   std::size_t width) const;
  /// Reads rows() into the lanes' own vectors.
  void read_lanes(const device::Buffer& buffer,
                  const std::vector<std::vector<double>*>& of_lane) const;

  /// An item per number in [0, count).
  template <class... T>
  void over(device::Program& program, std::size_t count, const char* kernel,
            const T&... arguments) {
    context_.launch(program, kernel, {count, 1, 64, 1}, static_cast<int>(count), arguments...);
  }
  /// Rows in [0, count) in runs.
  template <class... T>
  void in_runs(device::Program& program, std::size_t count, const char* kernel,
               const T&... arguments) {
    context_.launch(program, kernel, {runs_, 1, numbers_.interleaved ? gpu_group : 1, 1},
                    static_cast<int>(count), static_cast<int>(runs_), arguments...);
  }
  /// Σ per lane of a kernel that leaves partial sums of `count` kinds, for the host, which waits.
  template <class... T>
  std::vector<Scalars> sums(device::Program& program, std::size_t count, const char* kernel,
                            const T&... arguments) {
    in_runs(program, rows_, kernel, arguments..., partial_);
    add_up(Place::free, count);
    return read(Place::free, count);
  }
  /// The same of one kind, for the device, with what follows of it.
  template <class... T>
  void sum_to(Place place, device::Program& program, const char* kernel, const T&... arguments) {
    in_runs(program, rows_, kernel, arguments..., partial_);
    add_up(place, 1);
  }
  /// To given().
  void write(const std::vector<Scalars>& values);
  /// No direction yet.
  void begin() { context_.zero(scalars_, scalars_.bytes()); }
  /// Waits for all that is under way.
  CgState look() const;

  device::Context& context_;
  const Numbers numbers_;

 private:
  static constexpr std::size_t gpu_group = 64;

  static constexpr auto free_place = static_cast<std::size_t>(Place::free);

  std::string build_options() const;
  void add_up(Place place, std::size_t count);
  std::vector<Scalars> read(Place place, std::size_t count) const;

  Lanes lanes_;
  std::size_t rows_, runs_;
  device::Buffer partial_, given_, scalars_;
  device::Program& adding_;
};

}  // namespace kappamu::forward::linear
