#include "resample/rest_finder.h"

#include <algorithm>
#include <cmath>

#include "resample/cell_inverse.h"
#include "resample/corner_planes.h"
#include "resample/cut_finder.h"

namespace maille {
namespace {

// Flat faces of tetrahedra would meet bent ones of octants, with slivers between them that belong
// to neither.
CellMap map_of(const DeformedVolume& volume, bool cut) {
  return cut ? CellMap::trilinear : volume.cell_map;
}

// A point that misses its cell beyond the volume's border is outside the volume.
bool beyond_border(VoxelIndex base, glm::vec3 t, Size3 size) {
  for (int c = 0; c < 3; ++c) {
    if (base[c] < 0 && t[c] < -kInside_cells) return true;
    if (base[c] == size[c] - 1 && t[c] > 1.0f + kInside_cells) return true;
  }
  return false;
}

bool is_at(Float4 corner, glm::vec3 point) {
  const glm::vec3 away = glm::abs(glm::vec3(corner[0], corner[1], corner[2]) - point);
  return std::max({away.x, away.y, away.z}) < kOnElement_cells;
}

// What a cell has to say about a point: its rest position, and how good the claim is. Of several
// the best.
std::optional<Claim> claim_of(const DeformedCell& cell, const CellInverse& inverse, VoxelIndex base,
                              glm::vec3 point, const DeformedVolume& volume) {
  const Size3 size = volume.size();
  std::optional<Claim> best;
  inverse.for_each_answer(point, kInside_cells, [&](glm::vec3 t) {
    if (beyond_border(base, t, size)) return;
    VoxelIndex element = base;
    std::size_t corner = 0;
    for (int c = 0; c < 3; ++c) {
      float& s = t[c];
      const float whole = s < 0.5f ? 0.0f : 1.0f;
      if (std::abs(s - whole) < kOnElement_cells) s = whole;
      // The nearer end; of a border cell, the end that is an element.
      const bool upper = base[c] < 0 || (base[c] < size[c] - 1 && s >= 0.5f);
      corner |= static_cast<std::size_t>(upper) << c;
      element[c] += upper;
    }
    Claim claim{score_of(cell.corner[corner], point, volume), linear_index(element, size),
                rest_in_cell(base, glm::clamp(t, 0.0f, 1.0f), size)};
    // Cells that are flat there have no better answer than the element itself.
    if (is_at(cell.corner[corner], point)) claim.rest = glm::vec3(element);
    if (!best || claim.beats(best->score, best->element)) best = claim;
  });
  return best;
}

// Gives open voxels the rest positions that cells claim.
void claim_voxels(const Sight& sight, const VoxelBox& box, CellMap map, BrickClaims& claims,
                  ClaimPass pass) {
  const DeformedVolume& volume = sight.volume();
  const bool only_uncovered = pass != ClaimPass::inside;
  const glm::ivec3 extent = box.size();
  sight.for_each_cells_over(box, [&](const VoxelBox& cells, const DeformedVolume::Entry&) {
    const float slack = only_uncovered ? kBoundsSlack_voxels : 0.0f;
    for_each_moved_cell(
        volume.lattice, volume.cuts_or_null(), cells, box.lo, glm::vec3(-slack),
        glm::vec3(extent - 1) + slack,
        [&](const DeformedCell& cell, VoxelIndex base, Float4 lowest, Float4 highest) {
          // Bounds are half open: a voxel on a face that two cells share is looked at once. One
          // that rounding leaves out is found by the pass for the uncovered.
          glm::ivec3 first, last;
          for (int c = 0; c < 3; ++c) {
            const float low = std::max(lowest[c] - slack, 0.0f);
            const float high = highest[c] + slack;
            first[c] = static_cast<int>(low);
            first[c] += static_cast<float>(first[c]) < low;
            last[c] =
                high > static_cast<float>(extent[c] - 1) ? extent[c] - 1 : static_cast<int>(high);
            last[c] -= static_cast<float>(last[c]) == high && !only_uncovered;
            if (first[c] > last[c]) return;
          }
          std::optional<CellInverse> inverse;
          for (int z = first.z; z <= last.z; ++z) {
            for (int y = first.y; y <= last.y; ++y) {
              for (int x = first.x; x <= last.x; ++x) {
                const auto i = static_cast<std::size_t>((z * extent.y + y) * extent.x + x);
                if (!claims.is_open(i, pass)) continue;
                if (!inverse) inverse.emplace(cell, map);
                const auto claim = claim_of(cell, *inverse, base, glm::vec3(x, y, z), volume);
                if (claim) claims.take(i, *claim);
              }
            }
          }
        });
  });
}

}  // namespace

void find_rest(const Sight& sight, const VoxelBox& box, BrickClaims& claims) {
  const bool cut = sight.cut(box);
  const CellMap map = map_of(sight.volume(), cut);
  const auto claim = [&](ClaimPass pass) {
    claim_voxels(sight, box, map, claims, pass);
    if (cut) claim_cut_voxels(sight, box, claims, pass);
  };
  claim(ClaimPass::inside);
  if (std::find(claims.score.begin(), claims.score.end(), BrickClaims::kUncovered) !=
      claims.score.end()) {
    claim(ClaimPass::left_out);
  }
}

std::optional<glm::dvec3> rest_position_of(const DeformedVolume& volume, glm::dvec3 point_voxel) {
  const Size3 size = volume.size();
  bool in_volume = true;
  for (int c = 0; c < 3; ++c) {
    if (!(std::abs(point_voxel[c]) < 1e9)) return std::nullopt;
    in_volume = in_volume && point_voxel[c] >= -0.5 && point_voxel[c] <= size[c] - 0.5;
  }
  const auto origin = glm::ivec3(glm::floor(point_voxel));
  const glm::vec3 point(point_voxel - glm::dvec3(origin));
  const glm::vec3 low = point - kBoundsSlack_voxels;
  const glm::vec3 high = point + kBoundsSlack_voxels;
  std::optional<Claim> best;
  const auto take = [&](const std::optional<Claim>& claim) {
    if (claim && (!best || claim->beats(best->score, best->element))) best = claim;
  };
  const VoxelBox voxels{origin, origin + 2};
  const CellMap map = map_of(volume, Sight(volume, voxels).cut(voxels));
  for (const DeformedVolume::Entry& entry : volume.entries) {
    const VoxelBox cells = entry.cover.cells_over(point_voxel);
    for_each_moved_cell(volume.lattice, volume.cuts_or_null(), cells, origin, low, high,
                        [&](const DeformedCell& cell, VoxelIndex base, Float4, Float4) {
                          const CellInverse inverse(cell, map);
                          take(claim_of(cell, inverse, base, point, volume));
                        });
    if (!entry.cut) continue;
    for_each_moved_cell<CellKind::cut>(
        volume.lattice, &volume.cuts, cells, origin, low, high,
        [&](const DeformedCell& cell, VoxelIndex base, Float4, Float4) {
          take(cut_claim(volume, cell, base, origin, point));
        });
  }
  // The cell that holds the point at rest, if all of it rests.
  bool rests = in_volume;
  for (int k = 0; k < 8; ++k) {
    const VoxelIndex corner = origin + VoxelIndex(k & 1, (k >> 1) & 1, (k >> 2) & 1);
    const VoxelIndex element = glm::clamp(corner, VoxelIndex(0), size - 1);
    rests = rests && volume.lattice.u(element) == glm::ivec3(0);
  }
  const VoxelBox here{origin, origin + 1};
  std::optional<float> score_at_rest;
  if (rests && volume.any_cut && CutRows(volume.cuts, here).cells(origin.y, origin.z) != 0) {
    CornerPlanes planes(volume.lattice, nullptr, here, origin);
    planes.advance_to(origin.z);
    const DeformedCell cell = CellRow(planes, origin.y, origin.z, 1).cell(0);
    const auto claim = cut_claim(volume, cell, origin, origin, point);
    if (claim) score_at_rest = claim->score;
  } else if (rests) {
    const glm::vec3 away = (point - glm::round(point)) * volume.spacing_mm;
    score_at_rest = glm::dot(away, away);
  }
  if (score_at_rest && (!best || *score_at_rest <= best->score)) return point_voxel;
  if (!best) return std::nullopt;
  return glm::dvec3(best->rest);
}

}  // namespace maille
