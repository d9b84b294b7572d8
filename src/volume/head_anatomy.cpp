#include "volume/head_anatomy.h"

#include <vector>

namespace maille {
namespace {

using P = glm::dvec3;

struct Bead {
  P at;
  double radius;
};

// Cones from bead to bead, on both sides of the head.
void join_chain(Solid& solid, const std::vector<Bead>& beads, double blend) {
  for (std::size_t i = 0; i + 1 < beads.size(); ++i) {
    solid.join(mirrored(cone(beads[i].at, beads[i].radius, beads[i + 1].at, beads[i + 1].radius)),
               blend);
  }
}

void add_skull_cap_and_neck(Solid& skin) {
  skin.join(ellipsoid({0, 4, 38}, {75, 97, 82}), 0);
  skin.join(ellipsoid({0, 46, 4}, {62, 48, 50}), 20);                     // back of the head
  skin.join(mirrored(ellipsoid({52, -30, 4}, {13, 32, 32})), 16);         // temple
  skin.join(mirrored(ellipsoid({56, 6, -16}, {15, 26, 34})), 14);         // around the ear
  skin.join(cone({0, 18, -50}, 50, {0, 26, -175}, 54), 22);               // neck
  skin.join(mirrored(cone({54, 18, -34}, 11, {20, -20, -165}, 13)), 16);  // sternomastoid
  skin.join(mirrored(cone({34, 54, -60}, 18, {48, 50, -175}, 34)), 18);   // trapezius
  skin.join(ellipsoid({0, -26, -124}, {10, 10, 13}), 14);                 // larynx
}

void add_ears(Solid& skin) {
  // The auricle stands off backwards: its flat side faces outwards and somewhat forwards, and the
  // front of its rim sinks into the cheek.
  const P out(0.88, -0.46, 0.10);
  const auto plate = [&](P at, P radii) { return mirrored(facing(ellipsoid(at, radii), out)); };
  const auto rim = [&](P at, double half_y, double half_z, double tube) {
    return mirrored(facing(ring(at, half_y, half_z, tube), out));
  };
  skin.join(mirrored(facing(disc({78, 17, 1}, 15.5, 1.5), out)), 4);  // plate
  skin.join(mirrored(facing(disc({77, 16, -13}, 14, 1.7), out)), 5);
  skin.join(rim({78.5, 17, -4}, 15, 21, 2.7), 2.5);                      // helix
  skin.join(mirrored(ellipsoid({75.5, 14.5, -28}, {3.8, 7.5, 10})), 8);  // lobe
  skin.carve(plate({85.5, 17.5, 5}, {3.6, 10, 12}), 2.5);                // scapha
  skin.join(rim({79.5, 16, -7}, 9, 12.5, 2.4), 3);                       // antihelix
  skin.carve(plate({82.5, 13.5, -8}, {6, 7, 9}), 2.5);                   // concha
  skin.join(mirrored(ellipsoid({74.5, 3, -11}, {3.4, 3.4, 5.5})), 3);    // tragus
}

void add_face(Solid& skin) {
  skin.join(ellipsoid({0, -36, -20}, {60, 57, 58}), 16);              // middle face
  skin.join(ellipsoid({0, -40, -68}, {47, 50, 40}), 16);              // jaw
  skin.join(mirrored(ellipsoid({44, -16, -58}, {15, 24, 30})), 16);   // chewing muscle
  skin.join(mirrored(ellipsoid({42, -58, -24}, {18, 21, 15})), 16);   // cheekbone
  skin.join(ellipsoid({0, -70, -62}, {30, 31, 26}), 14);              // around the mouth
  skin.join(ellipsoid({0, -83, -95}, {17, 15, 13}), 14);              // chin
  skin.join(ellipsoid({0, -86, 13}, {14, 9, 9}), 14);                 // glabella
  skin.join(mirrored(ellipsoid({30, -62, -50}, {19, 22, 24})), 16);   // cheek
  skin.join(mirrored(cone({14, -86, 17}, 6, {34, -81, 20}, 6)), 14);  // brow
  skin.join(mirrored(cone({34, -81, 20}, 6, {50, -64, 14}, 5)), 14);
}

void add_eyes(Solid& skin) {
  skin.carve(mirrored(ellipsoid({31, -103, -2}, {15, 16.5, 10})), 14);  // socket
  skin.join(mirrored(ball({31, -77, 0}, 14.2)), 6);                     // lids
  skin.carve(mirrored(ellipsoid({31.5, -91, -0.5}, {12.3, 7, 3.7})), 1);
  skin.join(mirrored(ball({31, -77, 0}, 12.6)), 0.5);  // eyeball
}

void add_nose(Solid& skin) {
  skin.join(cone({0, -82, 6}, 8, {0, -104, -30}, 9), 14);              // bridge
  skin.join(mirrored(cone({8, -84, -10}, 6, {11, -92, -34}, 8)), 12);  // sides
  skin.join(ball({0, -110.5, -37}, 8.6), 8);                           // tip
  skin.join(mirrored(ellipsoid({10.5, -101, -41}, {7, 9.5, 7})), 4);   // wings
  skin.join(cone({0, -107, -43}, 4, {0, -97, -49}, 5), 4);             // columella
}

void add_mouth(Solid& skin) {
  skin.join(ellipsoid({0, -98, -60}, {10, 6.5, 4.4}), 4);  // upper lip
  skin.join(mirrored(cone({5.5, -98.5, -59.5}, 4.2, {22, -89, -63}, 2.4)), 4);
  skin.join(ellipsoid({0, -97.5, -69.3}, {15, 7, 5.6}), 4);  // lower lip
  skin.join(mirrored(cone({8, -96, -68.5}, 4.4, {21, -88.5, -65}, 2.2)), 4);
  skin.carve(cone({-8, -103.6, -63.8}, 0.9, {8, -103.6, -63.8}, 0.9), 2.6);  // mouth line
  skin.carve(mirrored(cone({8, -103.6, -63.8}, 0.9, {26, -91.5, -63.6}, 0.9)), 2.6);
  skin.carve(cone({0, -108.5, -49}, 2.4, {0, -107.5, -56}, 2.8), 4);  // philtrum
  skin.carve(ellipsoid({0, -107, -79}, {20, 8, 5}), 10);              // above the chin
}

void add_skull(Solid& bone) {
  bone.join(ellipsoid({0, 4, 46}, {69, 90.5, 68}), 0);  // vault
  bone.join(ellipsoid({0, 46, 2}, {53, 44.5, 37}), 18);
  bone.join(mirrored(ellipsoid({44, -24, 4}, {11, 34, 26})), 10);        // temple
  bone.join(mirrored(cone({6, -83, 16}, 7.5, {43, -67, 19}, 6.5)), 14);  // brow ridge
  bone.join(mirrored(cone({44, -66, 14}, 5, {48, -59, -8}, 4.5)), 9);    // outer orbit rim
  bone.join(mirrored(ellipsoid({43, -57, -20}, {11, 11, 10})), 9);       // cheekbone
  bone.join(mirrored(cone({30, -76, -17}, 4.5, {46, -62, -18}, 5)), 5);  // lower orbit rim
  join_chain(
      bone, {{{50, -52, -20}, 4.5}, {{62, -30, -19}, 3.2}, {{66, -8, -14}, 3.2}, {{64, 6, -10}, 4}},
      4);
  bone.join(ellipsoid({0, -58, -34}, {35, 28, 24}), 8);                // upper jaw
  bone.join(mirrored(cone({16, -80, 2}, 4, {17, -78, -30}, 6)), 6);    // beside the nose
  bone.join(mirrored(cone({2, -87, 6}, 3.4, {4, -96, -14}, 2.4)), 3);  // nasal bones
  bone.join(ellipsoid({0, -24, -12}, {30, 34, 18}), 8);
  bone.join(ellipsoid({0, 36, -30}, {36, 30, 10}), 8);                 // base of the skull
  bone.join(mirrored(cone({22, -30, -16}, 5, {20, -28, -46}, 4)), 5);  // pterygoid
  bone.join(mirrored(ellipsoid({52, 24, -32}, {11, 14, 19})), 8);      // mastoid
  bone.join(mirrored(ellipsoid({55, 6, -8}, {11, 18, 10})), 8);        // around the ear
}

void carve_skull(Solid& bone) {
  bone.carve(cone({0, 31, -20}, 12, {0, 32, -50}, 13), 4);             // foramen magnum
  bone.carve(mirrored(cone({32, -92, -1}, 19, {17, -40, 3}, 6)), 4);   // orbit
  bone.carve(mirrored(cone({5, -100, -20}, 5, {6, -96, -38}, 8)), 4);  // nasal opening
  bone.carve(mirrored(cone({7, -84, -12}, 5.5, {8, -80, -34}, 8)), 3);
  bone.carve(mirrored(ellipsoid({8, -58, -20}, {6.5, 34, 22})), 2);      // nasal cavity
  bone.carve(mirrored(ellipsoid({24, -60, -32}, {9, 18, 13})), 2);       // maxillary sinus
  bone.carve(ellipsoid({0, -54, -66}, {24, 30, 20}), 4);                 // mouth
  bone.carve(mirrored(cone({50, 6, -11}, 3.2, {90, 10, -12}, 3.2)), 1);  // ear canal
  bone.join(cone({0, -88, -12}, 1.2, {0, -40, -20}, 1.2), 0);            // septum
  bone.join(ellipsoid({0, -60, -22}, {1.0, 28, 20}), 0);
}

void add_jaw(Solid& bone) {
  bone.join(mirrored(cone({0, -83, -97}, 7, {25, -72, -95}, 6.5)), 5);  // body, lower border
  bone.join(mirrored(cone({25, -72, -95}, 6.5, {47, -10, -78}, 5.5)), 5);
  bone.join(mirrored(cone({0, -84, -81}, 5.5, {21, -73, -81}, 5.5)), 9);  // body, upper border
  bone.join(mirrored(cone({21, -73, -81}, 5.5, {40, -24, -70}, 5)), 9);
  bone.join(ellipsoid({0, -86, -97}, {11, 7, 7}), 6);                      // chin
  bone.join(mirrored(cone({48, -8, -76}, 5, {56, 1, -18}, 4.5)), 5);       // ramus to the joint
  bone.join(mirrored(cone({42, -22, -72}, 4.5, {52, -20, -26}, 3.2)), 9);  // and to the front
  bone.join(mirrored(cone({46, -14, -70}, 4, {54, -8, -40}, 3.6)), 9);
}

void add_spine(Solid& bone) {
  for (int n = 0; n < 6; ++n) {
    const double z = -58 - 18.0 * n, y = 18 + 1.2 * n;
    bone.join(ellipsoid({0, y, z}, {n == 0 ? 22.0 : 14.0, 10, 8.2}), 1);                 // body
    bone.join(mirrored(cone({10, y + 4, z}, 5, {22, y + 10, z - 1}, 5)), 3);             // side
    bone.join(mirrored(cone({20, y + 11, z}, 5, {3, y + 27, z - 3}, 3)), 3);             // arch
    bone.join(cone({0, y + 26, z - 3}, 3.4, {0, y + (n == 1 ? 42 : 38), z - 8}, 4), 3);  // spine
  }
  bone.join(cone({0, 14, -72}, 6, {0, 13, -52}, 5), 2);                    // dens
  bone.join(mirrored(cone({0, -25, -112}, 2.6, {18, -2, -108}, 1.8)), 2);  // hyoid
}

// Eight teeth a side along half an ellipse, by the rational parametrisation of the circle.
void add_teeth(Solid& teeth) {
  for (int n = 0; n < 7; ++n) {
    const double t = 0.07 + 0.123 * n, across = 2 * t / (1 + t * t),
                 forward = (1 - t * t) / (1 + t * t);
    const double width = n < 5 ? 3.7 : 4.6;
    const P upper(26 * across, -54 - 36 * forward, -57),
        lower(24.5 * across, -54 - 33.5 * forward, -71);
    teeth.join(mirrored(ellipsoid(upper, {width, 3.6, 7})), 0.3);
    teeth.join(mirrored(ellipsoid(lower, {width * 0.95, 3.4, 7})), 0.3);
    teeth.join(mirrored(cone(upper + P(0, 1, 2), 2.6, upper + P(0, 3, 13), 1.4)), 0.5);
    teeth.join(mirrored(cone(lower - P(0, -1, 2), 2.4, lower - P(0, -3, 13), 1.4)), 0.5);
  }
}

void add_air(Solid& air) {
  air.join(mirrored(cone({6.5, -112, -53}, 3.6, {7, -103, -42}, 4.0)), 1);  // nostril
  air.join(mirrored(cone({7, -103, -42}, 4.0, {6.5, -86, -36}, 4.2)), 2);
  air.join(mirrored(ellipsoid({7, -60, -22}, {4.8, 31, 18})), 3);            // nasal cavity
  air.carve(mirrored(cone({11, -82, -28}, 3.2, {11, -40, -30}, 3.2)), 1.5);  // turbinates
  air.carve(mirrored(cone({11, -78, -17}, 2.6, {11, -40, -18}, 2.6)), 1.5);
  air.join(cone({0, -24, -34}, 9, {0, -12, -72}, 8), 5);  // pharynx
  air.join(cone({0, -12, -72}, 8, {0, -10, -108}, 6.5), 5);
  air.join(cone({0, -10, -108}, 6.5, {0, -14, -126}, 4.5), 4);         // larynx
  air.join(cone({0, -14, -126}, 4.5, {0, -10, -175}, 8.5), 4);         // windpipe
  air.join(ellipsoid({0, -52, -53}, {19, 30, 2.6}), 2);                // mouth
  air.join(mirrored(ellipsoid({24, -60, -32}, {7.5, 16, 11})), 0);     // maxillary sinus
  air.join(mirrored(ellipsoid({8, -81, 18}, {6, 3, 7})), 1);           // frontal sinus
  air.join(ellipsoid({0, -24, -6}, {10, 11, 8}), 0);                   // sphenoid sinus
  air.join(mirrored(cone({77, 10, -11}, 3.0, {50, 5, -11}, 2.4)), 1);  // ear canal
  air.join(mirrored(ellipsoid({54, 24, -30}, {4, 6, 9})), 0);          // mastoid cells
}

}  // namespace

HeadAnatomy::HeadAnatomy() {
  add_skull_cap_and_neck(skin);
  add_face(skin);
  add_eyes(skin);
  add_nose(skin);
  add_mouth(skin);
  add_ears(skin);

  add_skull(bone);
  carve_skull(bone);
  add_jaw(bone);
  add_spine(bone);
  add_teeth(teeth);

  brain.join(ellipsoid({0, 4, 46}, {62.5, 84, 61.5}), 0);
  brain.join(ellipsoid({0, 46, 2}, {47, 38, 31}), 14);
  brain.carve(mirrored(cone({32, -92, -1}, 24, {17, -40, 3}, 11)), 4);  // roof of the orbit
  brain.join(cone({0, 32, -20}, 9, {0, 34, -52}, 6), 6);                // brain stem
  brain.join(cone({0, 34, -52}, 6, {0, 40, -175}, 5), 2);               // spinal cord
  ventricles.join(mirrored(cone({6, -28, 42}, 4, {10, 8, 50}, 4.5)), 4);
  ventricles.join(mirrored(cone({10, 8, 50}, 4.5, {20, 40, 34}, 3.5)), 4);
  ventricles.join(ellipsoid({0, 4, 28}, {2, 12, 9}), 3);

  orbits.join(mirrored(cone({32, -84, -1}, 17, {17, -42, 3}, 5)), 0);
  eyes.join(mirrored(ball({31, -77, 0}, 12.6)), 0);
  eyes.join(mirrored(cone({29, -66, 0}, 2.2, {14, -38, 3}, 2)), 2);  // optic nerve
  add_air(air);
}

}  // namespace maille
