#include "device/context.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <shared_mutex>
#include <thread>
#include <tuple>
#include <utility>

#include "core/error.h"
#include "core/process_memory.h"
#include "device/kernel_cache.h"
#include "device/opencl_api.h"
#include "device/traffic.h"

namespace kappamu::device {

namespace {

struct {
  std::atomic<std::size_t> launches = 0, waits = 0, waited_ns = 0, bytes = 0;
} passed;

/// A call that waits for the device, as long as this lives.
class Wait {
 public:
  explicit Wait(std::size_t bytes) {
    ++passed.waits;
    passed.bytes += bytes;
  }
  ~Wait() {
    const std::chrono::nanoseconds waited = std::chrono::steady_clock::now() - began_;
    passed.waited_ns += static_cast<std::size_t>(waited.count());
  }
  Wait(const Wait&) = delete;
  Wait& operator=(const Wait&) = delete;

 private:
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
};

}  // namespace

Traffic traffic() {
  return {passed.launches, passed.waits, 1e-9 * static_cast<double>(passed.waited_ns),
          passed.bytes};
}

class Program {
 public:
  explicit Program(cl_program program) : program_(program) {}
  cl_program handle() const { return program_; }

 private:
  cl_program program_;  ///< lives as long as the process, like its context
};

struct Context::Impl {
  struct Timed {
    LaunchTime launch;
    cl_event event = nullptr;
  };
  /// What each thread has of its own: a kernel holds its arguments until it is launched.
  struct ThreadsOwn {
    cl_command_queue queue = nullptr;
    std::map<std::pair<const Program*, std::string>, cl_kernel> kernels;
    std::vector<Timed>* timed = nullptr;  ///< where launches are noted, while they are
  };

  DeviceInfo info;
  const pid_t process = getpid();  ///< a fork of it has none of the driver's threads
  cl_device_id device = nullptr;
  cl_context context = nullptr;
  std::atomic<std::size_t> allocated = 0;
  std::mutex lock;                                                  ///< of both maps
  std::map<std::pair<std::string, std::string>, Program> programs;  ///< by (text, options)
  std::map<std::thread::id, ThreadsOwn> threads;
  /// Held alone by a launch wider than any of its kernel and local size before, shared by others:
  /// PoCL before 7 makes a version of a kernel for every such width, counts the uses of a version
  /// down at the newest one, whichever it lent, and ends the process where that has none left.
  std::shared_mutex widening;
  using Shape = std::tuple<const Program*, std::string, std::size_t, std::size_t>;
  std::map<Shape, std::size_t> widest;  ///< by kernel and local size

  cl_command_queue make_queue(cl_command_queue_properties properties) const {
    cl_int code = CL_SUCCESS;
    cl_command_queue queue = clCreateCommandQueue(context, device, properties, &code);
    check_call(code, "clCreateCommandQueue", info.name);
    return queue;
  }
  /// Throws InputError in a fork, where the driver would wait for ever.
  void require_own_process() const {
    if (getpid() == process) return;
    throw InputError(
        "this process was forked from one that had used device '" + info.name +
            "', and cannot use it; start processes by 'spawn' or 'forkserver', or fork "
            "before the device is used",
        {{"device"}});
  }
  ThreadsOwn& own() {
    require_own_process();
    const std::scoped_lock guard(lock);
    ThreadsOwn& found = threads[std::this_thread::get_id()];
    if (found.queue == nullptr) found.queue = make_queue(0);
    return found;
  }
  cl_command_queue queue() { return own().queue; }
  void finish_all() {
    const std::scoped_lock guard(lock);
    for (const auto& [id, thread] : threads)
      check_call(clFinish(thread.queue), "clFinish", info.name);
  }
  /// Calls `enqueue`, which launches a kernel of `shape` over `width`, by itself if it must be.
  void in_turn(const Shape& shape, std::size_t width, cl_command_queue queue,
               const std::function<void()>& enqueue) {
    {
      const std::shared_lock beside_others(widening);
      const auto found = widest.find(shape);
      if (found != widest.end() && width <= found->second) return enqueue();
    }
    const std::unique_lock alone(widening);
    finish_all();
    enqueue();
    check_call(clFinish(queue), "clFinish", info.name);
    widest[shape] = std::max(width, widest[shape]);
  }
  static cl_kernel kernel(ThreadsOwn& own, const Program& program, const std::string& name,
                          const std::string& device) {
    cl_kernel& found = own.kernels[{&program, name}];
    if (found != nullptr) return found;
    cl_int code = CL_SUCCESS;
    found = clCreateKernel(program.handle(), name.c_str(), &code);
    check_call(code, ("clCreateKernel(" + name + ")").c_str(), device);
    return found;
  }
};

Context::Context(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Context::~Context() = default;

Context& Context::of(std::size_t index) {
  // Never destroyed: OpenCL drivers may be unloaded before static objects are.
  static auto& contexts = *new std::map<std::size_t, std::unique_ptr<Context>>;
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  auto& slot = contexts[index];
  if (slot) return *slot;

  auto impl = std::make_unique<Impl>();
  const auto devices = platform_devices();
  check(index < devices.size(), "device index beyond the list");
  impl->info = list_devices()[index];
  impl->device = devices[index].device;
  const std::string& name = impl->info.name;
  const cl_context_properties properties[] = {
      CL_CONTEXT_PLATFORM, reinterpret_cast<cl_context_properties>(devices[index].platform), 0};
  cl_int code = CL_SUCCESS;
  impl->context = clCreateContext(properties, 1, &impl->device, nullptr, nullptr, &code);
  check_call(code, "clCreateContext", name);
  slot.reset(new Context(std::move(impl)));
  return *slot;
}

Context& Context::chosen(const std::string& wanted) {
  return of(choose(list_devices(), wanted).index);
}

const DeviceInfo& Context::info() const {
  return impl_->info;
}

Program& Context::program(const KernelSource& source, const std::string& asked) {
  // Compilers print counts of their warnings on the user's terminal; errors come in the log.
  const std::string options = asked + " -w";
  const std::scoped_lock guard(impl_->lock);
  const std::pair<std::string, std::string> key{source.text, options};
  const auto found = impl_->programs.find(key);
  if (found != impl_->programs.end()) return found->second;

  announce_build(key.first + key.second, impl_->info.name);
  cl_int code = CL_SUCCESS;
  const char* text = source.text;
  cl_program program = clCreateProgramWithSource(impl_->context, 1, &text, nullptr, &code);
  check_call(code, "clCreateProgramWithSource", impl_->info.name);
  code = clBuildProgram(program, 1, &impl_->device, options.c_str(), nullptr, nullptr);
  if (code != CL_SUCCESS) {
    const std::string log = text_property([&](std::size_t size, void* value, std::size_t* needed) {
      return clGetProgramBuildInfo(program, impl_->device, CL_PROGRAM_BUILD_LOG, size, value,
                                   needed);
    });
    clReleaseProgram(program);
    throw DeviceError(std::string("clBuildProgram failed with ") + error_name(code) + " for " +
                      source.path + " with '" + options + "' on device '" + impl_->info.name +
                      "': " + first_error(log));
  }
  return impl_->programs.emplace(key, Program(program)).first->second;
}

Buffer Context::allocate(std::size_t bytes) {
  Buffer buffer;
  cl_int code = CL_SUCCESS;
  cl_mem memory = clCreateBuffer(impl_->context, CL_MEM_READ_WRITE, std::max<std::size_t>(bytes, 1),
                                 nullptr, &code);
  // Many drivers give larger pieces than they state, so that the limit alone refuses nothing.
  if (code != CL_SUCCESS && bytes > impl_->info.max_allocation_bytes) {
    throw InputError("device '" + impl_->info.name + "' gives at most " +
                         gigabytes(static_cast<double>(impl_->info.max_allocation_bytes)) +
                         " in one piece, and " + gigabytes(static_cast<double>(bytes)) +
                         " are needed; use a coarser grid, fewer patterns at once, or another "
                         "device",
                     {{"device"}});
  }
  check_call(code, "clCreateBuffer", impl_->info.name);
  // Contexts live as long as the process, so the deleter may count in this one.
  impl_->allocated += bytes;
  buffer.handle_ = std::shared_ptr<void>(memory, [this, bytes](void* m) {
    clReleaseMemObject(static_cast<cl_mem>(m));
    impl_->allocated -= bytes;
  });
  buffer.bytes_ = bytes;
  return buffer;
}

Buffer Context::part(const Buffer& whole, std::size_t offset, std::size_t bytes) {
  check(offset % part_alignment == 0 && offset + bytes <= whole.bytes(),
        "a part must lie inside its device buffer and begin at a multiple of its alignment");
  // OpenCL has no parts of parts: both are parts of what was allocated.
  cl_mem from = static_cast<cl_mem>(whole.handle_.get()), allocated = nullptr;
  std::size_t before = 0;
  check_call(clGetMemObjectInfo(from, CL_MEM_ASSOCIATED_MEMOBJECT, sizeof(cl_mem),
                                static_cast<void*>(&allocated), nullptr),
             "clGetMemObjectInfo", impl_->info.name);
  check_call(clGetMemObjectInfo(from, CL_MEM_OFFSET, sizeof(std::size_t), &before, nullptr),
             "clGetMemObjectInfo", impl_->info.name);
  const cl_buffer_region region{before + offset, std::max<std::size_t>(bytes, 1)};
  cl_int code = CL_SUCCESS;
  cl_mem memory = clCreateSubBuffer(allocated != nullptr ? allocated : from, CL_MEM_READ_WRITE,
                                    CL_BUFFER_CREATE_TYPE_REGION, &region, &code);
  check_call(code, "clCreateSubBuffer", impl_->info.name);
  Buffer buffer;
  buffer.handle_ = std::shared_ptr<void>(
      memory, [keep = whole.handle_](void* m) { clReleaseMemObject(static_cast<cl_mem>(m)); });
  buffer.bytes_ = bytes;
  return buffer;
}

std::size_t Context::allocated_bytes() const {
  return impl_->allocated;
}

void Context::write(const Buffer& buffer, const void* data, std::size_t bytes) {
  check(bytes <= buffer.bytes(), "write past the end of a device buffer");
  const Wait wait(bytes);
  check_call(clEnqueueWriteBuffer(impl_->queue(), static_cast<cl_mem>(buffer.handle_.get()),
                                  CL_TRUE, 0, bytes, data, 0, nullptr, nullptr),
             "clEnqueueWriteBuffer", impl_->info.name);
}

void Context::read(const Buffer& buffer, void* data, std::size_t bytes) {
  check(bytes <= buffer.bytes(), "read past the end of a device buffer");
  const Wait wait(bytes);
  check_call(clEnqueueReadBuffer(impl_->queue(), static_cast<cl_mem>(buffer.handle_.get()), CL_TRUE,
                                 0, bytes, data, 0, nullptr, nullptr),
             "clEnqueueReadBuffer", impl_->info.name);
}

void* Context::map(const Buffer& buffer, std::size_t bytes, bool to_write) {
  check(bytes <= buffer.bytes(), "map past the end of a device buffer");
  const Wait wait(bytes);
  cl_int code = CL_SUCCESS;
  void* memory =
      clEnqueueMapBuffer(impl_->queue(), static_cast<cl_mem>(buffer.handle_.get()), CL_TRUE,
                         to_write ? CL_MAP_WRITE_INVALIDATE_REGION : CL_MAP_READ, 0, bytes, 0,
                         nullptr, nullptr, &code);
  check_call(code, "clEnqueueMapBuffer", impl_->info.name);
  return memory;
}

void Context::unmap(const Buffer& buffer, void* memory) {
  check_call(clEnqueueUnmapMemObject(impl_->queue(), static_cast<cl_mem>(buffer.handle_.get()),
                                     memory, 0, nullptr, nullptr),
             "clEnqueueUnmapMemObject", impl_->info.name);
}

void Context::zero(const Buffer& buffer, std::size_t bytes) {
  check(bytes <= buffer.bytes(), "zeroing past the end of a device buffer");
  // Static, should a driver read it later than it may.
  static const cl_uchar zero = 0;
  check_call(clEnqueueFillBuffer(impl_->queue(), static_cast<cl_mem>(buffer.handle_.get()), &zero,
                                 1, 0, bytes, 0, nullptr, nullptr),
             "clEnqueueFillBuffer", impl_->info.name);
}

void Context::copy(const Buffer& from, const Buffer& to, std::size_t bytes) {
  check(bytes <= from.bytes() && bytes <= to.bytes(), "copy past the end of a device buffer");
  check_call(
      clEnqueueCopyBuffer(impl_->queue(), static_cast<cl_mem>(from.handle_.get()),
                          static_cast<cl_mem>(to.handle_.get()), 0, 0, bytes, 0, nullptr, nullptr),
      "clEnqueueCopyBuffer", impl_->info.name);
}

void Context::launch_list(Program& program, const char* name, const Range& range,
                          std::span<const Argument> arguments) {
  const std::string& device = impl_->info.name;
  Impl::ThreadsOwn& own = impl_->own();
  ++passed.launches;
  cl_kernel kernel = Impl::kernel(own, program, name, device);
  cl_uint position = 0;
  for (const Argument& argument : arguments) {
    cl_mem memory = static_cast<cl_mem>(argument.handle_);
    const cl_int code = argument.is_buffer_
                            ? clSetKernelArg(kernel, position, sizeof(cl_mem), &memory)
                            : clSetKernelArg(kernel, position, argument.size_, argument.bytes_);
    if (code != CL_SUCCESS) {
      check_call(
          code,
          ("clSetKernelArg(" + std::string(name) + ", " + std::to_string(position) + ")").c_str(),
          device);
    }
    ++position;
  }
  const auto round_up = [](std::size_t n, std::size_t unit) {
    return (n + unit - 1) / unit * unit;
  };
  const std::size_t local[] = {range.local0, range.local1};
  const std::size_t global[] = {round_up(range.global0, range.local0),
                                round_up(range.global1, range.local1)};
  cl_event event = nullptr;
  const auto enqueue = [&] {
    const cl_int code = clEnqueueNDRangeKernel(own.queue, kernel, 2, nullptr, global, local, 0,
                                               nullptr, own.timed != nullptr ? &event : nullptr);
    if (code != CL_SUCCESS) {
      check_call(code, ("clEnqueueNDRangeKernel(" + std::string(name) + ")").c_str(), device);
    }
  };
  impl_->in_turn({&program, name, local[0], local[1]}, std::max(global[0], global[1]), own.queue,
                 enqueue);
  if (own.timed != nullptr) {
    Impl::Timed timed{{name, {}, 0.0}, event};
    for (const Argument& argument : arguments) {
      if (!argument.is_int_) continue;
      std::memcpy(&timed.launch.integers.emplace_back(), argument.bytes_, sizeof(int));
    }
    own.timed->push_back(std::move(timed));
  }
}

void Context::finish() {
  const Wait wait(0);
  check_call(clFinish(impl_->queue()), "clFinish", impl_->info.name);
}

std::vector<LaunchTime> Context::launches_of(const std::function<void()>& work) {
  Impl::ThreadsOwn& own = impl_->own();
  check(own.timed == nullptr, "launches_of: one at a time");
  finish();
  cl_command_queue profiling = impl_->make_queue(CL_QUEUE_PROFILING_ENABLE);
  std::vector<Impl::Timed> timed;
  std::swap(own.queue, profiling);
  own.timed = &timed;
  // Whatever comes, the plain queue is put back and the events are freed.
  const auto restore = [&](void*) {
    clFinish(own.queue);
    own.timed = nullptr;
    std::swap(own.queue, profiling);
    for (const Impl::Timed& one : timed) clReleaseEvent(one.event);
    clReleaseCommandQueue(profiling);
  };
  const std::unique_ptr<void, decltype(restore)> guard(impl_.get(), restore);
  work();
  finish();
  std::vector<LaunchTime> launches;
  for (Impl::Timed& one : timed) {
    cl_ulong start = 0, end = 0;
    for (const auto& [what, value] : {std::pair{CL_PROFILING_COMMAND_START, &start},
                                      std::pair{CL_PROFILING_COMMAND_END, &end}}) {
      check_call(clGetEventProfilingInfo(one.event, what, sizeof(cl_ulong), value, nullptr),
                 "clGetEventProfilingInfo", impl_->info.name);
    }
    one.launch.seconds = 1e-9 * static_cast<double>(end - start);
    launches.push_back(one.launch);
  }
  return launches;
}

}  // namespace kappamu::device
