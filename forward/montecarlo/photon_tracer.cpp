#include "forward/montecarlo/photon_tracer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/grid/grid_physics.h"
#include "forward/montecarlo/photon_tables.h"

namespace kappamu::forward {

extern const device::KernelSource photon_tracer_cl;

namespace {

// The device adds to the words of these; the host reads them as they lie.
static_assert(sizeof(Score) == 16 && sizeof(PatternTotals) == 112);
static_assert(sizeof(VoxelChances) == 8 && sizeof(AliasEntry) == 8);

constexpr double seconds_per_launch = 0.3;              // between two updates of the progress
constexpr std::uint64_t first_launch_photons = 20'000;  // of all patterns together

template <class T>
device::Buffer upload(device::Context& context, const std::vector<T>& values) {
  device::Buffer buffer = context.allocate(values.size() * sizeof(T));
  context.write(buffer, values.data(), values.size() * sizeof(T));
  return buffer;
}

template <class T>
device::Buffer zeros(device::Context& context, std::size_t count) {
  device::Buffer buffer = context.allocate(count * sizeof(T));
  context.zero(buffer, count * sizeof(T));
  return buffer;
}

void validate(const GridSetup& setup, const TraceOptions& options) {
  validate(setup);
  if (setup.convention != Convention::physical) {
    throw InputError(
        "Monte Carlo transport is physics and knows no convention of the diffusion equation; "
        "choose the physical convention with it");
  }
  if (options.photons < 2 || options.photons > 0xFFFFFFFFULL) {
    throw InputError("photons per pattern is " + std::to_string(options.photons) +
                     "; choose a number from 2 to 4294967295");
  }
}

/// A wrong compiler shows in the generator before it shows in the light.
void check_generator(device::Context& context) {
  const std::array<PhiloxBlock, 1> counter{{{0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}}};
  const PhiloxBlock known{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1};
  if (philox_blocks(context, {0xa4093822, 0x299f31d0}, counter).front() != known) {
    throw device::DeviceError("device '" + context.info().name +
                              "' draws wrong random numbers (Philox4x32-10, known answer); choose "
                              "another device");
  }
}

int mirrored_axes(const GridSetup& setup) {
  int mask = 0;
  for (const Face face : all_faces) {
    if (!is_open(setup, face)) mask |= 1 << axis_of(face);
  }
  return mask;
}

/// Enough work-items to fill the device, few enough that each follows many photons.
device::Range range_of(const device::DeviceInfo& device, std::size_t patterns,
                       std::optional<std::size_t> wanted) {
  const bool gpu = device.kind == device::Kind::gpu;
  const std::size_t local = gpu ? 64 : 4;
  const std::size_t all = device.compute_units * (gpu ? std::size_t{2048} : std::size_t{128});
  const std::size_t items = wanted.value_or(std::max(local, all / patterns));
  return {(items + local - 1) / local * local, patterns, local, 1};
}

/// Where photons enter each pattern's pixels, and the patterns that have light.
struct Entries {
  std::vector<AliasEntry> pixels;
  std::vector<std::int32_t> lit_patterns;
};

/// The last `points` patterns are points.
Entries entries_of(std::span<const double> irradiance, std::size_t lit_pixels, std::size_t patterns,
                   std::size_t points) {
  Entries entries{std::vector<AliasEntry>(patterns * lit_pixels), {}};
  for (std::size_t m = 0; m < patterns; ++m) {
    const bool point = m >= patterns - points;
    const std::span<const double> light = irradiance.subspan(m * lit_pixels, lit_pixels);
    const bool dark = std::all_of(light.begin(), light.end(), [](double e) { return e == 0.0; });
    if (dark && !point) continue;
    entries.lit_patterns.push_back(static_cast<std::int32_t>(m));
    if (point) continue;
    const std::vector<AliasEntry> aliases = alias_table(light);
    std::copy(aliases.begin(), aliases.end(),
              entries.pixels.begin() + static_cast<std::ptrdiff_t>(m * lit_pixels));
  }
  return entries;
}

/// x, y, z [voxel edges] and nothing.
std::vector<std::array<float, 4>> points_of(const GridShape& shape, const LightGeometry& light) {
  std::vector<std::array<float, 4>> points;
  for (const PointSource& point : light.points) {
    const Eigen::Vector3f at = (point.position_mm / shape.voxel_mm).cast<float>();
    points.push_back({at.x(), at.y(), at.z(), 0.0F});
  }
  if (points.empty()) points.push_back({});  // a device has no empty buffers
  return points;
}

/// x, y, z [voxel edges] of the cameras before the two faces across an axis, and whether there is
/// one; the axis, or -1.
struct CameraTable {
  int axis = -1;
  std::vector<std::array<float, 4>> position{{}, {}};
};
CameraTable camera_table(const GridShape& shape, const Cameras& cameras) {
  CameraTable table;
  for (const auto& [face, position_mm] : cameras) {
    check(table.axis < 0 || table.axis == axis_of(face), "cameras see opposite faces");
    table.axis = axis_of(face);
    const Eigen::Vector3f at = (position_mm / shape.voxel_mm).cast<float>();
    table.position[is_plus(face) ? 1 : 0] = {at.x(), at.y(), at.z(), 1.0F};
  }
  return table;
}

/// Tallies that photons add to more than once, emptied after every batch of photons.
class BatchedTally {
 public:
  BatchedTally(device::Context& context, std::uint64_t photons, std::size_t values)
      : context_(context),
        buffer_(zeros<std::uint64_t>(context, std::max<std::size_t>(1, values))),
        photons_(photons),
        batches_(std::max(std::min(least_batches, photons),
                          (photons + most_in_a_batch - 1) / most_in_a_batch)),
        sum_(values, 0.0),
        squares_(values, 0.0) {}

  const device::Buffer& buffer() const { return buffer_; }
  bool wanted() const { return !sum_.empty(); }

  /// The end of the batch that photon `first` belongs to; all of them where nothing is tallied.
  std::uint64_t end_of_batch(std::uint64_t first) const {
    if (!wanted()) return photons_;
    std::uint64_t batch = first * batches_ / photons_;
    while (start(batch + 1) <= first) ++batch;
    return start(batch + 1);
  }

  void finish_batch(std::uint64_t last) {
    if (!wanted()) return;
    std::vector<std::uint64_t> weights(sum_.size());
    context_.read(buffer_, weights.data(), weights.size() * sizeof(std::uint64_t));
    context_.zero(buffer_, weights.size() * sizeof(std::uint64_t));
    const auto photons = static_cast<double>(last - finished_);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const double weight = static_cast<double>(weights[i]) / Score::full_weight;
      sum_[i] += weight;
      squares_[i] += weight * weight / photons;
    }
    finished_ = last;
    ++count_;
  }

  /// Means per photon times `unit` of the values from `first` on, and their standard errors from
  /// the scatter of the batches.
  void append(double unit, std::size_t first, std::size_t count, std::vector<double>& means,
              std::vector<double>& errors) const {
    const auto n = static_cast<double>(photons_);
    for (std::size_t i = first; i < std::min(first + count, sum_.size()); ++i) {
      const double mean = sum_[i] / n;
      const double scatter = std::max(0.0, squares_[i] / n - mean * mean);
      means.push_back(unit * mean);
      errors.push_back(unit * std::sqrt(scatter / std::max(1.0, count_ - 1.0)));
    }
  }

 private:
  static constexpr std::uint64_t least_batches = 10;
  /// So many full weights may add to one value 8192 times each before 64 bits overflow.
  static constexpr std::uint64_t most_in_a_batch = 1 << 20;

  std::uint64_t start(std::uint64_t batch) const { return batch * photons_ / batches_; }

  device::Context& context_;
  device::Buffer buffer_;
  std::uint64_t photons_, batches_, finished_ = 0;
  double count_ = 0.0;
  std::vector<double> sum_, squares_;
};

}  // namespace

double Score::mean(std::uint64_t photons) const {
  return static_cast<double>(weight) / full_weight / static_cast<double>(photons);
}

double Score::standard_error(std::uint64_t photons) const {
  const auto n = static_cast<double>(photons);
  const double average = mean(photons);
  const double second = static_cast<double>(square) / full_square / n;
  return std::sqrt(std::max(0.0, second - average * average) / (n - 1.0));
}

std::size_t first_pixel(const GridShape& shape, Face face) {
  std::size_t first = 0;
  for (const Face before : all_faces) {
    if (before == face) break;
    first += face_shape(shape, before).cells();
  }
  return first;
}

std::size_t surface_pixels(const GridShape& shape) {
  return first_pixel(shape, Face::z_plus) + face_shape(shape, Face::z_plus).cells();
}

std::vector<PhiloxBlock> philox_blocks(device::Context& context, std::array<std::uint32_t, 2> key,
                                       std::span<const PhiloxBlock> counters) {
  const std::vector<PhiloxBlock> in(counters.begin(), counters.end());
  std::vector<PhiloxBlock> out(in.size());
  const device::Buffer counter_buffer = upload(context, in);
  const device::Buffer block_buffer = context.allocate(out.size() * sizeof(PhiloxBlock));
  context.launch(context.program(photon_tracer_cl, ""), "philox_blocks",
                 {.global0 = in.size(), .global1 = 1, .local0 = 1, .local1 = 1}, key[0], key[1],
                 static_cast<int>(in.size()), counter_buffer, block_buffer);
  context.read(block_buffer, out.data(), out.size() * sizeof(PhiloxBlock));
  return out;
}

PhotonTally trace_photons(device::Context& context, const GridSetup& setup, const Medium& medium,
                          std::span<const double> irradiance, int patterns,
                          const TraceOptions& options, Progress& progress) {
  validate(setup, options);
  validate(setup, options.light, patterns);
  const GridShape& shape = setup.shape;
  validate_medium(shape, medium.kappa.values(), medium.mu.values());
  const auto count = static_cast<std::size_t>(patterns);
  const std::size_t lit_pixels = face_shape(shape, setup.lit_face).cells();
  check(irradiance.size() == count * lit_pixels, "trace_photons: wrong number of irradiances");
  check_generator(context);

  const CollisionTable table = collision_table(medium, options.anisotropy);
  const auto [entry, lit_patterns] =
      entries_of(irradiance, lit_pixels, count, options.light.points.size());

  PhotonTally tally;
  tally.photons = options.photons;
  tally.majorant = table.majorant;
  tally.mean_extinction = table.mean;
  tally.exits.resize(count * surface_pixels(shape));
  tally.totals.resize(count);
  const CameraTable cameras = camera_table(shape, options.cameras);
  const std::size_t view_pixels =
      options.cameras.empty() ? 0 : face_shape(shape, options.cameras.begin()->first).cells();
  BatchedTally fluence(context, options.photons, options.fluence ? count * shape.cells() : 0);
  BatchedTally view(context, options.photons, 2 * count * view_pixels);
  const auto write_batched = [&] {
    const double unit = 1.0 / (table.majorant * std::pow(shape.voxel_mm, 3));
    fluence.append(unit, 0, count * shape.cells(), tally.fluence, tally.fluence_error);
    for (const auto& [face, position_mm] : options.cameras) {
      const auto f = static_cast<std::size_t>(face);
      for (std::size_t m = 0; m < count; ++m) {
        view.append(1.0, (2 * m + (is_plus(face) ? 1 : 0)) * view_pixels, view_pixels,
                    tally.view[f], tally.view_error[f]);
      }
    }
  };
  if (lit_patterns.empty()) {
    fluence.finish_batch(options.photons);
    view.finish_batch(options.photons);
    write_batched();
    return tally;
  }

  device::Program& program = context.program(photon_tracer_cl, "");
  const device::Buffer voxels = upload(context, table.voxels);
  const device::Buffer entries = upload(context, entry);
  const device::Buffer lit = upload(context, lit_patterns);
  const device::Buffer exits = zeros<Score>(context, tally.exits.size());
  const device::Buffer totals = zeros<PatternTotals>(context, count);
  const device::Buffer points = upload(context, points_of(shape, options.light));
  const device::Buffer camera_positions = upload(context, cameras.position);
  const auto two_a = static_cast<float>(2.0 * boundary_constants(setup.eta).A);
  const Eigen::Vector3f beam = enter_beam(setup, options.light).direction.cast<float>();
  const device::Range range = range_of(context.info(), lit_patterns.size(), options.items);
  const auto step = static_cast<float>(1.0 / (table.majorant * shape.voxel_mm));
  std::uint64_t chunk = std::max<std::uint64_t>(1, first_launch_photons / lit_patterns.size());
  for (std::uint64_t first = 0; first < options.photons;) {
    const std::uint64_t batch_end = std::min(fluence.end_of_batch(first), view.end_of_batch(first));
    const std::uint64_t last = std::min(batch_end, first + chunk);
    const Stopwatch watch;
    context.launch(program, "trace", range, shape.nx, shape.ny, shape.nz, step,
                   static_cast<float>(options.anisotropy), static_cast<float>(setup.eta),
                   static_cast<int>(setup.lit_face), mirrored_axes(setup),
                   setup.source == SourceModel::boundary ? 1 : 0,
                   static_cast<std::uint32_t>(options.seed),
                   static_cast<std::uint32_t>(options.seed >> 32), first, last,
                   static_cast<std::int32_t>(lit_patterns.size()), lit, voxels, entries, beam.x(),
                   beam.y(), beam.z(), static_cast<int>(count - options.light.points.size()),
                   points, fluence.wanted() ? 1 : 0, fluence.buffer(), cameras.axis, two_a,
                   camera_positions, view.buffer(), exits, totals);
    context.finish();
    if (last == batch_end) {
      fluence.finish_batch(last);
      view.finish_batch(last);
    }
    const double wanted =
        static_cast<double>(last - first) * seconds_per_launch / std::max(watch.seconds(), 1e-6);
    chunk = std::clamp(static_cast<std::uint64_t>(wanted), std::max<std::uint64_t>(1, chunk / 4),
                       4 * chunk);
    first = last;
    progress.update(
        "photons", static_cast<double>(last) / static_cast<double>(options.photons),
        std::to_string(last) + " of " + std::to_string(options.photons) + " per pattern");
  }
  write_batched();
  context.read(exits, tally.exits.data(), tally.exits.size() * sizeof(Score));
  context.read(totals, tally.totals.data(), tally.totals.size() * sizeof(PatternTotals));
  return tally;
}

}  // namespace kappamu::forward
