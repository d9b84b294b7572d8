// For tests that look at every voxel and should not say the same a thousand times.
#pragma once

#include <cstdint>
#include <sstream>
#include <string>

namespace maille::testing {

// What a test finds wrong: how often, and the first.
class Faults {
 public:
  template <class... Parts>
  void add(const Parts&... parts) {
    if (count_++ == 0) (first_ << ... << parts);
  }
  std::int64_t count() const { return count_; }
  std::string first() const { return first_.str(); }

 private:
  std::int64_t count_ = 0;
  std::ostringstream first_;
};

}  // namespace maille::testing
