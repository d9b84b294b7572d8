#include "references/paper_values.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace maille {
namespace {

// A point this far outside of a tetrahedron, in barycentric coordinates, is inside: or rounding
// would keep points on a shared face out of both.
constexpr double kInside = 1e-9;
// A tetrahedron of less volume than this share of the product of its edges is flat.
constexpr double kFlat = 1e-12;

// By corner; nothing where the point lies outside or the tetrahedron is flat.
std::optional<std::array<double, 4>> barycentric_coordinates(
    const std::array<glm::dvec3, 4>& corners_mm, glm::dvec3 point_mm) {
  const glm::dvec3 a = corners_mm[1] - corners_mm[0];
  const glm::dvec3 b = corners_mm[2] - corners_mm[0];
  const glm::dvec3 c = corners_mm[3] - corners_mm[0];
  const glm::dvec3 p = point_mm - corners_mm[0];
  const double volume = glm::dot(a, glm::cross(b, c));
  if (!(std::abs(volume) > kFlat * glm::length(a) * glm::length(b) * glm::length(c))) {
    return std::nullopt;
  }
  const double of_a = glm::dot(p, glm::cross(b, c)) / volume;
  const double of_b = glm::dot(a, glm::cross(p, c)) / volume;
  const double of_c = glm::dot(a, glm::cross(b, p)) / volume;
  const std::array<double, 4> coordinates{1.0 - of_a - of_b - of_c, of_a, of_b, of_c};
  for (const double coordinate : coordinates) {
    if (coordinate < -kInside) return std::nullopt;
  }
  return coordinates;
}

PaperValue barycentric(const DeformedElements& elements, std::span<const double> values,
                       std::size_t element, glm::dvec3 point_mm) {
  // The two corners, between the diagonal's ends, of each of the six: an order of the three axes.
  constexpr std::array<std::array<unsigned, 2>, 6> kBetween{
      {{1, 3}, {1, 5}, {2, 3}, {2, 6}, {4, 5}, {4, 6}}};
  PaperValue found{values[element], false};
  any_cell_around(element, elements.size(), [&](VoxelIndex base) {
    for (const auto& between : kBetween) {
      std::array<std::size_t, 4> of{};
      std::array<glm::dvec3, 4> corners_mm{};
      const std::array<unsigned, 4> corners{0, between[0], between[1], 7};
      for (std::size_t k = 0; k < 4; ++k) {
        of[k] = cell_corner(base, corners[k], elements.size());
        corners_mm[k] = elements.at_mm(of[k]);
      }
      const auto coordinates = barycentric_coordinates(corners_mm, point_mm);
      if (!coordinates) continue;
      double value = 0.0;
      for (std::size_t k = 0; k < 4; ++k) value += (*coordinates)[k] * values[of[k]];
      found = {value, true};
      return true;
    }
    return false;
  });
  return found;
}

double rbf(const DeformedElements& elements, std::span<const double> values, std::size_t element,
           glm::dvec3 point_voxels) {
  const auto squared_voxels = [&](std::size_t i) {
    const glm::dvec3 away = elements.at_mm(i) / elements.spacing_mm() - point_voxels;
    return glm::dot(away, away);
  };
  // Weights as shares of the nearest one's, which cancels out: where a cell is stretched over 50
  // voxels and more each of them would be 0.
  double least = std::numeric_limits<double>::infinity();
  for_each_in_neighbourhood(element, elements.size(),
                            [&](std::size_t i) { least = std::min(least, squared_voxels(i)); });
  double weights = 0.0;
  double sum = 0.0;
  for_each_in_neighbourhood(element, elements.size(), [&](std::size_t i) {
    const double weight =
        std::exp((least - squared_voxels(i)) / (kRbfRadius_voxels * kRbfRadius_voxels));
    weights += weight;
    sum += weight * values[i];
  });
  return sum / weights;
}

}  // namespace

PaperValue paper_value(const DeformedElements& elements, std::span<const double> values,
                       std::size_t element, glm::dvec3 point_voxels, PaperMethod method) {
  switch (method) {
    case PaperMethod::nearest: break;
    case PaperMethod::barycentric:
      return barycentric(elements, values, element, point_voxels * elements.spacing_mm());
    case PaperMethod::rbf: return {rbf(elements, values, element, point_voxels), true};
  }
  return {values[element], true};
}

}  // namespace maille
