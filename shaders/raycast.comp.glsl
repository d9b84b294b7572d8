#version 450
#extension GL_GOOGLE_include_directive : require

// One ray a pixel through the volume, into a picture of display colours.

#include "volume.glsl"

layout(local_size_x = k_group_edge, local_size_y = k_group_edge) in;

layout(constant_id = 0) const int k_mode = k_mode_composite;
layout(constant_id = 1) const bool k_shading = true;
// What lies between two samples is taken for all values on the way.
layout(constant_id = 3) const bool k_integrated = true;

layout(set = 0, binding = 4, rgba8) writeonly uniform image2D picture;

vec3 surface_color(Walk walk, float n) {
  vec3 color = transfer_at(constants.background.w).rgb;
  if (k_shading) color *= brightness(gradient_at(position_at(walk, n)), walk.direction);
  return color;
}

// What a ray has met so far, where the way between two samples is integrated.
struct Front {
  int n;  // of the last sample
  float at;
  vec4 integral;
};

// r, g, b and the opacity of the way from the sample before to this one. Where that one was left out
// the function is clear from there to here, values in between included: a value changes steadily
// along a ray, and no block on the way has one that shows.
//
// where: what absorbs lies about there, counted in samples. Lit there, not at the sample: else a
// surface would be lit at another depth from pixel to pixel, and show rings again.
vec4 on_the_way(inout Front front, int n, float value, out float where) {
  float at = entry_of(value);
  vec4 integral = table_at(k_transfer_entries, at);
  bool first = n != front.n + 1;
  if (first) {
    front.at = at;
    front.integral = integral;
  }
  float from = front.at;
  float way = at - from;
  where = first ? float(n) : float(n) - 0.5;
  vec4 depth;
  if (abs(way) < 1.0) {
    // Differences of the integrals have no digits left here.
    depth = table_at(0, 0.5 * (at + from));
    depth.rgb *= depth.a;
  } else {
    depth = (integral - front.integral) / way;
    if (k_shading && depth.a > 0.0) {
      float place = (table_at(2 * k_transfer_entries, at).a -
                     table_at(2 * k_transfer_entries, from).a) / (depth.a * way);
      where = float(n) - 1.0 + clamp((place - from) / way, 0.0, 1.0);
    }
  }
  front = Front(n, at, integral);
  if (!(depth.a > 0.0)) return vec4(0.0);
  return vec4(depth.rgb / depth.a, 1.0 - exp(-depth.a));
}

vec3 composite(Walk walk) {
  vec3 color = vec3(0.0);
  float opacity = 0.0;
  bool hit = false;
  vec3 position;
  int n = 0;
  int sure = 0;
  Front front = Front(-2, 0.0, vec4(0.0));
  while (n <= walk.last) {
    if (!is_to_be_taken(walk, n, sure, position)) continue;
    float value = value_at(position);
    if (k_mode == k_mode_composite_with_iso && value >= constants.background.w) {
      hit = true;
      break;
    }
    float where = float(n);
    vec4 sampled = k_integrated ? on_the_way(front, n, value, where) : transfer_at(value);
    ++n;
    if (sampled.a > 0.0) {
      if (k_shading) {
        sampled.rgb *= brightness(gradient_at(position_at(walk, where)), walk.direction);
      }
      float part = sampled.a * (1.0 - opacity);
      color += sampled.rgb * part;
      opacity += part;
      if (opacity > k_opaque) break;
    }
  }
  vec3 behind = constants.background.rgb;
  if (hit) behind = surface_color(walk, surface_before(walk, n, k_picture_refinements));
  return color + (1.0 - opacity) * behind;
}

vec3 iso_surface(Walk walk) {
  float n;
  if (!first_hit(walk, k_picture_refinements, n)) return constants.background.rgb;
  return surface_color(walk, n);
}

// From the background's colour (the transfer function's lowest value) to white (its highest).
vec3 grey(float value) {
  float part = (value - constants.transfer.x) * constants.transfer.y;
  part /= float(k_transfer_entries - 1);
  return mix(constants.background.rgb, vec3(1.0), clamp(part, 0.0, 1.0));
}

vec3 highest_value(Walk walk) {
  float highest = constants.transfer.x;
  vec3 position;
  int n = 0;
  int sure = 0;
  while (n <= walk.last) {
    if (!is_to_be_taken(walk, n, sure, position)) continue;
    ++n;
    highest = max(highest, value_at(position));
  }
  return grey(highest);
}

// What is not above the transfer function's lowest value is air, and counts for nothing.
vec3 mean_value(Walk walk) {
  float sum = 0.0;
  int count = 0;
  vec3 position;
  int n = 0;
  int sure = 0;
  while (n <= walk.last) {
    if (!is_to_be_taken(walk, n, sure, position)) continue;
    ++n;
    float above = value_at(position) - constants.transfer.x;
    if (above > 0.0) {
      sum += above;
      ++count;
    }
  }
  return grey(constants.transfer.x + sum / float(max(count, 1)));
}

void main() {
  // Rays that are worked on together, eight or more in a row, lie 4 x 2 pixels: nearer to each other
  // than 8 x 1, they end together.
  int lane = int(gl_LocalInvocationIndex);
  ivec2 in_group = ivec2((lane >> 1 & 4) + (lane & 3), (lane >> 3 & 6) + (lane >> 2 & 1));
  ivec2 pixel = ivec2(gl_WorkGroupID.xy) * k_group_edge + in_group;
  if (any(greaterThanEqual(pixel, imageSize(picture)))) return;
  vec2 at = vec2(pixel) + 0.5;
  vec3 toward = constants.corner.xyz + at.x * constants.across.xyz + at.y * constants.along.xyz;
  Walk walk = walk_along(constants.eye.xyz, toward);
  vec3 color = constants.background.rgb;
  if (walk.last >= 0) {
    if (k_mode == k_mode_iso) {
      color = iso_surface(walk);
    } else if (k_mode == k_mode_mip) {
      color = highest_value(walk);
    } else if (k_mode == k_mode_average) {
      color = mean_value(walk);
    } else {
      color = composite(walk);
    }
  }
  imageStore(picture, pixel, vec4(color, 1.0));
}
