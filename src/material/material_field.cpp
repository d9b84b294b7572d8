#include "material/material_field.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace maille {
namespace {

template <class T>
std::vector<MaterialId> ids_of_all_values(const MaterialTable& table) {
  using Bits = std::make_unsigned_t<T>;
  std::vector<MaterialId> ids(std::size_t{std::numeric_limits<Bits>::max()} + 1);
  for (std::size_t bits = 0; bits < ids.size(); ++bits) {
    ids[bits] = table.id_of(static_cast<double>(static_cast<T>(static_cast<Bits>(bits))));
  }
  return ids;
}

}  // namespace

MaterialField::MaterialField(Volume volume, MaterialTable table)
    : volume_(std::move(volume)), table_(std::move(table)) {
  if (single_material()) return;
  with_voxel_type(volume_.type(), [&]<class T>() {
    if constexpr (std::is_integral_v<T>) id_of_stored_ = ids_of_all_values<T>(table_);
  });
}

MaterialId MaterialField::at(VoxelIndex voxel) const {
  if (single_material()) return 0;
  MaterialId id = 0;
  read({voxel, voxel + 1}, {&id, 1});
  return id;
}

std::optional<MaterialId> MaterialField::read(const VoxelBox& box,
                                              std::span<MaterialId> ids) const {
  if (single_material()) {
    std::fill(ids.begin(), ids.end(), MaterialId{0});
    return MaterialId{0};
  }
  const Size3 extent = box.size();
  auto out = ids.begin();
  with_voxel_type(volume_.type(), [&]<class T>() {
    const auto samples = volume_.voxels<T>();
    for (int z = box.lo.z; z < box.hi.z; ++z) {
      for (int y = box.lo.y; y < box.hi.y; ++y) {
        const T* row =
            &samples[static_cast<std::size_t>(linear_index({box.lo.x, y, z}, volume_.size()))];
        for (int x = 0; x < extent.x; ++x) {
          if constexpr (std::is_integral_v<T>) {
            *out++ = id_of_stored_[static_cast<std::make_unsigned_t<T>>(row[x])];
          } else {
            *out++ = table_.id_of(static_cast<double>(row[x]));
          }
        }
      }
    }
  });
  const auto filled = ids.first(static_cast<std::size_t>(voxel_count(extent)));
  // memcmp of the ids with themselves one later: equal neighbours all along means one material.
  const bool uniform =
      filled.size() < 2 || std::memcmp(filled.data(), filled.data() + 1, filled.size() - 1) == 0;
  if (filled.empty() || !uniform) return std::nullopt;
  return filled.front();
}

}  // namespace maille
