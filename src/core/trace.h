// Spans of time, for `--trace FILE`: Chrome/Perfetto trace JSON of what every thread and the GPU
// did.
//
// Off until start() is called; an idle Span then costs one relaxed load. The recorder is one for
// the process, because a span must not need a pointer handed through every call.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/result.h"

namespace maille::trace {

void start();
bool running();

// Nanoseconds on the process's steady clock; GPU timestamps are put on this line by whoever
// calibrates them.
std::int64_t now_ns();

void name_this_thread(std::string name);

// A span of a track that is no thread of ours ("gpu graphics queue").
void add_span(std::string track, std::string name, std::int64_t begin_ns, std::int64_t end_ns);

// The time from construction to destruction, on the calling thread's track. name must outlive the
// recorder: a literal.
class Span {
 public:
  explicit Span(const char* name) : name_(name), begin_ns_(running() ? now_ns() : -1) {}
  ~Span();
  Span(const Span&) = delete;
  Span& operator=(const Span&) = delete;

 private:
  const char* name_;
  std::int64_t begin_ns_;
};

// Writes everything recorded so far. Errors: file_system.
Result<void> write(const std::filesystem::path& path);

}  // namespace maille::trace
