// All points of a volume at rest that lie at a point now, in double precision: what the product's
// inverse is compared with. It shares nothing with it but where the elements lie.
//
// Every cell whose bounds hold the point is taken apart, by Krawczyk's operator: with M the inverse
// of the Jacobian in a box's middle c, all t of the box with x(t) = p lie in
// c + M (p - x(c)) +- |M| |J - J_c| / 2. That tells boxes without an answer, and boxes with at most
// one, to which the same step then leads; all others are halved along each axis. So folded cells
// give all their answers and no starting point is guessed.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "deform/cuts.h"
#include "deform/lattice.h"

namespace maille::testing {

// X + u(X): between the elements u is trilinear, beyond the border it is that of the border.
inline glm::dvec3 moved(const Lattice& lattice, glm::dvec3 rest) {
  const Size3 size = lattice.grid().volume_size();
  const glm::dvec3 inside = glm::clamp(rest, glm::dvec3(0), glm::dvec3(size - 1));
  const VoxelIndex base =
      glm::max(glm::min(VoxelIndex(glm::floor(inside)), size - 2), VoxelIndex(0));
  const glm::dvec3 t = inside - glm::dvec3(base);
  glm::dvec3 at = rest;
  for (unsigned k = 0; k < 8; ++k) {
    const VoxelIndex corner(k & 1u, k >> 1 & 1u, k >> 2);
    const glm::dvec3 along = glm::mix(1.0 - t, t, glm::dvec3(corner));
    const double weight = along.x * along.y * along.z;
    if (weight == 0.0) continue;
    at += weight * lattice.displacement_voxels(glm::min(base + corner, size - 1));
  }
  return at;
}

class TrueAnswers {
 public:
  struct Answers {
    std::vector<glm::dvec3> rest;  // each once
    // Somewhere near the point cells are so flat that doubles do not tell whether they hold it.
    bool unsure = false;
  };

  // Cells that something was cut from are left out.
  explicit TrueAnswers(const Lattice& lattice, const Cuts* cuts = nullptr)
      : size_(lattice.grid().volume_size()), cells_of_(bins() + 1, 0) {
    std::vector<Cell> cells;
    for (int z = -1; z < size_.z; ++z) {
      for (int y = -1; y < size_.y; ++y) {
        for (int x = -1; x < size_.x; ++x) {
          const VoxelIndex base(x, y, z);
          if (!cuts || whole(*cuts, base)) cells.push_back(cell_of(lattice, base));
        }
      }
    }
    // By the voxels that their bounds hold or come near.
    for (const Cell& cell : cells) {
      for_each_bin(cell, [&](std::size_t bin) { ++cells_of_[bin + 1]; });
    }
    for (std::size_t b = 1; b < cells_of_.size(); ++b) cells_of_[b] += cells_of_[b - 1];
    sorted_.resize(cells_of_.back());
    std::vector<std::size_t> next(cells_of_.begin(), cells_of_.end() - 1);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      for_each_bin(cells[i], [&](std::size_t bin) { sorted_[next[bin]++] = i; });
    }
    cells_ = std::move(cells);
  }

  // point: within a voxel of the volume.
  Answers at(glm::dvec3 point) const {
    Answers answers;
    const std::size_t bin = bin_of(VoxelIndex(glm::round(point)));
    for (std::size_t i = cells_of_[bin]; i < cells_of_[bin + 1]; ++i) {
      const Cell& cell = cells_[sorted_[i]];
      Search search{point, cell, answers};
      search.look_into(cell.corners, glm::dvec3(0), 1.0);
    }
    return answers;
  }

  // Whether some point within `slack_voxels` of this one is held by a cell, or by none: what a
  // point near the end of the material may be taken for.
  bool may_be_covered(glm::dvec3 point, double slack_voxels) const {
    return any_around(point, slack_voxels, [](const Answers& a) { return !a.rest.empty(); });
  }
  bool may_be_uncovered(glm::dvec3 point, double slack_voxels) const {
    return any_around(point, slack_voxels, [](const Answers& a) { return a.rest.empty(); });
  }

  // Whether a cell, by its lowest corner, has all its links and elements.
  static bool whole(const Cuts& cuts, VoxelIndex base) {
    const Size3 size = cuts.grid().volume_size();
    for (unsigned k = 0; k < 8; ++k) {
      const VoxelIndex corner = base + VoxelIndex(k & 1u, k >> 1 & 1u, k >> 2);
      const VoxelIndex element = glm::clamp(corner, VoxelIndex(0), size - 1);
      if (cuts.carved(element)) return false;
      for (unsigned axis = 0; axis < 3; ++axis) {
        if (k >> axis & 1u) continue;
        VoxelIndex next = corner;
        ++next[static_cast<int>(axis)];
        const VoxelIndex upper = glm::clamp(next, VoxelIndex(0), size - 1);
        if (upper != element && cuts.removed(element, static_cast<int>(axis))) return false;
      }
    }
    return true;
  }

 private:
  using Corners = std::array<glm::dvec3, 8>;  // (i,j,k) at i + 2j + 4k
  struct Cell {
    glm::dvec3 rest;  // of corner 0
    glm::dvec3 edge;  // at rest: half a voxel beyond the border
    Corners corners;  // now
  };

  static glm::dvec3 blend(const Corners& c, glm::dvec3 t) {
    const auto mix = [](const glm::dvec3& a, const glm::dvec3& b, double s) {
      return a + s * (b - a);
    };
    const glm::dvec3 near = mix(mix(c[0], c[1], t.x), mix(c[2], c[3], t.x), t.y);
    const glm::dvec3 far = mix(mix(c[4], c[5], t.x), mix(c[6], c[7], t.x), t.y);
    return mix(near, far, t.z);
  }

  struct Search {
    static constexpr double kRounding = 1e-9;         // of a box
    static constexpr double kRounding_voxels = 1e-8;  // of where points lie now
    static constexpr double kSmallest = 1.0 / 4096;   // of a cell
    static constexpr int kMostBoxes = 3000;           // of a cell

    glm::dvec3 point;
    const Cell& cell;
    Answers& answers;
    int boxes = 0;

    void found(glm::dvec3 t) {
      const glm::dvec3 rest = cell.rest + t * cell.edge;
      for (const glm::dvec3& known : answers.rest) {
        if (glm::distance(known, rest) < 1e-6) return;
      }
      answers.rest.push_back(rest);
    }

    // A box of the cell: its corners now, and in the cell its lowest and its edge.
    void look_into(const Corners& c, glm::dvec3 lowest, double edge) {
      if (answers.unsure && boxes > kMostBoxes) return;
      for (int k = 0; k < 3; ++k) {
        double least = c[0][k];
        double most = c[0][k];
        for (const glm::dvec3& corner : c) {
          least = std::min(least, corner[k]);
          most = std::max(most, corner[k]);
        }
        if (point[k] < least - kRounding_voxels || point[k] > most + kRounding_voxels) return;
      }
      if (++boxes > kMostBoxes || edge < kSmallest) {
        answers.unsure = true;
        return;
      }
      glm::dmat3 middle;
      glm::dmat3 away;
      for (unsigned axis = 0; axis < 3; ++axis) {
        glm::dvec3 low(1e300);
        glm::dvec3 high(-1e300);
        for (unsigned k = 0; k < 8; ++k) {
          if (k >> axis & 1u) continue;
          const glm::dvec3 along = c[k | 1u << axis] - c[k];
          low = glm::min(low, along);
          high = glm::max(high, along);
        }
        middle[static_cast<int>(axis)] = 0.5 * (low + high);
        away[static_cast<int>(axis)] = 0.5 * (high - low);
      }
      const double volume = glm::determinant(middle);
      const double scale = glm::length(middle[0]) * glm::length(middle[1]) * glm::length(middle[2]);
      if (std::abs(volume) > 1e-9 * scale) {
        const glm::dmat3 inverse = glm::inverse(middle);
        const glm::dvec3 center = 0.5 + inverse * (point - blend(c, glm::dvec3(0.5)));
        double share = 0.0;
        for (int k = 0; k < 3; ++k) {
          double reach = kRounding;
          for (int axis = 0; axis < 3; ++axis) {
            for (int j = 0; j < 3; ++j) reach += 0.5 * std::abs(inverse[j][k]) * away[axis][j];
          }
          if (center[k] + reach < 0.0 || center[k] - reach > 1.0) return;
          share = std::max(share, 2.0 * reach);
        }
        if (share < 0.7) {
          glm::dvec3 t = center;
          for (int i = 0; i < 100; ++i) {
            const glm::dvec3 from = glm::clamp(t, -kRounding, 1.0 + kRounding);
            const glm::dvec3 next = from + inverse * (point - blend(c, from));
            const glm::dvec3 step = glm::abs(next - t);
            t = next;
            if (std::max({step.x, step.y, step.z}) < 1e-13) break;
          }
          t = glm::clamp(t, -kRounding, 1.0 + kRounding);
          const glm::dvec3 off = blend(c, t) - point;
          if (glm::length(off) < kRounding_voxels) found(lowest + edge * t);
          return;
        }
      }
      for (unsigned part = 0; part < 8; ++part) {
        const glm::dvec3 from = 0.5 * glm::dvec3(part & 1u, part >> 1 & 1u, part >> 2);
        Corners half;
        for (unsigned k = 0; k < 8; ++k) {
          half[k] = blend(c, from + 0.5 * glm::dvec3(k & 1u, k >> 1 & 1u, k >> 2));
        }
        look_into(half, lowest + edge * from, 0.5 * edge);
      }
    }
  };

  template <class F>
  bool any_around(glm::dvec3 point, double slack_voxels, F&& holds) const {
    for (int z = -1; z <= 1; ++z) {
      for (int y = -1; y <= 1; ++y) {
        for (int x = -1; x <= 1; ++x) {
          const Answers here = at(point + slack_voxels * glm::dvec3(x, y, z));
          if (here.unsure || holds(here)) return true;
        }
      }
    }
    return false;
  }

  Cell cell_of(const Lattice& lattice, VoxelIndex base) const {
    const glm::dvec3 low = glm::max(glm::dvec3(base), glm::dvec3(-0.5));
    const glm::dvec3 high = glm::min(glm::dvec3(base + 1), glm::dvec3(size_) - 0.5);
    Cell cell{low, high - low, {}};
    for (unsigned k = 0; k < 8; ++k) {
      const VoxelIndex corner(k & 1u, k >> 1 & 1u, k >> 2);
      const VoxelIndex element = glm::clamp(base + corner, VoxelIndex(0), size_ - 1);
      cell.corners[k] =
          glm::mix(low, high, glm::dvec3(corner)) + lattice.displacement_voxels(element);
    }
    return cell;
  }

  std::size_t bins() const { return static_cast<std::size_t>(voxel_count(size_ + 2)); }
  std::size_t bin_of(VoxelIndex voxel) const {
    return static_cast<std::size_t>(linear_index(voxel + 1, size_ + 2));
  }
  template <class F>
  void for_each_bin(const Cell& cell, F&& f) const {
    glm::dvec3 least = cell.corners[0];
    glm::dvec3 most = least;
    for (const glm::dvec3& corner : cell.corners) {
      least = glm::min(least, corner);
      most = glm::max(most, corner);
    }
    const glm::dvec3 last(size_);
    const VoxelIndex lo(glm::clamp(glm::floor(least), glm::dvec3(-1), last + 1.0));
    const VoxelIndex hi(glm::clamp(glm::ceil(most), glm::dvec3(-2), last));
    for (int z = lo.z; z <= hi.z; ++z) {
      for (int y = lo.y; y <= hi.y; ++y) {
        for (int x = lo.x; x <= hi.x; ++x) f(bin_of({x, y, z}));
      }
    }
  }

  Size3 size_;
  std::vector<Cell> cells_;
  std::vector<std::size_t> cells_of_;  // [bin], in sorted_; one more at the end
  std::vector<std::size_t> sorted_;
};

}  // namespace maille::testing
