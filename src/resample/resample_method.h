// What value a voxel of the deformed volume shows.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace maille {

// x(X) = X + u(X): where the point X of the volume at rest lies now.
enum class ResampleMethod {
  nearest,      // the value of the element that lies nearest (in mm): labels, masks
  linear,       // of X, trilinear in the volume at rest; u is trilinear in each cell
  barycentric,  // of X, linear in the tetrahedron of six in its cell that holds it, and so is u
  rbf,          // smoothed: gaussian_mean.h
};

inline constexpr std::array kResampleMethods = {ResampleMethod::nearest, ResampleMethod::linear,
                                                ResampleMethod::barycentric, ResampleMethod::rbf};

constexpr std::string_view name_of(ResampleMethod method) {
  switch (method) {
    case ResampleMethod::nearest: return "nearest";
    case ResampleMethod::linear: return "linear";
    case ResampleMethod::barycentric: return "barycentric";
    case ResampleMethod::rbf: break;
  }
  return "rbf";
}

constexpr std::optional<ResampleMethod> method_named(std::string_view name) {
  for (const ResampleMethod method : kResampleMethods) {
    if (name_of(method) == name) return method;
  }
  return std::nullopt;
}

}  // namespace maille
