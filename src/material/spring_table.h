// What the springs of relaxation take from a table of materials.
//
// Stiffness is not taken as it stands. From a ratio of 1000 on the stiffer of two neighbours holds
// its shape so well that the equilibrium hardly changes (1000 against 10^6: RMS 1.1e-4, at most
// 1.8e-3 voxel; design: relaxation), while every solver pays for the ratio and floats run out of
// digits. So, with the stiffnesses of the table from soft to stiff:
// - a gap of more than 1000 between two that follow one another is taken as 1000. All that is
//   stiffer moves along with it, and the order stays;
// - a rigid material is 1000 times as stiff as the stiffest that is not rigid, whatever its number.
//   (Equally stiff would let it give way beside a stiff one; without end is what no float holds.)
//   Where all are rigid, all are alike;
// - where that leaves more than 18 decades, as eight materials can, gaps are narrowed further, the
//   widest first and all to the same. Cutting off the ends instead would make materials equal that
//   a person made different.
// Fixed materials count like any other: their springs pull their free neighbours.
//
// The gaps are those between levels, so a table with interpolated ranges mostly has none.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "material/material_table.h"

namespace maille {

class SpringTable {
 public:
  static SpringTable of(const MaterialTable& table);

  int count() const { return static_cast<int>(springs_.size()); }  // as many as the table's

  // 1 / stiffness, within 1e-12 to 1e6, so that forces and their squares are far from the ends of a
  // float. Exactly the table's where nothing is clamped and all stiffnesses are within 1e-6 to
  // 1e12; otherwise all are multiplied by what it takes. Only ratios matter.
  float compliance(MaterialId id) const { return springs_[id].compliance; }

  float rest_vector_blend(MaterialId id) const { return springs_[id].rest_vector_blend; }
  bool one_blend() const { return smallest_blend_ == largest_blend_; }  // all have the same
  float smallest_blend() const { return smallest_blend_; }

  // Where springs are not what the table says, or a material is rigid beside one that is not: one
  // sentence for a person, naming the materials.
  const std::optional<std::string>& clamped() const { return clamped_; }

 private:
  struct Spring {
    float compliance;
    float rest_vector_blend;
  };

  SpringTable() = default;
  std::vector<Spring> springs_;
  float smallest_blend_ = 0.0f;
  float largest_blend_ = 0.0f;
  std::optional<std::string> clamped_;
};

}  // namespace maille
