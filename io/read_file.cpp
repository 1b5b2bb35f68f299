#include "io/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <system_error>

#include "core/error.h"
#include "io/atomic_file.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail_reading(const fs::path& file, const std::string& why) {
  throw InputError("cannot read " + file.string() + ": " + why);
}

template <class Buffer>
Buffer read_whole(const fs::path& file, std::size_t largest) {
  std::ifstream in = open_file(file);
  in.seekg(0, std::ios::end);
  const std::streamoff size = in.tellg();
  if (size < 0) fail_reading(file, "it is not an ordinary file");
  if (static_cast<std::size_t>(size) > largest) {
    fail_reading(file, "its " + std::to_string(size) + " bytes are more than the " +
                           std::to_string(largest) + " that such a file may have");
  }
  Buffer buffer(static_cast<std::size_t>(size), typename Buffer::value_type{});
  in.seekg(0);
  in.read(reinterpret_cast<char*>(buffer.data()), size);
  if (in.gcount() != size) fail_reading(file, "it ended while it was being read");
  return buffer;
}

}  // namespace

std::ifstream open_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) fail_reading(file, "there is no such file");
  if (status.type() == fs::file_type::directory) fail_reading(file, "it is a folder, not a file");
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) fail_reading(file, std::generic_category().message(errno));
  return in;
}

std::vector<std::byte> read_bytes(const fs::path& file, std::size_t largest) {
  return read_whole<std::vector<std::byte>>(file, largest);
}

std::string read_text(const fs::path& file, std::size_t largest) {
  return read_whole<std::string>(file, largest);
}

void read_parts(const fs::path& file, const std::function<void(std::span<const char>)>& take) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail_reading(file, std::generic_category().message(errno));
  const std::unique_ptr<const int, void (*)(const int*)> closed(
      &fd, [](const int* open) { ::close(*open); });
  struct stat state {};
  const bool large =
      ::fstat(fd, &state) == 0 && static_cast<std::uintmax_t>(state.st_size) >= cache_bypass;
  bool direct = large && ::fcntl(fd, F_SETFL, O_DIRECT) == 0;
  constexpr std::size_t page = 4096;
  const std::size_t size = large ? std::size_t{1} << 22 : std::size_t{1} << 16;
  std::vector<char> buffer(size + page);
  void* begin = buffer.data();
  std::size_t space = buffer.size();
  char* const at = static_cast<char*>(std::align(page, size, begin, space));
  while (true) {
    const ssize_t read = ::read(fd, at, size);
    if (read == 0) return;
    if (read > 0) {
      take({at, static_cast<std::size_t>(read)});
    } else if (errno == EINVAL && direct) {
      direct = false;
      ::fcntl(fd, F_SETFL, 0);
    } else if (errno != EINTR) {
      fail_reading(file, std::generic_category().message(errno));
    }
  }
}

}  // namespace kappamu::io
