#include "app/run_options.h"

namespace maille {

HeadlessOptions headless_options(const std::string& command, const GlobalOptions& global) {
  HeadlessOptions options;
  options.document.command = command;
  options.document.threads = global.threads;
  options.document.deterministic = global.deterministic;
  options.document.undo_memory_bytes = global.undo_memory_bytes;
  options.document.lattice_memory_bytes = global.lattice_memory_bytes;
  options.quiet = global.quiet;
  options.verbose = global.verbose;
  return options;
}

ViewOptions view_options(PictureSize size, const GlobalOptions& global) {
  ViewOptions options;
  options.renderer.device = global.device;
  options.renderer.store = global.store;
#ifdef MAILLE_VALIDATION
  options.renderer.print_validation = true;  // what is said while everything is taken down too
#endif
  options.size = size;
  return options;
}

}  // namespace maille
