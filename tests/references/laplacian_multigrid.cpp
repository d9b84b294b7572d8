#include "references/laplacian_multigrid.h"

#include <algorithm>
#include <utility>

#include "references/dense_problem.h"

namespace maille {
namespace {

constexpr float kDamping = 0.65f;
constexpr int kSweeps = 2;
constexpr int kSweepsOnCoarsest = 40;
constexpr std::int64_t kCoarsest = 100;          // elements
constexpr std::int64_t kWorthAllWorkers = 8192;  // elements

}  // namespace

LaplacianMultigrid::Level::Level(Size3 of_size) : size(of_size) {
  for (std::size_t s = 0; s < DenseSprings::kForward; ++s) {
    const glm::ivec3 o = DenseSprings::kOffsets[s];
    steps[s] = o.x + std::ptrdiff_t{size.x} * (o.y + std::ptrdiff_t{size.y} * o.z);
    margin = std::max(margin, steps[s]);
  }
  const auto length = static_cast<std::size_t>(voxel_count(size) + 2 * margin);
  for (auto& w : weights) w.assign(length, 0.0f);
  inverse_diagonal.assign(length, 0.0f);
  x.assign(length, glm::vec3(0.0f));
  r = x;
  next = x;
}

std::size_t LaplacianMultigrid::Level::at(VoxelIndex voxel) const {
  return static_cast<std::size_t>(margin) + element_of(voxel, size);
}

template <class F>
void LaplacianMultigrid::for_each_element(const Level& level, F&& f) {
  const std::int64_t count = voxel_count(level.size);
  const std::int64_t layer = count / level.size.z;
  const auto run = [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) f(static_cast<std::size_t>(level.margin + i));
  };
  if (count < kWorthAllWorkers) return run(0, count);
  pool_.for_each(level.size.z, [&](std::int64_t z, int) { run(z * layer, (z + 1) * layer); });
}

LaplacianMultigrid::LaplacianMultigrid(const DenseSprings& springs, WorkerPool& pool)
    : pool_(pool) {
  Level finest(springs.size());
  std::vector<float> diagonal(finest.inverse_diagonal.size(), 0.0f);
  const auto margin = static_cast<std::size_t>(finest.margin);
  for (std::size_t i = 0; i < springs.count(); ++i) {
    for (int s = 0; s < DenseSprings::kForward; ++s) {
      const float weight = springs.laplacian_weight(i, s);
      if (weight == 0.0f) continue;
      const std::size_t j = i + static_cast<std::size_t>(springs.step(s));
      if (!springs.held(i)) diagonal[margin + i] += weight;
      if (!springs.held(j)) diagonal[margin + j] += weight;
      if (!springs.held(i) && !springs.held(j)) {
        finest.weights[s][margin + i] = weight;
      }
    }
  }
  levels_.push_back(std::move(finest));
  for (;;) {
    Level& level = levels_.back();
    for (std::size_t i = 0; i < diagonal.size(); ++i) {
      level.inverse_diagonal[i] = diagonal[i] > 0.0f ? 1.0f / diagonal[i] : 0.0f;
    }
    if (voxel_count(level.size) <= kCoarsest) break;
    std::vector<float> coarse_diagonal;
    Level coarse = coarser(level, diagonal, coarse_diagonal);
    levels_.push_back(std::move(coarse));
    diagonal = std::move(coarse_diagonal);
  }
}

LaplacianMultigrid::Level LaplacianMultigrid::coarser(const Level& fine,
                                                      const std::vector<float>& fine_diagonal,
                                                      std::vector<float>& diagonal) const {
  Level coarse((fine.size + 1) / 2);
  diagonal.assign(coarse.inverse_diagonal.size(), 0.0f);
  for (int z = 0; z < fine.size.z; ++z) {
    for (int y = 0; y < fine.size.y; ++y) {
      for (int x = 0; x < fine.size.x; ++x) {
        const VoxelIndex at(x, y, z);
        const std::size_t i = fine.at(at);
        const std::size_t above = coarse.at(at / 2);
        diagonal[above] += fine_diagonal[i];
        for (std::size_t s = 0; s < DenseSprings::kForward; ++s) {
          const float weight = fine.weights[s][i];
          if (weight == 0.0f) continue;
          const VoxelIndex there = (at + DenseSprings::kOffsets[s]) / 2;
          const glm::ivec3 offset = there - at / 2;
          if (offset == glm::ivec3(0)) {
            diagonal[above] -= 2.0f * weight;
            continue;
          }
          for (std::size_t c = 0; c < DenseSprings::kForward; ++c) {
            if (DenseSprings::kOffsets[c] == offset) coarse.weights[c][above] += weight;
            if (DenseSprings::kOffsets[c] == -offset) coarse.weights[c][coarse.at(there)] += weight;
          }
        }
      }
    }
  }
  // What nothing holds cancels to a rounding, not to 0.
  for (int z = 0; z < coarse.size.z; ++z) {
    for (int y = 0; y < coarse.size.y; ++y) {
      for (int x = 0; x < coarse.size.x; ++x) {
        const std::size_t i = coarse.at({x, y, z});
        float sum = 0.0f;
        for (std::size_t s = 0; s < DenseSprings::kForward; ++s) {
          const auto step = static_cast<std::size_t>(coarse.steps[s]);
          sum += coarse.weights[s][i] + coarse.weights[s][i - step];
        }
        diagonal[i] = std::max(diagonal[i], sum);
      }
    }
  }
  return coarse;
}

void LaplacianMultigrid::residual(Level& level) {
  for_each_element(level, [&](std::size_t i) {
    const float inverse = level.inverse_diagonal[i];
    if (inverse == 0.0f) {
      level.next[i] = glm::vec3(0.0f);
      return;
    }
    glm::vec3 sum = level.r[i] - level.x[i] / inverse;
    for (std::size_t s = 0; s < DenseSprings::kForward; ++s) {
      const auto step = static_cast<std::size_t>(level.steps[s]);
      sum +=
          level.weights[s][i] * level.x[i + step] + level.weights[s][i - step] * level.x[i - step];
    }
    level.next[i] = sum;
  });
}

void LaplacianMultigrid::smooth(Level& level, int sweeps) {
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    residual(level);
    for_each_element(level, [&](std::size_t i) {
      level.x[i] += kDamping * level.inverse_diagonal[i] * level.next[i];
    });
  }
}

// From r and the x that is there.
void LaplacianMultigrid::cycle(std::size_t index) {
  Level& level = levels_[index];
  if (index + 1 == levels_.size()) return smooth(level, kSweepsOnCoarsest);
  smooth(level, kSweeps);
  residual(level);
  Level& coarse = levels_[index + 1];
  const auto gather = [&](int z) {
    for (int y = 0; y < coarse.size.y; ++y) {
      for (int x = 0; x < coarse.size.x; ++x) {
        glm::vec3 sum(0.0f);
        for (int bits = 0; bits < 8; ++bits) {
          const VoxelIndex below(2 * x + (bits & 1), 2 * y + (bits >> 1 & 1), 2 * z + (bits >> 2));
          if (contains(level.size, below)) sum += level.next[level.at(below)];
        }
        const std::size_t i = coarse.at({x, y, z});
        coarse.r[i] = sum;
        coarse.x[i] = glm::vec3(0.0f);
      }
    }
  };
  if (voxel_count(level.size) < kWorthAllWorkers) {
    for (int z = 0; z < coarse.size.z; ++z) gather(z);
  } else {
    pool_.for_each(coarse.size.z, [&](std::int64_t z, int) { gather(static_cast<int>(z)); });
  }
  cycle(index + 1);
  if (index > 0) cycle(index + 1);  // twice on the coarse ones
  const auto hand_down = [&](int z) {
    for (int y = 0; y < level.size.y; ++y) {
      for (int x = 0; x < level.size.x; ++x) {
        const std::size_t i = level.at({x, y, z});
        if (level.inverse_diagonal[i] != 0.0f) {
          level.x[i] += coarse.x[coarse.at({x / 2, y / 2, z / 2})];
        }
      }
    }
  };
  if (voxel_count(level.size) < kWorthAllWorkers) {
    for (int z = 0; z < level.size.z; ++z) hand_down(z);
  } else {
    pool_.for_each(level.size.z, [&](std::int64_t z, int) { hand_down(static_cast<int>(z)); });
  }
  smooth(level, kSweeps);
}

void LaplacianMultigrid::apply(const DisplacementField& r, DisplacementField& z) {
  // In floats: scaled, or small residuals would underflow.
  double most = 0.0;
  for (const glm::dvec3& v : r)
    most = std::max({most, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  z.assign(r.size(), glm::dvec3(0.0));
  if (most == 0.0) return;
  Level& finest = levels_.front();
  for_each_element(finest, [&](std::size_t i) {
    finest.r[i] = glm::vec3(r[i - static_cast<std::size_t>(finest.margin)] / most);
    finest.x[i] = glm::vec3(0.0f);
  });
  cycle(0);
  for_each_element(finest, [&](std::size_t i) {
    z[i - static_cast<std::size_t>(finest.margin)] = most * glm::dvec3(finest.x[i]);
  });
}

}  // namespace maille
