#include "app/mpi/npy_parts.h"

#include <array>
#include <numeric>

#include "core/error.h"
#include "forward/distributed/together.h"
#include "io/npy.h"

namespace kappamu::app::mpi {

namespace {

namespace fs = std::filesystem;
using forward::distributed::Box;
using forward::distributed::on_first;
using forward::distributed::shared;
using forward::distributed::together;

/// A file that all ranks have opened; closed by them at the end.
class SharedFile {
 public:
  SharedFile(MPI_Comm comm, const fs::path& file, int mode) : name_(file.string()), comm_(comm) {
    require(MPI_File_open(comm, name_.c_str(), mode, MPI_INFO_NULL, &file_), "open");
  }
  ~SharedFile() {
    if (file_ != MPI_FILE_NULL) MPI_File_close(&file_);
  }
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  MPI_File get() const { return file_; }
  /// All fail where one does.
  void require(int code, const char* what) const {
    together(comm_, [&] {
      if (code == MPI_SUCCESS) return;
      std::array<char, MPI_MAX_ERROR_STRING> text{};
      int length = 0;
      MPI_Error_string(code, text.data(), &length);
      throw InputError(name_ + ": cannot " + what + " it (" + text.data() + ")");
    });
  }

 private:
  std::string name_;
  MPI_Comm comm_;
  MPI_File file_ = MPI_FILE_NULL;
};

/// The numbers of `part` in a file, as MPI sees them.
class View {
 public:
  View(const SharedFile& file, const Part& part, std::size_t begin, MPI_Datatype number) {
    const auto ints = [](const std::vector<std::size_t>& v) {
      return std::vector<int>(v.begin(), v.end());
    };
    if (part.size() == 0) {
      file.require(MPI_File_set_view(file.get(), static_cast<MPI_Offset>(begin), number, number,
                                     "native", MPI_INFO_NULL),
                   "read");
      return;
    }
    MPI_Type_create_subarray(static_cast<int>(part.shape.size()), ints(part.shape).data(),
                             ints(part.count).data(), ints(part.begin).data(), MPI_ORDER_C, number,
                             &type_);
    MPI_Type_commit(&type_);
    file.require(MPI_File_set_view(file.get(), static_cast<MPI_Offset>(begin), number, type_,
                                   "native", MPI_INFO_NULL),
                 "read");
  }
  ~View() {
    if (type_ != MPI_DATATYPE_NULL) MPI_Type_free(&type_);
  }
  View(const View&) = delete;
  View& operator=(const View&) = delete;

 private:
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
};

template <class T>
std::vector<double> read_numbers(const SharedFile& file, const Part& part, std::size_t begin,
                                 MPI_Datatype number) {
  const View view(file, part, begin, number);
  std::vector<T> numbers(part.size());
  file.require(MPI_File_read_all(file.get(), numbers.data(), static_cast<int>(numbers.size()),
                                 number, MPI_STATUS_IGNORE),
               "read");
  return {numbers.begin(), numbers.end()};
}

template <class T>
void write_numbers(MPI_Comm comm, const fs::path& name, const Part& part, std::span<const T> values,
                   const char* type, MPI_Datatype number) {
  check(values.size() == part.size(), "the values do not fit their part of the array");
  const SharedFile file(comm, name, MPI_MODE_CREATE | MPI_MODE_WRONLY);
  const std::string header = io::npy_header(type, part.shape);
  int rank = 0;
  MPI_Comm_rank(comm, &rank);
  int written = MPI_SUCCESS;
  if (rank == 0) {
    written = MPI_File_write_at(file.get(), 0, header.data(), static_cast<int>(header.size()),
                                MPI_CHAR, MPI_STATUS_IGNORE);
  }
  file.require(written, "write");
  const View view(file, part, header.size(), number);
  file.require(MPI_File_write_all(file.get(), values.data(), static_cast<int>(values.size()),
                                  number, MPI_STATUS_IGNORE),
               "write");
}

io::NpyLayout shared_layout(MPI_Comm comm, const fs::path& file) {
  io::NpyLayout layout;
  on_first(comm, [&] { layout = io::read_npy_layout(file); });
  layout.type = shared(comm, layout.type);
  std::array<unsigned long, 2> numbers{layout.begin, layout.shape.size()};
  MPI_Bcast(numbers.data(), 2, MPI_UNSIGNED_LONG, 0, comm);
  layout.begin = numbers[0];
  layout.shape.resize(numbers[1]);
  MPI_Bcast(layout.shape.data(), static_cast<int>(numbers[1]), MPI_UNSIGNED_LONG, 0, comm);
  return layout;
}

}  // namespace

std::size_t Part::size() const {
  return std::accumulate(count.begin(), count.end(), std::size_t{1}, std::multiplies<>());
}

Part volume_part(const GridShape& whole, const Box& box) {
  Part part;
  for (const int axis : {2, 1, 0}) {
    part.shape.push_back(static_cast<std::size_t>(whole.extent(axis)));
    part.begin.push_back(static_cast<std::size_t>(box.begin[axis]));
    part.count.push_back(static_cast<std::size_t>(box.extent(axis)));
  }
  return part;
}

Part face_part(const GridShape& whole, Face face, int patterns, const Box& box, bool touching) {
  const int normal = axis_of(face);
  const int w = is_plus(face) ? whole.extent(normal) - 1 : 0;
  const bool none = touching && (w < box.begin[normal] || w >= box.end[normal]);
  Part part{{static_cast<std::size_t>(patterns)}, {0}, {static_cast<std::size_t>(patterns)}};
  const auto [u, v] = face_axes(face);
  for (const int axis : {v, u}) {
    part.shape.push_back(static_cast<std::size_t>(whole.extent(axis)));
    part.begin.push_back(static_cast<std::size_t>(box.begin[axis]));
    part.count.push_back(none ? 0 : static_cast<std::size_t>(box.extent(axis)));
  }
  return part;
}

Part within(Part part, std::size_t index, std::size_t count) {
  part.shape.insert(part.shape.begin(), count);
  part.begin.insert(part.begin.begin(), index);
  part.count.insert(part.count.begin(), 1);
  return part;
}

std::vector<std::size_t> npy_shape(MPI_Comm comm, const fs::path& file) {
  return shared_layout(comm, file).shape;
}

std::vector<double> read_part(MPI_Comm comm, const fs::path& name, const Part& part) {
  const io::NpyLayout layout = shared_layout(comm, name);
  // [v][u] is one pattern's map.
  std::vector<std::size_t> shape = layout.shape;
  if (shape.size() + 1 == part.shape.size() && part.shape.front() == 1) {
    shape.insert(shape.begin(), 1);
  }
  if (shape != part.shape) {
    throw InputError(name.string() + ": array has shape " + io::shape_to_string(layout.shape) +
                     " instead of " + io::shape_to_string(part.shape));
  }
  const SharedFile file(comm, name, MPI_MODE_RDONLY);
  if (layout.type == "<f4") return read_numbers<float>(file, part, layout.begin, MPI_FLOAT);
  if (layout.type == "<f8") return read_numbers<double>(file, part, layout.begin, MPI_DOUBLE);
  if (layout.type == "|u1" || layout.type == "|b1") {
    return read_numbers<unsigned char>(file, part, layout.begin, MPI_UNSIGNED_CHAR);
  }
  throw InputError(name.string() + ": element type '" + layout.type +
                   "' is not read by parts; save it as float32 (array.astype('<f4'))");
}

void write_part(MPI_Comm comm, const fs::path& file, const Part& part,
                std::span<const float> values) {
  write_numbers(comm, file, part, values, "<f4", MPI_FLOAT);
}
void write_part(MPI_Comm comm, const fs::path& file, const Part& part,
                std::span<const double> values) {
  write_numbers(comm, file, part, values, "<f8", MPI_DOUBLE);
}

}  // namespace kappamu::app::mpi
