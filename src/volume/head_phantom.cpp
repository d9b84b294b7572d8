#include "volume/organ_phantoms.h"

#include <vector>

#include "volume/head_anatomy.h"
#include "volume/phantom_grid.h"
#include "volume/solid_layer.h"

namespace maille {
namespace {

// HU
constexpr float kAir = -1000, kMuscle = 48, kSkin = 40, kFat = -85, kEye = 15, kLiquor = 6,
                kGreyMatter = 38, kWhiteMatter = 28, kCortical = 1150, kSpongy = 550, kTooth = 2100;
constexpr float kNoise = 5;  // standard deviation

// Depths in mm below which tissue no longer changes.
constexpr float kFatDepth = 8, kBoneWall = 4, kFoldDepth = 18;

class HeadPainter {
 public:
  HeadPainter(const HeadAnatomy& anatomy, const PhantomGrid& grid, std::uint64_t seed)
      : grid_(grid),
        seed_(seed),
        inverse_edge_(1.0f / grid.edge_width()),
        skin_(anatomy.skin, grid.edge_width()),
        bone_(anatomy.bone, grid.edge_width()),
        teeth_(anatomy.teeth, grid.edge_width()),
        brain_(anatomy.brain, grid.edge_width()),
        ventricles_(anatomy.ventricles, grid.edge_width()),
        orbits_(anatomy.orbits, grid.edge_width()),
        eyes_(anatomy.eyes, grid.edge_width()),
        air_(anatomy.air, grid.edge_width()) {}

  void paint(const PointBlock& block, VoxelIndex first, std::int16_t* samples) {
    skin_.enter(block, kFatDepth);
    if (skin_.is_outside()) {
      write_block(grid_, first, samples,
                  [](std::size_t) { return static_cast<std::int16_t>(kAir); });
      return;
    }
    bone_.enter(block, kBoneWall);
    brain_.enter(block, std::max(kFoldDepth, kBoneWall));
    for (SolidLayer* layer : {&teeth_, &ventricles_, &orbits_, &eyes_, &air_}) {
      layer->enter(block, 0);
    }
    write_block(grid_, first, samples, [&](std::size_t i) {
      const int n = PointBlock::kEdge, at = static_cast<int>(i);
      const VoxelIndex voxel = first + VoxelIndex(at % n, at / n % n, at / n / n);
      return static_cast<std::int16_t>(rounded(value(block, i, voxel)));
    });
  }

 private:
  float value(const PointBlock& block, std::size_t i, VoxelIndex voxel) const {
    const glm::vec3 p(block.x[i], block.y[i], block.z[i]);
    const float depth = -skin_.distance(i);
    float hu = soft_tissue(depth, p);
    hu = mix(hu, kFat, orbits_.coverage_at(i));
    hu = mix(hu, kEye, eyes_.coverage_at(i));
    hu = bone_over(hu, depth, i);
    const float in_brain = brain_.coverage_at(i);
    if (in_brain > 0) hu = mix(hu, brain_tissue(-brain_.distance(i), p, i), in_brain);
    const float matter = skin_.coverage_at(i) * (1.0f - air_.coverage_at(i));
    hu += kNoise * noise_of(voxel_hash(voxel, seed_));
    return mix(kAir, hu, matter);
  }

  // Bone and teeth, never nearer to the skin's surface than a thin cheek is.
  float bone_over(float hu, float depth, std::size_t i) const {
    constexpr float kLeastCover = 2.5f;  // mm
    if (bone_.is_outside() && teeth_.is_outside()) return hu;
    const float covered = coverage(kLeastCover - depth, inverse_edge_);
    if (!bone_.is_outside()) {
      // The brain is painted later and lies in the bone: its wall is a surface of the bone too.
      const float distance = brain_.is_outside() ? bone_.distance(i)
                                                 : std::max(bone_.distance(i), -brain_.distance(i));
      const float spongy = coverage(1.9f + distance, 1.0f / 1.6f);
      hu = mix(hu, mix(kCortical, kSpongy, spongy), bone_.coverage_at(i) * covered);
    }
    return mix(hu, kTooth, teeth_.coverage_at(i) * covered);
  }

  // Skin, a layer of fat that is thin over the middle of the face, then muscle.
  float soft_tissue(float depth, glm::vec3 p) const {
    if (depth > kFatDepth) return kMuscle;
    const glm::vec3 from_nose = (p - glm::vec3(0, -105, -45)) * (1.0f / 32.0f);
    const float away = glm::dot(from_nose, from_nose);
    if (away < 1.0f) return kMuscle;
    const float fat = coverage(2.2f - depth, 1.0f) * coverage(depth - 5.0f, 0.6f);
    return mix(depth < 2.2f ? kSkin : kMuscle, kFat, fat * std::min(away - 1.0f, 1.0f));
  }

  float brain_tissue(float depth, glm::vec3 p, std::size_t i) const {
    constexpr float kFoldsPerMm = 1.0f / 8.5f;
    float hu = kWhiteMatter;
    if (depth < kFoldDepth) {
      const float fold = std::abs(smooth_noise(p * kFoldsPerMm, seed_) - 0.5f);
      // Furrows are open at the surface and close at kFoldDepth.
      const float furrow = 0.055f * (1.0f - depth * (1.0f / kFoldDepth));
      const float from_liquor = std::min(depth - 1.5f, (fold - furrow) * 26.0f + 0.1f * depth);
      hu = mix(kWhiteMatter, kGreyMatter, coverage(from_liquor - 3.5f, 0.7f));
      hu = mix(hu, kLiquor, coverage(from_liquor, 1.0f));
    }
    return mix(hu, kLiquor, ventricles_.coverage_at(i));
  }

  const PhantomGrid& grid_;
  std::uint64_t seed_;
  float inverse_edge_;
  SolidLayer skin_, bone_, teeth_, brain_, ventricles_, orbits_, eyes_, air_;
};

}  // namespace

Volume make_head(Size3 size, std::uint64_t seed, WorkerPool& pool) {
  const HeadAnatomy anatomy;
  const PhantomGrid grid(size, kHeadLowest, kHeadHighest);
  std::vector<std::int16_t> samples(static_cast<std::size_t>(voxel_count(size)));
  std::vector<HeadPainter> painters(static_cast<std::size_t>(pool.thread_count()),
                                    HeadPainter(anatomy, grid, seed));
  for_each_block(grid, pool, [&](const PointBlock& block, VoxelIndex first, int worker) {
    painters[static_cast<std::size_t>(worker)].paint(block, first, samples.data());
  });
  return Volume::of(size, VoxelType::int16, grid.world_from_voxel(), std::move(samples));
}

}  // namespace maille
