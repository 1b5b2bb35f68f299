#include "io/read_file.h"

#include <cerrno>
#include <system_error>

#include "core/error.h"

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

}  // namespace kappamu::io
