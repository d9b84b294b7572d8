#include "deform/stiffness_multigrid.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/trace.h"
#include "deform/bfloat16.h"
#include "deform/coarse_stiffness.h"
#include "deform/spring_rows.h"
#include "deform/stiffness_level.h"

namespace maille {
// The elements of the lattice.
class StiffnessMultigrid::Fine : public StiffnessLevel {
 public:
  Fine(const SpringBox& box, WorkerPool& pool) : StiffnessLevel(box.extent(), pool), box_(box) {
    bool plain = true;
    const std::int64_t rows = std::int64_t{box.extent().y} * box.extent().z;
    for (std::int64_t r = 0; r < rows; ++r) {
      plain = plain && (box.kind(r) == RowKind::plain || box.kind(r) == RowKind::held);
    }
    if (plain && !box.compliances()) return;
    gain_ = BoxArray<Bfloat16>(box.extent(), pool);
    pool.for_each(rows, [&](std::int64_t r, int) {
      if (box.kind(r) == RowKind::held) return;
      for_each_run(box, r, 1, box.extent().x - 1, [&](const SpringRun& run) {
        float sum[kLongestRun] = {};
        for (int s = 0; s < kSprings; ++s) {
          float k[kLongestRun];
          stiffnesses(box, run, s, k);
          for (int x = 0; x < run.count; ++x) sum[x] += k[x];
        }
        for (int x = 0; x < run.count; ++x) {
          if (!(sum[x] > 0.0f) || !box.is_free(run.first + x)) continue;
          gain_[run.first + x] = Bfloat16(kJacobi / sum[x]);
        }
      });
    });
  }

  void gains(std::int64_t begin, int count, float* gain) const override {
    if (gain_) {
      const Bfloat16* const kept = &gain_[begin];
      for (int x = 0; x < count; ++x) gain[x] = static_cast<float>(kept[x]);
      return;
    }
    const float one = kJacobi * box_.one_compliance() / static_cast<float>(kSprings);
    const std::uint8_t* const free = box_.free_flags() + begin;
    for (int x = 0; x < count; ++x) gain[x] = free[x] ? one : 0.0f;
  }

  void apply(std::int64_t begin, int count, const std::array<RowsAround, 3>& w,
             RunVectors& out) const override {
    const std::int64_t r = begin / extent().x;
    const std::uint32_t* const missing = box_.missing(r);
    laplacian(box_,
              {box_.kind(r), begin, count, missing ? missing + (begin - r * extent().x) : nullptr},
              w, out);
  }

  float stiffness_of(std::int64_t e, int s) const override { return box_.stiffness(e, s); }

  std::int64_t bytes() const { return gain_.bytes(); }

 private:
  const SpringBox& box_;
  BoxArray<Bfloat16> gain_;  // none where all springs are alike
};

// The coarsest level, solved at once.
class StiffnessMultigrid::Direct {
 public:
  explicit Direct(const CoarseStiffness& level) {
    const Size3 inner = level.inner();
    const auto n = static_cast<Eigen::Index>(voxel_count(inner));
    elements_.reserve(static_cast<std::size_t>(n));
    std::vector<Eigen::Index> unknown(static_cast<std::size_t>(voxel_count(level.extent())), -1);
    for (int z = 1; z <= inner.z; ++z) {
      for (int y = 1; y <= inner.y; ++y) {
        for (int x = 1; x <= inner.x; ++x) {
          const std::int64_t e = level.row(y, z) * level.extent().x + x;
          if (level.diagonal(e) <= 0.0f) continue;
          unknown[static_cast<std::size_t>(e)] = static_cast<Eigen::Index>(elements_.size());
          elements_.push_back(e);
        }
      }
    }
    const auto count = static_cast<Eigen::Index>(elements_.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(count, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const std::int64_t e = elements_[static_cast<std::size_t>(i)];
      // What hangs on nothing may lie anywhere: a little holds it.
      matrix(i, i) = static_cast<double>(level.diagonal(e)) * (1.0 + kHold);
      for (int s = 0; s < kSprings / 2; ++s) {
        const Eigen::Index j = unknown[static_cast<std::size_t>(e + level.step(s))];
        if (j < 0) continue;
        matrix(i, j) -= static_cast<double>(level.stiffness(s, e));
        matrix(j, i) -= static_cast<double>(level.stiffness(s, e));
      }
    }
    factors_.compute(matrix);
  }

  void solve(const BoxVectors& forces, BoxVectors& moves) const {
    Eigen::MatrixXd right(static_cast<Eigen::Index>(elements_.size()), 3);
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        right(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)) =
            static_cast<double>(forces[c][elements_[i]]);
      }
    }
    const Eigen::MatrixXd solved = factors_.solve(right);
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        moves[c][elements_[i]] =
            static_cast<float>(solved(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(c)));
      }
    }
  }

 private:
  static constexpr double kHold = 1e-6;

  std::vector<std::int64_t> elements_;
  Eigen::LDLT<Eigen::MatrixXd> factors_;
};

StiffnessMultigrid::StiffnessMultigrid(const SpringBox& box, WorkerPool& pool)
    : fine_(std::make_unique<Fine>(box, pool)) {
  const trace::Span span("multigrid set-up");
  // Few enough to solve at once.
  constexpr std::int64_t kDirect = 80;
  const bool cut = box.lacks_springs();
  if (cut) fine_->part_blocks();
  levels_.push_back(std::make_unique<CoarseStiffness>(box, *fine_, pool));
  while (voxel_count(levels_.back()->inner()) > kDirect) {
    if (cut) levels_.back()->part_blocks();
    auto coarser = std::make_unique<CoarseStiffness>(*levels_.back(), pool);
    levels_.back()->forget_ground();
    levels_.push_back(std::move(coarser));
  }
  levels_.back()->forget_ground();
  direct_ = std::make_unique<Direct>(*levels_.back());
}
StiffnessMultigrid::~StiffnessMultigrid() = default;

void StiffnessMultigrid::solve(const BoxVectors& forces, BoxVectors& moves) {
  const trace::Span span("multigrid");
  fine_->restrict_forces(forces, levels_.front()->forces);
  solve_level(0);
  fine_->prolong_and_smooth(forces, levels_.front()->moves, moves);
}

// One cycle from a level's forces to its moves.
void StiffnessMultigrid::cycle(std::size_t l) {
  CoarseStiffness& level = *levels_[l];
  if (l + 1 == levels_.size()) return direct_->solve(level.forces, level.moves);
  level.restrict_forces(level.forces, levels_[l + 1]->forces);
  solve_level(l + 1);
  level.prolong_and_smooth(level.forces, levels_[l + 1]->moves, level.moves);
}

// Up to two cycles, the best combination of what they give; forces become what the first leaves.
void StiffnessMultigrid::solve_level(std::size_t l) {
  cycle(l);
  if (l + 1 == levels_.size()) return;
  CoarseStiffness& level = *levels_[l];
  const auto dot = [](const RunVectors& a, const BoxVectors& b, std::int64_t e, int count) {
    return dot_of_run(a.x, &b[0][e], count) + dot_of_run(a.y, &b[1][e], count) +
           dot_of_run(a.z, &b[2][e], count);
  };
  const auto dot_of = [](const BoxVectors& a, const BoxVectors& b, std::int64_t e, int count) {
    return dot_of_run(&a[0][e], &b[0][e], count) + dot_of_run(&a[1][e], &b[1][e], count) +
           dot_of_run(&a[2][e], &b[2][e], count);
  };
  const auto first = level.sum_over_rows<3>([&](std::int64_t e, int count, auto& sums) {
    RunVectors out;
    level.apply(e, count, level.rows_of(level.moves, e), out);
    sums[0] += dot(out, level.moves, e, count);
    sums[1] += dot_of(level.forces, level.moves, e, count);
    sums[2] += dot_of(level.forces, level.forces, e, count);
  });
  if (!(first[0] > 0.0)) return;  // nothing moves
  const double step = first[1] / first[0];
  std::swap(level.moves, level.first_moves);
  const auto left = level.sum_over_rows<1>([&](std::int64_t e, int count, auto& sums) {
    RunVectors out;
    level.apply(e, count, level.rows_of(level.first_moves, e), out);
    const float* const parts[3] = {out.x, out.y, out.z};
    for (std::size_t c = 0; c < 3; ++c) {
      float* const f = &level.forces[c][e];
      for (int x = 0; x < count; ++x) f[x] -= static_cast<float>(step) * parts[c][x];
    }
    sums[0] += dot_of(level.forces, level.forces, e, count);
  });
  // Notay's threshold: a quarter of the residual is as good as the finer levels can use.
  constexpr double kEnough = 0.25 * 0.25;
  double share_first = step;
  double share_second = 0.0;
  if (left[0] > kEnough * first[2]) {
    cycle(l);
    const auto second = level.sum_over_rows<3>([&](std::int64_t e, int count, auto& sums) {
      RunVectors out;
      level.apply(e, count, level.rows_of(level.moves, e), out);
      sums[0] += dot(out, level.moves, e, count);
      sums[1] += dot(out, level.first_moves, e, count);
      sums[2] += dot_of(level.forces, level.moves, e, count);
    });
    const double rest = second[0] - second[1] * second[1] / first[0];
    if (rest > 0.0) {
      share_second = second[2] / rest;
      share_first -= second[1] / first[0] * share_second;
    }
  }
  static_cast<void>(level.sum_over_rows<1>([&](std::int64_t e, int count, auto&) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float* const a = &level.first_moves[c][e];
      float* const b = &level.moves[c][e];
      for (int x = 0; x < count; ++x) {
        b[x] = static_cast<float>(share_first) * a[x] + static_cast<float>(share_second) * b[x];
      }
    }
  }));
}

std::int64_t StiffnessMultigrid::bytes() const {
  std::int64_t sum = fine_->bytes();
  for (const auto& level : levels_) sum += level->bytes();
  return sum;
}

}  // namespace maille
