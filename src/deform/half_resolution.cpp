#include "deform/half_resolution.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "deform/spring_rows.h"

namespace maille {
namespace {

// Element i of the half-resolution box is element 2 i of the fine one, or its last.
int fine_of(int i, int fine_extent) { return std::min(2 * i, fine_extent - 1); }

// Held elements between those that are kept must not be lost: whether a free element of the half
// box has one beside it in the fine box that no kept element stands for; which.
std::int64_t held_between(const SpringBox& fine, glm::ivec3 at) {
  const Size3 extent = fine.extent();
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const glm::ivec3 beside = at + glm::ivec3(dx, dy, dz);
        if (glm::any(glm::lessThan(beside, glm::ivec3(1))) ||
            glm::any(glm::greaterThan(beside, extent - 2))) {
          continue;
        }
        const std::int64_t e = fine.element(beside.x, beside.y, beside.z);
        if (fine.is_free(e)) continue;
        bool kept = false;
        for (int corner = 0; corner < 8; ++corner) {
          const glm::ivec3 to(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1);
          const glm::ivec3 even = glm::min((beside + to) / 2 * 2, extent - 1);
          kept = kept || !fine.is_free(fine.element(even.x, even.y, even.z));
        }
        if (!kept) return e;
      }
    }
  }
  return -1;
}

}  // namespace

std::unique_ptr<SpringBox> SpringBox::at_half_resolution(const SpringBox& fine, WorkerPool& pool) {
  const Size3 from = fine.extent_;
  std::unique_ptr<SpringBox> box(new SpringBox);
  SpringBox& half = *box;
  half.extent_ = from / 2 + 1;
  half.free_ = {VoxelIndex(1), half.extent_ - 1};
  half.volume_size_ = half.extent_;
  half.spacing_mm_ = 2.0 * fine.spacing_mm_;
  half.springs_ = springs_of(half.spacing_mm_);
  for (std::size_t s = 0; s < half.springs_.size(); ++s) {
    const glm::ivec3 o = half.springs_[s].offset;
    half.steps_[s] = half.element(o.x, o.y, o.z);
  }
  half.u_mm_ = make_box_vectors(half.extent_, pool);
  if (fine.keeps()) half.kept_mm_ = make_box_vectors(half.extent_, pool);
  half.free_flags_ = BoxArray<std::uint8_t>(half.extent_, pool);
  half.one_compliance_ = fine.one_compliance_;
  half.one_blend_ = fine.one_blend_;
  half.beyond_volume_ = fine.beyond_volume_;
  if (fine.compliance_) half.compliance_ = BoxArray<float>(half.extent_, pool);
  if (fine.blend_) half.blend_ = BoxArray<float>(half.extent_, pool);

  std::vector<std::int64_t> free_in_plane(static_cast<std::size_t>(half.extent_.z));
  pool.for_each(half.extent_.z, [&](std::int64_t plane, int) {
    const int z = static_cast<int>(plane);
    const int fine_z = fine_of(z, from.z);
    for (int y = 0; y < half.extent_.y; ++y) {
      const int fine_y = fine_of(y, from.y);
      const bool rim = z == 0 || y == 0 || z == half.extent_.z - 1 || y == half.extent_.y - 1;
      const std::int64_t row = half.element(0, y, z);
      for (int x = 0; x < half.extent_.x; ++x) {
        const glm::ivec3 at(fine_of(x, from.x), fine_y, fine_z);
        std::int64_t e = fine.element(at.x, at.y, at.z);
        if (half.compliance_) {
          half.compliance_[row + x] = fine.mean_compliance(at);
          if (half.blend_) half.blend_[row + x] = fine.blend(e);
        }
        if (!rim && x > 0 && x < half.extent_.x - 1 && fine.is_free(e)) {
          const std::int64_t held = held_between(fine, at);
          if (held >= 0) {
            e = held;
          } else {
            half.free_flags_[row + x] = 1;
            ++free_in_plane[static_cast<std::size_t>(plane)];
          }
        }
        for (std::size_t c = 0; c < 3; ++c) half.u_mm_[c][row + x] = fine.u_mm_[c][e];
        if (!fine.keeps()) continue;
        for (std::size_t c = 0; c < 3; ++c) half.kept_mm_[c][row + x] = fine.kept_mm_[c][e];
      }
    }
  });
  for (const std::int64_t count : free_in_plane) half.free_elements_ += count;
  half.tell_rows_apart(pool);
  if (half.keeps()) half.find_keeping_rows(pool);
  return box;
}

// Geometric, over the 2^3 elements from one on: between springs in series and side by side.
float SpringBox::mean_compliance(glm::ivec3 at) const {
  const float own = compliance_[element(at.x, at.y, at.z)];
  if (!std::isfinite(own)) return own;
  bool same = true;
  double logs = 0.0;
  int count = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 to =
        glm::min(at + glm::ivec3(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1), extent_ - 1);
    const float c = compliance_[element(to.x, to.y, to.z)];
    if (!std::isfinite(c)) continue;
    same = same && c == own;
    ++count;
  }
  if (same) return own;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 to =
        glm::min(at + glm::ivec3(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1), extent_ - 1);
    const float c = compliance_[element(to.x, to.y, to.z)];
    if (std::isfinite(c)) logs += std::log2(double{c});
  }
  return static_cast<float>(std::exp2(logs / count));
}

double interpolate_moves(const SpringBox& half, const BoxVectors* before, const SpringBox& fine,
                         BoxVectors& moves, WorkerPool& pool) {
  const Size3 extent = fine.extent();
  const glm::vec3 voxels_from_mm(1.0 / fine.spacing_mm());
  std::vector<float> furthest(static_cast<std::size_t>(extent.z), 0.0f);
  pool.for_each(extent.z - 2, [&](std::int64_t plane, int) {
    const int z = static_cast<int>(plane) + 1;
    std::vector<float> between(static_cast<std::size_t>(half.extent().x));
    for (int y = 1; y < extent.y - 1; ++y) {
      if (fine.kind(fine.row(y, z)) == RowKind::held) continue;
      const std::int64_t begin = fine.element(0, y, z);
      for (std::size_t c = 0; c < 3; ++c) {
        std::fill(between.begin(), between.end(), 0.0f);
        for (int corner = 0; corner < 4; ++corner) {
          const int half_y = (y + (corner & 1)) / 2;
          const int half_z = (z + (corner >> 1)) / 2;
          const std::int64_t from = half.element(0, half_y, half_z);
          const float* const now = &half.u_mm()[c][from];
          if (!before) {
            for (std::size_t x = 0; x < between.size(); ++x) between[x] += 0.25f * now[x];
            continue;
          }
          const float* const was = &(*before)[c][from];
          for (std::size_t x = 0; x < between.size(); ++x) between[x] += 0.25f * (now[x] - was[x]);
        }
        float* const to = &moves[c][begin];
        const float* const here = &fine.u_mm()[c][begin];
        const std::uint8_t* const free = fine.free_flags() + begin;
        for (int x = 0; x < extent.x; ++x) {
          const auto low = static_cast<std::size_t>(x / 2);
          const auto high = static_cast<std::size_t>((x + 1) / 2);
          to[x] = free[x] ? 0.5f * (between[low] + between[high]) : 0.0f;
        }
        if (before) continue;
        for (int x = 0; x < extent.x; ++x) to[x] -= free[x] ? here[x] : 0.0f;
      }
      float& most = furthest[static_cast<std::size_t>(z)];
      most = std::max(most, largest_square(&moves[0][begin], &moves[1][begin], &moves[2][begin],
                                           voxels_from_mm, extent.x));
    }
  });
  return std::sqrt(double{*std::max_element(furthest.begin(), furthest.end())});
}

}  // namespace maille
