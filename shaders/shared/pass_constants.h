// What the ray-cast and pick passes are told, written once for both languages.
//
// GLSL includes it after declaring its version; C++ sees the structs in namespace maille::shader.
// Only vec4 and ivec4 members: then std140 and C++ agree without padding rules.
#ifndef MAILLE_SHARED_PASS_CONSTANTS_H
#define MAILLE_SHARED_PASS_CONSTANTS_H

#ifdef __cplusplus
#include <glm/glm.hpp>
namespace maille::shader {
using glm::ivec4;
using glm::vec4;
#define MAILLE_CONSTANT inline constexpr
#else
#define MAILLE_CONSTANT const
#endif

// An 8x8 group walks a coherent bundle of rays; 4x8 was up to ten times slower on one driver.
MAILLE_CONSTANT int k_group_edge = 8;

// Blocks of voxels that are skipped as one: small enough to follow a surface, large enough that the
// grid of a 1024^3 volume is 2 MiB.
MAILLE_CONSTANT int k_block_edge = 8;

// An entry every 4 HU when the function spans a whole 12-bit CT, with lines in between, and 16 KiB,
// or 48 with the integrals, which one vkCmdUpdateBuffer carries (its limit is 64 KiB).
MAILLE_CONSTANT int k_transfer_entries = 1024;

// What lies behind 1/128 of the light is not seen in 8 bits a channel.
MAILLE_CONSTANT float k_opaque = 0.9921875f;

// Halvings of the step that brackets a surface. A pick's 1/1024 of a step is ten times finer than
// it promises; a picture takes the gradient there, in which 1/16 of a step is not seen.
MAILLE_CONSTANT int k_pick_refinements = 10;
MAILLE_CONSTANT int k_picture_refinements = 4;

// Light that reaches a surface turned away from the headlight. Lower hides the shape of hollows,
// higher flattens everything.
MAILLE_CONSTANT float k_ambient = 0.3f;

// Change a voxel, as a part of the transfer function's range, at which shading is half: noise
// inside a tissue has no direction worth lighting.
MAILLE_CONSTANT float k_flat_gradient = 0.01f;

// How far a block is left early when it is skipped, in voxels: beyond the rounding of positions in
// volumes of 4096 voxels an axis.
MAILLE_CONSTANT float k_wall_margin = 0.002f;

// RenderMode, as specialization constant 0 of the ray-cast pass.
MAILLE_CONSTANT int k_mode_composite = 0;
MAILLE_CONSTANT int k_mode_iso = 1;
MAILLE_CONSTANT int k_mode_mip = 2;
MAILLE_CONSTANT int k_mode_composite_with_iso = 3;
MAILLE_CONSTANT int k_mode_average = 4;

// Lengths are in voxels, values in texel units (what the sampler returns).
struct PassConstants {
  ivec4 volume_size;        // xyz voxels
  ivec4 block_count;        // xyz blocks; w: so many around what shows are looked at too
  vec4 texture_from_voxel;  // xyz: one voxel, as a part of the texture along each axis
  // direction(position) = corner + position.x * across + position.y * along, in voxels. Not unit.
  vec4 eye;  // xyz; w: sampling distance
  vec4 corner;
  vec4 across;
  vec4 along;
  // Symmetric 3x3 matrices as diagonal and (yz, zx, xy): squared world length of a voxel vector,
  // and of the world gradient that a voxel gradient stands for.
  vec4 length_diagonal;
  vec4 length_mixed;
  vec4 gradient_diagonal;
  vec4 gradient_mixed;
  vec4 background;  // rgb; w: iso value
  // x: value of the first entry, y: entries a unit, z: squared gradient at which shading is half
  vec4 transfer;
};

struct PickConstants {
  vec4 origin;     // xyz in voxels
  vec4 direction;  // xyz in voxels, any length
};

struct PickResult {
  vec4 position;  // xyz in voxels; w: 1 for a hit, 0 for a miss
  vec4 gradient;  // xyz texel units a voxel; w: value there
};

#ifdef __cplusplus
}  // namespace maille::shader
#endif
#undef MAILLE_CONSTANT

#endif
