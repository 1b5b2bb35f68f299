// Volumes to OpenVDB files.
#include <openvdb/io/Archive.h>
#include <openvdb/openvdb.h>

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/numbers/fnv.h"
#include "core/shown_text.h"
#include "io/atomic_file.h"
#include "io/volume/vdb_content.h"
#include "io/volume/volume_file.h"

namespace kappamu::io {

namespace {

/// OpenVDB's file writer, over a stream of ours: its own opens the file itself and does not notice
/// a full disk. Seekable, so that readers find single grids fast.
class StreamArchive : public openvdb::io::Archive {
 public:
  void write_to(std::ostream& out, const openvdb::GridCPtrVec& grids,
                const openvdb::MetaMap& metadata, const std::string& identity) const {
    Archive::write(out, grids, /*seekable=*/true, metadata);
    // OpenVDB puts a random UUID after magic number, file version, library version and offset flag
    // (8 + 4 + 8 + 1 bytes). Ours follows from the content: same volume, same bytes.
    constexpr std::streamoff uuid_offset = 21;
    out.seekp(uuid_offset);
    out << identity;
  }
};

/// A UUID (version 8 of RFC 9562, which leaves its bits free) from all numbers and texts, by the
/// 64-bit hash FNV-1a.
std::string identity_of(const std::vector<NamedVolume>& volumes,
                        const std::map<std::string, std::string>& metadata) {
  Fnv hash;
  for (const NamedVolume& named : volumes) {
    hash.add(named.name.data(), named.name.size());
    hash.add(named.volume->values().data(), named.volume->size() * sizeof(double));
  }
  for (const auto& [name, text] : metadata) {
    hash.add(name.data(), name.size());
    hash.add(text.data(), text.size());
  }
  const std::uint64_t high = hash.value();
  hash.add(&high, sizeof high);
  const std::uint64_t low = hash.value();
  return formatted("%08x-%04x-8%03x-8%03x-%012llx", static_cast<unsigned>(high >> 32),
                   static_cast<unsigned>(high >> 16 & 0xFFFF), static_cast<unsigned>(high & 0xFFF),
                   static_cast<unsigned>(low >> 52),
                   static_cast<unsigned long long>(low & 0xFFFFFFFFFFFF));
}

/// Sample frame [mm] from voxel index: scale by h, centres at half voxels.
openvdb::math::Transform::Ptr sample_from_index(double voxel_mm) {
  auto transform = openvdb::math::Transform::createLinearTransform(voxel_mm);
  transform->postTranslate(openvdb::Vec3d(0.5 * voxel_mm));
  return transform;
}

openvdb::CoordBBox box_of(const GridShape& shape) {
  return {openvdb::Coord(0), openvdb::Coord(shape.nx - 1, shape.ny - 1, shape.nz - 1)};
}

/// Of zeros. The library makes it: Grid::create() would compile all of the tree anew.
template <class Grid>
typename Grid::Ptr made() {
  return openvdb::gridPtrCast<Grid>(openvdb::GridBase::createGrid(Grid::gridType()));
}

openvdb::FloatGrid::Ptr make_grid(const std::string& name, const std::string& unit,
                                  const Volume<double>& volume) {
  const GridShape& shape = volume.shape();
  const auto grid = made<openvdb::FloatGrid>();
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(sample_from_index(shape.voxel_mm));
  grid->insertMeta("units", openvdb::StringMetadata(unit));
  // Active everywhere, also where the value equals the background (μ = 0 is a measurement).
  grid->denseFill(box_of(shape), 0.0F, true);
  auto accessor = grid->getAccessor();
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        accessor.setValueOnly(openvdb::Coord(x, y, z), static_cast<float>(volume(x, y, z)));
      }
    }
  }
  return grid;
}

/// Three channels as one grid, as shaders of renderers take them.
openvdb::Vec3SGrid::Ptr make_colour_grid(const std::string& name, const std::string& unit,
                                         const std::array<const Volume<double>*, 3>& channels) {
  const GridShape& shape = channels[0]->shape();
  const auto grid = made<openvdb::Vec3SGrid>();
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  grid->setTransform(sample_from_index(shape.voxel_mm));
  grid->insertMeta("units", openvdb::StringMetadata(unit));
  grid->denseFill(box_of(shape), openvdb::Vec3s(0.0F), true);
  auto accessor = grid->getAccessor();
  for (int z = 0; z < shape.nz; ++z) {
    for (int y = 0; y < shape.ny; ++y) {
      for (int x = 0; x < shape.nx; ++x) {
        const auto value = [&](std::size_t c) {
          return static_cast<float>((*channels[c])(x, y, z));
        };
        accessor.setValueOnly(openvdb::Coord(x, y, z), {value(0), value(1), value(2)});
      }
    }
  }
  return grid;
}

openvdb::MetaMap common_metadata() {
  openvdb::MetaMap map;
  map.insertMeta("creator", openvdb::StringMetadata("kappamu"));
  map.insertMeta("world_units", openvdb::StringMetadata("mm"));
  return map;
}

openvdb::MetaMap file_metadata(const VolumeSet& set) {
  openvdb::MetaMap map = common_metadata();
  const GridShape& shape = set.shape();
  std::string channels;
  for (const std::string& name : set.channels) {
    channels.append(channels.empty() ? "" : " ").append(name);
  }
  map.insertMeta("channels", openvdb::StringMetadata(channels));
  map.insertMeta("grid", openvdb::Vec3IMetadata({shape.nx, shape.ny, shape.nz}));
  map.insertMeta("voxel_mm", openvdb::DoubleMetadata(shape.voxel_mm));
  if (set.eta) map.insertMeta(eta_name, openvdb::DoubleMetadata(*set.eta));
  for (const auto& [name, text] : set.metadata) {
    map.insertMeta(provenance_prefix + name, openvdb::StringMetadata(text));
  }
  return map;
}

openvdb::GridCPtrVec make_grids(const VolumeSet& set) {
  openvdb::GridCPtrVec grids;
  for (const NamedVolume& named : named_volumes(set)) {
    grids.push_back(make_grid(named.name, named.unit, *named.volume));
  }
  Volume<double> density(set.shape());
  std::vector<ScatteringVolumes> scattering;
  for (std::size_t c = 0; c < set.channels.size(); ++c) {
    scattering.push_back(scattering_volumes(set.media[c]));
    const Volume<double>& sigma_t = scattering.back().sigma_t;
    grids.push_back(make_grid("sigma_t_" + set.channels[c], "1/mm", sigma_t));
    grids.push_back(make_grid("albedo_" + set.channels[c], "1", scattering.back().albedo));
    for (std::size_t i = 0; i < density.size(); ++i) {
      density[i] += sigma_t[i] / static_cast<double>(set.channels.size());
    }
  }
  grids.push_back(make_grid("density", "1/mm", density));
  if (set.channels == std::vector<std::string>{"R", "G", "B"}) {
    grids.push_back(
        make_colour_grid("sigma_t", "1/mm",
                         {&scattering[0].sigma_t, &scattering[1].sigma_t, &scattering[2].sigma_t}));
    grids.push_back(make_colour_grid(
        "color", "1", {&scattering[0].albedo, &scattering[1].albedo, &scattering[2].albedo}));
  }
  return grids;
}

}  // namespace

void write_vdb(const std::filesystem::path& file, const VolumeSet& set) {
  validate(set, file.string());
  start_openvdb();
  const openvdb::GridCPtrVec grids = make_grids(set);
  const std::string identity = identity_of(named_volumes(set), set.metadata);
  write_stream_atomically(file, [&](std::ostream& out) {
    StreamArchive().write_to(out, grids, file_metadata(set), identity);
  });
}

void write_vdb(const std::filesystem::path& file, const std::vector<NamedVolume>& volumes) {
  start_openvdb();
  openvdb::GridCPtrVec grids;
  for (const NamedVolume& named : volumes) {
    grids.push_back(make_grid(named.name, named.unit, *named.volume));
  }
  write_stream_atomically(file, [&](std::ostream& out) {
    StreamArchive().write_to(out, grids, common_metadata(), identity_of(volumes, {}));
  });
}

}  // namespace kappamu::io
