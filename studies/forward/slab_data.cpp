#include "studies/forward/slab_data.h"

#include <cctype>
#include <fstream>
#include <map>
#include <sstream>

#include "core/error.h"

namespace kappamu::studies {

namespace {

namespace fs = std::filesystem;

double number(const std::string& text, const std::string& where) {
  std::size_t used = 0;
  double value = 0.0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != text.size()) {
    throw InputError(where + ": '" + text + "' is not a number.");
  }
  return value;
}

struct Rows {
  MeasuredSlab header;
  std::string columns = "rt";               ///< one letter each, as iad names them
  std::vector<std::vector<double>> values;  ///< [row][column]
};

constexpr std::size_t header_numbers = 17;

MeasuredSlab header_of(const std::vector<double>& n) {
  MeasuredSlab slab;
  slab.n_sample = n[0];
  slab.n_slide = n[1];
  slab.thickness = n[2];
  slab.standard = n[5];  // of reflectance alone: iad has 1 for transmission unless a column T says
  slab.spheres = static_cast<int>(n[6]);
  const auto sphere = [&n](std::size_t first) {
    Sphere s;
    s.diameter = n[first];
    s.sample_port = n[first + 1];
    s.third_port = n[first + 2];
    s.detector_port = n[first + 3];
    s.wall_reflectance = n[first + 4];
    return s;
  };
  slab.reflection = sphere(7);
  slab.transmission = sphere(12);
  return slab;
}

Rows read_rxt(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  if (!in || !std::getline(in, line) || line.rfind("IAD1", 0) != 0) {
    throw InputError(file.string() + ": cannot be read as an .rxt file; its first line is IAD1.");
  }
  Rows rows;
  std::vector<double> header;
  for (int at = 2; std::getline(in, line); ++at) {
    const std::string where = file.string() + ":" + std::to_string(at);
    std::istringstream tokens(line.substr(0, line.find('#')));
    std::vector<std::string> words;
    for (std::string word; tokens >> word;) words.push_back(word);
    if (words.empty()) continue;
    if (header.size() < header_numbers) {
      header.push_back(number(words[0], where));
    } else if (std::isalpha(static_cast<unsigned char>(words[0][0])) != 0) {
      rows.columns.clear();
      for (const std::string& word : words) rows.columns += word[0];
    } else if (words.size() > 1) {  // a single number counts the columns
      std::vector<double>& row = rows.values.emplace_back();
      for (const std::string& word : words) row.push_back(number(word, where));
    }
  }
  if (header.size() < header_numbers) {
    throw InputError(file.string() + ": the header ends after " + std::to_string(header.size()) +
                     " numbers; it has " + std::to_string(header_numbers) + ".");
  }
  rows.header = header_of(header);
  return rows;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  if (!cells.empty() && !cells.back().empty() && cells.back().back() == '\r') {
    cells.back().pop_back();
  }
  return cells;
}

/// What a row says of itself overrules the file's header.
MeasuredSlab with_row(const Rows& rows, std::size_t index) {
  MeasuredSlab slab = rows.header;
  if (index >= rows.values.size()) return slab;
  for (std::size_t c = 0; c < rows.columns.size() && c < rows.values[index].size(); ++c) {
    const double value = rows.values[index][c];
    if (rows.columns[c] == 'n') slab.n_sample = value;
    if (rows.columns[c] == 'N') slab.n_slide = value;
    if (rows.columns[c] == 'R') slab.standard = value;
    if (rows.columns[c] == 'T') slab.transmission_standard = value;
    if (rows.columns[c] == 'd') slab.thickness = value;
  }
  return slab;
}

}  // namespace

double Sphere::gain(double sample, double third) const {
  const double wall = 1.0 - share(sample_port) - share(third_port) - share(detector_port);
  return 1.0 / (1.0 - (wall_reflectance + share(third_port) / wall * third) *
                          (wall + (1.0 - share(third_port)) * share(sample_port) * sample));
}

double Sphere::first_bounce(double third) const {
  return wall_reflectance * (1.0 - share(third_port)) + third * share(third_port);
}

std::vector<MeasuredSlab> read_measured_slabs(const fs::path& folder) {
  const fs::path table = folder / "peer_iad.csv";
  std::ifstream in(table);
  std::string line;
  if (!in || !std::getline(in, line)) {
    throw InputError(table.string() +
                     ": cannot be read; --data names the folder with peer_iad.csv and the .rxt "
                     "files it was made from.");
  }
  std::vector<MeasuredSlab> slabs;
  std::map<std::string, Rows> files;
  std::map<std::string, std::size_t> seen;
  for (int at = 2; std::getline(in, line); ++at) {
    const std::string where = table.string() + ":" + std::to_string(at);
    const auto cells = cells_of(line);
    if (cells.size() != 10) {
      throw InputError(where + ": " + std::to_string(cells.size()) +
                       " columns where the table has 10 (file ... flag).");
    }
    const std::size_t index = seen[cells[0]]++;
    if (cells[9] != "*") continue;
    if (!files.contains(cells[0])) files[cells[0]] = read_rxt(folder / (cells[0] + ".rxt"));
    MeasuredSlab slab = with_row(files[cells[0]], index);
    slab.file = cells[0];
    slab.row = cells[1];
    slab.reflectance = number(cells[2], where);
    slab.transmittance = number(cells[4], where);
    slab.sigma_a = number(cells[6], where);
    slab.sigma_s_prime = number(cells[7], where);
    slab.anisotropy = number(cells[8], where);
    slabs.push_back(slab);
  }
  return slabs;
}

}  // namespace kappamu::studies
