#include "deform/state_trail.h"

#include <algorithm>
#include <cmath>
#include <random>

namespace maille {
namespace {

constexpr double kElements = 2048.0;
constexpr std::size_t kStates = 24;

// An element in each block of the free box, where a few tries find one that is free.
std::vector<std::int64_t> spread_elements(const SpringBox& box) {
  constexpr int kTries = 8;
  const VoxelBox& free = box.free_box();
  const auto volume = static_cast<double>(voxel_count(free.size()));
  const int edge = std::max(1, static_cast<int>(std::ceil(std::cbrt(volume / kElements))));
  std::mt19937 random(1);
  std::vector<std::int64_t> elements;
  VoxelIndex lo{};
  for (lo.z = free.lo.z; lo.z < free.hi.z; lo.z += edge) {
    for (lo.y = free.lo.y; lo.y < free.hi.y; lo.y += edge) {
      for (lo.x = free.lo.x; lo.x < free.hi.x; lo.x += edge) {
        const VoxelIndex size = glm::min(VoxelIndex(edge), free.hi - lo);
        for (int i = 0; i < kTries; ++i) {
          const auto within = [&](int most) {
            return static_cast<int>(random() % static_cast<unsigned>(most));
          };
          const VoxelIndex offset(within(size.x), within(size.y), within(size.z));
          const std::int64_t e = box.element(lo + offset);
          if (!box.is_free(e)) continue;
          elements.push_back(e);
          break;
        }
      }
    }
  }
  return elements;
}

}  // namespace

StateTrail::StateTrail(const SpringBox& box)
    : voxels_from_mm_(1.0 / box.spacing_mm()), elements_(spread_elements(box)) {}

void StateTrail::add(const SpringBox& box) {
  if (!kept_.empty() && kept_.back().cycle % stride_ != 0) kept_.pop_back();
  State state{++cycle_, {}};
  state.u_mm.reserve(elements_.size());
  for (const std::int64_t e : elements_) {
    state.u_mm.emplace_back(box.u_mm()[0][e], box.u_mm()[1][e], box.u_mm()[2][e]);
  }
  kept_.push_back(std::move(state));
  while (kept_.size() > 2 && kept_[1].cycle <= cycle_ / 2 - stride_) kept_.pop_front();
  if (kept_.size() <= kStates) return;
  stride_ *= 2;
  std::erase_if(kept_, [&](const State& s) { return s.cycle % stride_ != 0 && s.cycle != cycle_; });
}

const StateTrail::State& StateTrail::at(std::int64_t cycle) const {
  return *std::lower_bound(kept_.begin(), kept_.end(), cycle,
                           [](const State& s, std::int64_t c) { return s.cycle < c; });
}

StateTrail::Left StateTrail::between(const State& a, const State& b) const {
  Left apart;
  for (std::size_t i = 0; i < a.u_mm.size(); ++i) {
    const glm::dvec3 d = (a.u_mm[i] - b.u_mm[i]) * voxels_from_mm_;
    apart.largest_voxels = std::max(apart.largest_voxels, glm::dot(d, d));
    apart.rms_voxels += glm::dot(d, d);
  }
  apart.largest_voxels = std::sqrt(apart.largest_voxels);
  apart.rms_voxels = std::sqrt(apart.rms_voxels / static_cast<double>(a.u_mm.size()));
  return apart;
}

StateTrail::Left StateTrail::left() const {
  // A span that is no shorter than the one before says no more than that much is left.
  constexpr double kSlowest = 0.97;
  constexpr double kOneWay = 0.9;
  if (cycle_ < 2 || elements_.empty()) return {};
  // Of those that are kept for long: the others come and go.
  const std::int64_t cycle = cycle_ / stride_ * stride_;
  const std::int64_t span = std::max(stride_, cycle / 4 / stride_ * stride_);
  const State& now = at(cycle);
  const State& then = at(cycle - span);
  const State& before = at(cycle - 2 * span);
  const double since = static_cast<double>(cycle_ - cycle) / static_cast<double>(span);
  const Left last = between(now, then);
  const Left first = between(then, before);
  const auto left_of = [&](double in_last, double in_first) {
    if (!(in_last > 0.0)) return 0.0;
    const double shrink = std::min(in_last / in_first, kSlowest);
    return in_last * std::pow(shrink, 1.0 + since) / (1.0 - shrink);
  };
  return {
      left_of(last.largest_voxels, first.largest_voxels),
      left_of(last.rms_voxels, first.rms_voxels),
      between(now, before).largest_voxels > kOneWay * (last.largest_voxels + first.largest_voxels)};
}

std::int64_t StateTrail::bytes() const {
  return static_cast<std::int64_t>(elements_.size() *
                                   (sizeof(std::int64_t) + kept_.size() * sizeof(glm::vec3)));
}

}  // namespace maille
