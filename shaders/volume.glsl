// What both passes do with the volume: sample it, skip it, walk along a ray through it.
//
// Positions are in voxel space: sample (i,j,k) sits at its integer point, the volume reaches half a
// voxel beyond its border samples (so a single slice is something to look at).

#include "shared/pass_constants.h"

layout(set = 0, binding = 0, std140) uniform Constants { PassConstants constants; };
layout(set = 0, binding = 1) uniform sampler3D volume;
layout(set = 0, binding = 2, std430) readonly buffer SkipGrid { uint blocks_away[]; };
layout(set = 0, binding = 3, std430) readonly buffer Transfer { vec4 transfer_table[]; };

// Off, every sample is taken: same pixels, for tests and measuring.
layout(constant_id = 2) const bool k_skip_empty = true;

// Sample n of a ray lies at entry + n * step * direction, n = 0 .. last. The index is one for the
// whole ray, so skipping never moves a sample.
struct Walk {
  vec3 entry;
  vec3 direction;  // unit
  vec3 samples;    // from one voxel to the next along each axis, signed, never infinite
  int last;        // -1: the ray misses the volume
};

Walk walk_along(vec3 origin, vec3 toward) {
  Walk walk;
  walk.direction = normalize(toward);
  vec3 divisor = mix(walk.direction, vec3(1e-8), lessThan(abs(walk.direction), vec3(1e-8)));
  vec3 inverse = 1.0 / divisor;
  walk.samples = inverse / constants.eye.w;
  vec3 low = (vec3(-0.5) - origin) * inverse;
  vec3 high = (vec3(constants.volume_size.xyz) - 0.5 - origin) * inverse;
  vec3 enter = min(low, high);
  vec3 leave = max(low, high);
  float first = max(max(enter.x, enter.y), max(enter.z, 0.0));
  float end = min(min(leave.x, leave.y), leave.z);
  walk.entry = origin + walk.direction * first;
  walk.last = end < first ? -1 : int(floor((end - first) / constants.eye.w));
  return walk;
}

vec3 position_at(Walk walk, float n) {
  precise vec3 position = walk.entry + walk.direction * (n * constants.eye.w);
  return position;
}

float value_at(vec3 position) {
  return textureLod(volume, (position + 0.5) * constants.texture_from_voxel.xyz, 0.0).r;
}

vec3 gradient_at(vec3 position) {
  return 0.5 * vec3(value_at(position + vec3(1, 0, 0)) - value_at(position - vec3(1, 0, 0)),
                    value_at(position + vec3(0, 1, 0)) - value_at(position - vec3(0, 1, 0)),
                    value_at(position + vec3(0, 0, 1)) - value_at(position - vec3(0, 0, 1)));
}

ivec3 block_of(vec3 position) {
  return clamp(ivec3(floor(position / float(k_block_edge))), ivec3(0),
               constants.block_count.xyz - 1);
}

// How many blocks away the nearest one is that shows something, 0 where this one does.
int blocks_to_go(ivec3 block) {
  int index = (block.z * constants.block_count.y + block.y) * constants.block_count.x + block.x;
  return int((blocks_away[index >> 2] >> ((index & 3) * 8)) & 0xffu);
}

// From sample n in a block around which there is nothing for so many blocks, this one counted, to
// the first sample that may lie beyond them.
int beyond_blocks(Walk walk, int n, vec3 position, ivec3 block, int empty) {
  ivec3 side = mix(ivec3(1 - empty), ivec3(empty), greaterThan(walk.samples, vec3(0.0)));
  vec3 wall = vec3((block + side) * k_block_edge);
  // The border blocks reach half a voxel further out than their walls; there the distance comes out
  // negative and the walk goes on by single samples.
  vec3 to_wall = (wall - position) * walk.samples - k_wall_margin * abs(walk.samples);
  float shortest = min(min(to_wall.x, to_wall.y), to_wall.z);
  return n + 1 + int(clamp(shortest, 0.0, 1e6));
}

// True where sample n, at this position, is to be taken; else n moves on to the next that may be.
// `sure`: samples before that one lie in a block that shows something; 0 to begin with. What every
// march does in one loop: rays of a group that look and others that go on take their turns then, in
// place of waiting for each other.
bool is_to_be_taken(Walk walk, inout int n, inout int sure, out vec3 position) {
  position = position_at(walk, float(n));
  if (!k_skip_empty || n < sure) return true;
  ivec3 block = block_of(position);
  int empty = blocks_to_go(block) - constants.block_count.w;
  int beyond = beyond_blocks(walk, n, position, block, max(empty, 1));
  if (empty <= 0) {
    sure = beyond;
    return true;
  }
  n = beyond;
  return false;
}

// Where in the transfer table.
float entry_of(float value) {
  float at = (value - constants.transfer.x) * constants.transfer.y;
  // Written so that a NaN lands at 0.
  return at > 0.0 ? min(at, float(k_transfer_entries - 1)) : 0.0;
}

// first: of the table, or of the integrals behind it. Between two equal entries exactly theirs.
vec4 table_at(int first, float at) {
  int entry = min(int(at), k_transfer_entries - 2);
  vec4 low = transfer_table[first + entry];
  return low + (at - float(entry)) * (transfer_table[first + entry + 1] - low);
}

// r, g, b and the opacity of one step (or its optical depth, where there are integrals).
vec4 transfer_at(float value) { return table_at(0, entry_of(value)); }

float squared_length(vec4 diagonal, vec4 mixed, vec3 v) {
  return dot(diagonal.xyz, v * v) + 2.0 * dot(mixed.xyz, v.yzx * v.zxy);
}

// Headlight: how bright is what has this gradient, seen along this direction? Surfaces are lit from
// both sides. With n the world gradient and d the world direction, n.d is the same product in voxel
// space, because one transforms by the inverse transpose.
float brightness(vec3 gradient, vec3 direction) {
  float gradient_length =
      squared_length(constants.gradient_diagonal, constants.gradient_mixed, gradient);
  float direction_length =
      squared_length(constants.length_diagonal, constants.length_mixed, direction);
  float cosine = abs(dot(gradient, direction)) *
                 inversesqrt(max(gradient_length * direction_length, 1e-30));
  float steepness = dot(gradient, gradient);
  float weight = steepness / (steepness + max(constants.transfer.z, 1e-30));
  return mix(1.0, k_ambient + (1.0 - k_ambient) * min(cosine, 1.0), weight);
}

// Sample n is the first one of the iso value: where between it and the one before the surface is.
// Counts in samples. To be called behind the loop that finds n, where all rays of a group do it at
// once. Bisection, not a secant: the value along the ray is no line between samples.
float surface_before(Walk walk, int n, int refinements) {
  float outside = float(max(n - 1, 0));
  float inside = float(n);
  for (int i = 0; i < refinements; ++i) {
    float middle = 0.5 * (outside + inside);
    if (value_at(position_at(walk, middle)) >= constants.background.w) {
      inside = middle;
    } else {
      outside = middle;
    }
  }
  return inside;
}

// The first surface of the iso value.
bool first_hit(Walk walk, int refinements, out float n_out) {
  vec3 position;
  int n = 0;
  int sure = 0;
  while (n <= walk.last) {
    if (!is_to_be_taken(walk, n, sure, position)) continue;
    if (value_at(position) >= constants.background.w) break;
    ++n;
  }
  bool hit = n <= walk.last;
  n_out = hit ? surface_before(walk, n, refinements) : 0.0;
  return hit;
}
