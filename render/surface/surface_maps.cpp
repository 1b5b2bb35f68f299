#include "render/surface/surface_maps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "io/image/image_file.h"
#include "render/linear_image.h"

namespace kappamu::render {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Heights and gloss are numbers, not light: codes over the largest code.
Image<float> read_numbers(const std::filesystem::path& file) {
  return io::is_float_image(file) ? io::read_float_image(file) : io::read_relative_image(file);
}

void expect_texture(const SurfaceImage& image, const TriangleMesh& mesh, const char* what) {
  if (image.size_mm || !mesh.texture.empty()) return;
  throw InputError(std::string("surface.") + what +
                   ": the mesh has no texture coordinates; export it with them, or state size_mm");
}

float texel(const Image<float>& image, long x, long y, int channel) {
  const long w = image.width(), h = image.height();
  return image(static_cast<int>((x % w + w) % w), static_cast<int>((y % h + h) % h),
               image.channels() == 1 ? 0 : channel);
}

/// Pixel coordinates and where in the cell of four pixels.
struct Cell {
  long x, y;
  double right, down;
};

Cell cell_at(const Image<float>& image, const Vector2d& at) {
  const double x = at.x() * image.width() - 0.5, y = (1.0 - at.y()) * image.height() - 0.5;
  return {std::lround(std::floor(x)), std::lround(std::floor(y)), x - std::floor(x),
          y - std::floor(y)};
}

double bilinear(const Image<float>& image, const Vector2d& at, int channel) {
  const Cell c = cell_at(image, at);
  const double above = (1.0 - c.right) * texel(image, c.x, c.y, channel) +
                       c.right * texel(image, c.x + 1, c.y, channel);
  const double below = (1.0 - c.right) * texel(image, c.x, c.y + 1, channel) +
                       c.right * texel(image, c.x + 1, c.y + 1, channel);
  return (1.0 - c.down) * above + c.down * below;
}

/// Of the bilinear function, by u and by v, differences over a pixel.
Vector2d slope(const Image<float>& image, const Vector2d& at) {
  const Vector2d du(0.5 / image.width(), 0.0), dv(0.0, 0.5 / image.height());
  return {(bilinear(image, at + du, 0) - bilinear(image, at - du, 0)) * image.width(),
          (bilinear(image, at + dv, 0) - bilinear(image, at - dv, 0)) * image.height()};
}

}  // namespace

SurfaceMaps::SurfaceMaps(const SurfaceDetail& detail, const TriangleMesh& mesh,
                         std::shared_ptr<const PlacedReflectance> measured)
    : detail_(detail), measured_(std::move(measured)) {
  bool by_texture = false;
  const auto take = [&](const std::optional<SurfaceImage>& image, const char* what) {
    if (!image) return false;
    expect_texture(*image, mesh, what);
    by_texture = by_texture || !image->size_mm;
    return true;
  };
  if (take(detail.bump, "bump")) bump_ = read_numbers(detail.bump->file);
  if (take(detail.gloss, "gloss")) gloss_ = read_numbers(detail.gloss->file);
  if (take(detail.reflectance_image, "reflectance")) {
    reflectance_ = read_linear_image(detail.reflectance_image->file);
  }
  if (by_texture) mesh_ = mesh;
}

std::array<SurfaceMaps::OnImage, 3> SurfaceMaps::on_image(const SurfaceImage& image,
                                                          const Place& place) const {
  std::array<OnImage, 3> found;
  if (image.size_mm) {
    // The share of each axis: the fourth power turns from one to the next within about 30 degrees.
    const Vector3d share = place.normal.array().square().square();
    for (int axis = 0; axis < 3; ++axis) {
      OnImage& one = found[static_cast<std::size_t>(axis)];
      const int right = axis == 0 ? 2 : 0, up = axis == 1 ? 2 : 1;
      one.weight = share[axis] / share.sum();
      one.at = {place.point[right] / image.size_mm->x(), place.point[up] / image.size_mm->y()};
      one.along = {Vector3d::Unit(right) / image.size_mm->x(),
                   Vector3d::Unit(up) / image.size_mm->y()};
    }
    return found;
  }
  const auto& [a, b, c] = mesh_.triangles[place.triangle];
  const CornerTexture& texture = mesh_.texture[place.triangle];
  const auto vertex = [&](int i) -> const Vector3d& {
    return mesh_.vertices[static_cast<std::size_t>(i)];
  };
  const Vector3d e1 = vertex(b) - vertex(a), e2 = vertex(c) - vertex(a), n = e1.cross(e2);
  const Vector2d t0 = texture[0].cast<double>(), t1 = texture[1].cast<double>() - t0,
                 t2 = texture[2].cast<double>() - t0;
  // Gradients of the barycentric weights of the second and third corner.
  const double area = n.squaredNorm();
  const Vector3d g1 = area > 0.0 ? Vector3d(e2.cross(n) / area) : Vector3d(Vector3d::Zero());
  const Vector3d g2 = area > 0.0 ? Vector3d(n.cross(e1) / area) : Vector3d(Vector3d::Zero());
  found[0].at = t0 + place.u * t1 + place.v * t2;
  found[0].along = {t1.x() * g1 + t2.x() * g2, t1.y() * g1 + t2.y() * g2};
  found[1].weight = found[2].weight = 0.0;
  return found;
}

Colour SurfaceMaps::value(const Image<float>& pixels, const SurfaceImage& image,
                          const Place& place) const {
  Colour sum = Colour::Zero();
  for (const OnImage& one : on_image(image, place)) {
    if (one.weight <= 0.0) continue;
    for (int c = 0; c < 3; ++c) sum[c] += one.weight * bilinear(pixels, one.at, c);
  }
  return sum;
}

Vector3d SurfaceMaps::normal(const Place& place) const {
  if (!detail_.bump) return place.normal;
  Vector3d gradient = Vector3d::Zero();
  for (const OnImage& one : on_image(*detail_.bump, place)) {
    if (one.weight <= 0.0) continue;
    const Vector2d by = slope(bump_, one.at);
    gradient += one.weight * detail_.depth_mm * (by.x() * one.along[0] + by.y() * one.along[1]);
  }
  gradient -= gradient.dot(place.normal) * place.normal;
  return (place.normal - gradient).normalized();
}

double SurfaceMaps::roughness(const Place& place, double otherwise) const {
  if (!detail_.gloss) return otherwise;
  const double gloss = std::clamp(value(gloss_, *detail_.gloss, place)[0], 0.0, 1.0);
  return detail_.dull + gloss * (detail_.glossy - detail_.dull);
}

Colour SurfaceMaps::reflectance(const Place& place) const {
  if (measured_) return detail_.reflectance * measured_->at(place);
  if (!detail_.reflectance_image) return detail_.reflectance;
  return detail_.reflectance * value(reflectance_, *detail_.reflectance_image, place);
}

}  // namespace kappamu::render
