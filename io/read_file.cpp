#include "io/read_file.h"

#include <cerrno>
#include <fstream>
#include <limits>
#include <system_error>

#include "core/error.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

constexpr std::streamoff most_text_bytes = 100'000'000;

template <class Buffer>
Buffer read_whole(const fs::path& file,
                  std::streamoff most_bytes = std::numeric_limits<std::streamoff>::max()) {
  const auto fail = [&](const std::string& why) {
    throw InputError("cannot read " + file.string() + ": " + why);
  };
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found) fail("there is no such file");
  if (status.type() == fs::file_type::directory) fail("it is a folder, not a file");
  errno = 0;
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) fail(std::generic_category().message(errno));
  const std::streamoff size = in.tellg();
  if (size < 0) fail("it is not an ordinary file");
  if (size > most_bytes) {
    fail("it has " + std::to_string(size / 1'000'000) + " MB, and a text file may have " +
         std::to_string(most_bytes / 1'000'000));
  }
  Buffer buffer(static_cast<std::size_t>(size), typename Buffer::value_type{});
  in.seekg(0);
  in.read(reinterpret_cast<char*>(buffer.data()), size);
  if (in.gcount() != size) fail("it ended while it was being read");
  return buffer;
}

}  // namespace

std::vector<std::byte> read_bytes(const fs::path& file) {
  return read_whole<std::vector<std::byte>>(file);
}

std::string read_text(const fs::path& file) {
  return read_whole<std::string>(file, most_text_bytes);
}

}  // namespace kappamu::io
