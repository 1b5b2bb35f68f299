// What strangers hand in, one target each: its reader, fed with any bytes, and small good inputs to
// begin from.
#pragma once

#include <filesystem>
#include <string_view>

#include "tests/fuzz/fuzz_file.h"

namespace kappamu::fuzz {

struct Target {
  std::string_view name;
  /// Reads, or throws InputError; anything else is a bug.
  void (*read)(Bytes bytes);
  /// Writes good inputs into the folder.
  void (*seed)(const std::filesystem::path& seeds);
};

// session.cpp
void read_session(Bytes bytes);
void seed_session(const std::filesystem::path& seeds);
void read_import(Bytes bytes);
void seed_import(const std::filesystem::path& seeds);
// image.cpp
void read_image(Bytes bytes);
void seed_image(const std::filesystem::path& seeds);
// arrays.cpp
void read_npy(Bytes bytes);
void seed_npy(const std::filesystem::path& seeds);
void read_measurements(Bytes bytes);
void seed_measurements(const std::filesystem::path& seeds);
void read_volume(Bytes bytes);
void seed_volume(const std::filesystem::path& seeds);
void read_vdb(Bytes bytes);
void seed_vdb(const std::filesystem::path& seeds);
// records.cpp
void read_calibration(Bytes bytes);
void seed_calibration(const std::filesystem::path& seeds);
void read_run(Bytes bytes);
void seed_run(const std::filesystem::path& seeds);
void read_fit(Bytes bytes);
void seed_fit(const std::filesystem::path& seeds);
void read_checkpoint(Bytes bytes);
void seed_checkpoint(const std::filesystem::path& seeds);
// objects.cpp
void read_scene(Bytes bytes);
void seed_scene(const std::filesystem::path& seeds);
void read_mesh(Bytes bytes);
void seed_mesh(const std::filesystem::path& seeds);
// lists.cpp
void read_list(Bytes bytes);
void seed_list(const std::filesystem::path& seeds);

inline constexpr Target targets[] = {
    {"session", read_session, seed_session},
    {"import", read_import, seed_import},
    {"image", read_image, seed_image},
    {"npy", read_npy, seed_npy},
    {"measurements", read_measurements, seed_measurements},
    {"volume", read_volume, seed_volume},
    {"vdb", read_vdb, seed_vdb},
    {"calibration", read_calibration, seed_calibration},
    {"run", read_run, seed_run},
    {"fit", read_fit, seed_fit},
    {"checkpoint", read_checkpoint, seed_checkpoint},
    {"scene", read_scene, seed_scene},
    {"mesh", read_mesh, seed_mesh},
    {"list", read_list, seed_list},
};

}  // namespace kappamu::fuzz
