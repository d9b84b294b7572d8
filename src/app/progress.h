// One line on stderr that says how far a run has come, overwritten in place; nothing at all when
// stderr is no terminal.
#pragma once

#include <string>

namespace maille {

class Progress {
 public:
  explicit Progress(bool wanted);
  ~Progress();  // leaves no line behind
  Progress(Progress&& other) noexcept;
  Progress& operator=(Progress&&) = delete;

  void show(const std::string& line);
  void clear();

 private:
  bool active_;
  bool line_is_there_ = false;
};

}  // namespace maille
