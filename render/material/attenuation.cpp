#include "render/material/attenuation.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "core/error.h"
#include "core/file_name.h"
#include "io/read_file.h"

namespace kappamu::render {

namespace {

using nlohmann::json;

class Reader {
 public:
  explicit Reader(const FileMaterialChoice& choice)
      : choice_(choice), bytes_(io::read_bytes(choice.file)) {}

  FileMaterial read() const {
    const std::string ending = lower_extension(choice_.file);
    if (ending == ".mtl") return read_mtl();
    if (ending == ".gltf" || ending == ".glb") return read_gltf();
    fail("is no file of materials by its name; give .gltf, .glb or .mtl");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(choice_.file.string() + ": " + what);
  }

  /// The index of the chosen one of `names`.
  std::size_t chosen(const std::vector<std::string>& names) const {
    if (!choice_.name && names.size() == 1) return 0;
    std::string list;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (choice_.name && names[i] == *choice_.name) return i;
      list += (i == 0 ? "'" : ", '") + names[i] + "'";
    }
    if (names.empty()) fail("has no materials; give a file that has");
    if (choice_.name) fail("has no material '" + *choice_.name + "'; its materials are " + list);
    fail("has several materials; name one of " + list);
  }

  json document() const {
    std::string text(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
    constexpr std::size_t start = 20;  // of a binary file's JSON, after two headers
    if (text.starts_with("glTF") && text.size() >= start) {
      std::uint32_t length = 0;
      std::memcpy(&length, text.data() + 12, sizeof(length));
      text = text.substr(start, length);
    }
    json parsed = json::parse(text, nullptr, false);
    if (!parsed.is_object()) fail("its glTF is not a JSON object; export it again");
    return parsed;
  }

  double number(const json& from, const char* field, double otherwise, double least) const {
    if (!from.is_object() || !from.contains(field)) return otherwise;
    if (!from[field].is_number() || !(from[field].get<double>() >= least))
      fail("its field " + std::string(field) + " is wrong; export it again");
    return from[field].get<double>();
  }

  FileMaterial read_gltf() const {
    const json all = document();
    const json materials = all.value("materials", json::array());
    std::vector<std::string> names;
    for (const json& one : materials) names.push_back(one.value("name", std::string()));
    const std::size_t index = chosen(names);
    const json extensions = materials[index].value("extensions", json::object());
    const std::string name = "material '" + names[index] + "'";
    if (!extensions.contains("KHR_materials_volume")) {
      fail(name + " has no extension KHR_materials_volume; write its coefficients in the scene");
    }
    if (!extensions.contains("KHR_materials_transmission") &&
        !extensions.contains("KHR_materials_diffuse_transmission")) {
      fail(name + " transmits no light; export it with KHR_materials_transmission");
    }
    const json& volume = extensions["KHR_materials_volume"];
    FileMaterial result;
    const double distance =
        number(volume, "attenuationDistance", std::numeric_limits<double>::infinity(), 1e-30);
    result.attenuation.distance_mm = distance * choice_.mm_per_unit;
    const json colour = volume.value("attenuationColor", json::array({1.0, 1.0, 1.0}));
    for (std::size_t c = 0; c < 3; ++c) {
      if (!colour.is_array() || colour.size() != 3 || !colour[c].is_number())
        fail(name + " has no attenuationColor of three numbers; export it again");
      result.attenuation.colour[static_cast<Eigen::Index>(c)] = colour[c].get<double>();
    }
    expect_colour(result.attenuation.colour, name, "attenuationColor");
    constexpr double usual_index = 1.5;
    const json ior = extensions.value("KHR_materials_ior", json::object());
    result.eta = number(ior, "ior", usual_index, 1.0);
    result.source = choice_.file.string() + ", " + name + ", KHR_materials_volume";
    return result;
  }

  FileMaterial read_mtl() const {
    struct Entry {
      std::string name;
      std::optional<Colour> filter;
      std::optional<double> index;
    };
    std::vector<Entry> entries;
    std::istringstream text(
        std::string(reinterpret_cast<const char*>(bytes_.data()), bytes_.size()));
    for (std::string line; std::getline(text, line);) {
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "newmtl") {
        entries.emplace_back();
        words >> entries.back().name;
      } else if (word == "Tf" && !entries.empty()) {
        Colour filter;
        if (!(words >> filter[0])) fail("line '" + line + "' is no filter of three numbers");
        if (!(words >> filter[1] >> filter[2])) filter.setConstant(filter[0]);
        entries.back().filter = filter;
      } else if (word == "Ni" && !entries.empty()) {
        double index = 0.0;
        if (!(words >> index) || !(index >= 1.0 && index <= 4.0))
          fail("line '" + line + "' is no refractive index of 1 to 4");
        entries.back().index = index;
      }
    }
    std::vector<std::string> names;
    for (const Entry& entry : entries) names.push_back(entry.name);
    const Entry& entry = entries[chosen(names)];
    const std::string name = "material '" + entry.name + "'";
    if (!entry.filter) fail(name + " has no transmission filter Tf; write its coefficients");
    if (!choice_.distance_mm) {
      fail(name +
           " has its filter Tf without a distance; write distance_mm, after which light "
           "has that colour");
    }
    expect_colour(*entry.filter, name, "Tf");
    return {{*entry.filter, *choice_.distance_mm},
            entry.index,
            choice_.file.string() + ", " + name + ", Tf"};
  }

  void expect_colour(const Colour& colour, const std::string& name,
                     const std::string& field) const {
    if ((colour > 0.0).all() && (colour <= 1.0).all()) return;
    fail(name + " has a " + field +
         " that is not above 0 and at most 1; a black one would absorb "
         "everything, write a small number");
  }

  const FileMaterialChoice& choice_;
  std::vector<std::byte> bytes_;
};

}  // namespace

Colour absorption_of(const Attenuation& attenuation) {
  return (-attenuation.colour.log() / attenuation.distance_mm).max(0.0);
}

FileMaterial read_file_material(const FileMaterialChoice& choice) {
  return Reader(choice).read();
}

}  // namespace kappamu::render
