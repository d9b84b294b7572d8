// What the ray caster should draw, once more: straight from the definitions, in double precision, a
// sample at a time, with nothing skipped, no table and no line shared with the shaders.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "render/camera.h"
#include "render/renderer.h"
#include "volume/volume.h"

namespace maille::reference {

// Trilinear; beyond the border samples their value goes on.
inline double value_at(const Volume& volume, glm::dvec3 voxel) {
  const glm::dvec3 last = glm::dvec3(volume.size()) - 1.0;
  const glm::dvec3 p = glm::clamp(voxel, glm::dvec3(0.0), last);
  const glm::ivec3 lo = glm::min(glm::ivec3(glm::floor(p)), glm::max(volume.size() - 2, 0));
  const glm::dvec3 part = p - glm::dvec3(lo);
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 step{corner & 1, (corner >> 1) & 1, (corner >> 2) & 1};
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis) weight *= step[axis] != 0 ? part[axis] : 1.0 - part[axis];
    if (weight == 0.0) continue;
    sum += weight * volume.value_at(lo + step);
  }
  return sum;
}

inline glm::dvec3 gradient_voxel(const Volume& volume, glm::dvec3 voxel) {
  glm::dvec3 gradient;
  for (int axis = 0; axis < 3; ++axis) {
    glm::dvec3 step(0.0);
    step[axis] = 1.0;
    gradient[axis] = (value_at(volume, voxel + step) - value_at(volume, voxel - step)) / 2.0;
  }
  return gradient;
}

struct March {
  glm::dvec3 entry, direction;  // voxel space, unit
  double length = -1.0;
};

inline March march(const Volume& volume, const Ray& ray) {
  const glm::dmat4 voxel_from_world = glm::inverse(volume.world_from_voxel());
  const glm::dvec3 origin = transform_point(voxel_from_world, ray.origin_mm);
  March march;
  march.direction = glm::normalize(transform_vector(voxel_from_world, ray.direction));
  double first = 0.0;
  double last = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = -0.5 - origin[axis];
    const double high = volume.size()[axis] - 0.5 - origin[axis];
    if (march.direction[axis] == 0.0) {
      if (low > 0.0 || high < 0.0) return march;
      continue;
    }
    const double a = low / march.direction[axis];
    const double b = high / march.direction[axis];
    first = std::max(first, std::min(a, b));
    last = std::min(last, std::max(a, b));
  }
  march.entry = origin + march.direction * first;
  march.length = last - first;
  return march;
}

// Distance from the entry to the first point of the iso value: bracketed by samples, then bisected.
inline std::optional<double> first_hit(const Volume& volume, const March& m,
                                       const RenderSettings& settings) {
  for (int n = 0; n * settings.step_voxels <= m.length; ++n) {
    const double t = n * settings.step_voxels;
    if (value_at(volume, m.entry + m.direction * t) < settings.iso_value) continue;
    double outside = std::max(0, n - 1) * settings.step_voxels;
    double inside = t;
    for (int i = 0; i < 50; ++i) {
      const double middle = (outside + inside) / 2.0;
      if (value_at(volume, m.entry + m.direction * middle) >= settings.iso_value) {
        inside = middle;
      } else {
        outside = middle;
      }
    }
    return inside;
  }
  return std::nullopt;
}

inline double brightness(const Volume& volume, const TransferFunction& transfer, glm::dvec3 voxel,
                         const Ray& ray) {
  const glm::dvec3 gradient = gradient_voxel(volume, voxel);
  const double flat = 0.01 * (transfer.highest() - transfer.lowest());
  const double steepness = glm::dot(gradient, gradient);
  if (steepness == 0.0) return 1.0;
  const glm::dmat3 voxel_from_world(glm::inverse(volume.world_from_voxel()));
  const glm::dvec3 normal = glm::normalize(glm::transpose(voxel_from_world) * gradient);
  const double weight = steepness / (steepness + flat * flat);
  const double lit = 0.3 + 0.7 * std::abs(glm::dot(normal, ray.direction));
  return 1.0 + weight * (lit - 1.0);
}

// Colour and opacity of the way between two samples: every value on it, one after the other. And
// where on it what absorbs is, in the mean.
struct Way {
  glm::dvec4 color{0.0};
  double middle = 0.5;
};

inline Way on_the_way(const TransferFunction& transfer, double from, double to,
                      double step_voxels) {
  constexpr int kParts = 400;
  glm::dvec3 colored(0.0);
  double depth = 0.0;
  double middle = 0.0;
  for (int i = 0; i < kParts; ++i) {
    const glm::dvec4 entry = transfer.at(from + (i + 0.5) / kParts * (to - from));
    const double part = -step_voxels * std::log(std::max(1.0 - entry.a, 1e-6)) / kParts;
    depth += part;
    colored += part * glm::dvec3(entry);
    middle += part * (i + 0.5) / kParts;
  }
  if (depth == 0.0) return {};
  return {{colored / depth, 1.0 - std::exp(-depth)}, middle / depth};
}

inline glm::dvec3 color(const Volume& volume, const TransferFunction& transfer,
                        const RenderSettings& settings, const Ray& ray) {
  const March m = march(volume, ray);
  if (m.length < 0.0) return settings.background;
  if (settings.mode == RenderMode::iso) {
    const auto hit = first_hit(volume, m, settings);
    if (!hit) return settings.background;
    const glm::dvec3 surface(transfer.at(settings.iso_value));
    return settings.shading
               ? surface * brightness(volume, transfer, m.entry + m.direction * *hit, ray)
               : surface;
  }
  glm::dvec3 sum(0.0);
  double clear = 1.0;
  double highest = transfer.lowest();
  double above = 0.0;
  int counted = 0;
  double before = 0.0;
  for (int n = 0; n * settings.step_voxels <= m.length; ++n) {
    const glm::dvec3 voxel = m.entry + m.direction * (n * settings.step_voxels);
    const double value = value_at(volume, voxel);
    if (settings.mode == RenderMode::composite_with_iso && value >= settings.iso_value) {
      RenderSettings surface = settings;
      surface.mode = RenderMode::iso;
      return sum + clear * color(volume, transfer, surface, ray);
    }
    highest = std::max(highest, value);
    if (value > transfer.lowest()) {
      above += value - transfer.lowest();
      ++counted;
    }
    const double from = settings.preintegration && n > 0 ? before : value;
    before = value;
    const auto [sample, middle] = on_the_way(transfer, from, value, settings.step_voxels);
    const double opacity = sample.a;
    if (opacity == 0.0) continue;
    const double back = settings.preintegration && n > 0 ? 1.0 - middle : 0.0;
    const glm::dvec3 lit = voxel - m.direction * (back * settings.step_voxels);
    const double light = settings.shading ? brightness(volume, transfer, lit, ray) : 1.0;
    sum += glm::dvec3(sample) * light * opacity * clear;
    clear *= 1.0 - opacity;
  }
  if (settings.mode == RenderMode::mip || settings.mode == RenderMode::average) {
    const double over = settings.mode == RenderMode::mip ? highest - transfer.lowest()
                                                         : above / std::max(counted, 1);
    const double part = std::clamp(over / (transfer.highest() - transfer.lowest()), 0.0, 1.0);
    return glm::mix(settings.background, glm::dvec3(1.0), part);
  }
  return sum + clear * settings.background;
}

inline Picture picture(const Volume& volume, const TransferFunction& transfer,
                       const RenderSettings& settings, const Camera& camera, PictureSize size) {
  Picture picture;
  picture.size = size;
  for (int y = 0; y < size.y; ++y) {
    for (int x = 0; x < size.x; ++x) {
      const glm::dvec3 c =
          color(volume, transfer, settings, ray_through_pixel(camera, size, {x, y}));
      for (int channel = 0; channel < 3; ++channel) {
        picture.rgba.push_back(
            static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(c[channel], 0.0, 1.0))));
      }
      picture.rgba.push_back(255);
    }
  }
  return picture;
}

}  // namespace maille::reference
