#include "io/volume/vdb_content.h"

#include <malloc.h>
#include <openvdb/io/Archive.h>
#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/io/GridDescriptor.h>
#include <openvdb/io/io.h>
#include <tbb/parallel_for.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <map>
#include <new>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

/// A file that ends where a length in it leads beyond its end.
class BoundedFile : public std::filebuf {
 public:
  explicit BoundedFile(const fs::path& file)
      : size_(static_cast<std::streamoff>(fs::file_size(file))) {
    open(file, std::ios::in | std::ios::binary);
  }
  std::streamoff left() { return size_ - seekoff(0, std::ios::cur, std::ios::in); }
  /// While true, each number of eight bytes is the length of a compressed block: OpenVDB reads
  /// nothing else of that size in a tree.
  void expect_blocks(bool expected) { blocks_ = expected; }

 protected:
  std::streamsize xsgetn(char* to, std::streamsize count) override {
    const bool is_block = std::exchange(uncompressed_, false);
    // OpenVDB reads such a block into a buffer of its own from the heap, and only then compares
    // the block's length with the buffer's.
    if (is_block && count > static_cast<std::streamsize>(malloc_usable_size(to))) return 0;
    const std::streamsize taken = std::filebuf::xsgetn(to, count);
    std::int64_t length = 0;
    if (!blocks_ || is_block || taken != sizeof length) return taken;
    std::memcpy(&length, to, sizeof length);
    uncompressed_ = length < 0;
    return length > left() || length < -left() ? 0 : taken;
  }

 private:
  std::streamoff size_;
  bool blocks_ = false;
  bool uncompressed_ = false;  ///< the length just read was negative: an uncompressed block follows
};

class ContentReader : public openvdb::io::Archive {
 public:
  explicit ContentReader(const fs::path& file) : path_(file), file_(file), in_(&file_) {
    in_.exceptions(std::ios::badbit | std::ios::failbit | std::ios::eofbit);
  }

  VdbContent read() {
    readHeader(in_);
    setFormatVersion(in_);
    setLibraryVersion(in_);
    setDataCompression(in_);
    VdbContent content{std::make_shared<openvdb::MetaMap>(), {}};
    check_metadata();
    content.metadata->readMeta(in_);
    const std::int32_t grids = readGridCount(in_);
    for (std::int32_t i = 0; i < grids; ++i) content.grids.push_back(read_grid());
    for (const auto& [grid, parent] : instances_) grid->setTree(whole_.at(parent)->baseTreePtr());
    return content;
  }

 private:
  openvdb::GridBase::Ptr read_grid() {
    looking_ahead([&] {
      const std::string name = text(), type = text();
      skip();  // the name of the instance's parent
      require_known(name, type);
    });
    openvdb::io::GridDescriptor descriptor;
    openvdb::GridBase::Ptr grid = descriptor.read(in_);
    // OpenVDB never frees what it has of a grid when the file ends in it.
    const std::streamoff begin = descriptor.getGridPos();
    const std::streamoff end = descriptor.getEndPos();
    if (begin < 0 || end < 0 || end - begin > file_.left()) throw std::runtime_error("truncated");
    grid->setName(descriptor.gridName());
    readGridCompression(in_);
    check_metadata();
    grid->readMeta(in_);
    looking_ahead([&] { skip(); });  // the transform's type
    grid->readTransform(in_);
    if (descriptor.isInstance()) {
      instances_.emplace_back(grid, descriptor.instanceParentName());
      return grid;
    }
    whole_.emplace(descriptor.uniqueName(), grid);
    file_.expect_blocks(true);
    grid->readTopology(in_);
    grid->readBuffers(in_);
    file_.expect_blocks(false);
    return grid;
  }

  void require_known(const std::string& name, std::string type) const {
    constexpr std::string_view half = "_HalfFloat";  // how it is stored, not what it is
    if (type.ends_with(half)) type.resize(type.size() - half.size());
    if (openvdb::GridBase::isRegistered(type)) return;
    throw InputError(path_.string() + ": grid " + openvdb::io::GridDescriptor::nameAsString(name) +
                     " is of type '" + shown_name(type) + "', which OpenVDB " +
                     openvdb::getLibraryVersionString() +
                     " cannot read; leave it out, or write it as a float grid");
  }

  /// Names, types and values of OpenVDB's metadata.
  void check_metadata() {
    looking_ahead([&] {
      const std::uint32_t count = number();
      for (std::uint32_t i = 0; i < count; ++i) {
        skip();
        const std::string type = text();
        const std::streampos begin = in_.tellg();
        skip();
        if (!openvdb::Metadata::isRegisteredType(type)) continue;
        // Values of a known type are read by their own size, whatever the file says.
        in_.seekg(begin);
        if (type == openvdb::io::DelayedLoadMetadata::staticTypeName()) check_delayed_load();
        openvdb::Metadata::createMetadata(type)->read(in_);
      }
    });
  }

  /// Memory is allocated for the leaves and bytes that this metadata claims before they are read:
  /// its length, the number of leaves, and of a byte and of a size per leaf the bytes they are
  /// compressed to, 0 where they are not.
  void check_delayed_load() {
    looking_ahead([&] {
      if (length() == 0) return;
      const std::uint32_t leaves = length();
      const std::uint32_t compressed = length();
      in_.seekg(compressed > 0 ? compressed : leaves, std::ios::cur);
      length();
    });
  }

  template <class Look>
  void looking_ahead(const Look& look) {
    const std::streampos begin = in_.tellg();
    look();
    in_.seekg(begin);
  }
  std::uint32_t number() {
    std::uint32_t value = 0;
    in_.read(reinterpret_cast<char*>(&value), sizeof value);
    return value;
  }
  std::uint32_t length() {
    const std::uint32_t value = number();
    if (std::streamoff{value} > file_.left()) throw std::runtime_error("truncated");
    return value;
  }
  std::string text() {
    std::string value(length(), '\0');
    in_.read(value.data(), static_cast<std::streamsize>(value.size()));
    return value;
  }
  void skip() { in_.seekg(length(), std::ios::cur); }

  const fs::path& path_;
  /// Trees by the names that instances give; an instance has none of its own.
  std::map<std::string, openvdb::GridBase::Ptr> whole_;
  std::vector<std::pair<openvdb::GridBase::Ptr, std::string>> instances_;
  BoundedFile file_;
  std::istream in_;
};

}  // namespace

// Two first steps of libraries that a lack of memory spoils for good: TBB, whose start fails, waits
// forever when it is next used, as by a grid that ends; OpenVDB puts the names of its types
// together by streams, which do not tell.
void start_openvdb() {
  tbb::parallel_for(0, 1, [](int) {});
  openvdb::initialize();
  if (openvdb::FloatGrid::gridType() != "Tree_float_5_4_3" ||
      openvdb::Vec3SGrid::gridType() != "Tree_vec3s_5_4_3") {
    throw std::bad_alloc();
  }
}

VdbContent read_vdb_content(const fs::path& file) {
  return ContentReader(file).read();
}

}  // namespace kappamu::io
