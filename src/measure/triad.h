// The memory bandwidth of the machine, measured where it is asked for: the bound that other speeds
// are compared with.
#pragma once

namespace maille {

// a[i] = b[i] + s * c[i] over arrays well beyond the caches, 24 bytes an i, the best of a few
// rounds on `threads` threads; takes about a tenth of a second.
double measure_triad_gb_per_s(int threads);

}  // namespace maille
