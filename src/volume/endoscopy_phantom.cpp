// The formula volume "endoscopy": a bowel as virtual endoscopy flies through it, in mm.
#include <cmath>
#include <vector>

#include "volume/organ_phantoms.h"
#include "volume/phantom_grid.h"
#include "volume/solid_layer.h"

namespace maille {
namespace {

using P = glm::dvec3;

constexpr glm::dvec3 kLowest{-60, -60, -80}, kHighest{60, 60, 80};
constexpr float kAir = -1000, kFat = -95, kWall = 45;  // HU
constexpr float kNoise = 5;                            // standard deviation
constexpr double kRadius = 14, kFoldDistance = 11;     // mm, as the next two
constexpr float kWallThickness = 3.2f;
constexpr float kRounding = 2.5f;  // of the folds' feet

struct Station {
  P at;
  P along;           // unit vector towards the next one
  double travelled;  // mm from the first one
};

// A Catmull-Rom curve through the bends of the bowel; its ends lie outside the box.
std::vector<Station> middle_line() {
  const std::vector<P> bends = {{-10, 0, -125}, {-22, 12, -95}, {-32, 18, -66}, {4, 36, -50},
                                {36, 8, -38},   {8, -34, -22},  {-34, -14, -4}, {-18, 30, 12},
                                {24, 28, 26},   {34, -16, 38},  {-8, -34, 50},  {-28, -2, 64},
                                {-6, 14, 92},   {0, 10, 125}};
  constexpr int kSteps = 16;
  std::vector<Station> line;
  for (std::size_t n = 1; n + 2 < bends.size(); ++n) {
    for (int step = 0; step < kSteps; ++step) {
      const double t = step / static_cast<double>(kSteps);
      const P &a = bends[n - 1], &b = bends[n], &c = bends[n + 1], &d = bends[n + 2];
      line.push_back({0.5 * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * (t * t) +
                             (3.0 * (b - c) + d - a) * (t * t * t)),
                      P(0), 0});
    }
  }
  for (std::size_t n = 0; n + 1 < line.size(); ++n) {
    const P step = line[n + 1].at - line[n].at;
    const double length = std::sqrt(glm::dot(step, step));
    line[n].along = step / length;
    line[n + 1].travelled = line[n].travelled + length;
  }
  line.pop_back();
  return line;
}

struct BowelAnatomy {
  Solid tube;   // the lumen were it smooth
  Solid bumps;  // what stands into it

  BowelAnatomy() {
    const auto line = middle_line();
    // Every 32nd first, then those half-way between, and so on: whoever walks the list of parts
    // (Solid::select) then knows early how near the nearest is, and drops most of the others.
    const auto join_part = [&](std::size_t n) {
      tube.join(cone(line[n].at, radius_at(line[n]), line[n + 1].at, radius_at(line[n + 1])), 1);
    };
    for (std::size_t n = 0; n + 1 < line.size(); n += 32) join_part(n);
    for (std::size_t step = 16; step > 0; step /= 2) {
      for (std::size_t n = step; n + 1 < line.size(); n += 2 * step) join_part(n);
    }
    add_folds(line);
    add_polyps(line);
  }

 private:
  // Pouches between the folds.
  static double radius_at(const Station& station) {
    const double folds = station.travelled / kFoldDistance, t = folds - std::floor(folds);
    return kRadius + 2.6 * (4 * t * (1 - t) - 0.6);
  }

  // Crescents, each over a third of the way round and turned against its neighbours.
  void add_folds(const std::vector<Station>& line) {
    for (std::size_t n = 1; n < line.size(); ++n) {
      const auto fold = static_cast<int>(line[n].travelled / kFoldDistance);
      if (fold == static_cast<int>(line[n - 1].travelled / kFoldDistance)) continue;
      const P side = across(line[n], fold);
      bumps.join(facing(disc(line[n].at + side * (kRadius * 1.1), 11, 1.1), line[n].along), 1);
    }
  }

  void add_polyps(const std::vector<Station>& line) {
    for (const std::size_t n : {29, 58, 83, 116, 140}) {
      const P side = across(line[n], static_cast<int>(n));
      const P root = line[n].at + side * kRadius, head = line[n].at + side * (kRadius * 0.55);
      bumps.join(cone(root, 1.8, head, 1.6), 2);
      bumps.join(ball(head, 2.4 + 0.01 * static_cast<double>(n)), 1);
    }
  }

  // One of three directions at right angles to the line, a third of a turn apart.
  static P across(const Station& station, int which) {
    const P helper = std::abs(station.along.z) < 0.8 ? P(0, 0, 1) : P(0, 1, 0);
    P u = glm::cross(station.along, helper);
    u = u / std::sqrt(glm::dot(u, u));
    const P v = glm::cross(station.along, u);
    constexpr double kHalfRootOf3 = 0.8660254037844386;
    if (which % 3 == 0) return u;
    return -0.5 * u + (which % 3 == 1 ? kHalfRootOf3 : -kHalfRootOf3) * v;
  }
};

class BowelPainter {
 public:
  BowelPainter(const BowelAnatomy& anatomy, const PhantomGrid& grid, std::uint64_t seed)
      : grid_(grid),
        seed_(seed),
        inverse_edge_(1.0f / grid.edge_width()),
        tube_(anatomy.tube, grid.edge_width() + 2 * kWallThickness),
        bumps_(anatomy.bumps, grid.edge_width() + 2 * kRounding) {}

  void paint(const PointBlock& block, VoxelIndex first, std::int16_t* samples) {
    bumps_.enter(block, kRounding);
    const float ever_deeper = static_cast<float>(2 * kRadius);  // than the lumen is
    tube_.enter(block, bumps_.is_outside() ? 0 : ever_deeper);
    write_block(grid_, first, samples, [&](std::size_t i) {
      const int n = PointBlock::kEdge, at = static_cast<int>(i);
      const VoxelIndex voxel = first + VoxelIndex(at % n, at / n % n, at / n / n);
      return static_cast<std::int16_t>(rounded(value(i, voxel)));
    });
  }

 private:
  float value(std::size_t i, VoxelIndex voxel) const {
    const float noise = kNoise * noise_of(voxel_hash(voxel, seed_));
    if (tube_.is_outside()) return kFat + noise;
    const float tube = tube_.distance(i);
    float lumen = tube;
    if (!bumps_.is_outside()) {  // smooth maximum of the tube and what is not bump
      const float not_bump = -bumps_.distance(i);
      const float h = std::max(kRounding - std::abs(tube - not_bump), 0.0f);
      lumen = std::max(tube, not_bump) + h * h * (0.25f / kRounding);
    }
    const float tissue = mix(kFat, kWall, coverage(tube - kWallThickness, inverse_edge_)) + noise;
    return mix(tissue, kAir, coverage(lumen, inverse_edge_));
  }

  const PhantomGrid& grid_;
  std::uint64_t seed_;
  float inverse_edge_;
  SolidLayer tube_, bumps_;
};

}  // namespace

Volume make_endoscopy(Size3 size, std::uint64_t seed, WorkerPool& pool) {
  const BowelAnatomy anatomy;
  const PhantomGrid grid(size, kLowest, kHighest);
  std::vector<std::int16_t> samples(static_cast<std::size_t>(voxel_count(size)));
  std::vector<BowelPainter> painters(static_cast<std::size_t>(pool.thread_count()),
                                     BowelPainter(anatomy, grid, seed));
  for_each_block(grid, pool, [&](const PointBlock& block, VoxelIndex first, int worker) {
    painters[static_cast<std::size_t>(worker)].paint(block, first, samples.data());
  });
  return Volume::of(size, VoxelType::int16, grid.world_from_voxel(), std::move(samples));
}

}  // namespace maille
