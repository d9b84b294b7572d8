// A direction to go along from the state of a box, in 6 bytes an element: 16 bits for each
// component, in units of the row's own.
//
// How far to go is measured on what is kept, so rounding loses nothing but a little of what made
// the direction best. In stiff parts that little counts: neighbours there move alike, so it is all
// that strains them. The upper half of a float (8 bits) left the parts of stiff scenes unsettled;
// 14 bits of what moves furthest in a row do not. One unit for all would not do: a single element
// that is flung from a fold would take the bits of all others.
#pragma once

#include <cstdint>
#include <vector>

#include "deform/box_array.h"

namespace maille {

class BoxDirection {
 public:
  // All zero. Throws std::bad_alloc.
  BoxDirection(Size3 extent, WorkerPool& pool);

  // Of all elements of a row (mm): the largest component keeps 14 bits. Finite values only.
  void set_row(std::int64_t row, const float* x_mm, const float* y_mm, const float* z_mm);
  // What is kept of it.
  void get_row(std::int64_t row, float* x_mm, float* y_mm, float* z_mm) const;

  float at(std::size_t component, std::int64_t element) const {
    return unit_mm(element / columns_) * static_cast<float>(units_[component][element]);
  }
  // For loops over rows, which may read rows around the box (box_array.h).
  const std::int16_t* units(std::size_t component, std::int64_t element) const {
    return &units_[component][element];
  }
  float unit_mm(std::int64_t row) const { return unit_mm_[static_cast<std::size_t>(row + room_)]; }

  std::int64_t bytes() const;

 private:
  int columns_;
  std::int64_t room_;  // rows before the first and after the last
  std::array<BoxArray<std::int16_t>, 3> units_;
  std::vector<float> unit_mm_;  // by row
};

}  // namespace maille
