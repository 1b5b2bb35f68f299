#include "studies/subject.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/shown_text.h"
#include "studies/record.h"
#include "studies/subjects.h"

namespace kappamu::studies {

namespace {

template <class Named>
const Named& find(const std::vector<Named>& all, const std::string& name, const std::string& what) {
  std::string known;
  for (const Named& one : all) {
    if (one.name == name) return one;
    known += (known.empty() ? "" : ", ") + one.name;
  }
  throw InputError(what + " '" + name + "' is unknown; choose one of " + known + ".");
}

std::string to_text(Size size) {
  return size == Size::quick ? "quick" : size == Size::small ? "small" : "full";
}

std::string cell(const Json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_number_float()) return value.dump();
  return shown_number(value.get<double>(), "%.4g");
}

/// Characters, not bytes, of UTF-8.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

double Request::number(const std::string& setting, double standard) const {
  if (!has(setting)) return standard;
  const std::string& text = settings.at(setting).at(0);
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size() || !std::isfinite(value)) {
    throw InputError("--" + setting + ": '" + text + "' is not a number.");
  }
  return value;
}

int Request::count(const std::string& setting, int standard) const {
  return static_cast<int>(number(setting, standard));
}

std::vector<std::string> Request::words(const std::string& setting) const {
  return has(setting) ? settings.at(setting) : std::vector<std::string>();
}

const std::vector<Subject>& subjects() {
  static const std::vector<Subject> all{
      forward_subject(),     validity_subject(),    slabs_subject(),  inverse_subject(),
      limits_subject(),      uncertainty_subject(), views_subject(),  rig_subject(),
      hdr_subject(),         objects_subject(),     dipole_subject(), boundary_subject(),
      polygrid_subject(),    sfdi_subject(),        fur_subject(),    figures_subject(),
      photographs_subject(), devices_subject()};
  return all;
}

const Subject& subject(const std::string& name) {
  return find(subjects(), name, "subject");
}

std::filesystem::path record_file(const std::filesystem::path& folder, const Subject& subject,
                                  const std::string& section) {
  return folder / (subject.name + (subject.sections.size() > 1 ? "-" + section : "") + ".json");
}

std::vector<Json> measure(const Subject& subject, const std::vector<std::string>& sections,
                          const Request& request, Progress& progress) {
  std::vector<Section> wanted;
  for (const std::string& name : sections) {
    wanted.push_back(find(subject.sections, name, "section"));
  }
  if (wanted.empty()) wanted = subject.sections;
  std::vector<Json> records;
  for (const Section& section : wanted) {
    Json record = record_header(subject.name, request.device);
    record["section"] = section.name;
    record["size"] = to_text(request.size);
    record["seed"] = request.seed;
    for (const auto& [name, words] : request.settings) record["settings"][name] = words;
    section.measure(request, progress, [&](const Json& body) {
      record.update(body, true);
      write_record(record, record_file(request.folder, subject, section.name));
    });
    records.push_back(std::move(record));
  }
  return records;
}

Json summary(const Subject& subject, const std::vector<Json>& records,
             const std::filesystem::path& folder) {
  if (subject.summary != nullptr) return subject.summary(records, folder);
  if (subject.sections.size() == 1) return records.at(0);
  Json all = Json::object();
  for (const Json& record : records) {
    all[record.at("section").get<std::string>()] = record.at("rows");
  }
  return all;
}

std::string printed(const Json& record) {
  if (!record.contains("rows") || record.at("rows").empty()) return "";
  std::vector<std::vector<std::string>> lines(1);
  const Json& rows = record.at("rows");
  for (const auto& [name, value] : rows.at(0).items()) {
    if (!value.is_structured()) lines[0].push_back(name);
  }
  for (const Json& row : rows) {
    lines.emplace_back();
    for (const std::string& name : lines[0]) {
      lines.back().push_back(row.contains(name) ? cell(row.at(name)) : "");
    }
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) {
      std::size_t widest = 0;
      for (const auto& other : lines) widest = std::max(widest, width(other[c]));
      text +=
          line[c] + (c + 1 == line.size() ? "\n" : std::string(widest - width(line[c]) + 2, ' '));
    }
  }
  return text;
}

}  // namespace kappamu::studies
