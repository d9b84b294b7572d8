// What a ray makes of the values that it meets.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace maille {

enum class RenderMode {
  composite,           // front to back through the transfer function
  iso,                 // the first surface of one value
  composite_with_iso,  // what lies before that surface, front to back, and the surface behind it
  mip,                 // the highest value along the ray
  average,             // the mean of the values above the transfer function's lowest
};

inline constexpr std::array kRenderModes{RenderMode::composite, RenderMode::iso,
                                         RenderMode::composite_with_iso, RenderMode::mip,
                                         RenderMode::average};

// As scene files have it.
constexpr std::string_view name_of(RenderMode mode) {
  switch (mode) {
    case RenderMode::composite: return "composite";
    case RenderMode::iso: return "iso";
    case RenderMode::composite_with_iso: return "composite+iso";
    case RenderMode::mip: return "mip";
    case RenderMode::average: break;
  }
  return "average";
}

constexpr std::optional<RenderMode> render_mode_named(std::string_view name) {
  for (const RenderMode mode : kRenderModes) {
    if (name_of(mode) == name) return mode;
  }
  return std::nullopt;
}

constexpr bool composites(RenderMode mode) {
  return mode == RenderMode::composite || mode == RenderMode::composite_with_iso;
}
constexpr bool shows_iso(RenderMode mode) {
  return mode == RenderMode::iso || mode == RenderMode::composite_with_iso;
}

}  // namespace maille
