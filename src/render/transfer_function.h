// What a voxel value looks like.
//
// Values are in the file's own units (HU for CT). Colours and opacity are 0..1; colours are what
// the display is given (sRGB-encoded). Opacity is what one voxel length of the value absorbs.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include <glm/glm.hpp>

#include "core/result.h"

namespace maille {

struct TransferPoint {
  double value = 0.0;
  glm::dvec3 color{1.0};
  double opacity = 0.0;
  bool operator==(const TransferPoint&) const = default;
};

// Piecewise linear between points, constant beyond the first and the last.
class TransferFunction {
 public:
  // Errors: bad_input (no point, values that fall, a number that is not finite or not in 0..1).
  // Two points of one value are a step.
  static Result<TransferFunction> of(std::vector<TransferPoint> points);

  // ct-skin, ct-bone, ct-airway; relative: a warm ramp over lowest..highest, for any other scan
  // (the others ignore the range). Errors: usage, listing the names.
  static Result<TransferFunction> preset(std::string_view name, double lowest, double highest);
  static std::span<const std::string_view> preset_names();

  std::span<const TransferPoint> points() const { return points_; }
  glm::dvec4 at(double value) const;  // r, g, b, opacity
  double lowest() const { return points_.front().value; }
  double highest() const { return points_.back().value; }

  // The value whose surface the eye takes for the outside: a preset's own (ct-skin -300, ct-bone
  // 250, ct-airway -500), otherwise where opacity first rises. A default for picks and iso
  // pictures.
  double surface_value() const;

  // Evenly spaced samples over lowest()..highest(), both included, opacity raised to a sampling
  // distance of step_voxels: 1 - (1 - opacity)^step.
  std::vector<glm::vec4> table(int entries, double step_voxels) const;

  // What a ray meets between two samples that lie step_voxels apart, whatever the function does
  // between their values (Engel, Kraus, Ertl: High-quality pre-integrated volume rendering, 2001;
  // here as integrals over one value, of which two are subtracted). 3 `entries` samples, spaced as
  // table's: colour and optical depth of a step; from the first entry on, the integrals of depth
  // times colour and of depth; and that of depth times where in the table it is. A unit is the way
  // from one entry to the next.
  std::vector<glm::vec4> integrated_table(int entries, double step_voxels) const;

  bool operator==(const TransferFunction&) const = default;

 private:
  explicit TransferFunction(std::vector<TransferPoint> points) : points_(std::move(points)) {}
  std::vector<TransferPoint> points_;
  double surface_value_ = 0.0;
};

}  // namespace maille
