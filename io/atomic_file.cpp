#include "io/atomic_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <memory>
#include <new>
#include <ostream>
#include <streambuf>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/error.h"

namespace kappamu::io {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view temporary_mark = ".partial-";

/// What the user can do about a failed write.
const char* advice(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free space or choose another folder";
    case EFBIG:
      return "the file system or a limit of this account refuses a file of this size, choose "
             "another folder";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder that you may write to";
    default:
      return "check the folder or choose another";
  }
}

[[noreturn]] void fail(const fs::path& target, int error) {
  throw InputError("cannot write " + target.string() + ": " +
                   std::generic_category().message(error) + "; " + advice(error));
}

/// ".name.partial-<process>-<count>.ext": hidden, unique, and with the extension libraries look at.
fs::path temporary_name(const fs::path& target) {
  static std::atomic<unsigned> count{0};
  std::string name(".");
  name.append(target.stem().string()).append(temporary_mark);
  name.append(std::to_string(::getpid())).append("-").append(std::to_string(count++));
  name.append(target.extension().string());
  return target.parent_path() / name;
}

/// Removes the file it names unless released.
class TemporaryFile {
 public:
  explicit TemporaryFile(fs::path name) : name_(std::move(name)) {}
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored;
    if (!name_.empty()) fs::remove(name_, ignored);
  }
  const fs::path& name() const { return name_; }
  void release() { name_.clear(); }

 private:
  fs::path name_;
};

/// Closes its descriptor; close() also reports what the system only tells then.
class Descriptor {
 public:
  Descriptor(const fs::path& name, int flags) : fd_(::open(name.c_str(), flags, 0666)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  /// 0 or the error number.
  int close() {
    const int result = ::close(fd_);
    fd_ = -1;
    return result == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

/// 0 or the error number. Some file systems cannot flush (EINVAL); their data is as safe as it
/// gets.
int flush_to_disk(int fd) {
  while (::fsync(fd) != 0) {
    if (errno == EINTR) continue;
    return errno == EINVAL || errno == ENOTSUP ? 0 : errno;
  }
  return 0;
}

/// A write-only stream buffer over a descriptor that remembers the first error.
class DescriptorBuffer : public std::streambuf {
 public:
  DescriptorBuffer(int fd, Cache cache)
      : fd_(fd),
        size_(cache == Cache::bypassed ? std::size_t{1} << 22 : std::size_t{1} << 16),
        buffer_(static_cast<char*>(::operator new(size_, std::align_val_t(sector)))) {
    direct_ = cache == Cache::bypassed && ::fcntl(fd_, F_SETFL, O_DIRECT) == 0;
    reset();
  }
  int error() const { return error_; }

 protected:
  int_type overflow(int_type c) override {
    if (!drain()) return traits_type::eof();
    if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
    return traits_type::not_eof(c);
  }
  std::streamsize xsputn(const char* data, std::streamsize size) override {
    if (size < epptr() - pptr()) {
      traits_type::copy(pptr(), data, static_cast<std::size_t>(size));
      pbump(static_cast<int>(size));
      return size;
    }
    if (!direct_) return drain() && write_all(data, static_cast<std::size_t>(size)) ? size : 0;
    for (std::streamsize done = 0; done < size;) {
      const std::streamsize part = std::min<std::streamsize>(size - done, epptr() - pptr());
      traits_type::copy(pptr(), data + done, static_cast<std::size_t>(part));
      pbump(static_cast<int>(part));
      done += part;
      if (pptr() == epptr() && !drain()) return 0;
    }
    return size;
  }
  int sync() override { return drain() ? 0 : -1; }
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
    if (!drain()) return pos_type(off_type(-1));
    const int whence = from == std::ios_base::beg   ? SEEK_SET
                       : from == std::ios_base::cur ? SEEK_CUR
                                                    : SEEK_END;
    return pos_type(::lseek(fd_, offset, whence));
  }
  pos_type seekpos(pos_type position, std::ios_base::openmode which) override {
    return seekoff(off_type(position), std::ios_base::beg, which);
  }

 private:
  static constexpr std::size_t sector = 4096;  // where writing past the cache begins and ends
  struct Release {
    void operator()(char* buffer) const { ::operator delete(buffer, std::align_val_t(sector)); }
  };

  void reset() { setp(buffer_.get(), buffer_.get() + size_); }
  bool drain() {
    const bool written = write_all(pbase(), static_cast<std::size_t>(pptr() - pbase()));
    reset();
    return written;
  }
  bool write_all(const char* data, std::size_t size) {
    if (size % sector != 0) use_cache();
    while (size > 0 && error_ == 0) {
      const ssize_t written = ::write(fd_, data, size);
      if (written < 0 && errno == EINVAL && direct_) {
        use_cache();
        continue;
      }
      if (written < 0) {
        if (errno != EINTR) error_ = errno;
        continue;
      }
      if (static_cast<std::size_t>(written) % sector != 0) use_cache();
      data += written;
      size -= static_cast<std::size_t>(written);
    }
    return error_ == 0;
  }

  void use_cache() {
    if (std::exchange(direct_, false)) ::fcntl(fd_, F_SETFL, 0);
  }

  int fd_;
  int error_ = 0;
  bool direct_ = false;
  std::size_t size_;
  std::unique_ptr<char, Release> buffer_;
};

void make_parent(const fs::path& target) {
  if (target.parent_path().empty()) return;
  std::error_code error;
  fs::create_directories(target.parent_path(), error);
  if (error) fail(target, error.value());
}

void rename_into_place(TemporaryFile& temporary, const fs::path& target) {
  std::error_code error;
  fs::rename(temporary.name(), target, error);
  if (error) fail(target, error.value());
  temporary.release();
}

}  // namespace

void write_atomically(const fs::path& target, const std::function<void(const fs::path&)>& write) {
  make_parent(target);
  TemporaryFile temporary(temporary_name(target));
  try {
    write(temporary.name());
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw InputError("cannot write " + target.string() + ": " + error.what());
  }
  Descriptor file(temporary.name(), O_RDONLY);
  if (file.get() < 0) fail(target, errno);
  if (const int error = flush_to_disk(file.get())) fail(target, error);
  rename_into_place(temporary, target);
}

void write_stream_atomically(const fs::path& target,
                             const std::function<void(std::ostream&)>& write, Cache cache) {
  make_parent(target);
  TemporaryFile temporary(temporary_name(target));
  Descriptor file(temporary.name(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC);
  if (file.get() < 0) fail(target, errno);
  DescriptorBuffer buffer(file.get(), cache);
  std::ostream stream(&buffer);
  try {
    write(stream);
    stream.flush();
  } catch (const std::exception& error) {
    // The disk's reason is the cause; what the writer threw about it is the consequence.
    if (buffer.error() != 0) fail(target, buffer.error());
    if (dynamic_cast<const InputError*>(&error) != nullptr) throw;
    if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) throw;
    throw InputError("cannot write " + target.string() + ": " + error.what());
  }
  if (buffer.error() != 0) fail(target, buffer.error());
  if (!stream) fail(target, EIO);
  if (const int error = flush_to_disk(file.get())) fail(target, error);
  if (const int error = file.close()) fail(target, error);
  rename_into_place(temporary, target);
}

void write_bytes_atomically(const fs::path& target, std::span<const std::byte> bytes) {
  write_stream_atomically(target, [&](std::ostream& out) {
    out.write(reinterpret_cast<const char*>(bytes.data()),
              static_cast<std::streamsize>(bytes.size()));
  });
}

void write_text_atomically(const fs::path& target, std::string_view text) {
  write_bytes_atomically(target, std::as_bytes(std::span(text)));
}

bool is_temporary_name(const std::string& name) {
  const std::size_t mark = name.rfind(temporary_mark);
  if (name.empty() || name.front() != '.' || mark == std::string::npos || mark < 2) return false;
  const char* at = name.data() + mark + temporary_mark.size();
  const char* end = name.data() + name.size();
  unsigned process = 0, count = 0;
  const auto [dash, no_process] = std::from_chars(at, end, process);
  if (no_process != std::errc() || dash == end || *dash != '-') return false;
  const auto [rest, no_count] = std::from_chars(dash + 1, end, count);
  return no_count == std::errc() && (rest == end || *rest == '.');
}

std::size_t remove_temporaries(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    const bool is_file = it->symlink_status(error).type() == fs::file_type::regular;
    if (is_file && is_temporary_name(it->path().filename().string())) found.push_back(it->path());
  }
  for (const fs::path& file : found) fs::remove(file, error);
  return found.size();
}

}  // namespace kappamu::io
