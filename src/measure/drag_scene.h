// Scenes to measure a drag in: a volume, its materials, what is grabbed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/result.h"
#include "measure/stroke.h"

namespace maille {

struct DragScene {
  std::string name;   // in files: small letters and underscores
  std::string title;  // for a person
  Volume volume;
  std::vector<Material> materials;
  std::vector<Grab> before;  // dragged and let go before the one that is measured
  Grab grab;

  Deformer deformer() const;
  // Plays what comes before; nothing stays pinned. Errors: as Deformer::drag_to.
  Result<void> play_before(Deformer& deformer, WorkerPool& pool) const;
};

// A material whose links give by `slack` of a voxel in every way: compress, stretch and shear. For
// voxels of one value.
Material slack_material(std::string name, int value, double slack, double stiffness);

// A volume of value 0 that costs no memory however large it is: never written, its pages are all
// the kernel's one page of zeros. Throws std::bad_alloc where not even addresses are left.
Volume empty_volume(Size3 size);

// In one material of slack 0.2 a drag by d along one axis moves an octahedron of half axis r = 5 d.
struct Octahedron {
  int half_axis = 0;  // of the furthest element that moves, in links
  std::int64_t elements() const;
  double drag_voxels() const;  // that moves just these
};
Octahedron octahedron_of(std::int64_t elements);  // the one nearest to that many

// That drag in a volume of at least 64 voxels along each axis, around the multiple of 32 below its
// middle, so that bricks are cut alike in all volumes. direction: its largest component is 1 or -1.
DragScene uniform_scene(std::string name, std::string title, Size3 size, Octahedron moved,
                        glm::dvec3 direction);
// The smallest cube for that.
Size3 volume_around(Octahedron moved);

// The same drag where one of the same length, in another direction, has been before it and beside
// it: what lies around it has moved, and not alike.
DragScene second_grab_scene(std::string name, std::string title, Octahedron moved,
                            glm::dvec3 direction);

// Blocks of 8^3 voxels of slack 0.2 and 0.004, all of which all three components of a drag have
// moved before, and all of which they move again: what takes most memory.
DragScene moved_again_scene(int edge, std::uint64_t seed);

// So many bricks in a row, of each of which one row of 32 elements moves: next to nothing to do.
DragScene single_row_scene(int bricks);

// A ball of slack 0.004 (radius a sixth of the edge) in a medium of slack 0.2, grabbed in its
// middle.
DragScene stiff_ball_scene(int edge, glm::dvec3 by_voxels);

// The materials given, of values 0, 1, 2 …, at random, one a block of block^3 voxels, grabbed in
// the middle.
DragScene random_scene(int edge, int block, std::vector<Material> materials, std::uint64_t seed,
                       glm::dvec3 by_voxels);
// Slack 0.2 and 0.004.
std::vector<Material> soft_and_stiff();
// Three that differ not only in how much they give but in which way: one order of work cannot suit
// all components of a drag.
std::vector<Material> three_tissues();

// One material of slack 0.2 along z and little to none along x and y and across: muscle, say.
DragScene anisotropic_scene(int edge, glm::dvec3 by_voxels);

// The tip of the nose of a head in Hounsfield units, two voxels inside: the skin furthest towards
// -y, where a tissue's thickness lies behind it. The volume's middle where there is none.
VoxelIndex nose_of(const Volume& head);

// The built-in head with the CT materials, its nose grabbed. Errors: as make_phantom.
Result<DragScene> head_scene(int edge, std::uint64_t seed, WorkerPool& pool);

}  // namespace maille
