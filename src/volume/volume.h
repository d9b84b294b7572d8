// A scalar volume: samples on a grid, and where that grid lies in the world.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/spaces.h"

namespace maille {

enum class VoxelType : std::uint8_t { uint8, int8, uint16, int16, float32 };

std::size_t bytes_per_voxel(VoxelType type);
std::string_view name_of(VoxelType type);  // "uint8" … "float32"

// Calls f.template operator()<T>() with the C++ type of the samples.
template <class F>
decltype(auto) with_voxel_type(VoxelType type, F&& f) {
  switch (type) {
    case VoxelType::uint8: return f.template operator()<std::uint8_t>();
    case VoxelType::int8: return f.template operator()<std::int8_t>();
    case VoxelType::uint16: return f.template operator()<std::uint16_t>();
    case VoxelType::int16: return f.template operator()<std::int16_t>();
    case VoxelType::float32: break;
  }
  return f.template operator()<float>();
}

// Immutable and cheap to copy: copies share the samples, which may be mapped from a file.
class Volume {
 public:
  // voxels: size.x*size.y*size.z samples, x fastest, in the machine's byte order, aligned for their
  // type; owner keeps them alive. Every size >= 1; world_from_voxel is invertible.
  Volume(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
         std::span<const std::byte> voxels, std::shared_ptr<const void> owner);

  // The same around samples that the volume owns.
  template <class T>
  static Volume of(Size3 size, VoxelType type, const glm::dmat4& world_from_voxel,
                   std::vector<T> samples) {
    auto owner = std::make_shared<const std::vector<T>>(std::move(samples));
    const auto bytes = std::as_bytes(std::span<const T>(*owner));
    return Volume(size, type, world_from_voxel, bytes, std::move(owner));
  }

  Size3 size() const { return size_; }
  VoxelType type() const { return type_; }
  const glm::dmat4& world_from_voxel() const { return world_from_voxel_; }
  glm::dvec3 spacing_mm() const;
  std::span<const std::byte> bytes() const { return voxels_; }

  // T must be the type that type() names.
  template <class T>
  std::span<const T> voxels() const {
    return {reinterpret_cast<const T*>(voxels_.data()), voxels_.size() / sizeof(T)};
  }

  double value_at(VoxelIndex voxel) const;  // voxel must lie inside

 private:
  Size3 size_;
  VoxelType type_;
  glm::dmat4 world_from_voxel_;
  std::span<const std::byte> voxels_;
  std::shared_ptr<const void> owner_;
};

// world_from_voxel of an axis-aligned grid with voxel (0,0,0) at origin_mm.
glm::dmat4 axis_aligned(glm::dvec3 spacing_mm, glm::dvec3 origin_mm = {0, 0, 0});

}  // namespace maille
