// The formula volume "beetle": a stag beetle in mm, +z up, head towards -y.
#include <cmath>
#include <vector>

#include "volume/organ_phantoms.h"
#include "volume/phantom_grid.h"
#include "volume/solid_layer.h"

namespace maille {
namespace {

using P = glm::dvec3;

constexpr glm::dvec3 kLowest{-20, -34, -13}, kHighest{20, 26, 11};
constexpr float kShell = 32000, kHardShell = 44000, kTissue = 9000;
constexpr float kNoise = 150;  // standard deviation
constexpr float kHem = -1.6f;  // mm: the wing cases end there, open below

struct Bead {
  P at;
  double radius;
};

void join_chain(Solid& solid, const std::vector<Bead>& beads, double blend) {
  for (std::size_t i = 0; i + 1 < beads.size(); ++i) {
    solid.join(mirrored(cone(beads[i].at, beads[i].radius, beads[i + 1].at, beads[i + 1].radius)),
               blend);
  }
}

struct BeetleAnatomy {
  Solid body;    // hollow: only its outermost part is chitin
  Solid wings;   // wing cases, thin shells over the body
  Solid limbs;   // legs, antennae, jaws: hard throughout
  Solid organs;  // soft tissue inside the body

  BeetleAnatomy() {
    body.join(ellipsoid({0, 8, -1.2}, {8.2, 13.5, 5}), 0);  // abdomen
    body.join(ellipsoid({0, -5, -1.2}, {7.6, 5, 4.8}), 2);  // middle body
    body.carve(ellipsoid({0, -9.4, 3.2}, {10, 0.6, 3}), 0.6);
    body.join(ellipsoid({0, -12.4, -0.4}, {8.4, 4.2, 4.6}), 0.4);              // pronotum
    body.join(ellipsoid({0, -19, -0.8}, {6.0, 3.6, 3.0}), 0.4);                // head
    body.join(mirrored(ellipsoid({5.2, -18.2, -0.4}, {1.3, 1.7, 1.3})), 0.2);  // eyes
    for (int n = 0; n < 4; ++n) {  // rings of the abdomen
      body.carve(ellipsoid({0, 7.0 + 4.0 * n, -6.4}, {9, 0.35, 2.2}), 0.4);
    }
    add_wing_cases();
    add_limbs();
    organs.join(cone({0, -16, -1.5}, 0.8, {0, 18, -2.4}, 1.5), 0);          // gut
    organs.join(mirrored(ellipsoid({3.6, -4, -1.6}, {2.6, 3.6, 2.6})), 1);  // muscles
    organs.join(mirrored(ellipsoid({3.4, -12, -0.6}, {2.8, 2.4, 2.6})), 1);
    organs.join(mirrored(ellipsoid({3.0, -19, -0.8}, {1.8, 1.8, 1.5})), 0.5);
    organs.join(mirrored(ellipsoid({4, 12, -2.2}, {2.2, 6, 1.8})), 1);
  }

 private:
  void add_wing_cases() {
    const P center(0, 8.2, -0.8), radii(9.2, 15.6, 6.8);
    wings.join(ellipsoid(center, radii), 0);
    // Point of the surface at y, a part of the half width away from the middle.
    const auto surface = [&](double y, double part) {
      const double t = (y - center.y) / radii.y, width = std::sqrt(1 - t * t);
      return center +
             P(part * width * radii.x, y - center.y, std::sqrt(1 - part * part) * width * radii.z);
    };
    constexpr int kSteps = 6;
    for (int n = 0; n < kSteps; ++n) {
      const double y0 = -6.2 + 4.7 * n, y1 = y0 + 4.7;
      wings.carve(cone(surface(y0, 0), 0.3, surface(y1, 0), 0.3), 0.4);  // seam
      for (const double part : {0.2, 0.38, 0.55, 0.7, 0.82}) {           // furrows
        wings.carve(mirrored(cone(surface(y0, part), 0.22, surface(y1, part), 0.22)), 0.6);
      }
    }
  }

  void add_limbs() {
    join_chain(limbs,  // upper jaws
               {{{3.0, -21.6, -1.0}, 1.5},
                {{5.6, -24.6, -0.6}, 1.2},
                {{6.6, -28.0, 0.2}, 0.95},
                {{5.4, -31.0, 1.0}, 0.7},
                {{3.2, -32.4, 1.4}, 0.35}},
               0.6);
    limbs.join(mirrored(cone({6.3, -27.2, 0.1}, 0.7, {4.2, -28.2, 0.3}, 0.25)), 0.5);
    limbs.join(mirrored(cone({5.8, -30.2, 0.8}, 0.5, {4.2, -30.0, 0.8}, 0.2)), 0.4);
    join_chain(limbs,  // antennae with a club
               {{{5.0, -20.6, -1.4}, 0.45},
                {{9.4, -22.4, -1.2}, 0.38},
                {{11.6, -24.4, -1.4}, 0.36},
                {{12.8, -26.2, -1.8}, 0.4}},
               0.2);
    for (int n = 0; n < 3; ++n) {
      const P at(12.9 + 0.35 * n, -26.4 - 0.9 * n, -1.9 - 0.1 * n);
      limbs.join(mirrored(ellipsoid(at, {0.35, 0.4, 0.9})), 0.1);
    }
    limbs.join(mirrored(cone({1.4, -22, -2.4}, 0.3, {2.2, -24.4, -3.2}, 0.25)), 0.1);  // palps
    leg({5, -12, -3.6}, {11.5, -17, -2.4}, {15.8, -23, -7.4}, {17.6, -28, -10.8}, 1.3);
    leg({5.4, -3.2, -4.6}, {13, -2.0, -2.6}, {17.2, 1.6, -8.4}, {18.2, 6.6, -10.8}, 1.15);
    leg({5, 2.4, -5.0}, {12.2, 8.4, -3.2}, {15.8, 16.4, -8.2}, {17.0, 22.6, -10.8}, 1.2);
  }

  // Hip, thigh, shin with thorns, five joints of the foot, claws.
  void leg(P hip, P knee, P ankle, P toe, double thickness) {
    limbs.join(mirrored(ellipsoid(hip, P(1.6, 1.5, 1.3) * thickness)), 0.3);
    limbs.join(mirrored(cone(hip, 0.75 * thickness, 0.5 * (hip + knee), 1.0 * thickness)), 0.2);
    limbs.join(mirrored(cone(0.5 * (hip + knee), 1.0 * thickness, knee, 0.6 * thickness)), 0.2);
    limbs.join(mirrored(cone(knee, 0.5 * thickness, ankle, 0.75 * thickness)), 0.1);
    for (int n = 1; n <= 3; ++n) {
      const P at = knee + (ankle - knee) * (0.3 * n);
      limbs.join(mirrored(cone(at, 0.4, at + P(0.9, 0.2, -0.9) * thickness, 0.1)), 0.2);
    }
    for (int n = 0; n < 5; ++n) {
      const P from = ankle + (toe - ankle) * (0.2 * n + 0.03),
              to = ankle + (toe - ankle) * (0.2 * n + 0.19);
      limbs.join(mirrored(cone(from, 0.22, to, 0.42)), 0);
    }
    limbs.join(mirrored(cone(toe, 0.28, toe + P(0.9, 0.3, -0.8), 0.08)), 0.1);
    limbs.join(mirrored(cone(toe, 0.28, toe + P(-0.5, 0.4, -0.9), 0.08)), 0.1);
  }
};

class BeetlePainter {
 public:
  BeetlePainter(const BeetleAnatomy& anatomy, const PhantomGrid& grid, std::uint64_t seed)
      : grid_(grid),
        seed_(seed),
        // Never thinner than an edge, or coarse grids would lose the animal.
        shell_(std::max(0.45f, 0.7f * grid.edge_width())),
        inverse_edge_(1.0f / grid.edge_width()),
        body_(anatomy.body, grid.edge_width()),
        wings_(anatomy.wings, grid.edge_width()),
        limbs_(anatomy.limbs, grid.edge_width()),
        organs_(anatomy.organs, grid.edge_width()) {}

  void paint(const PointBlock& block, VoxelIndex first, std::uint16_t* samples) {
    bool is_empty = true;
    for (SolidLayer* layer : {&body_, &wings_, &limbs_, &organs_}) {
      layer->enter(block, shell_ + grid_.edge_width());
      is_empty = is_empty && layer->is_outside();
    }
    if (is_empty) {
      write_block(grid_, first, samples, [](std::size_t) { return std::uint16_t{0}; });
      return;
    }
    write_block(grid_, first, samples, [&](std::size_t i) {
      const int n = PointBlock::kEdge, at = static_cast<int>(i);
      const VoxelIndex voxel = first + VoxelIndex(at % n, at / n % n, at / n / n);
      return static_cast<std::uint16_t>(std::max(rounded(value(i, block.z[i], voxel)), 0));
    });
  }

 private:
  float value(std::size_t i, float z, VoxelIndex voxel) const {
    float value = mix(0.0f, kTissue, organs_.coverage_at(i));
    value = mix(value, kShell, shell_of(body_, i));
    value = mix(value, kHardShell, shell_of(wings_, i) * coverage(kHem - z, inverse_edge_));
    value = mix(value, kHardShell, limbs_.coverage_at(i));
    if (value < 1.0f) return 0.0f;
    return value + kNoise * noise_of(voxel_hash(voxel, seed_)) * std::min(value * 1e-4f, 1.0f);
  }

  float shell_of(const SolidLayer& layer, std::size_t i) const {
    if (layer.is_outside()) return 0.0f;
    return layer.coverage_at(i) * coverage(-layer.distance(i) - shell_, inverse_edge_);
  }

  const PhantomGrid& grid_;
  std::uint64_t seed_;
  float shell_;  // mm
  float inverse_edge_;
  SolidLayer body_, wings_, limbs_, organs_;
};

}  // namespace

Volume make_beetle(Size3 size, std::uint64_t seed, WorkerPool& pool) {
  const BeetleAnatomy anatomy;
  const PhantomGrid grid(size, kLowest, kHighest);
  std::vector<std::uint16_t> samples(static_cast<std::size_t>(voxel_count(size)));
  std::vector<BeetlePainter> painters(static_cast<std::size_t>(pool.thread_count()),
                                      BeetlePainter(anatomy, grid, seed));
  for_each_block(grid, pool, [&](const PointBlock& block, VoxelIndex first, int worker) {
    painters[static_cast<std::size_t>(worker)].paint(block, first, samples.data());
  });
  return Volume::of(size, VoxelType::uint16, grid.world_from_voxel(), std::move(samples));
}

}  // namespace maille
