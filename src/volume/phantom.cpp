#include "volume/phantom.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <unistd.h>

#include "core/trace.h"
#include "volume/organ_phantoms.h"
#include "volume/phantom_grid.h"

namespace maille {
namespace {

constexpr std::array<std::string_view, 5> kNames = {"hydrogen", "head", "endoscopy", "beetle",
                                                    "spheres"};

// e^x for -700 < x <= 0 in operations that round alike everywhere, to 13 digits (the C library's
// last bit varies): e^x = (e^(x/1024))^1024, the inner one by its series.
double exponential(double x) {
  const double y = x * (1.0 / 1024.0);
  double sum = 1.0;
  for (int n = 8; n >= 1; --n) sum = 1.0 + sum * y / n;
  for (int n = 0; n < 10; ++n) sum *= sum;
  return sum;
}

// value_of(position in mm) for every sample.
template <class F>
Volume make_uint8(const PhantomGrid& grid, WorkerPool& pool, F&& value_of) {
  std::vector<std::uint8_t> samples(static_cast<std::size_t>(voxel_count(grid.size)));
  pool.for_each(grid.size.z, [&](std::int64_t z, int) {
    auto* sample = samples.data() + z * grid.size.y * grid.size.x;
    for (int y = 0; y < grid.size.y; ++y) {
      for (int x = 0; x < grid.size.x; ++x) {
        const double value = value_of(grid.position(glm::dvec3(x, y, static_cast<double>(z))));
        *sample++ = static_cast<std::uint8_t>(std::floor(value + 0.5));
      }
    }
  });
  return Volume::of(grid.size, VoxelType::uint8, grid.world_from_voxel(), std::move(samples));
}

// |psi|^2 of 3d, m = 0, is proportional to (3 z^2 - r^2)^2 exp(-2 r / 3) with r in Bohr radii; it
// is greatest on the axis at r = 6, where it is 144^2 / 4 * exp(-4).
Volume make_hydrogen(Size3 size, WorkerPool& pool) {
  constexpr double kHalfBoxMm = 32.0, kHalfBoxBohr = 17.0;
  const PhantomGrid grid(size, glm::dvec3(-kHalfBoxMm), glm::dvec3(kHalfBoxMm));
  const double to_255 = 255.0 / (72.0 * 72.0 * exponential(-4.0));
  return make_uint8(grid, pool, [=](glm::dvec3 position) {
    const glm::dvec3 p = position * (kHalfBoxBohr / kHalfBoxMm);
    const double r_squared = p.x * p.x + p.y * p.y + p.z * p.z;
    const double angular = 3.0 * p.z * p.z - r_squared;
    const double density = angular * angular * exponential(-2.0 / 3.0 * std::sqrt(r_squared));
    return std::min(density * to_255, 255.0);
  });
}

Volume make_spheres(Size3 size, WorkerPool& pool) {
  constexpr float kInner = 20, kPadding = 32, kOuter = 44;
  const PhantomGrid grid(size, glm::dvec3(-50), glm::dvec3(50));
  const float inverse_edge = 1.0f / grid.edge_width();
  return make_uint8(grid, pool, [=](glm::dvec3 p) {
    const auto r = static_cast<float>(std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z));
    float value = mix(0.0f, 120.0f, coverage(r - kOuter, inverse_edge));
    value = mix(value, 60.0f, coverage(r - kPadding, inverse_edge));
    return mix(value, 200.0f, coverage(r - kInner, inverse_edge));
  });
}

Error refuse(const std::string& why) { return {ErrorKind::usage, "phantom: " + why}; }

}  // namespace

std::span<const std::string_view> phantom_names() { return kNames; }

Result<Volume> make_phantom(std::string_view name, Size3 size, std::uint64_t seed) {
  WorkerPool pool;
  return make_phantom(name, size, seed, pool);
}

Result<Volume> make_phantom(std::string_view name, Size3 size, std::uint64_t seed,
                            WorkerPool& pool) {
  const trace::Span span("make phantom");
  if (std::find(kNames.begin(), kNames.end(), name) == kNames.end()) {
    std::string known;
    for (const auto each : kNames) known += (known.empty() ? "" : ", ") + std::string(each);
    return refuse("expected one of " + known + ", got \"" + std::string(name) + "\"");
  }
  if (size.x < 1 || size.y < 1 || size.z < 1) return refuse("expected sizes >= 1");
  const double bytes = 2.0 * size.x * size.y * size.z;
  const double memory =
      static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE));
  if (bytes > memory) {
    return refuse("expected a size that memory holds, got " + std::to_string(size.x) + "x" +
                  std::to_string(size.y) + "x" + std::to_string(size.z));
  }
  if (name == "hydrogen") return make_hydrogen(size, pool);
  if (name == "head") return make_head(size, seed, pool);
  if (name == "endoscopy") return make_endoscopy(size, seed, pool);
  if (name == "beetle") return make_beetle(size, seed, pool);
  return make_spheres(size, pool);
}

}  // namespace maille
