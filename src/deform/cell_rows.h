// The least corner determinant of the cells of a row, many at a time.
#pragma once

#include "deform/spring_box.h"

namespace maille {

struct CellRowMeasure {
  float least = 0.0f;         // of all cells
  float longest_edge = 0.0f;  // no edge is longer, in units of the cell at rest along each axis
};

// Of the cells whose lowest corners are the elements from `first` on; least_of_cell: count values.
// count <= kLongestRun. Cells that reach beyond the volume are measured like any other.
CellRowMeasure measure_cells(const SpringBox& box, std::int64_t first, int count,
                             float* least_of_cell);

}  // namespace maille
