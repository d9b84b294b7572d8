// The formula volumes that have a file each. What they show and their values: phantom.h.
#pragma once

#include <cstdint>

#include "core/parallel.h"
#include "volume/volume.h"

namespace maille {

Volume make_head(Size3 size, std::uint64_t seed, WorkerPool& pool);
Volume make_endoscopy(Size3 size, std::uint64_t seed, WorkerPool& pool);
Volume make_beetle(Size3 size, std::uint64_t seed, WorkerPool& pool);

}  // namespace maille
