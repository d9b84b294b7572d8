#include "app/commands.h"
#include "app/paths.h"
#include "volume/phantom.h"
#include "volume/volume_file.h"

namespace maille {

Result<void> run_phantom(const PhantomOptions& options, const GlobalOptions& global) {
  if (auto checked = check_outputs({{OutputKind::volume, "--output", options.output}}); !checked) {
    return checked;
  }
  const auto volume = make_phantom(options.name, options.size, global.seed);
  if (!volume) return volume.error();
  return write_volume(options.output, *volume);
}

}  // namespace maille
