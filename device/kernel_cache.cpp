#include "device/kernel_cache.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <mutex>
#include <system_error>
#include <utility>

#include "core/error.h"

namespace kappamu::device {

namespace {

namespace fs = std::filesystem;

std::function<void(const std::string&)>& listener() {
  static std::function<void(const std::string&)> heard_by;
  return heard_by;
}

void notice(const std::string& sentence) {
  if (listener()) listener()(sentence);
}

bool can_write(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  return fs::is_directory(folder, error) && ::access(folder.c_str(), W_OK | X_OK) == 0;
}

/// As PoCL chooses it.
fs::path default_folder() {
  const char* const cache = std::getenv("XDG_CACHE_HOME");
  if (cache != nullptr && *cache != '\0') return fs::path(cache) / "pocl" / "kcache";
  const char* const home = std::getenv("HOME");
  if (home != nullptr) return fs::path(home) / ".cache" / "pocl" / "kcache";
  return "/tmp/pocl/kcache";
}

/// Nobody else may put programs there.
bool is_own(const fs::path& folder) {
  struct stat found {};
  return ::lstat(folder.c_str(), &found) == 0 && S_ISDIR(found.st_mode) &&
         found.st_uid == ::geteuid() && (found.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

fs::path find_folder() {
  const char* const stated = std::getenv("POCL_CACHE_DIR");
  if (stated != nullptr) {
    if (*stated != '\0' && can_write(stated)) return stated;
    throw InputError("POCL_CACHE_DIR is '" + std::string(stated) +
                     "', where OpenCL cannot write; set it to a folder that you may write to, or "
                     "unset it");
  }
  const fs::path usual = default_folder();
  if (can_write(usual)) return usual;
  std::error_code error;
  const fs::path own =
      fs::temp_directory_path(error) / ("kappamu-kernels-" + std::to_string(::geteuid()));
  if (::mkdir(own.c_str(), S_IRWXU) != 0 && !is_own(own)) {
    throw InputError("OpenCL cannot write its compiled kernels to '" + usual.string() +
                     "'; set POCL_CACHE_DIR to a folder that you may write to");
  }
  ::setenv("POCL_CACHE_DIR", own.c_str(), 1);
  notice("'" + usual.string() + "' cannot be written: compiled OpenCL kernels are kept in '" +
         own.string() + "' (POCL_CACHE_DIR chooses another folder)");
  return own;
}

}  // namespace

void on_notice(std::function<void(const std::string&)> heard_by) {
  listener() = std::move(heard_by);
}

fs::path kernel_cache_folder() {
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  static const fs::path folder = find_folder();  // again if it threw
  return folder;
}

void announce_build(const std::string& program, const std::string& device_name) {
  // A file by the program's name tells later processes. Where it cannot be written they tell again.
  const fs::path folder = kernel_cache_folder() / "kappamu";
  const fs::path stamp =
      folder / std::to_string(std::hash<std::string>{}(program + '\n' + device_name));
  std::error_code error;
  if (fs::exists(stamp, error)) return;
  static std::once_flag once;
  std::call_once(once, [&] {
    notice("building OpenCL kernels for " + device_name +
           ": up to a minute, once per machine and version");
  });
  fs::create_directories(folder, error);
  std::ofstream{stamp};
}

}  // namespace kappamu::device
