// Scenes to measure a relaxation in: a drag, and what holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "measure/drag_scene.h"

namespace maille {

struct RelaxationScene {
  DragScene drag;
  AnchorRules anchors;
};

// About so many elements each; the drag grows with the scene.

// One soft material, a ball dragged.
RelaxationScene homogeneous_relaxation(std::int64_t elements);
// A ball of a fifth of the edge, 1000 times stiffer than the medium around it, dragged by its
// middle.
RelaxationScene stiff_ball_relaxation(std::int64_t elements);
// Three materials of stiffness 0.1, 1 and 10 in random blocks of 4^3.
RelaxationScene random_relaxation(std::int64_t elements, std::uint64_t seed);
// Eight elements thick, hung between two of its edges, its middle pulled out of it.
RelaxationScene sheet_relaxation(std::int64_t elements);
// What lies around the nose of the built-in head, or of a scan in Hounsfield units that faces -y,
// with the CT materials; the nose pulled. Errors: as make_phantom or read_volume.
Result<RelaxationScene> nose_relaxation(std::int64_t elements, std::uint64_t seed,
                                        const std::optional<std::filesystem::path>& scan,
                                        WorkerPool& pool);

}  // namespace maille
