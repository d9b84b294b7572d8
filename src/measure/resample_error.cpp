#include "measure/resample_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "measure/product_resampling.h"
#include "measure/resample_references.h"
#include "references/nearest_brute_force.h"
#include "resample/resample_method.h"

namespace maille {
namespace {

using Found = ResampleError::Found;
using Row = ResampleError::Row;
using Scene = ResampleError::Scene;

constexpr int kMostIterations = 8;                               // of fixed-point inversion
constexpr auto kNone = std::numeric_limits<std::size_t>::max();  // instead of an element

Volume volume_of(std::span<const double> values, Size3 size) {
  return Volume::of(size, VoxelType::float32, axis_aligned(glm::dvec3(1)),
                    std::vector<float>(values.begin(), values.end()));
}

// As they are stored, in floats: the product and the others are given the same.
std::vector<double> analytic_values(Size3 size) {
  std::vector<double> values(static_cast<std::size_t>(voxel_count(size)));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<float>(analytic_value(glm::dvec3(voxel_of(i, size))));
  }
  return values;
}

DeformedElements elements_of(const Lattice& lattice) {
  const Size3 size = lattice.grid().volume_size();
  std::vector<glm::dvec3> u_voxels(static_cast<std::size_t>(voxel_count(size)));
  for (std::size_t i = 0; i < u_voxels.size(); ++i) {
    u_voxels[i] = lattice.displacement_voxels(voxel_of(i, size));
  }
  return DeformedElements(size, glm::dvec3(1), std::move(u_voxels));
}

// One scene and all that is known about it.
class SceneMeasurement {
 public:
  SceneMeasurement(const ResampleScene& scene, const ResampleErrorOptions& options,
                   WorkerPool& pool)
      : options_(options),
        pool_(pool),
        size_(options.edge),
        values_(analytic_values(size_)),
        lattice_(lattice_of(scene, size_, pool)),
        elements_(elements_of(lattice_)),
        truth_(scene, size_, values_, pool) {
    out_.name = scene.name;
    out_.title = scene.title;
    out_.moves = scene.moves;
    out_.folds = scene.folds;
    out_.size = size_;
    out_.folded_cells = count_folded_cells(lattice_, Cuts(size_), pool);
    out_.judged_voxels = truth_.judged_voxels();
    out_.lost_voxels = truth_.lost_voxels();
    out_.worst_forward_voxels = truth_.worst_forward_voxels();
  }

  Scene measured() {
    find_nearest();
    measure_product();
    measure_references();
    return std::move(out_);
  }

 private:
  std::optional<ResampleDeviation> deviation(const VoxelBox& voxels, std::span<const float> shown,
                                             std::span<const glm::vec3> rest_voxels) const {
    if (truth_.lost_voxels() > 0) return std::nullopt;
    return deviation_from(truth_, size_, voxels, shown, rest_voxels, pool_);
  }

  void measure_product() {
    const VoxelBox whole{VoxelIndex(0), size_};
    ProductResampling product(volume_of(values_, size_), lattice_);
    product.run(ResampleMethod::linear, pool_);
    product.skip_empty_bricks();
    shown_linear_ = product.shown();
    for (const ResampleMethod method : kResampleMethods) {
      const std::string name(name_of(method));
      options_.progress(out_.title + ": Maille, " + name);
      product.run(method, pool_);
      const auto rest_voxels = method == ResampleMethod::linear ? product.rest_positions(pool_)
                                                                : std::vector<glm::vec3>();
      Row row;
      row.way = "maille";
      row.method = name;
      row.voxels = count_filled(whole);
      row.deviation = deviation(whole, product.shown(), rest_voxels);
      if (method == ResampleMethod::nearest) row.found = found_among(whole, elements_shown());
      for (const int threads : options_.threads) {
        WorkerPool workers(threads);
        const RunLimit limit{options_.runs, options_.seconds, std::min(options_.runs, 3)};
        row.threads = threads;
        row.timing =
            timing_of(seconds_of_runs(limit, [&] { return product.run(method, workers); }));
        out_.rows.push_back(row);
      }
    }
  }

  // That something lies in.
  std::int64_t count_filled(const VoxelBox& voxels) const {
    std::int64_t filled = 0;
    for_each_voxel_of(voxels, [&](std::size_t, std::size_t voxel) {
      filled += !std::isnan(shown_linear_[voxel]);
    });
    return filled;
  }

  // By a volume that shows their numbers. Floats hold them below 2^24.
  std::vector<std::size_t> elements_shown() {
    std::vector<double> numbers(values_.size());
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<double>(i);
    ProductResampling product(volume_of(numbers, size_), lattice_);
    product.run(ResampleMethod::nearest, pool_);
    const std::vector<float> shown = product.shown();
    std::vector<std::size_t> elements(shown.size(), kNone);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      if (!std::isnan(shown[i])) elements[i] = static_cast<std::size_t>(shown[i]);
    }
    return elements;
  }

  // Of the judged voxels, or every so manieth of them.
  void find_nearest() {
    options_.progress(out_.title + ": the nearest elements, by brute force");
    const NearestBruteForce nearest(elements_);
    const auto stride = static_cast<std::size_t>(
        (voxel_count(size_) + options_.nearest_voxels - 1) / options_.nearest_voxels);
    out_.nearest_stride = static_cast<std::int64_t>(stride);
    nearest_.assign(values_.size(), kNone);
    const auto plane = static_cast<std::size_t>(size_.x) * static_cast<std::size_t>(size_.y);
    pool_.for_each(size_.z, [&](std::int64_t z, int) {
      const std::size_t begin = static_cast<std::size_t>(z) * plane;
      for (std::size_t i = (begin + stride - 1) / stride * stride; i < begin + plane; i += stride) {
        if (truth_.answers(i).empty()) continue;
        nearest_[i] = nearest.nearest_to(glm::dvec3(voxel_of(i, size_))).element;
      }
    });
  }

  // elements: found for each voxel of a box. Of two that are as near either is right.
  Found found_among(const VoxelBox& voxels, std::span<const std::size_t> elements) const {
    Found found;
    for_each_voxel_of(voxels, [&](std::size_t i, std::size_t voxel) {
      if (nearest_[voxel] == kNone) return;
      ++found.there;
      if (elements[i] == kNone) {
        ++found.missed;
        return;
      }
      const glm::dvec3 at_mm(voxel_of(voxel, size_));  // voxels of 1 mm
      const bool right = elements_.distance(elements[i], at_mm).squared_mm2 ==
                         elements_.distance(nearest_[voxel], at_mm).squared_mm2;
      found.right += right;
      found.wrong += !right;
    });
    return found;
  }

  // Calls f(index in the box, index in the volume), x fastest.
  template <class F>
  void for_each_voxel_of(const VoxelBox& voxels, F&& f) const {
    std::size_t i = 0;
    for (int z = voxels.lo.z; z < voxels.hi.z; ++z) {
      for (int y = voxels.lo.y; y < voxels.hi.y; ++y) {
        auto voxel = static_cast<std::size_t>(linear_index({voxels.lo.x, y, z}, size_));
        for (int x = voxels.lo.x; x < voxels.hi.x; ++x, ++i, ++voxel) f(i, voxel);
      }
    }
  }

  void measure_references() {
    VoxelBox voxels = truth_.bounds();
    const int layers = std::min(options_.reference_layers, voxels.size().z);
    voxels.lo.z += (voxels.size().z - layers) / 2;
    voxels.hi.z = voxels.lo.z + layers;
    out_.reference_voxels = voxels;
    const RunLimit limit{options_.reference_runs, options_.reference_seconds};
    using Neighbours = PaperWalkOptions::Neighbours;
    for (const Neighbours neighbours : {Neighbours::six, Neighbours::twenty_six}) {
      const bool six = neighbours == Neighbours::six;
      options_.progress(out_.title + ": the paper's walk by " + (six ? "6" : "26"));
      const PaperAnswers paper = run_paper(elements_, values_, voxels, neighbours, limit);
      std::vector<std::size_t> walked;
      for (const WalkedVoxel& end : paper.walked) {
        walked.push_back(end.found() ? end.element : kNone);
      }
      for (const PaperAnswer& value : paper.values) {
        Row row = reference_row(six ? "walk_6" : "walk_26", voxels, value.answer);
        row.method = value.method == PaperMethod::nearest       ? "nearest"
                     : value.method == PaperMethod::barycentric ? "barycentric"
                                                                : "rbf";
        if (value.method == PaperMethod::nearest) row.found = found_among(voxels, walked);
        out_.rows.push_back(std::move(row));
      }
    }
    options_.progress(out_.title + ": fixed-point inversion");
    for (int iterations = 1; iterations <= kMostIterations; ++iterations) {
      Row row = reference_row("fixed_point", voxels,
                              run_fixed_point(elements_, values_, voxels, iterations, limit));
      row.method = "linear";
      row.iterations = iterations;
      out_.rows.push_back(std::move(row));
    }
  }

  Row reference_row(std::string way, const VoxelBox& voxels, const ReferenceAnswer& answer) const {
    Row row;
    row.way = std::move(way);
    row.timing = answer.timing;
    row.voxels = count_filled(voxels);
    row.deviation = deviation(voxels, answer.values, answer.rest_voxels);
    return row;
  }

  const ResampleErrorOptions& options_;
  WorkerPool& pool_;
  Size3 size_;
  std::vector<double> values_;
  Lattice lattice_;
  DeformedElements elements_;
  ResampleTruth truth_;
  std::vector<std::size_t> nearest_;  // of each voxel that it was found for
  std::vector<float> shown_linear_;   // by the product; NaN where nothing lies
  Scene out_;
};

}  // namespace

double ResampleError::Row::nanoseconds_a_voxel() const {
  return 1e9 * timing.median_seconds / static_cast<double>(voxels);
}

double ResampleError::Row::million_voxels_per_second() const {
  return 1e-6 * static_cast<double>(voxels) / timing.median_seconds;
}

double ResampleError::triad_share(const ConstantBricks& bricks) const {
  return bricks.gb_per_s() / machine.triad_gb_per_s.at(bricks.threads);
}

std::optional<double> paper_million_voxels_per_second(const std::string& method) {
  if (method == "nearest") return 4.41;
  if (method == "barycentric") return 2.46;
  if (method == "rbf") return 1.48;
  return std::nullopt;
}

ResampleError measure_resample_error(const ResampleErrorOptions& options) {
  ResampleError report;
  report.runs = options.runs;
  options.progress("memory bandwidth");
  report.machine = this_machine(options.threads);
  for (const int threads : options.threads) {
    options.progress("bricks displaced by whole voxels");
    WorkerPool workers(threads);
    report.constant_bricks.push_back(
        measure_constant_bricks(options.copy_edge, options.runs, workers));
  }
  WorkerPool pool(*std::max_element(options.threads.begin(), options.threads.end()));
  for (const ResampleScene& scene : resample_scenes(options.edge)) {
    options.progress(scene.title + ": the truth");
    report.scenes.push_back(SceneMeasurement(scene, options, pool).measured());
  }
  return report;
}

}  // namespace maille
