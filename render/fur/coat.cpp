#include "render/fur/coat.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/error.h"
#include "io/image/image_file.h"

namespace kappamu::render {

namespace {

/// The pixel at (u, v), v upwards; the image repeats.
Eigen::Array3f colour_at(const Image<float>& image, const Eigen::Vector2f& uv) {
  const auto wrapped = [](float share, int size) {
    const float place = share - std::floor(share);
    return std::min(static_cast<int>(place * static_cast<float>(size)), size - 1);
  };
  const int x = wrapped(uv.x(), image.width()), y = wrapped(1.0F - uv.y(), image.height());
  const int second = image.channels() > 1 ? 1 : 0, third = image.channels() > 2 ? 2 : 0;
  return {image(x, y, 0), image(x, y, second), image(x, y, third)};
}

using Take = std::function<void(std::size_t vertex, const Eigen::Array3f& mean)>;

void read_map(const TriangleMesh& mesh, const std::optional<std::filesystem::path>& file,
              const char* field, const Take& take) {
  if (!file) return;
  if (mesh.texture.empty()) {
    throw InputError(std::string("fur: ") + field +
                     " needs a mesh with texture coordinates, and this one has none; name a mesh "
                     "file that has them");
  }
  const Image<float> image = io::read_relative_image(*file);
  std::vector<Eigen::Array3f> sum(mesh.vertices.size(), Eigen::Array3f::Zero());
  std::vector<float> count(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto vertex = static_cast<std::size_t>(mesh.triangles[t][c]);
      sum[vertex] += colour_at(image, mesh.texture[t][c]);
      count[vertex] += 1.0F;
    }
  }
  for (std::size_t v = 0; v < sum.size(); ++v) {
    if (count[v] > 0.0F) take(v, sum[v] / count[v]);
  }
}

}  // namespace

Coat coat_of(const TriangleMesh& mesh, const Fur& fur) {
  const std::size_t size = mesh.vertices.size();
  Coat coat{std::vector<float>(size, 1.0F), std::vector<float>(size, 1.0F),
            std::vector<Eigen::Array3f>(size, Eigen::Array3f::Ones()), std::vector<float>(size)};
  read_map(mesh, fur.length_map, "length_map",
           [&](std::size_t v, const Eigen::Array3f& mean) { coat.length[v] = mean.mean(); });
  read_map(mesh, fur.density_map, "density_map",
           [&](std::size_t v, const Eigen::Array3f& mean) { coat.density[v] = mean.mean(); });
  read_map(mesh, fur.colour_map, "colour_map", [&](std::size_t v, const Eigen::Array3f& mean) {
    // sRGB codes to a linear factor.
    coat.colour[v] = (mean <= 0.04045F).select(mean / 12.92F, ((mean + 0.055F) / 1.055F).pow(2.4F));
  });
  read_map(mesh, fur.comb_map, "comb_map", [&](std::size_t v, const Eigen::Array3f& mean) {
    coat.turn[v] = std::atan2(mean[1] - 0.5F, mean[0] - 0.5F);
  });
  return coat;
}

}  // namespace kappamu::render
