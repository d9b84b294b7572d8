#include "measure/resample_truth.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "references/fixed_point_inverse.h"

namespace maille {
namespace {

// Of a plane of voxels.
struct Plane {
  std::vector<RestTruth> answers;
  std::vector<std::size_t> counts;  // of answers, by voxel
  std::int64_t lost = 0;
  double worst_forward_voxels = 0.0;
  VoxelBox bounds;
};

// Newton starts where the voxel before ended, and where that leads nowhere at the voxel itself.
std::optional<glm::dvec3> followed(const ResampleScene& scene, glm::dvec3 point,
                                   const std::optional<glm::dvec3>& before) {
  if (before) {
    if (const auto rest = rest_by_newton(scene, point, *before)) return rest;
  }
  return rest_by_newton(scene, point, point);
}

Plane plane_of(const ResampleScene& scene, Size3 size, std::span<const double> values, int z) {
  // Rounding alone puts nothing outside.
  constexpr double kRounding_voxels = 1e-9;
  Plane plane;
  for (int y = 0; y < size.y; ++y) {
    std::optional<glm::dvec3> before;
    for (int x = 0; x < size.x; ++x) {
      const glm::dvec3 point(x, y, z);
      std::vector<glm::dvec3> rest;
      if (scene.rest_positions) {
        rest = scene.rest_positions(point);
      } else if (const auto found = followed(scene, point, before)) {
        rest = {*found};
        before = found;
      } else {
        ++plane.lost;
      }
      const bool inside = !rest.empty() && std::all_of(rest.begin(), rest.end(), [&](auto& at) {
        const glm::dvec3 within = glm::clamp(at, glm::dvec3(0), glm::dvec3(size - 1));
        if (glm::length(at - within) > kRounding_voxels) return false;
        at = within;
        return true;
      });
      plane.counts.push_back(inside ? rest.size() : 0);
      if (!inside) continue;
      for (const glm::dvec3& at : rest) {
        plane.worst_forward_voxels = std::max(plane.worst_forward_voxels,
                                              glm::length(at + scene.displacement(at).u - point));
        plane.answers.push_back(
            {at, static_cast<float>(analytic_value(at)), trilinear(size, values, at)});
      }
      plane.bounds = united(plane.bounds, {{x, y, z}, {x + 1, y + 1, z + 1}});
    }
  }
  return plane;
}

template <class Distance>
double least_of(std::span<const RestTruth> answers, Distance&& distance) {
  double least = std::numeric_limits<double>::infinity();
  for (const RestTruth& answer : answers) least = std::min(least, distance(answer));
  return least;
}

}  // namespace

ResampleTruth::ResampleTruth(const ResampleScene& scene, Size3 size, std::span<const double> values,
                             WorkerPool& pool) {
  std::vector<Plane> planes(static_cast<std::size_t>(size.z));
  pool.for_each(size.z, [&](std::int64_t z, int) {
    planes[static_cast<std::size_t>(z)] = plane_of(scene, size, values, static_cast<int>(z));
  });
  first_.reserve(static_cast<std::size_t>(voxel_count(size)) + 1);
  first_.push_back(0);
  for (Plane& plane : planes) {
    answers_.insert(answers_.end(), plane.answers.begin(), plane.answers.end());
    for (const std::size_t count : plane.counts) {
      first_.push_back(first_.back() + count);
      judged_ += count > 0;
    }
    lost_ += plane.lost;
    worst_forward_voxels_ = std::max(worst_forward_voxels_, plane.worst_forward_voxels);
    bounds_ = united(bounds_, plane.bounds);
    plane = {};
  }
}

void Deviation::add(const Deviation& other) {
  squares_ += other.squares_;
  max_ = other.max_ > max_ || other.max_ != other.max_ ? other.max_ : max_;
  count_ += other.count_;
}

double Deviation::rms() const {
  return count_ == 0 ? 0.0 : std::sqrt(squares_ / static_cast<double>(count_));
}

std::optional<double> ResampleDeviation::times_floor() const {
  if (!(floor.rms() > 0.0)) return std::nullopt;
  return value.rms() / floor.rms();
}

ResampleDeviation deviation_from(const ResampleTruth& truth, Size3 size, const VoxelBox& voxels,
                                 std::span<const float> values,
                                 std::span<const glm::vec3> rest_voxels, WorkerPool& pool) {
  const Size3 extent = voxels.size();
  std::vector<ResampleDeviation> planes(static_cast<std::size_t>(extent.z));
  pool.for_each(extent.z, [&](std::int64_t plane, int) {
    ResampleDeviation& sum = planes[static_cast<std::size_t>(plane)];
    auto i = static_cast<std::size_t>(plane * extent.x * extent.y);
    for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
      for (int x = voxels.lo.x; x < voxels.hi.x; ++x, ++i) {
        const VoxelIndex voxel(x, y, voxels.lo.z + static_cast<int>(plane));
        const auto answers = truth.answers(static_cast<std::size_t>(linear_index(voxel, size)));
        if (answers.empty()) continue;
        if (!rest_voxels.empty() && !std::isnan(rest_voxels[i].x)) {
          const glm::dvec3 rest(rest_voxels[i]);
          sum.rest_voxels.add(
              least_of(answers, [&](auto& at) { return glm::length(rest - at.rest_voxels); }));
        }
        if (std::isnan(values[i])) {
          ++sum.unfilled_voxels;
          continue;
        }
        const double value = values[i];
        sum.value.add(least_of(answers, [&](auto& at) { return std::abs(value - at.value); }));
        sum.floor.add(
            least_of(answers, [&](auto& at) { return std::abs(at.interpolated - at.value); }));
      }
    }
  });
  // By rising plane: the same sums for any number of threads.
  ResampleDeviation all;
  for (const ResampleDeviation& plane : planes) {
    all.value.add(plane.value);
    all.floor.add(plane.floor);
    all.rest_voxels.add(plane.rest_voxels);
    all.unfilled_voxels += plane.unfilled_voxels;
  }
  return all;
}

}  // namespace maille
