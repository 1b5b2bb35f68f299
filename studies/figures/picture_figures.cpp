#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/processor_time.h"
#include "forward/registry.h"
#include "io/image/image_file.h"
#include "render/render_scene.h"
#include "studies/figures/cluster_tile.h"
#include "studies/figures/figure_file.h"
#include "studies/figures/figures_bench.h"

namespace kappamu::studies {

namespace {

using Tile = Image<std::uint8_t>;
using Shows = FigureColumn::Shows;

constexpr int gap = 4;  ///< between tiles [px]

struct MadeCell {
  render::RenderResult result;
  double seconds = 0.0;
};

double luminance_at(const Image<float>& picture, int x, int y) {
  return 0.2126 * picture(x, y, 0) + 0.7152 * picture(x, y, 1) + 0.0722 * picture(x, y, 2);
}

/// Colours over [0, 1], evenly spaced.
template <std::size_t n>
std::array<std::uint8_t, 3> ramp(const std::array<std::array<double, 3>, n>& colours, double at) {
  const double place = std::clamp(at, 0.0, 1.0) * (n - 1);
  const auto k = std::min<std::size_t>(static_cast<std::size_t>(place), n - 2);
  std::array<std::uint8_t, 3> mixed{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double value =
        colours[k][c] + (place - static_cast<double>(k)) * (colours[k + 1][c] - colours[k][c]);
    mixed[c] = static_cast<std::uint8_t>(std::lround(value));
  }
  return mixed;
}

std::array<std::uint8_t, 3> signed_colour(double share) {
  constexpr std::array<std::array<double, 3>, 3> colours{
      {{5, 48, 140}, {245, 245, 245}, {160, 10, 30}}};
  return ramp(colours, 0.5 + 0.5 * share);
}

/// Of a relative error, three decades to 1.
std::array<std::uint8_t, 3> error_colour(double error) {
  constexpr std::array<std::array<double, 3>, 5> colours{
      {{30, 30, 120}, {0, 130, 170}, {60, 170, 60}, {250, 210, 40}, {190, 20, 20}}};
  return ramp(colours, error > 0.0 ? 1.0 + std::log10(error) / 3.0 : 0.0);
}

/// Pixels that both pictures cover to the full; others stay black.
Tile compared(const render::Picture& of, const render::Picture& from, Shows shows, double range) {
  Tile tile(of.radiance.width(), of.radiance.height(), 3);
  constexpr float covered = 0.999F;
  for (int y = 0; y < tile.height(); ++y) {
    for (int x = 0; x < tile.width(); ++x) {
      const double truth = luminance_at(from.radiance, x, y);
      if (of.coverage(x, y) < covered || from.coverage(x, y) < covered || truth <= 0.0) continue;
      const double error = luminance_at(of.radiance, x, y) / truth - 1.0;
      const auto colour =
          shows == Shows::error ? error_colour(std::abs(error)) : signed_colour(error / range);
      for (int c = 0; c < 3; ++c) tile(x, y, c) = colour[static_cast<std::size_t>(c)];
    }
  }
  return tile;
}

/// Relative 2-norm over the surface and the three channels; nothing where the meshes differ.
std::optional<double> exitance_error(const render::RenderResult& of,
                                     const render::RenderResult& from) {
  if (of.surface != from.surface) return std::nullopt;
  double difference = 0.0, norm = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    for (std::size_t t = 0; t < of.exitance[c].size(); ++t) {
      const double area = of.surface[7 * t + 6];
      difference += area * std::pow(of.exitance[c][t] - from.exitance[c][t], 2);
      norm += area * std::pow(from.exitance[c][t], 2);
    }
  }
  return norm > 0.0 ? std::optional(std::sqrt(difference / norm)) : std::nullopt;
}

/// The largest that models state of their own numerics, or of noise.
double stated_error(const render::RenderResult& result) {
  double worst = 0.0;
  for (const render::ObjectReport& object : result.objects) {
    for (const render::ChannelReport& channel : object.channels) {
      worst = std::max(worst, channel.error_estimate);
    }
  }
  return worst;
}

class Plate {
 public:
  void add(Tile tile) { rows_.back().push_back(std::move(tile)); }
  void next_row() { rows_.emplace_back(); }

  Tile whole() const {
    int width = 0, height = 0;
    for (const auto& row : rows_) {
      width = std::max(width, width_of(row));
      height += height_of(row) + gap;
    }
    Tile all(width, height - gap, 3, 255);
    int top = 0;
    for (const auto& row : rows_) {
      int left = 0;
      for (const Tile& tile : row) {
        for (int y = 0; y < tile.height(); ++y) {
          for (int x = 0; x < tile.width(); ++x) {
            for (int c = 0; c < 3; ++c) all(left + x, top + y, c) = tile(x, y, c);
          }
        }
        left += tile.width() + gap;
      }
      top += height_of(row) + gap;
    }
    return all;
  }

 private:
  static int width_of(const std::vector<Tile>& row) {
    int width = -gap;
    for (const Tile& tile : row) width += tile.width() + gap;
    return width;
  }
  static int height_of(const std::vector<Tile>& row) {
    int height = 0;
    for (const Tile& tile : row) height = std::max(height, tile.height());
    return height;
  }

  std::vector<std::vector<Tile>> rows_;
};

MadeCell make_cell(const render::Scene& scene, const Request& request, Progress& progress) {
  MadeCell made;
  const auto model = forward::make_object_model(scene.model.name, forward::ModelError::warned,
                                                scene.model.parameters);
  const Stopwatch watch;
  made.result = render::render_scene(scene, *model,
                                     {.device = request.device, .seed = request.seed}, progress);
  made.seconds = watch.seconds();
  return made;
}

/// One row of the plate, and its numbers.
void make_row(const Figure& figure, const FigureRow& row, const Request& request,
              Progress& progress, Plate& plate, Json& numbers) {
  std::map<std::string, MadeCell> made;
  double exposure = 0.0;
  for (const FigureColumn& column : figure.columns) {
    if (column.shows == Shows::clusters) {
      plate.add(cluster_tile(scene_of_cell(figure, row, column, request.size == Size::quick),
                             column.triangle_at));
      continue;
    }
    if (column.shows != Shows::picture) {
      plate.add(compared(made.at(column.of).result.picture, made.at(column.from).result.picture,
                         column.shows, column.range));
      const auto error = exitance_error(made.at(column.of).result, made.at(column.from).result);
      if (error) {
        for (Json& number : numbers) {
          if (number.at("figure") == figure.name && number.at("row") == row.name &&
              number.at("column") == column.of) {
            number["error"] = *error;
            number["from"] = column.from;
          }
        }
      }
      continue;
    }
    const render::Scene scene = scene_of_cell(figure, row, column, request.size == Size::quick);
    MadeCell cell = make_cell(scene, request, progress);
    if (exposure == 0.0) exposure = cell.result.exposure;
    const bool own = column.own_exposure || scene.film.exposure;
    plate.add(
        render::tone_mapped(cell.result.picture.radiance, own ? cell.result.exposure : exposure));
    numbers.push_back({{"figure", figure.name},
                       {"row", row.name},
                       {"column", column.name},
                       {"model", scene.model.name},
                       {"seconds", cell.seconds},
                       {"stated", stated_error(cell.result)}});
    made[column.name] = std::move(cell);
  }
}

std::vector<std::filesystem::path> figure_files(const Request& request) {
  const std::filesystem::path folder =
      request.has("files") ? request.words("files").front() : "studies/figures";
  std::vector<std::filesystem::path> files;
  for (const std::string& name : request.words("figure"))
    files.push_back(folder / (name + ".json"));
  if (!files.empty()) return files;
  std::error_code unreadable;
  for (const auto& entry : std::filesystem::directory_iterator(folder, unreadable)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  if (files.empty()) {
    throw InputError(folder.string() + ": no figures lie there; give their folder");
  }
  return files;
}

}  // namespace

void figure_pictures(const Request& request, Progress& progress, const Save& save) {
  std::vector<Figure> figures;
  for (const auto& file : figure_files(request)) figures.push_back(read_figure(file));
  Json rows = Json::array(), made = Json::array();
  for (const Figure& figure : figures) {
    Plate plate;
    for (const FigureRow& row : figure.rows) {
      plate.next_row();
      make_row(figure, row, request, progress, plate, rows);
    }
    const Tile whole = plate.whole();
    const std::filesystem::path file = request.folder / ("figures-" + figure.name + ".png");
    io::write_image(file, whole);
    Json entry{{"name", figure.name}, {"source", figure.source}, {"title", figure.title}};
    for (const FigureRow& row : figure.rows) entry["rows"].push_back(row.name);
    for (const FigureColumn& column : figure.columns) entry["columns"].push_back(column.name);
    made.push_back(std::move(entry));
    save({{"figures", made}, {"rows", rows}});
  }
}

}  // namespace kappamu::studies
