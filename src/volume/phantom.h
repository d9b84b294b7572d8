// Formula volumes ("phantoms"): the same name, size and seed give the same bits on every machine.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/parallel.h"
#include "volume/volume.h"

namespace maille {

std::span<const std::string_view> phantom_names();

// Each fills a box of fixed extent in mm, centred near the world's origin, with whatever number of
// voxels it is asked for; edges are ramps, about a voxel and a half to each side.
//
//   name       box, mm        type, values
//   hydrogen   64 x 64 x 64   uint8: |psi|^2 of the 3d orbital with m = 0, its axis along z, scaled
//                             to 0 .. 255 (the paper's Table 1: 64^3)
//   head       200x240x276    int16 HU, LPS, the face towards -y, cut through the neck at the lower
//                             z face: air -1000 (outside, sinuses, airway), fat -85, brain 6 .. 40,
//                             skin and muscle 40 .. 50, spongy bone 550, cortical bone 1150, teeth
//                             2100; noise of deviation 5 HU everywhere but in air. Chin to vertex
//                             228 mm; an ear and a nose to pull
//   endoscopy  120x120x160    int16 HU: lumen -1000 winding from the lower to the upper z face,
//                             wall with folds and polyps 45, fat -95 around; noise as in head
//   beetle     40 x 60 x 24   uint16: air 0, soft tissue about 9000, chitin 30000 .. 45000 as thin
//                             shells, hollow inside; noise of deviation 150 everywhere but in air
//   spheres    100x100x100    uint8: ball of radius 20 mm 200, very soft invisible padding up to
//                             32 mm 60, outer ball up to 44 mm 120, 0 outside (the paper's Fig. 4)
//
// hydrogen and spheres have nothing random and do not mind the seed.
// Errors: usage (unknown name, a size below 1 or beyond what memory holds).
Result<Volume> make_phantom(std::string_view name, Size3 size, std::uint64_t seed);

// The same on the workers given; how many there are changes no bit.
Result<Volume> make_phantom(std::string_view name, Size3 size, std::uint64_t seed,
                            WorkerPool& pool);

}  // namespace maille
