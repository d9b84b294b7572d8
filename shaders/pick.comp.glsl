#version 450
#extension GL_GOOGLE_include_directive : require

// What does one ray hit first? The walk is the ray-cast pass's own, so a pick finds what is seen.

#include "volume.glsl"

layout(local_size_x = 1) in;

layout(push_constant) uniform Push { PickConstants pick; };
layout(set = 0, binding = 4, std430) writeonly buffer Result { PickResult result; };

void main() {
  Walk walk = walk_along(pick.origin.xyz, pick.direction.xyz);
  float n;
  bool hit = first_hit(walk, k_pick_refinements, n);
  vec3 position = position_at(walk, n);
  result.position = vec4(position, hit ? 1.0 : 0.0);
  result.gradient = hit ? vec4(gradient_at(position), value_at(position)) : vec4(0.0);
}
