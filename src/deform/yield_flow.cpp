#include "deform/yield_flow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "core/trace.h"
#include "deform/disturbance.h"
#include "deform/fold_energy.h"
#include "deform/relaxation_region.h"
#include "deform/spring_rows.h"
#include "deform/stiffness_multigrid.h"

namespace maille {
namespace {

constexpr double kLeastOpenAtRest = 0.05;  // J of X + P
// Of an element: two boxes' vectors and materials, six vectors to solve for one, coarser levels,
// parts.
constexpr std::int64_t kBytesPerElement = 160;
// Springs of what does not yield, for its parts to be carried along as they are.
constexpr float kStiffer = 1000.0f;
// What holds the displacements has nothing to do with the flow.
constexpr AnchorRules kNothingHeld{0, true};

glm::dvec3 at(const BoxVectors& v, std::int64_t e) {
  return {double{v[0][e]}, double{v[1][e]}, double{v[2][e]}};
}

SpringBox box_of_all(const YieldProblem& problem, const VoxelBox& voxels, WorkerPool& pool) {
  const ElementSet nothing;
  return SpringBox(
      {problem.lattice, problem.materials, problem.cuts, nothing, kNothingHeld, &problem.kept},
      voxels, pool);
}

// Calls f(element) for the elements of a plane of a box but its rim.
template <class F>
void for_each_inner(const SpringBox& box, int z, F&& f) {
  const Size3 extent = box.extent();
  for (int y = 1; y < extent.y - 1; ++y) {
    const std::int64_t row = box.element(0, y, z);
    for (int x = 1; x < extent.x - 1; ++x) f(row + x);
  }
}

// Fixed materials hold, whatever asks them to flow.
template <class F>
void for_each_held(const SpringBox& box, WorkerPool& pool, F&& f) {
  pool.for_each(box.extent().z - 2, [&](std::int64_t plane, int) {
    for_each_inner(box, static_cast<int>(plane) + 1, [&](std::int64_t e) {
      if (!box.is_free(e)) f(e);
    });
  });
}

// Of each element, infinite beyond the volume.
BoxArray<float> yield_strains(const SpringBox& box, const MaterialField& materials,
                              WorkerPool& pool) {
  BoxArray<float> strains(box.extent(), pool);
  const Size3 extent = box.extent();
  const VoxelBox all =
      intersection({box.lo(), box.lo() + extent}, {VoxelIndex(0), materials.size()});
  const std::int64_t plane_size = std::int64_t{extent.x} * extent.y;
  std::vector<std::vector<MaterialId>> scratch(static_cast<std::size_t>(pool.thread_count()));
  pool.for_each(extent.z, [&](std::int64_t plane, int worker) {
    float* const begin = &strains[plane * plane_size];
    std::fill(begin, begin + plane_size, std::numeric_limits<float>::infinity());
    const int z = box.lo().z + static_cast<int>(plane);
    if (z < all.lo.z || z >= all.hi.z) return;
    auto& ids = scratch[static_cast<std::size_t>(worker)];
    const VoxelBox voxels{{all.lo.x, all.lo.y, z}, {all.hi.x, all.hi.y, z + 1}};
    ids.resize(static_cast<std::size_t>(voxel_count(voxels.size())));
    static_cast<void>(materials.read(voxels, ids));
    auto id = ids.begin();
    for (int y = all.lo.y; y < all.hi.y; ++y) {
      float* const row = &strains[box.element(VoxelIndex{all.lo.x, y, z})];
      for (int x = 0; x < all.size().x; ++x) row[x] = materials.table().yield_strain(*id++);
    }
  });
  return strains;
}

// Of each element but the rim's, whose springs lead out of the box: the share that it keeps.
BoxArray<float> yielding_shares(const SpringBox& box, const BoxArray<float>& yield_strains,
                                WorkerPool& pool) {
  BoxArray<float> shares(box.extent(), pool);
  pool.for_each(box.extent().z - 2, [&](std::int64_t plane, int) {
    for_each_inner(box, static_cast<int>(plane) + 1, [&](std::int64_t e) {
      double share = 0.0;
      for (int s = 0; s < kSprings; ++s) {
        const std::int64_t other = e + box.step(s);
        const double yields = double{std::max(yield_strains[e], yield_strains[other])};
        if (!std::isfinite(yields) || !(box.stiffness(e, s) > 0.0f)) continue;
        const glm::dvec3 rest = glm::dvec3(box.springs()[static_cast<std::size_t>(s)].rest_mm);
        const double rest_length = glm::length(rest + box.kept_mm(e, s));
        const double length = glm::length(rest + at(box.u_mm(), e) - at(box.u_mm(), other));
        const double strain = std::abs(length - rest_length) / rest_length;
        if (strain > yields) share = std::max(share, 1.0 - yields / strain);
      }
      shares[e] = static_cast<float>(share);
    });
  });
  return shares;
}

VoxelBox box_of_shares(const SpringBox& box, const BoxArray<float>& shares, WorkerPool& pool) {
  std::vector<VoxelBox> of_planes(static_cast<std::size_t>(box.extent().z));
  pool.for_each(box.extent().z - 2, [&](std::int64_t plane, int) {
    VoxelBox& here = of_planes[static_cast<std::size_t>(plane)];
    for_each_inner(box, static_cast<int>(plane) + 1, [&](std::int64_t e) {
      if (!(shares[e] > 0.0f)) return;
      const VoxelIndex voxel = box.voxel(e);
      here = united(here, {voxel, voxel + 1});
    });
  });
  VoxelBox all;
  for (const VoxelBox& plane : of_planes) all = united(all, plane);
  return all;
}

// Of all elements that yield, found slab by slab: they may be few of those that have moved.
VoxelBox yielding_box(const YieldProblem& problem, WorkerPool& pool) {
  const VoxelBox moved = united(moved_box(problem.lattice), moved_box(problem.kept));
  if (moved.empty()) return {};
  const VoxelBox strained =
      intersection({moved.lo - 1, moved.hi + 1}, {VoxelIndex(0), problem.materials.size()});
  constexpr int kSlab = 32;
  VoxelBox all;
  for (int z = strained.lo.z; z < strained.hi.z; z += kSlab) {
    VoxelBox slab = strained;
    slab.lo.z = z;
    slab.hi.z = std::min(z + kSlab, strained.hi.z);
    const SpringBox box = box_of_all(problem, slab, pool);
    const auto shares = yielding_shares(box, yield_strains(box, problem.materials, pool), pool);
    all = united(all, box_of_shares(box, shares, pool));
  }
  return all;
}

// Calls f(elements, whether they hang on the rim) for each part, connected by springs, of those
// inner elements that are in it.
template <class In, class F>
void for_each_part(const SpringBox& box, WorkerPool& pool, In&& in, F&& f) {
  BoxArray<std::uint8_t> inner(box.extent(), pool);
  pool.for_each(box.extent().z - 2, [&](std::int64_t plane, int) {
    for_each_inner(box, static_cast<int>(plane) + 1, [&](std::int64_t e) { inner[e] = 1; });
  });
  BoxArray<std::uint8_t> seen(box.extent(), pool);
  std::vector<std::int64_t> part;
  for (int z = 1; z < box.extent().z - 1; ++z) {
    for_each_inner(box, z, [&](std::int64_t seed) {
      if (!in(seed) || seen[seed]) return;
      bool at_rim = false;
      part.assign(1, seed);
      seen[seed] = 1;
      for (std::size_t next = 0; next < part.size(); ++next) {
        for (int s = 0; s < kSprings; ++s) {
          const std::int64_t other = part[next] + box.step(s);
          if (!(box.stiffness(part[next], s) > 0.0f)) continue;
          if (!inner[other]) {
            at_rim = true;
          } else if (in(other) && !seen[other]) {
            seen[other] = 1;
            part.push_back(other);
          }
        }
      }
      f(part, at_rim);
    });
  }
}

// What flows and how: springs ask, elements that do not yield go as one with those beside them.
struct Asked {
  BoxVectors forces;  // sums of k t
  ElementSet stays;   // does not flow
  std::vector<std::vector<std::int64_t>>
      parts;                       // that do not yield and are carried along; or empty
  BoxArray<std::int32_t> part_of;  // of their elements: which, from 1 on; 0: none

  void stiffen_parts(SpringBox& box, WorkerPool& pool) const {
    box.stiffen([&](std::int64_t e) { return part_of[e] > 0; }, kStiffer, pool);
  }
};

// What does not yield and goes on beyond the box, or is fixed, stays where it is. Where there is
// nothing of that, the largest part that does not yield stays, or some element: where all lie is
// nothing to any spring.
void tell_what_stays(const SpringBox& box, const BoxArray<float>& shares, const BrickGrid& grid,
                     Asked& asked, WorkerPool& pool) {
  const auto stay = [&](std::int64_t e) { asked.stays.insert(box.voxel(e), grid); };
  const auto any_fixed = [&](const std::vector<std::int64_t>& part) {
    return std::any_of(part.begin(), part.end(), [&](std::int64_t e) { return !box.is_free(e); });
  };
  asked.part_of = BoxArray<std::int32_t>(box.extent(), pool);
  for_each_part(
      box, pool, [&](std::int64_t e) { return !(shares[e] > 0.0f); },
      [&](const std::vector<std::int64_t>& part, bool at_rim) {
        if (at_rim || any_fixed(part)) {
          std::for_each(part.begin(), part.end(), stay);
          return;
        }
        asked.parts.push_back(part);
        const auto number = static_cast<std::int32_t>(asked.parts.size());
        for (const std::int64_t e : part) asked.part_of[e] = number;
      });
  for_each_part(
      box, pool, [](std::int64_t) { return true; },
      [&](const std::vector<std::int64_t>& all, bool at_rim) {
        if (at_rim || any_fixed(all)) return;
        std::vector<std::int64_t>* largest = nullptr;
        for (const std::int64_t e : all) {
          if (asked.part_of[e] == 0) continue;
          auto& part = asked.parts[static_cast<std::size_t>(asked.part_of[e] - 1)];
          if (!largest || part.size() > largest->size()) largest = &part;
        }
        if (!largest) return stay(all.front());
        for (const std::int64_t e : *largest) {
          stay(e);
          asked.part_of[e] = 0;
        }
        largest->clear();
      });
}

Asked asked_by_springs(const YieldProblem& problem, const VoxelBox& voxels, WorkerPool& pool) {
  SpringBox box = box_of_all(problem, voxels, pool);
  const auto strains = yield_strains(box, problem.materials, pool);
  const auto shares = yielding_shares(box, strains, pool);
  Asked asked{make_box_vectors(box.extent(), pool), {}, {}, {}};
  tell_what_stays(box, shares, problem.lattice.grid(), asked, pool);
  asked.stiffen_parts(box, pool);
  pool.for_each(box.extent().z - 2, [&](std::int64_t plane, int) {
    for_each_inner(box, static_cast<int>(plane) + 1, [&](std::int64_t e) {
      glm::dvec3 sum(0.0);
      for (int s = 0; s < kSprings; ++s) {
        const std::int64_t other = e + box.step(s);
        const double share = 0.5 * (double{shares[e]} + double{shares[other]});
        if (share == 0.0 || !std::isfinite(std::max(strains[e], strains[other]))) continue;
        const glm::dvec3 from_rest = at(box.u_mm(), e) - at(box.u_mm(), other) - box.kept_mm(e, s);
        sum += double{box.stiffness(e, s)} * share * from_rest;
      }
      for (std::size_t c = 0; c < 3; ++c) {
        asked.forces[c][e] = static_cast<float>(sum[static_cast<int>(c)]);
      }
    });
  });
  return asked;
}

// What does not yield is carried along as it is: so near to that as stiff springs took it, it goes
// the mean way of its elements, each part all the way.
void carry_along(const Asked& asked, BoxVectors& flow) {
  for (const auto& part : asked.parts) {
    if (part.empty()) continue;
    for (auto& component : flow) {
      double sum = 0.0;
      for (const std::int64_t e : part) sum += double{component[e]};
      const auto mean = static_cast<float>(sum / static_cast<double>(part.size()));
      for (const std::int64_t e : part) component[e] = mean;
    }
  }
}

// Solves the stiffness Laplacian of a box for moves, by conjugate gradients; flexible ones, since a
// K-cycle is not quite the same operator each time.
class LaplacianSolver {
 public:
  LaplacianSolver(const SpringBox& box, BoxVectors forces, WorkerPool& pool)
      : box_(box),
        pool_(pool),
        multigrid_(box, pool),
        left_(std::move(forces)),
        moves_(make_box_vectors(box.extent(), pool)),
        direction_(make_box_vectors(box.extent(), pool)),
        image_(make_box_vectors(box.extent(), pool)),
        solution_(make_box_vectors(box.extent(), pool)) {}

  // multigrid's moves are what is left to within a factor of a few: so to 1e-3 voxel.
  BoxVectors solve() {
    constexpr double kEnough_voxels = 2e-4;
    constexpr int kMostIterations = 200;
    multigrid_.solve(left_, moves_);
    double moves_dot_left = dot(moves_, left_);
    float keep = 0.0f;
    for (int i = 0; i < kMostIterations && largest_move_voxels() > kEnough_voxels; ++i) {
      turn(keep);
      const double length = dot(direction_, left_) / apply_laplacian();
      if (!std::isfinite(length)) break;
      for_each_row([&](const SpringRun& run) {
        for (std::size_t c = 0; c < 3; ++c) {
          const auto by = static_cast<float>(length);
          float* const solution = &solution_[c][run.first];
          float* const left = &left_[c][run.first];
          for (int x = 0; x < run.count; ++x) {
            solution[x] += by * direction_[c][run.first + x];
            left[x] -= by * image_[c][run.first + x];
          }
        }
      });
      const double old_moves_dot_left = dot(moves_, left_);
      multigrid_.solve(left_, moves_);
      const double now = dot(moves_, left_);
      keep = moves_dot_left > 0.0
                 ? static_cast<float>(std::max(0.0, (now - old_moves_dot_left) / moves_dot_left))
                 : 0.0f;
      moves_dot_left = now;
    }
    return std::move(solution_);
  }

 private:
  template <class F>
  void for_each_row(F&& f) {
    const Size3 extent = box_.extent();
    pool_.for_each(extent.z - 2, [&](std::int64_t plane, int) {
      for (int y = 1; y < extent.y - 1; ++y) {
        const std::int64_t row = box_.row(y, static_cast<int>(plane) + 1);
        if (box_.kind(row) != RowKind::held) for_each_run(box_, row, 1, extent.x - 1, f);
      }
    });
  }

  template <class F>
  double sum_over_rows(F&& f) {
    std::vector<double> parts(static_cast<std::size_t>(box_.extent().z));
    for_each_row([&](const SpringRun& run) {
      const std::int64_t plane = run.first / (std::int64_t{box_.extent().x} * box_.extent().y);
      parts[static_cast<std::size_t>(plane)] += f(run);
    });
    double sum = 0.0;
    for (const double part : parts) sum += part;
    return sum;
  }

  double dot(const BoxVectors& a, const BoxVectors& b) {
    return sum_over_rows([&](const SpringRun& run) {
      double sum = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        sum += dot_of_run(&a[c][run.first], &b[c][run.first], run.count);
      }
      return sum;
    });
  }

  void turn(float keep) {
    for_each_row([&](const SpringRun& run) {
      for (std::size_t c = 0; c < 3; ++c) {
        float* const to = &direction_[c][run.first];
        const float* const from = &moves_[c][run.first];
        for (int x = 0; x < run.count; ++x) to[x] = from[x] + keep * to[x];
      }
    });
  }

  // image = L direction; returns direction . image.
  double apply_laplacian() {
    const Size3 extent = box_.extent();
    for_each_row([&](const SpringRun& run) {
      std::array<RowsAround, 3> rows;
      for (std::size_t c = 0; c < 3; ++c) {
        for (int r = 0; r < 9; ++r) {
          const std::int64_t step = (std::int64_t{r / 3 - 1} * extent.y + (r % 3 - 1)) * extent.x;
          rows[c].at[static_cast<std::size_t>(r)] = &direction_[c][run.first + step];
        }
      }
      RunVectors out;
      laplacian(box_, run, rows, out);
      const std::uint8_t* const free = box_.free_flags() + run.first;
      const float* const parts[3] = {out.x, out.y, out.z};
      for (std::size_t c = 0; c < 3; ++c) {
        float* const to = &image_[c][run.first];
        for (int x = 0; x < run.count; ++x) to[x] = free[x] ? parts[c][x] : 0.0f;
      }
    });
    return dot(direction_, image_);
  }

  double largest_move_voxels() {
    const glm::vec3 voxels_from_mm(1.0 / box_.spacing_mm());
    std::vector<float> parts(static_cast<std::size_t>(box_.extent().z));
    for_each_row([&](const SpringRun& run) {
      const std::int64_t plane = run.first / (std::int64_t{box_.extent().x} * box_.extent().y);
      float& part = parts[static_cast<std::size_t>(plane)];
      part = std::max(part, largest_square(&moves_[0][run.first], &moves_[1][run.first],
                                           &moves_[2][run.first], voxels_from_mm, run.count));
    });
    return std::sqrt(double{*std::max_element(parts.begin(), parts.end())});
  }

  const SpringBox& box_;
  WorkerPool& pool_;
  StiffnessMultigrid multigrid_;
  BoxVectors left_;
  BoxVectors moves_;
  BoxVectors direction_;
  BoxVectors image_;
  BoxVectors solution_;
};

// Adds a flow to P, which a box is in the state of, less of it where cells of the state of rest
// would come near to folding: by halves, so that only those around give way.
class OpenFlow {
 public:
  OpenFlow(SpringBox& box, const BoxVectors& flow, const Asked& asked, WorkerPool& pool)
      : box_(box),
        flow_(flow),
        asked_(asked),
        folds_(box),
        before_(make_box_vectors(box.extent(), pool)),
        halvings_(box.extent(), pool) {
    for (std::size_t c = 0; c < 3; ++c) before_[c].take_values_of(box_.u_mm()[c]);
    const Size3 extent = box_.extent();
    std::vector<std::vector<CellCorner>> of_planes(static_cast<std::size_t>(extent.z));
    pool.for_each(extent.z - 2, [&](std::int64_t plane, int) {
      for_each_inner(box_, static_cast<int>(plane) + 1, [&](std::int64_t e) { place(e); });
    });
    pool.for_each(extent.z, [&](std::int64_t plane, int) {
      auto& closed = of_planes[static_cast<std::size_t>(plane)];
      const std::int64_t size = std::int64_t{extent.x} * extent.y;
      for (std::int64_t e = plane * size; e < (plane + 1) * size; ++e) {
        for (std::uint8_t signs = 0; signs < 8; ++signs) {
          const CellCorner corner{e, signs};
          if (folds_.counts(corner) && closes(corner)) closed.push_back(corner);
        }
      }
    });
    std::vector<CellCorner> closed;
    for (const auto& some : of_planes) closed.insert(closed.end(), some.begin(), some.end());
    while (!closed.empty()) closed = halve_around(closed);
  }

 private:
  static constexpr std::array<float, 6> kShares = {1.0f, 0.5f, 0.25f, 0.125f, 0.0625f, 0.0f};

  // In fixed point, so that what is measured is what will be kept.
  void place(std::int64_t e) {
    if (!box_.is_free(e)) return;
    const glm::vec3 units(double{kUnitsPerVoxel} / box_.spacing_mm());
    const float share = kShares[halvings_[e]];
    for (std::size_t c = 0; c < 3; ++c) {
      const float unit = units[static_cast<int>(c)];
      box_.u_mm()[c][e] = before_[c][e] + std::nearbyint(share * flow_[c][e] * unit) / unit;
    }
  }

  // Worse than too little and than it was: a cell that a cut has kept apart may be folded already.
  bool closes(const CellCorner& corner) const {
    const double now = folds_.determinant(corner);
    if (now > kLeastOpenAtRest) return false;
    return now < glm::determinant(glm::dmat3(1.0) + folds_.edges_of(corner, before_));
  }

  // Returns the corners around what it has changed that are still closed. Ends: without any flow
  // all is as it was.
  std::vector<CellCorner> halve_around(const std::vector<CellCorner>& closed) {
    std::vector<std::int64_t> elements;
    std::vector<std::int32_t> parts;
    for (const CellCorner& corner : closed) {
      for (const std::int64_t e : folds_.elements_of(corner)) {
        if (!box_.is_free(e) || halvings_[e] + 1u >= kShares.size()) continue;
        elements.push_back(e);
        if (asked_.part_of[e] > 0) parts.push_back(asked_.part_of[e]);
      }
    }
    sort_once(parts);
    for (const std::int32_t number : parts) {
      const auto& part = asked_.parts[static_cast<std::size_t>(number - 1)];
      elements.insert(elements.end(), part.begin(), part.end());
    }
    sort_once(elements);
    std::vector<CellCorner> around;
    for (const std::int64_t e : elements) {
      ++halvings_[e];
      place(e);
      folds_.for_each_corner_at(e, [&](const CellCorner& corner) { around.push_back(corner); });
    }
    sort_once(around);
    std::erase_if(around, [&](const CellCorner& corner) { return !closes(corner); });
    return around;
  }

  template <class T>
  static void sort_once(std::vector<T>& v) {
    std::sort(v.begin(), v.end());
    v.erase(std::unique(v.begin(), v.end()), v.end());
  }

  SpringBox& box_;
  const BoxVectors& flow_;
  const Asked& asked_;
  FoldEnergy folds_;
  BoxVectors before_;
  BoxArray<std::uint8_t> halvings_;
};

}  // namespace

YieldFlow let_yield(const YieldProblem& problem, WorkerPool& pool) {
  const trace::Span span("material yields");
  YieldFlow result{problem.kept, yielding_box(problem, pool)};
  if (result.yielded.empty()) return result;
  // With what is around it: what it encloses must be told from what holds on to the rest.
  const RelaxationRegion region(result.yielded, problem.materials.size(), kNothingHeld,
                                std::max<std::int64_t>(1, problem.memory_bytes / kBytesPerElement));
  result.limited = region.limited();
  if (region.box().empty()) return result;
  Asked asked = asked_by_springs(problem, region.box(), pool);
  // Of P itself: its Laplacian is that of the displacements.
  SpringBox box({problem.kept, problem.materials, problem.cuts, asked.stays, kNothingHeld},
                region.box(), pool);
  if (box.free_elements() == 0) return result;
  asked.stiffen_parts(box, pool);
  for_each_held(box, pool, [&](std::int64_t e) {
    for (auto& component : asked.forces) component[e] = 0.0f;
  });
  BoxVectors flow = LaplacianSolver(box, std::move(asked.forces), pool).solve();
  carry_along(asked, flow);
  const OpenFlow open(box, flow, asked, pool);
  result.kept = box.lattice(problem.kept, pool);
  return result;
}

}  // namespace maille
