// One OpenCL device at work: buffers, programs, launches. The only place that calls OpenCL. Threads
// may use it side by side: each has an in-order queue of its own, kept for the next thread of its
// id, and buffers of its own too.
#pragma once

#include <cstddef>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "device/device_info.h"
#include "device/kernel_source.h"

namespace kappamu::device {

/// An OpenCL call failed; what() names the call, the error and the device, and holds the build log
/// where there is one. Running out of device memory is an InputError instead: the user can act on
/// it.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Device memory, freed with its last owner.
class Buffer {
 public:
  Buffer() = default;
  std::size_t bytes() const { return bytes_; }
  explicit operator bool() const { return handle_ != nullptr; }

 private:
  friend class Context;
  friend class Argument;
  friend class BufferPool;
  std::shared_ptr<void> handle_;  ///< cl_mem
  std::size_t bytes_ = 0;
};

/// A kernel argument: a buffer or a scalar of the kernel's own type.
class Argument {
 public:
  explicit Argument(const Buffer& buffer) : handle_(buffer.handle_.get()), is_buffer_(true) {}
  template <class T>
  requires std::is_arithmetic_v<T>
  explicit Argument(T value) : is_int_(std::is_same_v<T, int>), size_(sizeof(T)) {
    static_assert(sizeof(T) <= sizeof(bytes_));
    std::memcpy(bytes_, &value, sizeof(T));
  }

 private:
  friend class Context;
  void* handle_ = nullptr;
  bool is_buffer_ = false, is_int_ = false;
  std::size_t size_ = 0;
  alignas(8) unsigned char bytes_[8] = {};
};

/// A two-dimensional index space. The global size is rounded up to a multiple of the local one, so
/// kernels return where get_global_id() is past their work.
struct Range {
  std::size_t global0 = 1, global1 = 1;
  std::size_t local0 = 1, local1 = 1;
};

/// One launch of a kernel, timed by the device itself.
struct LaunchTime {
  std::string kernel;
  std::vector<int> integers;  ///< its arguments of type int, in their order
  double seconds = 0.0;       ///< from start to end
};

/// A compiled OpenCL file; lives as long as its context.
class Program;

class Context {
 public:
  /// The context of list_devices()[index]; one per device and process, kept for the life of the
  /// process together with the programs built on it.
  static Context& of(std::size_t index);
  /// That of the device choose() finds for `wanted`. Throws as choose() does.
  static Context& chosen(const std::string& wanted);

  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const DeviceInfo& info() const;

  /// Compiles `source` with `options` ("-DREAL=float"), or returns what was compiled before from
  /// the same text and options. Throws DeviceError with the build log.
  Program& program(const KernelSource& source, const std::string& options);

  /// Uninitialised device memory. Throws InputError when the device has too little.
  Buffer allocate(std::size_t bytes);
  /// `bytes` of `whole` from `offset` on, a multiple of part_alignment; keeps the whole alive.
  Buffer part(const Buffer& whole, std::size_t offset, std::size_t bytes);
  static constexpr std::size_t part_alignment = 4096;  ///< [bytes] no device asks for more
  /// Bytes of all buffers alive, parts not counted again.
  std::size_t allocated_bytes() const;
  void write(const Buffer& buffer, const void* data, std::size_t bytes);
  void read(const Buffer& buffer, void* data, std::size_t bytes);  ///< after all work before it
  /// Calls fill(memory) or look(memory) with the buffer's first bytes; without a copy where the
  /// device's memory is the processor's. fill() writes all of them.
  template <class Fill>
  void fill(const Buffer& buffer, std::size_t bytes, const Fill& fill) {
    void* memory = map(buffer, bytes, true);
    fill(memory);
    unmap(buffer, memory);
  }
  template <class Look>
  void look(const Buffer& buffer, std::size_t bytes, const Look& look) {
    void* memory = map(buffer, bytes, false);
    look(static_cast<const void*>(memory));
    unmap(buffer, memory);
  }
  void zero(const Buffer& buffer, std::size_t bytes);
  void copy(const Buffer& from, const Buffer& to, std::size_t bytes);

  template <class... T>
  void launch(Program& program, const char* kernel, const Range& range, const T&... arguments) {
    const Argument list[] = {Argument(arguments)...};
    launch_list(program, kernel, range, list);
  }

  /// Waits until all work that this thread queued is done.
  void finish();

  /// Runs `work` and returns what it launched here in this thread, in order; to be called from
  /// outside of `work`.
  std::vector<LaunchTime> launches_of(const std::function<void()>& work);

 private:
  struct Impl;
  explicit Context(std::unique_ptr<Impl> impl);
  void* map(const Buffer& buffer, std::size_t bytes, bool to_write);
  void unmap(const Buffer& buffer, void* memory);
  void launch_list(Program& program, const char* kernel, const Range& range,
                   std::span<const Argument> arguments);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kappamu::device
