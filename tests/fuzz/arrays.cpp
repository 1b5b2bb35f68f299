// NumPy arrays, surface measurements and volumes.

#include "io/measurements_file.h"
#include "io/npy.h"
#include "io/read_file.h"
#include "io/volume/volume_file.h"
#include "tests/fuzz/targets.h"

namespace kappamu::fuzz {

namespace fs = std::filesystem;

namespace {

/// Little, so that whoever fills them takes no time from the next input.
constexpr std::size_t most_voxels = 100'000;

SurfaceMeasurements small_measurements() {
  SurfaceMeasurements m;
  m.grid = {3, 2, 2, 0.5};
  m.channels = {"R"};
  m.patterns = 2;
  m.irradiance.assign(12, 1.0F);
  m.value.assign(12, 0.25F);
  m.variance.assign(12, 1e-4F);
  m.mask.assign(12, 1);
  return m;
}

io::VolumeSet small_volume() {
  io::VolumeSet set;
  const GridShape shape{3, 2, 2, 0.5};
  set.channels = {"R"};
  set.media.push_back({Volume<double>(shape, 0.3), Volume<double>(shape, 0.01)});
  set.eta = 1.3;
  set.metadata["session"] = "made up";
  return set;
}

const Files& measurement_files() {
  static const Files files = [] {
    io::write_measurements(folder() / "measurements", small_measurements());
    return Files(folder() / "measurements",
                 {"measurements.json", "irradiance.npy", "value.npy", "variance.npy", "mask.npy"});
  }();
  return files;
}

const Files& volume_files() {
  static const Files files = [] {
    io::write_volume_folder(folder() / "volume", small_volume());
    return Files(folder() / "volume", {"volume.json", "kappa_R.npy", "mu_R.npy"});
  }();
  return files;
}

}  // namespace

void read_npy(Bytes bytes) {
  write(folder() / "array.npy", bytes);
  io::read_npy(folder() / "array.npy");
}

void seed_npy(const fs::path& seeds) {
  const std::vector<double> values{1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  io::write_npy(seeds / "double.npy", {3, 1, 2}, values);
  io::write_npy(seeds / "float.npy", {2}, std::vector<float>{0.5F, 0.25F});
}

void read_measurements(Bytes bytes) {
  const Files& files = measurement_files();
  files.with(bytes, [&] { io::read_measurements(files.path()); });
}

void seed_measurements(const fs::path& seeds) {
  measurement_files().seed(seeds);
}

void read_volume(Bytes bytes) {
  const Files& files = volume_files();
  files.with(bytes, [&] { io::read_volume_folder(files.path(), most_voxels); });
}

void seed_volume(const fs::path& seeds) {
  volume_files().seed(seeds);
}

void read_vdb(Bytes bytes) {
  write(folder() / "volume.vdb", bytes);
  io::read_vdb(folder() / "volume.vdb", most_voxels);
}

void seed_vdb(const fs::path& seeds) {
  io::write_vdb(seeds / "volume.vdb", small_volume());
}

}  // namespace kappamu::fuzz
