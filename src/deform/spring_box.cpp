#include "deform/spring_box.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "deform/missing_springs.h"

namespace maille {
namespace {

constexpr float kNoElement = std::numeric_limits<float>::infinity();  // as a compliance

// Calls f(linear index, voxels) for each brick, with those of its voxels that lie in a box.
template <class F>
void for_each_brick_of(const VoxelBox& box, const BrickGrid& grid, F&& f) {
  if (box.empty()) return;
  const BrickIndex first = BrickGrid::brick_of(box.lo);
  const BrickIndex last = BrickGrid::brick_of(box.hi - 1);
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        f(grid.linear({x, y, z}), intersection(grid.box({x, y, z}), box));
      }
    }
  }
}

}  // namespace

VoxelBox SpringBox::clipped_to_volume(const VoxelBox& box, Size3 volume) {
  return intersection(box, {VoxelIndex(0), volume});
}

SpringBox::SpringBox(const Problem& problem, const VoxelBox& free, WorkerPool& pool)
    : free_(free),
      volume_size_(problem.materials.size()),
      extent_(free.size() + 2),
      spacing_mm_(problem.materials.spacing_mm()),
      springs_(springs_of(spacing_mm_)),
      u_mm_(make_box_vectors(extent_, pool)),
      free_flags_(extent_, pool) {
  for (std::size_t s = 0; s < springs_.size(); ++s) {
    const glm::ivec3 o = springs_[s].offset;
    steps_[s] = element(o.x, o.y, o.z);
  }
  read_displacements(problem.start, pool);
  if (problem.kept) read_kept(*problem.kept, pool);
  read_materials(problem, pool);
  read_held(problem, pool);
  read_cuts(problem.cuts);
  tell_rows_apart(pool);
}

void SpringBox::read_displacements(const Lattice& start, WorkerPool& pool) {
  const VoxelBox all = clipped_to_volume({lo(), lo() + extent_}, volume_size_);
  struct Part {
    const LatticeBrick* brick;
    VoxelBox voxels;
  };
  std::vector<Part> parts;
  glm::ivec3 lowest(std::numeric_limits<int>::max());
  glm::ivec3 highest(std::numeric_limits<int>::min());
  for_each_brick_of(all, start.grid(), [&](std::int64_t b, const VoxelBox& voxels) {
    const LatticeBrick* const brick = start.brick(b);
    parts.push_back({brick, voxels});
    lowest = glm::min(lowest, brick ? brick->lowest() : glm::ivec3(0));
    highest = glm::max(highest, brick ? brick->highest() : glm::ivec3(0));
  });
  common_u_ = glm::clamp(glm::ivec3(0), lowest, highest);
  pool.for_each(static_cast<std::int64_t>(parts.size()), [&](std::int64_t i, int) {
    const auto& [brick, voxels] = parts[static_cast<std::size_t>(i)];
    if (brick || common_u_ != glm::ivec3(0)) read_brick(brick, voxels, common_u_, u_mm_);
  });
}

void SpringBox::read_kept(const Lattice& kept, WorkerPool& pool) {
  struct Part {
    const LatticeBrick* brick;
    VoxelBox voxels;
  };
  std::vector<Part> parts;
  for_each_brick_of(clipped_to_volume({lo(), lo() + extent_}, volume_size_), kept.grid(),
                    [&](std::int64_t b, const VoxelBox& voxels) {
                      if (kept.brick(b)) parts.push_back({kept.brick(b), voxels});
                    });
  if (parts.empty()) return;
  kept_mm_ = make_box_vectors(extent_, pool);
  pool.for_each(static_cast<std::int64_t>(parts.size()), [&](std::int64_t i, int) {
    const auto& [brick, voxels] = parts[static_cast<std::size_t>(i)];
    read_brick(brick, voxels, glm::ivec3(0), kept_mm_);
  });
  find_keeping_rows(pool);
}

// In mm, less what is the same for all. brick: null where it rests.
void SpringBox::read_brick(const LatticeBrick* brick, const VoxelBox& voxels, glm::ivec3 less,
                           BoxVectors& to) const {
  for (int c = 0; c < 3; ++c) {
    const auto mm_from_units = static_cast<float>(spacing_mm_[c] / kUnitsPerVoxel);
    for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
      for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
        std::int32_t u[kBrickEdge] = {};
        const VoxelIndex first{voxels.lo.x, y, z};
        const int count = voxels.size().x;
        if (brick) brick->read_row(c, element_in_brick(first), count, u);
        float* const row = &to[static_cast<std::size_t>(c)][element(first)];
        for (int x = 0; x < count; ++x) {
          row[x] = static_cast<float>(u[x] - less[c]) * mm_from_units;
        }
      }
    }
  }
}

void SpringBox::find_keeping_rows(WorkerPool& pool) {
  const auto rows = static_cast<std::size_t>(extent_.y) * static_cast<std::size_t>(extent_.z);
  std::vector<std::uint8_t> own(rows);
  pool.for_each(static_cast<std::int64_t>(rows), [&](std::int64_t r, int) {
    for (const auto& kept : kept_mm_) {
      const float* const row = &kept[r * extent_.x];
      if (std::any_of(row, row + extent_.x, [](float p) { return p != 0.0f; })) {
        own[static_cast<std::size_t>(r)] = 1;
      }
    }
  });
  keeping_rows_.assign(rows, 0);
  for (int z = 0; z < extent_.z; ++z) {
    for (int y = 0; y < extent_.y; ++y) {
      if (!own[static_cast<std::size_t>(row(y, z))]) continue;
      for (int dz = std::max(z - 1, 0); dz <= std::min(z + 1, extent_.z - 1); ++dz) {
        for (int dy = std::max(y - 1, 0); dy <= std::min(y + 1, extent_.y - 1); ++dy) {
          keeping_rows_[static_cast<std::size_t>(row(dy, dz))] = 1;
        }
      }
    }
  }
}

void SpringBox::read_materials(const Problem& problem, WorkerPool& pool) {
  const SpringTable table = SpringTable::of(problem.materials.table());
  const VoxelBox all = clipped_to_volume({lo(), lo() + extent_}, volume_size_);
  const bool inside = all.size() == extent_;
  beyond_volume_ = !inside;
  one_compliance_ = table.compliance(0);
  one_blend_ = table.rest_vector_blend(0);
  if (inside && problem.materials.single_material()) return;

  // Planes of one material, the same in all of them, need no array.
  std::vector<std::optional<MaterialId>> only(static_cast<std::size_t>(all.size().z));
  const auto ids_of_plane = [&](int z, std::vector<MaterialId>& ids) {
    const VoxelBox plane{{all.lo.x, all.lo.y, z}, {all.hi.x, all.hi.y, z + 1}};
    ids.resize(static_cast<std::size_t>(voxel_count(plane.size())));
    return problem.materials.read(plane, ids);
  };
  std::vector<std::vector<MaterialId>> scratch(static_cast<std::size_t>(pool.thread_count()));
  compliance_ = BoxArray<float>(extent_, pool);
  if (!table.one_blend()) blend_ = BoxArray<float>(extent_, pool);
  pool.for_each(extent_.z, [&](std::int64_t plane, int worker) {
    const int z = lo().z + static_cast<int>(plane);
    float* const compliance = &compliance_[element(0, 0, static_cast<int>(plane))];
    std::fill(compliance, compliance + std::int64_t{extent_.x} * extent_.y, kNoElement);
    if (z < all.lo.z || z >= all.hi.z) return;
    auto& ids = scratch[static_cast<std::size_t>(worker)];
    only[static_cast<std::size_t>(z - all.lo.z)] = ids_of_plane(z, ids);
    auto id = ids.begin();
    for (int y = all.lo.y; y < all.hi.y; ++y) {
      const std::int64_t row = element({all.lo.x, y, z});
      for (int x = 0; x < all.size().x; ++x, ++id) {
        compliance_[row + x] = table.compliance(*id);
        if (blend_) blend_[row + x] = table.rest_vector_blend(*id);
      }
    }
  });
  const bool one_material =
      inside && only.front() &&
      std::all_of(only.begin(), only.end(), [&](const auto& id) { return id == only.front(); });
  if (!one_material) return;
  one_compliance_ = table.compliance(*only.front());
  one_blend_ = table.rest_vector_blend(*only.front());
  compliance_ = {};
  blend_ = {};
}

void SpringBox::read_held(const Problem& problem, WorkerPool& pool) {
  const BrickGrid& grid = problem.start.grid();
  const AnchorRules anchors = problem.anchors;
  const std::uint8_t holding =
      anchors.faces ? anchors.faces : static_cast<std::uint8_t>(anchors.free_border ? 0 : 63);
  const MaterialTable& table = problem.materials.table();
  std::vector<std::int64_t> free_in_plane(static_cast<std::size_t>(extent_.z));
  std::vector<std::vector<MaterialId>> scratch(static_cast<std::size_t>(pool.thread_count()));
  pool.for_each(free_.size().z, [&](std::int64_t plane, int worker) {
    const int z = free_.lo.z + static_cast<int>(plane);
    auto& ids = scratch[static_cast<std::size_t>(worker)];
    if (table.any_fixed()) {
      const VoxelBox box{{free_.lo.x, free_.lo.y, z}, {free_.hi.x, free_.hi.y, z + 1}};
      ids.resize(static_cast<std::size_t>(voxel_count(box.size())));
      static_cast<void>(problem.materials.read(box, ids));
    }
    std::int64_t count = 0;
    for (int y = free_.lo.y; y < free_.hi.y; ++y) {
      const std::int64_t row = element({free_.lo.x, y, z});
      for (int x = free_.lo.x; x < free_.hi.x; ++x) {
        const bool on_face = holding && (faces_of({x, y, z}, volume_size_) & holding);
        free_flags_[row + x - free_.lo.x] = !on_face;
      }
      if (table.any_fixed()) {
        const auto* const id = &ids[static_cast<std::size_t>(y - free_.lo.y) *
                                    static_cast<std::size_t>(free_.size().x)];
        for (int x = 0; x < free_.size().x; ++x) {
          if (table.fixed(id[x])) free_flags_[row + x] = 0;
        }
      }
    }
    for_each_brick_of({{free_.lo.x, free_.lo.y, z}, {free_.hi.x, free_.hi.y, z + 1}}, grid,
                      [&](std::int64_t b, const VoxelBox& voxels) {
                        const auto* const mask = problem.held.brick(b);
                        const CutBrick* const cut = problem.cuts.brick(b);
                        if (!mask && !cut) return;
                        for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
                          for (int x = voxels.lo.x; x < voxels.hi.x; ++x) {
                            const VoxelIndex voxel{x, y, z};
                            const bool held =
                                mask &&
                                mask->test(static_cast<std::size_t>(element_in_brick(voxel)));
                            if (held || (cut && problem.cuts.carved(voxel))) {
                              free_flags_[element(voxel)] = 0;
                            }
                          }
                        }
                      });
    for (int y = free_.lo.y; y < free_.hi.y; ++y) {
      const std::uint8_t* const row = &free_flags_[element({free_.lo.x, y, z})];
      for (int x = 0; x < free_.size().x; ++x) count += row[x];
    }
    free_in_plane[static_cast<std::size_t>(plane)] = count;
  });
  for (const std::int64_t count : free_in_plane) free_elements_ += count;
}

void SpringBox::read_cuts(const Cuts& cuts) {
  if (cuts.empty()) return;
  const VoxelBox all = clipped_to_volume({lo(), lo() + extent_}, volume_size_);
  for_each_brick_of(all, cuts.grid(), [&](std::int64_t b, const VoxelBox& voxels) {
    const std::vector<std::uint32_t> gone = missing_springs(cuts, b, springs_);
    if (gone.empty()) return;
    if (missing_row_.empty()) {
      missing_row_.assign(static_cast<std::size_t>(extent_.y) * static_cast<std::size_t>(extent_.z),
                          -1);
    }
    for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
      for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
        const auto from = static_cast<std::size_t>(element_in_brick({voxels.lo.x, y, z}));
        const auto width = static_cast<std::size_t>(voxels.size().x);
        if (std::all_of(&gone[from], &gone[from] + width, [](auto bits) { return bits == 0; })) {
          continue;
        }
        std::int64_t& begin = missing_row_[static_cast<std::size_t>(row(y - lo().y, z - lo().z))];
        if (begin < 0) {
          begin = static_cast<std::int64_t>(missing_.size());
          missing_.resize(missing_.size() + static_cast<std::size_t>(extent_.x));
        }
        std::copy(&gone[from], &gone[from] + width,
                  &missing_[static_cast<std::size_t>(begin + voxels.lo.x - lo().x)]);
      }
    }
  });
}

void SpringBox::tell_rows_apart(WorkerPool& pool) {
  const auto rows = static_cast<std::size_t>(extent_.y) * static_cast<std::size_t>(extent_.z);
  kinds_.assign(rows, RowKind::held);
  all_free_.assign(rows, 0);
  std::vector<std::uint8_t> one_material(rows, 1);
  if (compliance_) {
    pool.for_each(static_cast<std::int64_t>(rows), [&](std::int64_t r, int) {
      const float* const c = &compliance_[r * extent_.x];
      const float* const b = blend_ ? &blend_[r * extent_.x] : nullptr;
      for (int x = 1; x < extent_.x; ++x) {
        if (c[x] != c[0] || (b && b[x] != b[0])) one_material[static_cast<std::size_t>(r)] = 0;
      }
    });
  }
  pool.for_each(extent_.z, [&](std::int64_t plane, int) {
    const int z = static_cast<int>(plane);
    if (z == 0 || z == extent_.z - 1) return;
    for (int y = 1; y < extent_.y - 1; ++y) {
      const std::int64_t r = row(y, z);
      const std::uint8_t* const flags = &free_flags_[r * extent_.x];
      const auto is_free = [](std::uint8_t f) { return f != 0; };
      if (std::none_of(flags, flags + extent_.x, is_free)) continue;
      all_free_[static_cast<std::size_t>(r)] =
          std::all_of(flags + 1, flags + extent_.x - 1, is_free);
      bool plain = true;
      for (int dz = -1; dz <= 1 && compliance_; ++dz) {
        for (int dy = -1; dy <= 1; ++dy) {
          const std::int64_t other = row(y + dy, z + dz);
          plain = plain && one_material[static_cast<std::size_t>(other)] &&
                  compliance_[other * extent_.x] == compliance_[r * extent_.x] &&
                  (!blend_ || blend_[other * extent_.x] == blend_[r * extent_.x]);
        }
      }
      kinds_[static_cast<std::size_t>(r)] = missing(r) ? RowKind::cut
                                            : plain    ? RowKind::plain
                                                       : RowKind::mixed;
    }
  });
}

glm::dvec3 SpringBox::displacement_voxels(std::int64_t e) const {
  const glm::dvec3 mm(u_mm_[0][e], u_mm_[1][e], u_mm_[2][e]);
  return mm / spacing_mm_ + glm::dvec3(common_u_) / double{kUnitsPerVoxel};
}

void SpringBox::round_to_fixed_point(BoxVectors& rounded_mm, WorkerPool& pool) const {
  pool.for_each(extent_.z, [&](std::int64_t plane, int) {
    const std::int64_t begin = plane * extent_.x * extent_.y;
    const std::int64_t end = begin + std::int64_t{extent_.x} * extent_.y;
    for (int c = 0; c < 3; ++c) {
      const auto units_from_mm = static_cast<float>(kUnitsPerVoxel / spacing_mm_[c]);
      const auto mm_from_units = static_cast<float>(spacing_mm_[c] / kUnitsPerVoxel);
      const BoxArray<float>& from = u_mm_[static_cast<std::size_t>(c)];
      BoxArray<float>& to = rounded_mm[static_cast<std::size_t>(c)];
      for (std::int64_t e = begin; e < end; ++e) {
        to[e] = free_flags_[e] ? std::nearbyint(from[e] * units_from_mm) * mm_from_units : from[e];
      }
    }
  });
}

Lattice SpringBox::lattice(const Lattice& published, WorkerPool& pool) const {
  struct Part {
    std::int64_t brick;
    VoxelBox voxels;
  };
  std::vector<Part> parts;
  for_each_brick_of(free_, published.grid(), [&](std::int64_t b, const VoxelBox& voxels) {
    parts.push_back({b, voxels});
  });
  std::vector<Lattice::Change> changes(parts.size());
  std::vector<std::unique_ptr<BrickDisplacements>> scratch(
      static_cast<std::size_t>(pool.thread_count()));
  pool.for_each(static_cast<std::int64_t>(parts.size()), [&](std::int64_t i, int worker) {
    const auto& [b, voxels] = parts[static_cast<std::size_t>(i)];
    auto& brick = scratch[static_cast<std::size_t>(worker)];
    if (!brick) brick = std::make_unique<BrickDisplacements>();
    const LatticeBrick* const from = published.brick(b);
    bool changed = false;
    for (int c = 0; c < 3; ++c) {
      const auto units_from_mm = static_cast<float>(kUnitsPerVoxel / spacing_mm_[c]);
      for (int r = 0; r < kBrickEdge * kBrickEdge; ++r) {
        std::int32_t* const u = &brick->u[c][r * kBrickEdge];
        if (from) {
          from->read_row(c, r * kBrickEdge, kBrickEdge, u);
        } else {
          std::fill(u, u + kBrickEdge, 0);
        }
      }
      for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
        for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
          std::int32_t* const u = &brick->u[c][((z & 31) * kBrickEdge + (y & 31)) * kBrickEdge];
          const std::int64_t begin = element({voxels.lo.x, y, z});
          const float* const mm = &u_mm_[static_cast<std::size_t>(c)][begin];
          const std::uint8_t* const flags = &free_flags_[begin];
          for (int x = 0; x < voxels.size().x; ++x) {
            // What is held keeps its bits: a float cannot hold every fixed-point displacement.
            if (!flags[x]) continue;
            std::int32_t& at = u[(voxels.lo.x & 31) + x];
            const auto now =
                static_cast<std::int32_t>(std::lrint(mm[x] * units_from_mm)) + common_u_[c];
            changed = changed || now != at;
            at = now;
          }
        }
      }
    }
    changes[static_cast<std::size_t>(i)] = {
        b, changed ? LatticeBrick::create(published.grid().box(published.grid().brick(b)), *brick)
                   : published.shared(b)};
  });
  Lattice now = published;
  now.set(changes);
  return now;
}

std::int64_t SpringBox::bytes() const {
  return bytes_of(u_mm_) + bytes_of(kept_mm_) + free_flags_.bytes() + compliance_.bytes() +
         blend_.bytes() +
         static_cast<std::int64_t>(kinds_.size() + keeping_rows_.size() +
                                   missing_row_.size() * sizeof(std::int64_t) +
                                   missing_.size() * sizeof(std::uint32_t));
}

}  // namespace maille
