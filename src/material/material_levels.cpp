#include "material/material_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace maille {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kFineEnough = 1.0 / 1024.0;  // half a fixed-point unit, as a share of a voxel

// The first value that belongs to `upper` when each takes what is nearer.
double border_of(const Material& lower, const Material& upper) {
  if (lower.value_high == upper.value_low) return upper.value_low;
  const double middle_of_gap = std::midpoint(lower.value_high, upper.value_low);
  return std::min(std::nextafter(middle_of_gap, kInfinity), upper.value_low);
}

// The value inside the range where the material's own numbers hold.
double middle_of(const Material& m) {
  if (std::isinf(m.value_low) && std::isinf(m.value_high)) return 0.0;
  if (std::isinf(m.value_low)) return std::nextafter(m.value_high, -kInfinity);
  if (std::isinf(m.value_high)) return m.value_low;
  const double middle = std::midpoint(m.value_low, m.value_high);
  return middle < m.value_high ? middle : m.value_low;  // of neighbouring doubles it may round up
}

// Rest length over length where a link yields: what runs straight of a yield strain.
double shortness_at_yield(const Material& m) {
  return 1.0 / (1.0 + m.yield_strain.value_or(kInfinity));
}

// A run of values between two middles, or between a middle and a border where flags change: limits
// run straight in it, flags stay.
struct Ramp {
  const Material* lower;
  const Material* upper;
  const Material* range;  // whose flags hold
  double value_from, value_to;
  double share_from, share_to;  // of the way from the middle of lower to that of upper
  bool from_middle, to_middle;
  double change = 0.0;     // what a single level would be wrong by, end to end
  int levels_between = 0;  // besides those of the middles

  // The middles' levels reach half as far into it as its own are wide.
  double width_of_level() const {
    return 1.0 / (levels_between + 0.5 * (int{from_middle} + int{to_middle}));
  }
  double error() const { return 0.5 * change * width_of_level(); }
};

// Between 0 and 1 of the ramp.
Material at(const Ramp& ramp, double along) {
  const double share = ramp.share_from + along * (ramp.share_to - ramp.share_from);
  const Material& a = *ramp.lower;
  const Material& b = *ramp.upper;
  Material level = *ramp.range;
  if (!level.rigid) {
    level.compress = a.compress + share * (b.compress - a.compress);
    level.stretch = a.stretch + share * (b.stretch - a.stretch);
    level.shear = a.shear + share * (b.shear - a.shear);
  }
  level.stiffness = a.stiffness * std::pow(b.stiffness / a.stiffness, share);
  level.rest_vector_blend =
      *a.rest_vector_blend + share * (*b.rest_vector_blend - *a.rest_vector_blend);
  if (a.yield_strain != b.yield_strain) {
    level.yield_strain = 1.0 / std::lerp(shortness_at_yield(a), shortness_at_yield(b), share) - 1.0;
  }
  return level;
}

// One hundredth of a voxel in a limit counts as much as one of a hundred in stiffness.
double change_of(const Ramp& ramp) {
  // Neighbouring doubles, at the end of an open range: no value lies between.
  if (std::nextafter(ramp.value_from, kInfinity) >= ramp.value_to) return 0.0;
  double most =
      std::max({std::abs(std::log(ramp.upper->stiffness / ramp.lower->stiffness)),
                std::abs(*ramp.upper->rest_vector_blend - *ramp.lower->rest_vector_blend),
                std::abs(shortness_at_yield(*ramp.upper) - shortness_at_yield(*ramp.lower))});
  if (!ramp.range->rigid) {
    for (const auto limit : {&Material::compress, &Material::stretch, &Material::shear}) {
      for (int c = 0; c < 3; ++c) {
        most = std::max(most, std::abs((ramp.upper->*limit)[c] - (ramp.lower->*limit)[c]));
      }
    }
  }
  return most * (ramp.share_to - ramp.share_from);
}

std::vector<Ramp> ramps_of(const std::vector<Material>& materials) {
  std::vector<Ramp> ramps;
  const auto add = [&](Ramp ramp) {
    ramp.change = change_of(ramp);
    ramps.push_back(ramp);
  };
  for (std::size_t i = 1; i < materials.size(); ++i) {
    const Material& lower = materials[i - 1];
    const Material& upper = materials[i];
    const double from = middle_of(lower);
    const double to = middle_of(upper);
    if (lower.fixed == upper.fixed && lower.rigid == upper.rigid) {
      add({&lower, &upper, &lower, from, to, 0.0, 1.0, true, true});
      continue;
    }
    const double border = border_of(lower, upper);
    // In long double, a range as wide as a double's reach has a width too.
    const auto share = static_cast<double>((static_cast<long double>(border) - from) /
                                           (static_cast<long double>(to) - from));
    add({&lower, &upper, &lower, from, border, 0.0, share, true, false});
    add({&lower, &upper, &upper, border, to, share, 1.0, false, true});
  }
  return ramps;
}

// Always to the worst ramp: no other sharing has a better worst one.
void share_out(int levels, std::vector<Ramp>& ramps) {
  for (; levels > 0; --levels) {
    const auto worst =
        std::max_element(ramps.begin(), ramps.end(),
                         [](const Ramp& a, const Ramp& b) { return a.error() < b.error(); });
    if (worst == ramps.end() || worst->error() <= kFineEnough) return;
    ++worst->levels_between;
  }
}

std::vector<Material> levels_of_ramps(const std::vector<Material>& materials) {
  auto ramps = ramps_of(materials);
  share_out(kMaxMaterials - static_cast<int>(materials.size()), ramps);
  std::vector<Material> levels{materials.front()};
  const auto add = [&](const Ramp& ramp, double begin, Material level) {
    level.value_low = std::lerp(ramp.value_from, ramp.value_to, begin);
    // The middle itself keeps its own level, however narrow the ranges.
    if (ramp.from_middle) {
      level.value_low = std::max(level.value_low, std::nextafter(ramp.value_from, kInfinity));
    }
    levels.push_back(std::move(level));
  };
  for (const Ramp& ramp : ramps) {
    const double width = ramp.width_of_level();
    double begin = ramp.from_middle ? 0.5 * width : 0.0;
    for (int i = 0; i < ramp.levels_between; ++i, begin += width) {
      add(ramp, begin, at(ramp, begin + 0.5 * width));
    }
    if (ramp.to_middle) add(ramp, std::max(0.0, 1.0 - 0.5 * width), *ramp.upper);
  }
  return levels;
}

}  // namespace

std::vector<Material> levels_of(const std::vector<Material>& materials,
                                Interpolation interpolation) {
  auto levels = materials;
  if (interpolation == Interpolation::linear) {
    levels = levels_of_ramps(materials);
  } else {
    for (std::size_t i = 1; i < levels.size(); ++i) {
      levels[i].value_low = border_of(materials[i - 1], materials[i]);
    }
  }
  levels.front().value_low = -kInfinity;
  for (std::size_t i = 1; i < levels.size(); ++i) levels[i - 1].value_high = levels[i].value_low;
  levels.back().value_high = kInfinity;
  return levels;
}

}  // namespace maille
