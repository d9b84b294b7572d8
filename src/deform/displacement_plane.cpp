#include "deform/displacement_plane.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "core/several_widths.h"

namespace maille {
namespace {

// What a pass over the rows of a plane finds out.
template <class T>
struct Extremes {
  T lowest = std::numeric_limits<T>::max();
  T highest = std::numeric_limits<T>::min();
  VoxelIndex first{kBrickEdge};  // of the elements that differ from `rest`, in the brick
  VoxelIndex last{-1};
};

// Whole rows at a time, with the lanes beyond the border masked, so that the compiler can keep a
// row in as few registers as the machine has width.
template <class T>
[[gnu::always_inline]] inline Extremes<T> extremes_of(const T* values, Size3 extent, T rest) {
  T lowest[kBrickEdge];
  T highest[kBrickEdge];
  T differs[kBrickEdge] = {};
  std::fill_n(lowest, kBrickEdge, std::numeric_limits<T>::max());
  std::fill_n(highest, kBrickEdge, std::numeric_limits<T>::min());
  T in_volume[kBrickEdge] = {};
  std::fill_n(in_volume, extent.x, static_cast<T>(~T{0}));
  Extremes<T> found;
  for (int z = 0; z < extent.z; ++z) {
    for (int y = 0; y < extent.y; ++y) {
      const T* row = values + (z * kBrickEdge + y) * kBrickEdge;
      T any = 0;
      for (int x = 0; x < kBrickEdge; ++x) {
        lowest[x] = std::min(lowest[x], row[x]);
        highest[x] = std::max(highest[x], row[x]);
        const T difference = static_cast<T>((row[x] ^ rest) & in_volume[x]);
        differs[x] = static_cast<T>(differs[x] | difference);
        any = static_cast<T>(any | difference);
      }
      if (any == 0) continue;
      found.first.y = std::min(found.first.y, y);
      found.last.y = std::max(found.last.y, y);
      found.first.z = std::min(found.first.z, z);
      found.last.z = z;
    }
  }
  for (int x = 0; x < extent.x; ++x) {
    found.lowest = std::min(found.lowest, lowest[x]);
    found.highest = std::max(found.highest, highest[x]);
    if (differs[x] == 0) continue;
    found.first.x = std::min(found.first.x, x);
    found.last.x = x;
  }
  return found;
}

MAILLE_FOR_SEVERAL_WIDTHS Extremes<std::int32_t> extremes(const std::int32_t* values, Size3 extent,
                                                          std::int32_t rest) {
  return extremes_of(values, extent, rest);
}

template <class T>
VoxelBox box_of(const VoxelBox& box, const Extremes<T>& found) {
  if (found.last.x < 0) return {};
  return {box.lo + found.first, box.lo + found.last + 1};
}

}  // namespace

DisplacementPlane::Pointer DisplacementPlane::encode(const VoxelBox& box, const std::int32_t* u) {
  const auto found = extremes(u, box.size(), 0);
  if (found.last.x < 0) return nullptr;
  auto plane = std::make_shared<DisplacementPlane>();
  plane->base_ = plane->lowest_ = found.lowest;
  plane->highest_ = found.highest;
  plane->moved_ = box_of(box, found);
  const auto range = std::int64_t{found.highest} - found.lowest;
  if (range > std::numeric_limits<std::uint16_t>::max()) {
    plane->wide_ = make_aligned_array<std::int32_t>(kBrickVoxels);
    std::copy_n(u, kBrickVoxels, plane->wide_.get());
  } else if (range > 0) {
    plane->offsets_ = make_aligned_array<std::uint16_t>(kBrickVoxels);
    for (std::size_t e = 0; e < kBrickVoxels; ++e) {
      plane->offsets_[e] = static_cast<std::uint16_t>(u[e] - found.lowest);
    }
  }
  return plane;
}

DisplacementPlane::Pointer DisplacementPlane::adopt(const Known& known,
                                                    AlignedArray<std::uint16_t> offsets) {
  auto plane = std::make_shared<DisplacementPlane>();
  plane->base_ = known.base;
  plane->step_ = known.step;
  plane->lowest_ = known.lowest;
  plane->highest_ = known.highest;
  plane->moved_ = known.moved;
  if (known.lowest == known.highest) {
    plane->base_ = known.lowest;
  } else {
    plane->offsets_ = std::move(offsets);
  }
  return plane;
}

namespace {

MAILLE_FOR_SEVERAL_WIDTHS
void add_base(std::int32_t base, std::int32_t step, const std::uint16_t* offset, int count,
              std::int32_t* u) {
  for (int x = 0; x < count; ++x) u[x] = base + step * offset[x];
}

}  // namespace

void DisplacementPlane::read_row(int first, int count, std::int32_t* u) const {
  if (offsets_) {
    add_base(base_, step_, &offsets_[static_cast<std::size_t>(first)], count, u);
  } else if (wide_) {
    std::copy_n(&wide_[static_cast<std::size_t>(first)], count, u);
  } else if (paged_) {
    const PagedArray::Pin values(*paged_);
    if (paged_->value_bytes() == sizeof(std::uint16_t)) {
      add_base(base_, step_, values.as<std::uint16_t>() + first, count, u);
    } else {
      std::copy_n(values.as<std::int32_t>() + first, count, u);
    }
  } else {
    std::fill_n(u, count, base_);
  }
}

std::int32_t DisplacementPlane::at_paged(std::size_t element) const {
  const PagedArray::Pin values(*paged_);
  if (paged_->value_bytes() == sizeof(std::uint16_t)) {
    return base_ + step_ * values.as<std::uint16_t>()[element];
  }
  return values.as<std::int32_t>()[element];
}

void DisplacementPlane::page_through(const std::shared_ptr<PlaneStore>& store) const {
  const auto give = [&](auto& array) {
    using Value = std::remove_reference_t<decltype(array[0])>;
    AlignedArray<std::byte> bytes(reinterpret_cast<std::byte*>(array.get()), array.get_deleter());
    try {
      paged_ = std::make_unique<const PagedArray>(store, std::move(bytes), int{sizeof(Value)});
    } catch (...) {
      bytes.release();  // the values stay where they are
      throw;
    }
    array.release();
  };
  if (offsets_) {
    give(offsets_);
  } else if (wide_) {
    give(wide_);
  }
}

std::int64_t DisplacementPlane::array_bytes() const {
  if (paged_) return paged_->bytes();
  const std::int64_t element = offsets_ ? sizeof(std::uint16_t) : wide_ ? sizeof(std::int32_t) : 0;
  return element * kBrickVoxels;
}

std::int64_t DisplacementPlane::bytes() const {
  const auto own = std::int64_t{sizeof(DisplacementPlane)};
  if (!paged_) return own + array_bytes();
  return own + std::int64_t{sizeof(PagedArray)} + paged_->bytes_in_memory();
}

}  // namespace maille
