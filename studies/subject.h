// What `kappamu-studies` measures: subjects, each with its sections and settings. A section
// measures and hands over its numbers as JSON; record, file and summary are made here, charts and
// tables by studies/bench_charts.py.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/progress.h"
#include "studies/record.h"

namespace kappamu::studies {

enum class Size {
  quick,  ///< seconds on toy problems: shows that it runs, proves nothing
  small,  ///< minutes; the same as full where a subject has no such form
  full
};

struct Request {
  std::filesystem::path folder;  ///< records go there
  std::string device = "auto";
  std::uint64_t seed = 1;
  Size size = Size::full;
  std::map<std::string, std::vector<std::string>> settings;  ///< those given, by name

  bool has(const std::string& setting) const { return settings.contains(setting); }
  /// The value given, or `standard`. Throws InputError when it is no number.
  double number(const std::string& setting, double standard) const;
  int count(const std::string& setting, int standard) const;
  /// All values given.
  std::vector<std::string> words(const std::string& setting) const;
};

/// An option that one subject has besides those of all.
struct Setting {
  enum class Kind { number, flag, words };
  std::string name;
  std::string sentence;  ///< with the default
  Kind kind = Kind::number;
  double low = 0.0, high = 1e9;           ///< of a number
  std::vector<std::string> choices = {};  ///< of words; empty: any
};

/// Receives what a section has so far, to be written: an interrupted one leaves its record. The
/// object's keys join the record's; "rows" is an array of flat objects where the numbers are a
/// table.
using Save = std::function<void(const Json& body)>;

struct Section {
  std::string name;
  std::string sentence;
  void (*measure)(const Request& request, Progress& progress, const Save& save);
};

struct Subject {
  std::string name;
  std::string sentence;  ///< one line
  std::string manual;    ///< what is measured, and when not to trust it
  std::vector<Section> sections;
  std::vector<Setting> settings = {};
  /// What --json prints, of the records just measured. Absent: the record, or the rows of each
  /// section by its name.
  Json (*summary)(const std::vector<Json>& records, const std::filesystem::path& folder) = nullptr;
};

const std::vector<Subject>& subjects();
/// Throws InputError listing the names when there is no such subject.
const Subject& subject(const std::string& name);

/// <subject>-<section>.json, or <subject>.json where there is but one section.
std::filesystem::path record_file(const std::filesystem::path& folder, const Subject& subject,
                                  const std::string& section);

/// Measures the sections named, all where none is, and writes their records. Throws InputError for
/// an unknown section.
std::vector<Json> measure(const Subject& subject, const std::vector<std::string>& sections,
                          const Request& request, Progress& progress);

Json summary(const Subject& subject, const std::vector<Json>& records,
             const std::filesystem::path& folder);

/// The record's rows as a table of text, columns aligned; empty without rows.
std::string printed(const Json& record);

}  // namespace kappamu::studies
