// Where PoCL keeps what it compiled, and what the user is told of it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace kappamu::device {

/// Who hears sentences such as that kernels are being built; nobody at first. To be set before the
/// first use of a device.
void on_notice(std::function<void(const std::string&)> listener);

/// The folder of PoCL's cache: POCL_CACHE_DIR, or the one in the user's home. Where that cannot be
/// written PoCL would show no device: a folder of the user's own among the temporary files is taken
/// for this process, with a notice. Throws InputError where POCL_CACHE_DIR cannot be written or
/// there is no such folder.
std::filesystem::path kernel_cache_folder();

/// Tells the user, once per process, that kernels are being built, unless a process before has
/// built this program, told by text, options and device, with the same cache.
void announce_build(const std::string& program, const std::string& device_name);

}  // namespace kappamu::device
