// Carving takes material out of a lattice and restoring puts it back, with a ball.
//
// The ball is of deformed voxel space: what a person sees under the tool. Its radius is counted in
// voxels along each axis, as a grab's is (ball_of_elements): with anisotropic voxels it is as many
// elements wide along all axes and no ball in mm. An element at a distance of exactly the radius is
// in it. A radius below 0 or any NaN takes nothing; an infinite radius takes all.
//
// cuts and lattice are of one volume. Bricks that do not change stay the same shared bricks; the
// cost is that of the bricks that the ball reaches.
#pragma once

#include "deform/cuts.h"
#include "deform/lattice.h"

namespace maille {

// The elements whose deformed place lies in the ball become carved, and all their links go, also
// those to elements outside of it.
Cuts carve(const Cuts& cuts, const Lattice& lattice, glm::dvec3 center_voxel, double radius_voxels);

// The carved elements whose deformed place lies in the ball are back, and so is every removed link
// with an end in the ball, unless its other end is still carved. Elements come back where they
// were left; links may be outside their limits then.
Cuts restore(const Cuts& cuts, const Lattice& lattice, glm::dvec3 center_voxel,
             double radius_voxels);

}  // namespace maille
