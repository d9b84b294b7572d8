#include "app/relaxation_text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace maille {
namespace {

// Two digits that count: far from equilibrium nobody reads thousandths, near it they are all.
std::string voxels(double distance) {
  char text[32];
  const int decimals =
      distance > 0.0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(distance))), 0, 5) : 0;
  std::snprintf(text, sizeof text, "%.*f voxels", decimals, distance);
  return text;
}

std::string progress(const SimulationStatus& s) {
  const std::string begin = s.paused ? "relaxation (paused): " : "relaxation: ";
  if (s.relaxing) {
    if (s.free_elements == 0) return begin + (s.paused ? "to be set up" : "being set up");
    if (!std::isfinite(s.residual_voxels)) return begin + "first step";
    return begin + voxels(s.residual_voxels) + " from equilibrium (RMS " +
           voxels(s.residual_rms_voxels) + "), step " + std::to_string(s.iterations);
  }
  if (s.converged) {
    return begin + "at equilibrium" +
           (s.residual_voxels > 0.0 ? ", within " + voxels(s.residual_voxels) : "");
  }
  if (s.no_nearer) {
    return begin + "comes no nearer to equilibrium, about " + voxels(s.residual_voxels) +
           " from it";
  }
  return "";
}

}  // namespace

std::vector<std::string> relaxation_text(const SimulationStatus& status) {
  std::vector<std::string> lines;
  if (auto line = progress(status); !line.empty()) lines.push_back(std::move(line));
  if (status.region_limited) {
    lines.push_back("relaxing " + std::to_string(status.free_elements) + " of " +
                    std::to_string(status.volume_elements) +
                    " elements: memory (--lattice-memory)");
  }
  return lines;
}

}  // namespace maille
