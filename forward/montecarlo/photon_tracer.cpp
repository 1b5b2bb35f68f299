#include "forward/montecarlo/photon_tracer.h"

#include <algorithm>
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
                              "another with --device");
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
  const GridShape& shape = setup.shape;
  validate_medium(shape, medium.kappa.values(), medium.mu.values());
  const auto count = static_cast<std::size_t>(patterns);
  const std::size_t lit_pixels = face_shape(shape, setup.lit_face).cells();
  check(irradiance.size() == count * lit_pixels, "trace_photons: wrong number of irradiances");
  check_generator(context);

  const CollisionTable table = collision_table(medium, options.anisotropy);
  std::vector<AliasEntry> entry(count * lit_pixels);
  std::vector<std::int32_t> lit_patterns;
  for (std::size_t m = 0; m < count; ++m) {
    const std::span<const double> light = irradiance.subspan(m * lit_pixels, lit_pixels);
    if (std::all_of(light.begin(), light.end(), [](double e) { return e == 0.0; })) continue;
    lit_patterns.push_back(static_cast<std::int32_t>(m));
    const std::vector<AliasEntry> aliases = alias_table(light);
    std::copy(aliases.begin(), aliases.end(),
              entry.begin() + static_cast<std::ptrdiff_t>(m * lit_pixels));
  }

  PhotonTally tally;
  tally.photons = options.photons;
  tally.majorant = table.majorant;
  tally.mean_extinction = table.mean;
  tally.exits.resize(count * surface_pixels(shape));
  tally.totals.resize(count);
  if (lit_patterns.empty()) return tally;

  device::Program& program = context.program(photon_tracer_cl, "");
  const device::Buffer voxels = upload(context, table.voxels);
  const device::Buffer entries = upload(context, entry);
  const device::Buffer lit = upload(context, lit_patterns);
  const device::Buffer exits = zeros<Score>(context, tally.exits.size());
  const device::Buffer totals = zeros<PatternTotals>(context, count);
  const device::Range range = range_of(context.info(), lit_patterns.size(), options.items);
  const auto step = static_cast<float>(1.0 / (table.majorant * shape.voxel_mm));
  std::uint64_t chunk = std::max<std::uint64_t>(1, first_launch_photons / lit_patterns.size());
  for (std::uint64_t first = 0; first < options.photons;) {
    const std::uint64_t last = std::min(options.photons, first + chunk);
    const Stopwatch watch;
    context.launch(
        program, "trace", range, shape.nx, shape.ny, shape.nz, step,
        static_cast<float>(options.anisotropy), static_cast<float>(setup.eta),
        static_cast<int>(setup.lit_face), mirrored_axes(setup),
        setup.source == SourceModel::boundary ? 1 : 0, static_cast<std::uint32_t>(options.seed),
        static_cast<std::uint32_t>(options.seed >> 32), first, last,
        static_cast<std::int32_t>(lit_patterns.size()), lit, voxels, entries, exits, totals);
    context.finish();
    const double wanted =
        static_cast<double>(chunk) * seconds_per_launch / std::max(watch.seconds(), 1e-6);
    chunk = std::clamp(static_cast<std::uint64_t>(wanted), std::max<std::uint64_t>(1, chunk / 4),
                       4 * chunk);
    first = last;
    progress.update(
        "photons", static_cast<double>(last) / static_cast<double>(options.photons),
        std::to_string(last) + " of " + std::to_string(options.photons) + " per pattern");
  }
  context.read(exits, tally.exits.data(), tally.exits.size() * sizeof(Score));
  context.read(totals, tally.totals.data(), tally.totals.size() * sizeof(PatternTotals));
  return tally;
}

}  // namespace kappamu::forward
