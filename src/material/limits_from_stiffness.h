// ChainMail limits that follow from stiffness, so that the step that answers a drag and the
// relaxation after it want the same shape (the paper, section 5.3).
#pragma once

#include <vector>

#include "core/result.h"
#include "material/material.h"

namespace maille {

// As in Material, and with compress > 2 shear for each component, so that nothing folds.
struct SoftestLimits {
  glm::dvec3 compress{0.6};
  glm::dvec3 stretch{1.5};
  glm::dvec3 shear{0.25};
};

// The softest material that can deform (neither fixed nor rigid; of all, if none can) gets the
// given limits. Every other gets those that the same force takes it to: strain goes by 1 /
// stiffness, and one still softer (a fixed one) gets no more than the softest. Being narrower in
// every direction, all keep the no-fold rule that the softest's keep. Rigid ones are rigid. Limits
// that the materials had are written over; all else stays.
//
// A strain below 1/512 voxel rounds to rigid: the limits of a material a thousand times as stiff as
// the softest are gone. warnings_of says where.
//
// Errors: bad_input: limits of the softest out of range or allowing folds; a stiffness or a value
// range that no table takes, naming the material.
Result<std::vector<Material>> limits_from_stiffness(std::vector<Material> materials,
                                                    const SoftestLimits& softest = {});

}  // namespace maille
