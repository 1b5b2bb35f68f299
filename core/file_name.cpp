#include "core/file_name.h"

#include <algorithm>
#include <cctype>

#include "core/error.h"
#include "core/shown_text.h"

namespace kappamu {

namespace {

bool is_control(char c) {
  return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
}

}  // namespace

bool is_plain_name(std::string_view name) {
  constexpr std::size_t longest = 100;  // with what is put around it, below every system's limit
  if (name.empty() || name.size() > longest || name.front() == '.') return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  });
}

void require_plain_name(std::string_view name, const std::string& where) {
  if (is_plain_name(name)) return;
  throw InputError(where + " is '" + shown_name(name) + "'; use " + plain_name_rule + ".");
}

bool stays_inside(std::string_view relative_path) {
  if (relative_path.empty() || relative_path.front() == '/') return false;
  if (std::any_of(relative_path.begin(), relative_path.end(), is_control)) return false;
  for (std::size_t begin = 0; begin <= relative_path.size();) {
    const std::size_t end = std::min(relative_path.find('/', begin), relative_path.size());
    if (relative_path.substr(begin, end - begin) == "..") return false;
    begin = end + 1;
  }
  return true;
}

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

std::string shown_name(std::string_view text) {
  constexpr std::size_t longest = 80;
  return shown_text(text, longest);
}

}  // namespace kappamu
