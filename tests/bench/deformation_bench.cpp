// How fast relaxation and resampling are, one thread each, beside what the machine's memory can do
// in the same run; ChainMail has `maille measure speed`. The paper's figures (Schulze et al. 2007,
// one thread of their machine): relaxation 23 million element updates/s, resampling 4.41 million
// voxels/s (nearest).
//
//   cmake --preset release -DMAILLE_BENCHMARKS=ON && cmake --build --preset release
//   build/release/tests/bench_deformation --benchmark_repetitions=7
//                                         --benchmark_report_aggregates_only=true
#include <memory>
#include <optional>
#include <random>

#include <benchmark/benchmark.h>

#include "deform/deformer.h"
#include "deform/spring_box.h"
#include "deform/spring_rows.h"
#include "resample/resampler.h"

namespace maille {
namespace {

constexpr Size3 kSize{256, 256, 256};

enum Scene : std::int64_t { one_material, random_blocks };

std::unique_ptr<Deformer> scene(Scene which) {
  constexpr int block = 8;
  std::mt19937 random(1);
  const Size3 blocks = kSize / block;
  std::vector<std::uint8_t> kinds(static_cast<std::size_t>(voxel_count(blocks)));
  for (auto& kind : kinds) kind = which == one_material ? 0 : random() % 2;
  std::vector<std::uint8_t> samples;
  samples.reserve(static_cast<std::size_t>(voxel_count(kSize)));
  for (int z = 0; z < kSize.z; ++z) {
    for (int y = 0; y < kSize.y; ++y) {
      for (int x = 0; x < kSize.x; ++x) {
        samples.push_back(
            kinds[static_cast<std::size_t>(linear_index(VoxelIndex(x, y, z) / block, blocks))]);
      }
    }
  }
  const auto material = [](const char* name, double low, double compress, double stretch,
                           double shear) {
    Material m;
    m.name = name;
    m.value_low = low;
    m.value_high = low + 1;
    m.compress = glm::dvec3(compress);
    m.stretch = glm::dvec3(stretch);
    m.shear = glm::dvec3(shear);
    return m;
  };
  std::vector<Material> materials{material("soft", 0, 0.6, 1.5, 0.25)};
  if (which != one_material) materials.push_back(material("firm", 1, 0.8, 1.3, 0.15));
  return std::make_unique<Deformer>(
      Volume::of(kSize, VoxelType::uint8, axis_aligned(glm::dvec3(1)), std::move(samples)),
      std::move(MaterialTable::create(std::move(materials))).value(), AnchorRules{});
}

// A drag of 25 voxels along one axis, which moves one to four million elements.
DragReport drag(Deformer& deformer) {
  static WorkerPool pool(1);
  return *deformer.drag_to({0, -25, 0}, pool);
}

void label(benchmark::State& state) {
  constexpr const char* kNames[] = {"one material", "random blocks of 8"};
  state.SetLabel(kNames[state.range(0)]);
}

std::unique_ptr<Deformer> dragged(benchmark::State& state) {
  label(state);
  auto deformer = scene(static_cast<Scene>(state.range(0)));
  static_cast<void>(deformer->begin_stroke(kSize / 2, 4));
  drag(*deformer);
  return deformer;
}

// The forces of all springs on all elements once: what the paper calls an update.
void plain_sweep(benchmark::State& state) {
  const auto deformer = dragged(state);
  const RelaxationStart start = deformer->relaxation_start(0.01);
  WorkerPool pool(static_cast<int>(state.range(1)));
  const SpringBox box({start.lattice, start.materials, start.cuts, start.held, start.anchors},
                      {VoxelIndex(1), kSize - 1}, pool);
  const Size3 extent = box.extent();
  for (auto _ : state) {
    pool.for_each(extent.z - 2, [&](std::int64_t plane, int) {
      RunVectors forces;
      for (int y = 1; y < extent.y - 1; ++y) {
        for_each_run(box, box.row(y, static_cast<int>(plane) + 1), 1, extent.x - 1,
                     [&](const SpringRun& run) {
                       spring_forces(box, run, forces);
                       benchmark::DoNotOptimize(forces);
                     });
      }
    });
  }
  state.counters["updates/s"] = benchmark::Counter(static_cast<double>(box.free_elements()),
                                                   benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(plain_sweep)
    ->ArgsProduct({{one_material, random_blocks}, {1, 2}})
    ->ArgNames({"scene", "threads"})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

void relaxation_set_up(benchmark::State& state) {
  const auto deformer = dragged(state);
  WorkerPool pool(1);
  std::int64_t elements = 0;
  for (auto _ : state) elements += deformer->relax(pool, {}).progress().free_elements;
  state.counters["elements/s"] =
      benchmark::Counter(static_cast<double>(elements), benchmark::Counter::kIsRate);
}
BENCHMARK(relaxation_set_up)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

// From the drag to equilibrium and again.
void relaxation_cycle(benchmark::State& state) {
  const auto deformer = dragged(state);
  WorkerPool pool(1);
  std::optional<Relaxation> relaxation;
  std::int64_t updates = 0;
  for (auto _ : state) {
    if (!relaxation || relaxation->progress().finished()) {
      state.PauseTiming();
      relaxation.reset();
      relaxation.emplace(deformer->relax(pool, {}));
      state.ResumeTiming();
    }
    const std::int64_t before = relaxation->progress().element_updates;
    updates += relaxation->iterate().element_updates - before;
  }
  state.counters["updates/s"] =
      benchmark::Counter(static_cast<double>(updates), benchmark::Counter::kIsRate);
}
BENCHMARK(relaxation_cycle)->DenseRange(0, 1)->Unit(benchmark::kMillisecond);

void resample(benchmark::State& state) {
  label(state);
  const auto method = static_cast<ResampleMethod>(state.range(1));
  const auto deformer = scene(static_cast<Scene>(state.range(0)));
  const Volume volume =
      Volume::of(kSize, VoxelType::int16, axis_aligned(glm::dvec3(1)),
                 std::vector<std::int16_t>(static_cast<std::size_t>(voxel_count(kSize)), 7));
  static_cast<void>(deformer->begin_stroke(kSize / 2, 4));
  drag(*deformer);
  const auto dirty = dirty_bricks(Lattice(kSize), Cuts(kSize), deformer->lattice(), Cuts(kSize),
                                  glm::dvec3(1), {VoxelIndex(0), kSize}, method);
  const Resampler resampler(volume, deformer->lattice(), Cuts(kSize), method, 0.0);
  std::vector<std::byte> brick(kBrickVoxels * sizeof(std::int16_t));
  ResampleCounts counts;
  for (auto _ : state) {
    for (const std::int64_t b : dirty) counts += resampler.resample(b, brick, true);
  }
  state.counters["voxels/s"] =
      benchmark::Counter(static_cast<double>(counts.voxels), benchmark::Counter::kIsRate);
  state.counters["moved voxels/s"] =
      benchmark::Counter(static_cast<double>(counts.moved_voxels), benchmark::Counter::kIsRate);
}
BENCHMARK(resample)->ArgsProduct({{0, 1}, {0, 1}})->Unit(benchmark::kMillisecond);

void triad(benchmark::State& state) {
  const std::size_t n = std::size_t{1} << 24;
  std::vector<float> a(n), b(n, 1.0f), c(n, 2.0f);
  for (auto _ : state) {
    for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 3.0f * c[i];
    benchmark::DoNotOptimize(a.data());
    benchmark::ClobberMemory();
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) *
                          static_cast<std::int64_t>(3 * n * sizeof(float)));
}
BENCHMARK(triad)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace maille

BENCHMARK_MAIN();
