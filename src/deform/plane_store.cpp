#include "deform/plane_store.h"

#include <algorithm>
#include <utility>

#include "core/failure.h"
#include "deform/plane_codec.h"
#include "volume/brick.h"

namespace maille {

PagedArray::PagedArray(std::shared_ptr<PlaneStore> store, AlignedArray<std::byte>&& array,
                       int value_bytes)
    : store_(std::move(store)), value_bytes_(value_bytes), values_(array.get()) {
  store_->take_in(*this);
  array.release();
}

PagedArray::~PagedArray() {
  store_->forget(*this);
  if (std::byte* const values = values_.load()) free_values(values);
}

void PagedArray::free_values(std::byte* values) const {
  AlignedDelete{static_cast<std::size_t>(bytes())}(values);
}

std::int64_t PagedArray::bytes() const { return std::int64_t{kBrickVoxels} * value_bytes_; }

std::int64_t PagedArray::bytes_in_memory() const {
  return values_.load(std::memory_order_relaxed) ? bytes() : 0;
}

const std::byte* PagedArray::pin() const {
  // Sequentially consistent, both here and in put_aside(): see the top of plane_store.h.
  pins_.fetch_add(1);
  const std::byte* values = values_.load();
  if (!values) {
    try {
      values = store_->bring_back(*this);
    } catch (...) {
      pins_.fetch_sub(1);
      throw;
    }
  }
  const auto now = store_->clock_.load(std::memory_order_relaxed);
  if (last_read_.load(std::memory_order_relaxed) != now) {
    last_read_.store(now, std::memory_order_relaxed);
  }
  return values;
}

void PlaneStore::take_in(const PagedArray& array) {
  const std::lock_guard lock(mutex_);
  array.last_read_ = clock_.load();
  array.place_ = in_memory_.size();
  in_memory_.push_back(&array);
  counters_.bytes_in_memory += array.bytes();
}

void PlaneStore::forget(const PagedArray& array) {
  const std::lock_guard lock(mutex_);
  if (array.values_.load()) leave_memory(array);
  if (array.slot_) file_->free(*array.slot_);
}

void PlaneStore::leave_memory(const PagedArray& array) {
  in_memory_[array.place_] = in_memory_.back();
  in_memory_[array.place_]->place_ = array.place_;
  in_memory_.pop_back();
  counters_.bytes_in_memory -= array.bytes();
}

void PlaneStore::enter_memory(const PagedArray& array, AlignedArray<std::byte> values) {
  array.place_ = in_memory_.size();
  in_memory_.push_back(&array);
  counters_.bytes_in_memory += array.bytes();
  counters_.peak_bytes_in_memory =
      std::max(counters_.peak_bytes_in_memory, counters_.bytes_in_memory);
  array.values_ = values.release();
  ++clock_;
}

const std::byte* PlaneStore::bring_back(const PagedArray& array) {
  const std::lock_guard lock(mutex_);
  if (const std::byte* values = array.values_.load()) return values;
  make_room(array.bytes());
  std::vector<std::byte> packed(static_cast<std::size_t>(array.slot_->bytes));
  if (auto read = file_->read(*array.slot_, packed); !read) throw Failure(read.error());
  const auto count = static_cast<std::size_t>(array.bytes());
  auto values = make_aligned_array<std::byte>(count);
  if (!unpack_plane(packed, {values.get(), count}, array.value_bytes_)) {
    throw Failure({ErrorKind::file_system, "the scratch file gave back other bytes than written"});
  }
  ++counters_.planes_read;
  enter_memory(array, std::move(values));
  return array.values_.load();
}

bool PlaneStore::put_aside(const PagedArray& array) {
  if (array.pins_.load() != 0) return false;
  std::byte* const values = array.values_.load();
  if (!array.slot_) {
    if (!file_) {
      auto created = ScratchFile::create();
      if (!created) throw Failure(created.error());
      file_.emplace(*std::move(created));
    }
    const auto packed =
        pack_plane({values, static_cast<std::size_t>(array.bytes())}, array.value_bytes_);
    const auto slot = file_->write(packed);
    if (!slot) throw Failure(slot.error());
    array.slot_ = *slot;
    ++counters_.planes_written;
    counters_.bytes_written += slot->bytes;
    counters_.scratch_file_bytes = std::max(counters_.scratch_file_bytes, file_->size_bytes());
  }
  array.values_ = nullptr;
  if (array.pins_.load() != 0) {
    // Somebody came meanwhile, and may have seen it before it went.
    array.values_ = values;
    return false;
  }
  array.free_values(values);
  leave_memory(array);
  return true;
}

void PlaneStore::make_room(std::int64_t bytes) {
  if (counters_.bytes_in_memory + bytes <= budget_bytes_) return;
  ++clock_;
  // A little more than needed, or the next row that is read sorts again.
  const std::int64_t target = budget_bytes_ - bytes - budget_bytes_ / 8;
  struct Candidate {
    bool wanted;
    std::uint64_t last_read;
    const PagedArray* array;
  };
  std::vector<Candidate> candidates;
  candidates.reserve(in_memory_.size());
  for (const PagedArray* array : in_memory_) {
    candidates.push_back({array->wanted_, array->last_read_.load(), array});
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::pair(a.wanted, a.last_read) < std::pair(b.wanted, b.last_read);
  });
  for (const Candidate& candidate : candidates) {
    if (counters_.bytes_in_memory <= target) break;
    put_aside(*candidate.array);
  }
}

void PlaneStore::hold_budget() {
  const std::lock_guard lock(mutex_);
  make_room(0);
  counters_.peak_bytes_in_memory =
      std::max(counters_.peak_bytes_in_memory, counters_.bytes_in_memory);
}

void PlaneStore::set_wanted(std::span<const PagedArray* const> arrays, bool wanted) {
  const std::lock_guard lock(mutex_);
  for (const PagedArray* array : arrays) array->wanted_ = wanted;
}

PlaneStoreCounters PlaneStore::counters() const {
  const std::lock_guard lock(mutex_);
  return counters_;
}

}  // namespace maille
