#include "deform/cell_rows.h"

#include <algorithm>
#include <cmath>

#include "core/several_widths.h"
#include "deform/spring_rows.h"

namespace maille {
namespace {

// u in mm at the four rows of corners: whether a step up along y, and along z.
struct CellInputs {
  const float* x[4];
  const float* y[4];
  const float* z[4];
  float voxels_x = 1.0f;  // in a mm
  float voxels_y = 1.0f;
  float voxels_z = 1.0f;
};

struct Edge {
  float x, y, z;
};

[[gnu::always_inline]] inline float determinant(Edge a, Edge b, Edge c) {
  return a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) +
         a.z * (b.x * c.y - b.y * c.x);
}
[[gnu::always_inline]] inline float length2(Edge e) { return e.x * e.x + e.y * e.y + e.z * e.z; }
[[gnu::always_inline]] inline float lesser(float a, float b) { return a < b ? a : b; }
[[gnu::always_inline]] inline float greater(float a, float b) { return a > b ? a : b; }

MAILLE_FOR_SEVERAL_WIDTHS
void least_determinants(const CellInputs& inputs, int count, float* least, float* longest) {
  const float* const x00 = inputs.x[0];
  const float* const x10 = inputs.x[1];
  const float* const x01 = inputs.x[2];
  const float* const x11 = inputs.x[3];
  const float* const y00 = inputs.y[0];
  const float* const y10 = inputs.y[1];
  const float* const y01 = inputs.y[2];
  const float* const y11 = inputs.y[3];
  const float* const z00 = inputs.z[0];
  const float* const z10 = inputs.z[1];
  const float* const z01 = inputs.z[2];
  const float* const z11 = inputs.z[3];
  const float* const x00_up = x00 + 1;
  const float* const x10_up = x10 + 1;
  const float* const x01_up = x01 + 1;
  const float* const x11_up = x11 + 1;
  const float* const y00_up = y00 + 1;
  const float* const y10_up = y10 + 1;
  const float* const y01_up = y01 + 1;
  const float* const y11_up = y11 + 1;
  const float* const z00_up = z00 + 1;
  const float* const z10_up = z10 + 1;
  const float* const z01_up = z01 + 1;
  const float* const z11_up = z11 + 1;
  const float sx = inputs.voxels_x;
  const float sy = inputs.voxels_y;
  const float sz = inputs.voxels_z;
  // Of its own: what it writes the compiler must know apart from what it reads.
  float lowest[kLongestRun];
  float furthest[kLongestRun];
  for (int i = 0; i < count; ++i) {
    const auto edge = [&](float ax, float ay, float az, float bx, float by, float bz) {
      return Edge{sx * (bx - ax), sy * (by - ay), sz * (bz - az)};
    };
    // Along an axis, at the lower or upper side of the other two.
    Edge along_x_00 = edge(x00[i], y00[i], z00[i], x00_up[i], y00_up[i], z00_up[i]);
    Edge along_x_10 = edge(x10[i], y10[i], z10[i], x10_up[i], y10_up[i], z10_up[i]);
    Edge along_x_01 = edge(x01[i], y01[i], z01[i], x01_up[i], y01_up[i], z01_up[i]);
    Edge along_x_11 = edge(x11[i], y11[i], z11[i], x11_up[i], y11_up[i], z11_up[i]);
    Edge along_y_00 = edge(x00[i], y00[i], z00[i], x10[i], y10[i], z10[i]);
    Edge along_y_10 = edge(x00_up[i], y00_up[i], z00_up[i], x10_up[i], y10_up[i], z10_up[i]);
    Edge along_y_01 = edge(x01[i], y01[i], z01[i], x11[i], y11[i], z11[i]);
    Edge along_y_11 = edge(x01_up[i], y01_up[i], z01_up[i], x11_up[i], y11_up[i], z11_up[i]);
    Edge along_z_00 = edge(x00[i], y00[i], z00[i], x01[i], y01[i], z01[i]);
    Edge along_z_10 = edge(x00_up[i], y00_up[i], z00_up[i], x01_up[i], y01_up[i], z01_up[i]);
    Edge along_z_01 = edge(x10[i], y10[i], z10[i], x11[i], y11[i], z11[i]);
    Edge along_z_11 = edge(x10_up[i], y10_up[i], z10_up[i], x11_up[i], y11_up[i], z11_up[i]);
    along_x_00.x += 1.0f;
    along_x_10.x += 1.0f;
    along_x_01.x += 1.0f;
    along_x_11.x += 1.0f;
    along_y_00.y += 1.0f;
    along_y_10.y += 1.0f;
    along_y_01.y += 1.0f;
    along_y_11.y += 1.0f;
    along_z_00.z += 1.0f;
    along_z_10.z += 1.0f;
    along_z_01.z += 1.0f;
    along_z_11.z += 1.0f;
    const float low = lesser(lesser(determinant(along_x_00, along_y_00, along_z_00),
                                    determinant(along_x_00, along_y_10, along_z_10)),
                             lesser(determinant(along_x_10, along_y_00, along_z_01),
                                    determinant(along_x_10, along_y_10, along_z_11)));
    const float high = lesser(lesser(determinant(along_x_01, along_y_01, along_z_00),
                                     determinant(along_x_01, along_y_11, along_z_10)),
                              lesser(determinant(along_x_11, along_y_01, along_z_01),
                                     determinant(along_x_11, along_y_11, along_z_11)));
    const float longest_x = greater(greater(length2(along_x_00), length2(along_x_10)),
                                    greater(length2(along_x_01), length2(along_x_11)));
    const float longest_y = greater(greater(length2(along_y_00), length2(along_y_10)),
                                    greater(length2(along_y_01), length2(along_y_11)));
    const float longest_z = greater(greater(length2(along_z_00), length2(along_z_10)),
                                    greater(length2(along_z_01), length2(along_z_11)));
    lowest[i] = lesser(low, high);
    furthest[i] = greater(greater(longest_x, longest_y), longest_z);
  }
  std::copy(lowest, lowest + count, least);
  std::copy(furthest, furthest + count, longest);
}

}  // namespace

CellRowMeasure measure_cells(const SpringBox& box, std::int64_t first, int count,
                             float* least_of_cell) {
  CellInputs in;
  const std::int64_t up_y = box.extent().x;
  const std::int64_t up_z = up_y * box.extent().y;
  for (std::size_t r = 0; r < 4; ++r) {
    const std::int64_t corner = first + (r & 1 ? up_y : 0) + (r & 2 ? up_z : 0);
    in.x[r] = &box.u_mm()[0][corner];
    in.y[r] = &box.u_mm()[1][corner];
    in.z[r] = &box.u_mm()[2][corner];
  }
  const glm::vec3 voxels_from_mm(1.0 / box.spacing_mm());
  in.voxels_x = voxels_from_mm.x;
  in.voxels_y = voxels_from_mm.y;
  in.voxels_z = voxels_from_mm.z;
  float longest2[kLongestRun];
  least_determinants(in, count, least_of_cell, longest2);
  CellRowMeasure measure{least_of_cell[0], longest2[0]};
  for (int x = 1; x < count; ++x) {
    measure.least = std::min(measure.least, least_of_cell[x]);
    measure.longest_edge = std::max(measure.longest_edge, longest2[x]);
  }
  measure.longest_edge = std::sqrt(measure.longest_edge);
  return measure;
}

}  // namespace maille
