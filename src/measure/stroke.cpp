#include "measure/stroke.h"

#include "core/stopwatch.h"

namespace maille {
namespace {

double ratio(std::int64_t bytes, std::int64_t elements) {
  return elements == 0 ? 0.0 : static_cast<double>(bytes) / static_cast<double>(elements);
}

}  // namespace

Result<TimedDrag> timed_drag(Deformer& deformer, glm::dvec3 by_voxels, WorkerPool& pool) {
  const Stopwatch start;
  auto report = deformer.drag_to(by_voxels, pool);
  const double seconds = start.seconds();
  if (!report) return report.error();
  const StrokeMemory after = deformer.stroke_memory();
  return TimedDrag{*report, seconds, peak_of(*report, after), after};
}

double LatticeUse::bytes_per_element() const { return ratio(bytes, elements); }

LatticeUse memory_of(const Deformer& deformer) {
  const Lattice& lattice = deformer.lattice();
  const BrickGrid& grid = lattice.grid();
  LatticeUse use{lattice.brick_count(), 0, lattice.bytes()};
  lattice.for_each_brick([&](std::int64_t linear, const LatticeBrick&) {
    use.elements += voxel_count(grid.box(grid.brick(linear)).size());
  });
  return use;
}

double bytes_per_element(const StrokeMemory& memory) {
  return ratio(memory.lattice_bytes + memory.gathered_bytes, memory.elements);
}

double bytes_per_element(const StrokePeak& peak) { return ratio(peak.bytes(), peak.elements); }

}  // namespace maille
