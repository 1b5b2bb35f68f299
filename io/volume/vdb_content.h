// What an OpenVDB file holds. Only vdb_*.cpp include OpenVDB.
#pragma once

#include <openvdb/openvdb.h>

#include <filesystem>

namespace kappamu::io {

/// Metadata of a file: the refractive index, and what begins the names of texts of its origin.
inline constexpr const char* eta_name = "eta";
inline constexpr const char* provenance_prefix = "provenance_";

/// Before the first grid; throws std::bad_alloc where memory is short.
void start_openvdb();

struct VdbContent {
  openvdb::MetaMap::Ptr metadata;  ///< of the file
  openvdb::GridPtrVec grids;
};

/// As openvdb::io::Stream reads it, instances with the trees they share, but no length is believed
/// that ends behind the file: OpenVDB itself makes room for whatever a text or a compressed block
/// claims, and takes what a truncated file lacks for zeros. Throws InputError for a grid of an
/// unknown type, and any std::exception where the file is damaged or truncated.
VdbContent read_vdb_content(const std::filesystem::path& file);

}  // namespace kappamu::io
