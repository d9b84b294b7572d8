#version 450
#extension GL_GOOGLE_include_directive : require

// What does one ray hit first? The walk is the ray-cast pass's own, so a pick finds what is seen.

#include "volume.glsl"

layout(local_size_x = 1) in;

layout(push_constant) uniform Push { PickConstants pick; };
layout(set = 0, binding = 4, std430) writeonly buffer Result { PickResult result; };

// Where the ray has become half opaque, between samples as if opacity grew evenly.
bool half_opaque(Walk walk, out float n_out) {
  float opacity = 0.0;
  for (int n = 0; n <= walk.last;) {
    vec3 position = position_at(walk, float(n));
    if (k_skip_empty) {
      ivec3 block = block_of(position);
      if (!is_visible(block)) {
        n = beyond_block(walk, n, position, block);
        continue;
      }
    }
    float part = transfer_at(value_at(position)).a * (1.0 - opacity);
    if (opacity + part >= 0.5) {
      n_out = max(float(n) - 1.0 + (0.5 - opacity) / part, 0.0);
      return true;
    }
    opacity += part;
    ++n;
  }
  n_out = 0.0;
  return false;
}

void main() {
  Walk walk = walk_along(pick.origin.xyz, pick.direction.xyz);
  float n;
  bool hit = pick.rule.x == k_pick_opacity ? half_opaque(walk, n) : first_hit(walk, n);
  vec3 position = position_at(walk, n);
  result.position = vec4(position, hit ? 1.0 : 0.0);
  result.gradient = hit ? vec4(gradient_at(position), value_at(position)) : vec4(0.0);
}
