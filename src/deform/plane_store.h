// Where the arrays of displacement planes live when their memory has a budget: what has not been
// read for longest is put aside in a scratch file, and reading brings it back.
//
// Arrays never change, so one is written at most once, and room is made by forgetting the copy in
// memory. A reader pins an array while it reads a row: it announces itself, then looks; the store
// takes the array away, then looks whether anybody has announced themselves, and if so puts it
// back. One of the two sees the other, so reading what is in memory takes no lock.
//
// Any thread may read while another makes room. Without a budget there is no store, and planes hold
// their arrays themselves (displacement_plane.h).
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "core/aligned_array.h"
#include "core/scratch_file.h"

namespace maille {

class PlaneStore;

// The array of one plane. Belongs to a store.
class PagedArray {
 public:
  // value_bytes: 2 or 4; the array has 32^3 values. What is over budget by it is put aside at the
  // store's next hold_budget().
  PagedArray(std::shared_ptr<PlaneStore> store, AlignedArray<std::byte>&& array, int value_bytes);
  ~PagedArray();
  PagedArray(const PagedArray&) = delete;
  PagedArray& operator=(const PagedArray&) = delete;

  // The array stays in memory as long as the pin. Throws Failure (file_system), std::bad_alloc.
  class Pin {
   public:
    explicit Pin(const PagedArray& array) : array_(array), values_(array.pin()) {}
    ~Pin() { array_.pins_.fetch_sub(1, std::memory_order_release); }
    Pin(const Pin&) = delete;
    Pin& operator=(const Pin&) = delete;
    template <class T>
    const T* as() const {
      return reinterpret_cast<const T*>(values_);
    }

   private:
    const PagedArray& array_;
    const std::byte* values_;
  };

  int value_bytes() const { return value_bytes_; }
  std::int64_t bytes() const;            // whether or not in memory
  std::int64_t bytes_in_memory() const;  // now

 private:
  friend class PlaneStore;
  const std::byte* pin() const;
  void free_values(std::byte* values) const;

  std::shared_ptr<PlaneStore> store_;
  int value_bytes_;
  mutable std::atomic<std::uint32_t> pins_{0};
  mutable std::atomic<std::byte*> values_;  // owned; null: put aside
  mutable std::atomic<std::uint64_t> last_read_{0};
  // The store's, under its mutex.
  mutable std::optional<ScratchFile::Slot> slot_;
  mutable std::size_t place_ = 0;  // among those in memory
  mutable bool wanted_ = true;
};

struct PlaneStoreCounters {
  std::int64_t bytes_in_memory = 0;
  std::int64_t peak_bytes_in_memory = 0;  // pinned ones included
  std::int64_t planes_written = 0;
  std::int64_t bytes_written = 0;
  std::int64_t planes_read = 0;
  std::int64_t scratch_file_bytes = 0;  // that it has grown to
};

class PlaneStore {
 public:
  explicit PlaneStore(std::int64_t budget_bytes) : budget_bytes_(budget_bytes) {}
  ~PlaneStore() = default;
  PlaneStore(const PlaneStore&) = delete;
  PlaneStore& operator=(const PlaneStore&) = delete;

  std::int64_t budget_bytes() const { return budget_bytes_; }
  // Puts arrays aside until the budget holds but for pinned ones. Throws Failure (file_system):
  // what could not be put aside stays in memory.
  void hold_budget();
  // Arrays that nobody wants to see now go first.
  void set_wanted(std::span<const PagedArray* const> arrays, bool wanted);

  PlaneStoreCounters counters() const;

 private:
  friend class PagedArray;
  void take_in(const PagedArray& array);
  void forget(const PagedArray& array);
  const std::byte* bring_back(const PagedArray& array);
  void make_room(std::int64_t bytes);
  bool put_aside(const PagedArray& array);  // false: it is being read
  void leave_memory(const PagedArray& array);
  void enter_memory(const PagedArray& array, AlignedArray<std::byte> values);

  const std::int64_t budget_bytes_;
  std::atomic<std::uint64_t> clock_{1};  // counts changes of what is in memory
  mutable std::mutex mutex_;             // what follows
  std::optional<ScratchFile> file_;      // made when first needed
  std::vector<const PagedArray*> in_memory_;
  PlaneStoreCounters counters_;
};

}  // namespace maille
