#include "core/trace.h"

#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <vector>

#include "core/atomic_file.h"

namespace maille::trace {
namespace {

struct Event {
  std::string track;
  std::string name;
  std::int64_t begin_ns;
  std::int64_t end_ns;
};

struct Recorder {
  std::mutex mutex;
  std::vector<Event> events;
};

Recorder& recorder() {
  static Recorder instance;
  return instance;
}

std::atomic<bool> is_running{false};
thread_local std::string thread_name = "main";

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) out += c;
  }
  return out;
}

}  // namespace

void start() { is_running.store(true, std::memory_order_relaxed); }

bool running() { return is_running.load(std::memory_order_relaxed); }

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void name_this_thread(std::string name) { thread_name = std::move(name); }

void add_span(std::string track, std::string name, std::int64_t begin_ns, std::int64_t end_ns) {
  if (!running()) return;
  Recorder& r = recorder();
  std::lock_guard lock(r.mutex);
  r.events.push_back({std::move(track), std::move(name), begin_ns, end_ns});
}

Span::~Span() {
  if (begin_ns_ >= 0) add_span(thread_name, name_, begin_ns_, now_ns());
}

Result<void> write(const std::filesystem::path& path) {
  std::string json = "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n";
  {
    Recorder& r = recorder();
    std::lock_guard lock(r.mutex);
    std::map<std::string, int> track_ids;
    bool first = true;
    const auto separate = [&] {
      if (!first) json += ",\n";
      first = false;
    };
    for (const Event& event : r.events) {
      const auto [track, is_new] =
          track_ids.try_emplace(event.track, static_cast<int>(track_ids.size()) + 1);
      const std::string tid = std::to_string(track->second);
      if (is_new) {
        separate();
        json += R"({"ph":"M","pid":1,"tid":)" + tid + R"(,"name":"thread_name","args":{"name":")" +
                escaped(event.track) + "\"}}";
      }
      separate();
      json += R"({"ph":"X","pid":1,"tid":)" + tid + R"(,"name":")" + escaped(event.name) +
              R"(","ts":)" + std::to_string(static_cast<double>(event.begin_ns) / 1000.0) +
              R"(,"dur":)" +
              std::to_string(static_cast<double>(event.end_ns - event.begin_ns) / 1000.0) + "}";
    }
  }
  json += "\n]}\n";
  return write_text_file(path, json);
}

}  // namespace maille::trace
