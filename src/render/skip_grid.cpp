#include "render/skip_grid.h"

#include <algorithm>
#include <cstdlib>

namespace maille {
namespace {

constexpr int kFurthest = SkipGrid::kFurthest_blocks;

// out[i] = the least over rows j near i of max(|i - j|, in[j]): `rows` rows of `width` bytes that
// lie `stride` bytes apart.
void nearest_of_rows(const std::uint8_t* in, int rows, std::ptrdiff_t stride, int width,
                     std::uint8_t* out) {
  for (int i = 0; i < rows; ++i) {
    std::uint8_t* const to = out + i * stride;
    std::copy_n(in + i * stride, width, to);
    const int first = std::max(i - kFurthest + 1, 0);
    const int last = std::min(i + kFurthest - 1, rows - 1);
    for (int j = first; j <= last; ++j) {
      const auto away = static_cast<std::uint8_t>(std::abs(i - j));
      const std::uint8_t* const from = in + j * stride;
      for (int x = 0; x < width; ++x) to[x] = std::min(to[x], std::max(away, from[x]));
    }
  }
}

}  // namespace

SkipGrid::SkipGrid(Size3 blocks)
    : blocks_(blocks),
      shows_(static_cast<std::size_t>(voxel_count(blocks)), 0),
      distances_((shows_.size() + 3) / 4 * 4, kFurthest) {}

void SkipGrid::set(glm::ivec3 block, bool shows) {
  auto& known = shows_[static_cast<std::size_t>(linear_index(block, blocks_))];
  const std::uint8_t now = shows ? 1 : 0;
  if (known == now) return;
  known = now;
  changed_ = united(changed_, {block, block + 1});
}

bool SkipGrid::update() {
  if (changed_.empty()) return false;
  const VoxelBox all{VoxelIndex(0), blocks_};
  // What may have another nearest one now, and all that may be that.
  const VoxelBox box = intersection({changed_.lo - kFurthest, changed_.hi + kFurthest}, all);
  const VoxelBox seen = intersection({box.lo - kFurthest, box.hi + kFurthest}, all);
  changed_ = VoxelBox();
  const Size3 size = seen.size();
  const auto plane = static_cast<std::ptrdiff_t>(size.x) * size.y;
  std::vector<std::uint8_t> along_x(static_cast<std::size_t>(voxel_count(size)));
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      const std::uint8_t* const shows =
          &shows_[static_cast<std::size_t>(linear_index(seen.lo + VoxelIndex(0, y, z), blocks_))];
      std::uint8_t* const row = &along_x[static_cast<std::size_t>(z * plane + y * size.x)];
      int away = kFurthest;
      for (int x = 0; x < size.x; ++x) {
        away = shows[x] != 0 ? 0 : std::min(away + 1, kFurthest);
        row[x] = static_cast<std::uint8_t>(away);
      }
      away = kFurthest;
      for (int x = size.x - 1; x >= 0; --x) {
        away = shows[x] != 0 ? 0 : std::min(away + 1, kFurthest);
        row[x] = std::min(row[x], static_cast<std::uint8_t>(away));
      }
    }
  }
  std::vector<std::uint8_t> along_y(along_x.size());
  for (int z = 0; z < size.z; ++z) {
    nearest_of_rows(&along_x[static_cast<std::size_t>(z * plane)], size.y, size.x, size.x,
                    &along_y[static_cast<std::size_t>(z * plane)]);
  }
  for (int y = 0; y < size.y; ++y) {
    const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x);
    nearest_of_rows(&along_y[row], size.z, plane, size.x, &along_x[row]);
  }
  const VoxelIndex from = box.lo - seen.lo;
  for (int z = 0; z < box.size().z; ++z) {
    for (int y = 0; y < box.size().y; ++y) {
      const auto at =
          static_cast<std::size_t>((from.z + z) * plane + (from.y + y) * size.x + from.x);
      const auto to = static_cast<std::size_t>(linear_index(box.lo + VoxelIndex(0, y, z), blocks_));
      std::copy_n(&along_x[at], box.size().x, &distances_[to]);
    }
  }
  return true;
}

}  // namespace maille
