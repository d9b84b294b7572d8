#include "app/commands.h"
#include "volume/phantom.h"
#include "volume/volume_file.h"

namespace maille {

Result<void> run_phantom(const PhantomOptions& options, const GlobalOptions& global) {
  const auto volume = make_phantom(options.name, options.size, global.seed);
  if (!volume) return volume.error();
  return write_volume(options.output, *volume);
}

}  // namespace maille
