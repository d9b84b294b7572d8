#include "measure/speed.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/stopwatch.h"

namespace maille {
namespace {

// Three components that move nearly as much each: the dearest direction.
constexpr glm::dvec3 kGeneral{1.0, -0.9, 0.8};

std::string text_of_size(Size3 size) {
  return std::to_string(size.x) + "x" + std::to_string(size.y) + "x" + std::to_string(size.z);
}

struct GroupedScene {
  std::string group;
  DragScene scene;
};

std::vector<GroupedScene> scenes_of(const SpeedOptions& options) {
  std::vector<GroupedScene> scenes;
  const auto add = [&](std::string group, DragScene scene) {
    scenes.push_back({std::move(group), std::move(scene)});
  };
  for (const std::int64_t count : options.element_counts) {
    const Octahedron moved = octahedron_of(count);
    add("one_axis", uniform_scene("one_axis", "one axis", volume_around(moved), moved, {0, -1, 0}));
  }
  for (const std::int64_t count : options.element_counts) {
    const Octahedron moved = octahedron_of(count);
    add("general",
        uniform_scene("general", "general direction", volume_around(moved), moved, kGeneral));
  }
  const Octahedron again = octahedron_of(options.again_count);
  add("again_one_axis",
      second_grab_scene("again_one_axis", "one axis, after another drag", again, {0, -1, 0}));
  add("again_general",
      second_grab_scene("again_general", "general direction, after another drag", again, kGeneral));
  add("stiff_ball",
      stiff_ball_scene(options.mixed_edge, glm::dvec3(0, -options.ball_drag_voxels, 0)));
  add("random_blocks", random_scene(options.mixed_edge, 8, soft_and_stiff(), options.seed,
                                    glm::dvec3(0, -options.block_drag_voxels, 0)));
  add("moved_again", moved_again_scene(options.moved_again_edge, options.seed));
  add("single_row", single_row_scene(options.row_bricks));
  const Octahedron small = octahedron_of(options.small_count);
  for (const Size3 size : {options.small_volume, options.large_volume}) {
    add("volume_size",
        uniform_scene("volume_size", "one axis in " + text_of_size(size), size, small, {0, -1, 0}));
  }
  add("large_volume",
      uniform_scene("large_volume", "one axis in " + text_of_size(options.large_volume),
                    options.large_volume, octahedron_of(options.large_count), {0, -1, 0}));
  return scenes;
}

Result<SpeedReport::Row> measure_row(const GroupedScene& grouped, int threads, int runs) {
  const DragScene& scene = grouped.scene;
  SpeedReport::Row row;
  row.group = grouped.group;
  row.title = scene.title;
  row.size = scene.volume.size();
  row.drag_voxels = scene.grab.by_voxels;
  row.threads = threads;
  row.least_bytes_per_element = bytes_an_element(scene);
  WorkerPool pool(threads);
  Deformer deformer = scene.deformer();
  if (auto played = scene.play_before(deformer, pool); !played) return played.error();
  std::vector<double> first, next;
  for (int run = 0; run < runs; ++run) {
    deformer.cancel_stroke();
    const Stopwatch button_down;
    if (auto begun = deformer.begin_stroke(scene.grab.element, scene.grab.radius_voxels); !begun) {
      return begun.error();
    }
    const double begin_seconds = button_down.seconds();
    // From the third position on memory is what the position before the last has left.
    for (int position = 0; position < 3; ++position) {
      const auto drag = timed_drag(deformer, scene.grab.by_voxels, pool);
      if (!drag) return drag.error();
      if (position == 0) first.push_back(begin_seconds + (*drag).seconds);
      if (position == 2) next.push_back((*drag).seconds);
      row.elements = (*drag).report.elements_moved;
      row.in_stroke = (*drag).memory;
      if ((*drag).peak.bytes() > row.at_most.bytes()) row.at_most = (*drag).peak;
    }
  }
  deformer.end_stroke();
  row.at_rest = memory_of(deformer);
  row.first = timing_of(std::move(first));
  row.next = timing_of(std::move(next));
  return row;
}

// Out from where the button went down, then once round it at full length: a third of the way out,
// every position after that with its largest component as long as the drag.
std::vector<glm::dvec3> pointer_path(int positions, double length_voxels) {
  std::vector<glm::dvec3> path;
  for (int i = 0; i < positions; ++i) {
    const double way = (i + 1.0) / positions;
    const double angle = 0.3 + 2.0 * std::numbers::pi * way;
    const glm::dvec3 curve(std::cos(angle), std::sin(angle), 0.5 * std::sin(2.0 * angle + 0.5));
    const double largest = std::max({std::abs(curve.x), std::abs(curve.y), std::abs(curve.z)});
    path.push_back(curve / largest * length_voxels * std::min(1.0, 3.0 * way));
  }
  return path;
}

Result<SpeedReport::Pointer> measure_pointer(const SpeedOptions& options, int threads) {
  const Octahedron moved = octahedron_of(options.pointer_count);
  const DragScene scene =
      uniform_scene("pointer", "pointer", volume_around(moved), moved, {1, 0, 0});
  const auto path = pointer_path(options.pointer_positions, moved.drag_voxels());
  SpeedReport::Pointer pointer;
  pointer.threads = threads;
  pointer.elements.resize(path.size());
  WorkerPool pool(threads);
  Deformer deformer = scene.deformer();
  std::vector<std::vector<double>> seconds(path.size());
  std::vector<double> all;
  for (int run = 0; run < options.runs; ++run) {
    deformer.cancel_stroke();
    if (auto begun = deformer.begin_stroke(scene.grab.element, scene.grab.radius_voxels); !begun) {
      return begun.error();
    }
    for (std::size_t i = 0; i < path.size(); ++i) {
      const auto drag = timed_drag(deformer, path[i], pool);
      if (!drag) return drag.error();
      pointer.elements[i] = (*drag).report.elements_moved;
      seconds[i].push_back((*drag).seconds);
      all.push_back((*drag).seconds);
    }
  }
  for (auto& of_position : seconds) pointer.positions.push_back(timing_of(std::move(of_position)));
  pointer.percentile_99_seconds = percentile(all, 0.99);
  pointer.all = timing_of(std::move(all));
  return pointer;
}

}  // namespace

double bytes_an_element(const DragScene& scene) {
  const double a_component = scene.before.empty() ? 2.0 : 4.0;
  double bytes = scene.materials.size() > 1 ? 1.0 : 0.0;
  for (int c = 0; c < 3; ++c) bytes += scene.grab.by_voxels[c] != 0.0 ? a_component : 0.0;
  return bytes;
}

double SpeedReport::Row::elements_per_second() const {
  return static_cast<double>(elements) / next.median_seconds;
}

double SpeedReport::Row::least_gb_per_s() const {
  return 1e-9 * least_bytes_per_element * elements_per_second();
}

double SpeedReport::Row::bricks_gb_per_s() const {
  return 1e-9 * least_bytes_per_element * static_cast<double>(at_rest.elements) /
         next.median_seconds;
}

double SpeedReport::Row::microseconds_per_brick() const {
  return 1e6 * next.median_seconds / static_cast<double>(at_rest.bricks);
}

double SpeedReport::triad_share(const Row& row) const {
  return row.least_gb_per_s() / machine.triad_gb_per_s.at(row.threads);
}

double SpeedReport::bricks_triad_share(const Row& row) const {
  return row.bricks_gb_per_s() / machine.triad_gb_per_s.at(row.threads);
}

const SpeedReport::Row* SpeedReport::find(const std::string& group, int threads,
                                          std::int64_t elements) const {
  for (const Row& row : rows) {
    if (row.group == group && row.threads == threads &&
        (elements == 0 || std::abs(row.elements - elements) <= elements / 10)) {
      return &row;
    }
  }
  return nullptr;
}

double SpeedReport::growth(const std::string& group, int threads) const {
  double n = 0, sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
  for (const Row& row : rows) {
    if (row.group != group || row.threads != threads) continue;
    const double x = std::log(static_cast<double>(row.elements));
    const double y = std::log(row.next.median_seconds);
    n += 1;
    sum_x += x;
    sum_y += y;
    sum_xx += x * x;
    sum_xy += x * y;
  }
  const double spread = n * sum_xx - sum_x * sum_x;
  return n < 2 || spread < 1e-9 ? 0.0 : (n * sum_xy - sum_x * sum_y) / spread;
}

Result<SpeedReport> measure_speed(const SpeedOptions& options) {
  SpeedReport report;
  report.seed = options.seed;
  options.progress("memory bandwidth");
  report.machine = this_machine(options.threads);
  for (const GroupedScene& scene : scenes_of(options)) {
    for (const int threads : options.threads) {
      options.progress(scene.scene.title + ", " + std::to_string(threads) +
                       (threads == 1 ? " thread" : " threads"));
      auto row = measure_row(scene, threads, options.runs);
      if (!row) return row.error();
      report.rows.push_back(*std::move(row));
    }
  }
  for (const int threads : options.threads) {
    options.progress("a pointer's drag, " + std::to_string(threads) +
                     (threads == 1 ? " thread" : " threads"));
    auto pointer = measure_pointer(options, threads);
    if (!pointer) return pointer.error();
    report.pointers.push_back(*std::move(pointer));
  }
  return report;
}

}  // namespace maille
