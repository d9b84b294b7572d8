// One thread drags, edits materials, cuts, carves, relaxes and undoes, as the simulation thread
// does; others read the states it has handed over meanwhile. Made for the thread sanitizer, and
// worth running without it: whatever a reader sees is a state that was published, to the bit, and
// the session comes to the same bits as without readers.
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "deform/carving.h"
#include "deform/deformer.h"
#include "deform/violations.h"
#include "tests/deform/scenes.h"

namespace maille {
namespace {

using testing::material;
using testing::random_volume;
using testing::table;

constexpr Size3 kSize{66, 40, 20};
constexpr std::int64_t kPlaneBytes = kBrickVoxels * 2;
// The present state fits, all of its bricks moved along all axes; the steps behind it do not.
constexpr std::int64_t kBudget = 3 * 6 * kPlaneBytes;
constexpr int kReaders = 2;

class Hash {
 public:
  void mix(std::uint64_t value) { hash_ = (hash_ ^ value) * 1099511628211u; }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 14695981039346656037u;
};

std::uint64_t hash_of_brick(const Lattice& lattice, std::int64_t linear) {
  const LatticeBrick* brick = lattice.brick(linear);
  Hash hash;
  if (!brick) return hash.value();
  const Size3 extent = lattice.grid().box(lattice.grid().brick(linear)).size();
  for (int c = 0; c < 3; ++c) {
    for (int z = 0; z < extent.z; ++z) {
      for (int y = 0; y < extent.y; ++y) {
        std::int32_t u[kBrickEdge];
        brick->read_row(c, (z * kBrickEdge + y) * kBrickEdge, kBrickEdge, u);
        for (int x = 0; x < extent.x; ++x) hash.mix(static_cast<std::uint32_t>(u[x]));
      }
    }
  }
  return hash.value();
}

std::uint64_t hash_of(const Cuts& cuts) {
  Hash hash;
  cuts.for_each_brick([&](std::int64_t linear, const CutBrick& brick) {
    hash.mix(static_cast<std::uint64_t>(linear));
    for (const CutBrick::Rows& rows : brick.removed) {
      for (const std::uint32_t row : rows) hash.mix(row);
    }
    for (const std::uint32_t row : brick.carved) hash.mix(row);
  });
  return hash.value();
}

// A state as it is handed over: a copy of pointers, and what its reader must find in it.
struct State {
  Lattice lattice;
  Cuts cuts;
  std::shared_ptr<const MaterialField> materials;
  std::uint64_t hash = 0;
  std::int64_t violated_links = 0;
  std::int64_t carved_links = 0;  // by the ball that readers take out of their copy
};

std::uint64_t hash_of(const State& state, WorkerPool& pool) {
  const std::int64_t count = state.lattice.grid().count();
  std::vector<std::uint64_t> of_bricks(static_cast<std::size_t>(count));
  pool.for_each(count, [&](std::int64_t b, int) {
    of_bricks[static_cast<std::size_t>(b)] = hash_of_brick(state.lattice, b);
  });
  Hash hash;
  for (const std::uint64_t h : of_bricks) hash.mix(h);
  hash.mix(hash_of(state.cuts));
  return hash.value();
}

std::int64_t violated_links(const State& state) {
  return violations_of(state.lattice, *state.materials, state.cuts).links;
}

std::int64_t carved_elsewhere(const State& state) {
  const Cuts carved = carve(state.cuts, state.lattice, {33, 31, 10}, 5);
  std::int64_t bits = 0;
  carved.for_each_brick([&](std::int64_t, const CutBrick& brick) {
    for (const std::uint32_t row : brick.carved) bits += __builtin_popcount(row);
  });
  return bits;
}

// The latest state, taken whole.
class Mailbox {
 public:
  void put(std::shared_ptr<const State> state) {
    const std::lock_guard lock(mutex_);
    latest_ = std::move(state);
  }
  State take_copy() const {
    const std::lock_guard lock(mutex_);
    return *latest_;
  }

 private:
  mutable std::mutex mutex_;
  std::shared_ptr<const State> latest_;
};

MaterialTable table_of_shear(double shear) {
  return table(
      {material(0, 1, 0.5, 1.5, shear), material(1, 2, 0.9, 1.2, 0.4), material(2, 3, 1, 1, 0)});
}

// A random session; every state it comes by is published before the next action.
class Session {
 public:
  Session(unsigned seed, std::optional<std::int64_t> budget, WorkerPool& pool)
      : random_(seed),
        pool_(pool),
        deformer_(random_volume(kSize, 3, 8, 5), table_of_shear(0.2), {},
                  {.undo_memory_bytes = std::int64_t{1} << 30, .lattice_memory_bytes = budget}) {
    publish();
  }

  void act() {
    const glm::dvec3 place(random_voxel());
    switch (below(12)) {
      case 0:
        EXPECT_TRUE(deformer_.set_materials(table_of_shear(0.05 + 0.01 * below(40))).ok());
        break;
      case 1: EXPECT_TRUE(deformer_.carve(place, 3).ok()); break;
      case 2: EXPECT_TRUE(deformer_.restore(place, 12).ok()); break;
      case 3: {
        const glm::dvec3 path[] = {place - 8.3, place + glm::dvec3(9.1, 7.3, 6.7)};
        auto blade = CutSurface::sweep(path, {0, 3, 14});
        ASSERT_TRUE(blade.ok());
        EXPECT_TRUE(deformer_.cut(*blade).ok());
        break;
      }
      case 4: {
        Relaxation relaxation = deformer_.relax(pool_, {});
        for (int n = 0; n < 2; ++n) {
          relaxation.iterate();
          deformer_.adopt(relaxation.lattice());
          publish();
        }
        break;
      }
      case 5: deformer_.release_all(); break;
      case 6:
      case 7: static_cast<void>(deformer_.undo()); break;
      case 8: static_cast<void>(deformer_.redo()); break;
      default: drag();
    }
    publish();
  }

  void undo_all() {
    while (deformer_.undo()) publish();
    EXPECT_TRUE(deformer_.lattice().at_rest());
    EXPECT_TRUE(deformer_.cuts().empty());
  }

  const Mailbox& mailbox() const { return mailbox_; }
  const std::vector<std::uint64_t>& hashes() const { return hashes_; }
  const Deformer& deformer() const { return deformer_; }

 private:
  void drag() {
    // Carved away altogether: there is nothing to drag.
    if (!deformer_.begin_stroke(random_voxel(), 2).ok()) return;
    const auto far = [&] { return below(90) / 10.0 - 4.5; };
    const glm::dvec3 by(far(), far(), far());
    for (const double share : {0.5, 1.0, -0.5}) {
      const auto report = deformer_.drag_to(by * share, pool_);
      EXPECT_TRUE(report.ok()) << (report.ok() ? "" : report.error().message);
      publish();
    }
    below(4) == 0 ? deformer_.cancel_stroke() : deformer_.end_stroke();
  }

  void publish() {
    auto state = std::make_shared<State>(
        State{deformer_.lattice(), deformer_.cuts(),
              std::make_shared<const MaterialField>(deformer_.materials())});
    state->hash = hash_of(*state, pool_);
    state->violated_links = violated_links(*state);
    state->carved_links = carved_elsewhere(*state);
    hashes_.push_back(state->hash);
    mailbox_.put(std::move(state));
  }

  int below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  VoxelIndex random_voxel() { return {below(kSize.x), below(kSize.y), below(kSize.z)}; }

  std::mt19937 random_;
  WorkerPool& pool_;
  Deformer deformer_;
  Mailbox mailbox_;
  std::vector<std::uint64_t> hashes_;
};

struct Reader {
  int read = 0;
  int wrong = 0;
};

// Reads the latest state and goes back to old ones, which undo may have put aside by then.
Reader read_on(const Mailbox& mailbox, WorkerPool& shared_pool, const std::atomic<bool>& is_over,
               unsigned seed) {
  std::mt19937 random(seed);
  WorkerPool own_pool(2);
  Reader reader;
  std::vector<State> kept;
  while (!is_over || reader.read < 8) {
    kept.push_back(mailbox.take_copy());
    if (kept.size() > 6) kept.erase(kept.begin() + static_cast<long>(random() % 6));
    const State state = kept[random() % kept.size()];
    WorkerPool& pool = random() % 4 == 0 ? shared_pool : own_pool;
    reader.wrong += hash_of(state, pool) != state.hash;
    reader.wrong += violated_links(state) != state.violated_links;
    reader.wrong += carved_elsewhere(state) != state.carved_links;
    ++reader.read;
  }
  return reader;
}

class Concurrency : public ::testing::TestWithParam<std::optional<std::int64_t>> {};

TEST_P(Concurrency, ReadersSeePublishedStatesOnly) {
  constexpr int kActions = 16;
  constexpr unsigned kSeed = 71;
  WorkerPool pool(3);
  Session session(kSeed, GetParam(), pool);
  std::atomic<bool> is_over{false};
  std::vector<Reader> readers(kReaders);
  {
    std::vector<std::jthread> threads;
    for (unsigned r = 0; r < kReaders; ++r) {
      threads.emplace_back(
          [&, r] { readers[r] = read_on(session.mailbox(), pool, is_over, kSeed + r); });
    }
    for (int n = 0; n < kActions; ++n) session.act();
    session.undo_all();
    is_over = true;
  }
  for (const Reader& reader : readers) {
    EXPECT_EQ(reader.wrong, 0);
    EXPECT_GE(reader.read, 8);
  }
  if (const LatticeMemory* memory = session.deformer().memory()) {
    EXPECT_GT(memory->store().counters().planes_read, 0);
  }
  // Alone, in one thread and without a budget.
  WorkerPool one(1);
  Session alone(kSeed, std::nullopt, one);
  for (int n = 0; n < kActions; ++n) alone.act();
  alone.undo_all();
  EXPECT_EQ(session.hashes(), alone.hashes());
  const std::set<std::uint64_t> different(alone.hashes().begin(), alone.hashes().end());
  EXPECT_GT(different.size(), 10u);
}

INSTANTIATE_TEST_SUITE_P(Memory, Concurrency,
                         ::testing::Values(std::optional<std::int64_t>(),
                                           std::optional<std::int64_t>(kBudget)));

}  // namespace
}  // namespace maille
