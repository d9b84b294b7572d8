// The shapes of the formula head in mm, LPS: +x left, +y back, +z up; the eyes' centres lie at z =
// 0, the mid-plane is x = 0. Sizes are those of an average adult (chin to vertex 228 mm).
#pragma once

#include <glm/glm.hpp>

#include "volume/solid.h"

namespace maille {

inline constexpr glm::dvec3 kHeadLowest{-100, -128, -152};
inline constexpr glm::dvec3 kHeadHighest{100, 112, 124};

struct HeadAnatomy {
  HeadAnatomy();

  Solid skin;  // everything that is not outside air, eyeballs included
  Solid bone;  // skull, jaw and cervical spine
  Solid teeth;
  Solid brain;  // the cranial cavity
  Solid ventricles;
  Solid orbits;  // fat around the eyes
  Solid eyes;
  Solid air;  // nostrils, nasal cavity, sinuses, mouth, throat and windpipe, ear canals
};

}  // namespace maille
