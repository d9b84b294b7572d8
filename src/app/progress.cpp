#include "app/progress.h"

#include <cstdio>
#include <utility>

#include <unistd.h>

namespace maille {

Progress::Progress(bool wanted) : active_(wanted && isatty(STDERR_FILENO) == 1) {}

Progress::Progress(Progress&& other) noexcept
    : active_(other.active_), line_is_there_(std::exchange(other.line_is_there_, false)) {}

Progress::~Progress() { clear(); }

void Progress::show(const std::string& line) {
  if (!active_) return;
  std::fprintf(stderr, "\r%s\033[K", line.c_str());
  std::fflush(stderr);
  line_is_there_ = true;
}

void Progress::clear() {
  if (!std::exchange(line_is_there_, false)) return;
  std::fputs("\r\033[K", stderr);
  std::fflush(stderr);
}

}  // namespace maille
