#include "render/fur/coat.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/error.h"
#include "io/image/image_file.h"
#include "render/fur/placement.h"

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

Coat coat_without_strokes(const TriangleMesh& mesh, const Fur& fur) {
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

/// The share of the way to its own that a stroke leads length, density and colour.
constexpr double strength = 0.5;

}  // namespace

CoatPainter::CoatPainter(const TriangleMesh& rest, const Fur& fur)
    : rest_(rest), bare_(coat_without_strokes(rest, fur)), coat_(bare_) {}

bool CoatPainter::goes_on(const Fur& fur) const {
  if (drawn_.empty()) return true;
  if (fur.comb != comb_ || fur.comb_turn_deg != comb_turn_deg_) return false;
  if (fur.strokes.size() < drawn_.size()) return false;
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    const std::vector<Eigen::Vector3d>&now = fur.strokes[i].points_mm,
          &before = drawn_[i].points_mm;
    const bool last = i + 1 == drawn_.size();
    if (!fur.strokes[i].same_brush(drawn_[i]) || now.size() < before.size() ||
        (!last && now.size() > before.size()) ||
        !std::equal(before.begin(), before.end(), now.begin())) {
      return false;
    }
  }
  return true;
}

const Coat& CoatPainter::of(const Fur& fur) {
  if (!goes_on(fur)) {
    coat_ = bare_;
    drawn_.clear();
  }
  if (drawn_.empty() && !fur.strokes.empty()) {
    frames_ = skin_frames(rest_, fur);
    comb_ = fur.comb;
    comb_turn_deg_ = fur.comb_turn_deg;
  }
  for (std::size_t i = drawn_.empty() ? 0 : drawn_.size() - 1; i < fur.strokes.size(); ++i) {
    draw(fur.strokes[i], i < drawn_.size() ? drawn_[i].points_mm.size() : 1);
  }
  drawn_ = fur.strokes;
  return coat_;
}

void CoatPainter::draw(const FurStroke& stroke, std::size_t first_point) {
  for (std::size_t point = first_point; point < stroke.points_mm.size(); ++point) {
    const Eigen::Vector3d &at = stroke.points_mm[point - 1], along = stroke.points_mm[point] - at;
    for (std::size_t v = 0; v < rest_.vertices.size(); ++v) {
      const double distance = (rest_.vertices[v] - at).norm() / stroke.radius_mm;
      if (distance >= 1.0) continue;
      const double weight = std::pow(1.0 - distance * distance, 2.0);
      const auto lead = [&](float& value, double goal) {
        value += static_cast<float>(strength * weight * (goal - static_cast<double>(value)));
      };
      switch (stroke.of) {
        case FurStroke::Of::comb: {
          const Eigen::Vector3d wanted = frames_[v].transpose() * along;
          if (wanted.head<2>().norm() < 1e-9) break;
          const auto turn = static_cast<double>(coat_.turn[v]);
          const Eigen::Vector2d mixed =
              (1.0 - weight) * Eigen::Vector2d(std::cos(turn), std::sin(turn)) +
              weight * wanted.head<2>().normalized();
          coat_.turn[v] = static_cast<float>(std::atan2(mixed.y(), mixed.x()));
          break;
        }
        case FurStroke::Of::length:
          lead(coat_.length[v], stroke.amount);
          break;
        case FurStroke::Of::density:
          lead(coat_.density[v], stroke.amount);
          break;
        case FurStroke::Of::colour:
          for (int c = 0; c < 3; ++c) lead(coat_.colour[v][c], stroke.colour[c]);
          break;
      }
    }
  }
}

Coat coat_of(const TriangleMesh& rest, const Fur& fur) {
  return CoatPainter(rest, fur).of(fur);
}

}  // namespace kappamu::render
