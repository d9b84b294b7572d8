// Compiled once for each kind of machine, inside a namespace and for a target of its own: see
// brick_closure.cpp. Rows is a row of 32 labels: load, store, subtract (saturating at 0), add
// (saturating), greater of two, any greater, and shifts by lanes.

// A row in an array, in loops that the compiler turns into whatever vectors its target has. Shifts
// go through memory: no instruction of any width in lanes would do for all.
template <class L>
struct ArrayRows {
  struct Row {
    alignas(64) L lane[kBrickEdge];
  };
  using Lanes = Row;

  static Row load(const L* from) {
    Row row;
    __builtin_memcpy(row.lane, from, sizeof row.lane);
    return row;
  }
  static void store(L* to, const Row& row) { __builtin_memcpy(to, row.lane, sizeof row.lane); }
  static Row splat(L value) {
    Row row;
    for (L& lane : row.lane) lane = value;
    return row;
  }
  static Row subtract(const Row& a, const Row& b) {
    Row row;
    for (int x = 0; x < kBrickEdge; ++x) {
      row.lane[x] = static_cast<L>((a.lane[x] > b.lane[x] ? a.lane[x] : b.lane[x]) - b.lane[x]);
    }
    return row;
  }
  static Row add(const Row& a, const Row& b) {
    Row row;
    for (int x = 0; x < kBrickEdge; ++x) {
      const L sum = static_cast<L>(a.lane[x] + b.lane[x]);
      row.lane[x] = sum < a.lane[x] ? static_cast<L>(~L{0}) : sum;
    }
    return row;
  }
  static Row greater(const Row& a, const Row& b) {
    Row row;
    for (int x = 0; x < kBrickEdge; ++x) {
      row.lane[x] = a.lane[x] > b.lane[x] ? a.lane[x] : b.lane[x];
    }
    return row;
  }
  static Row lesser(const Row& a, const Row& b) {
    Row row;
    for (int x = 0; x < kBrickEdge; ++x) {
      row.lane[x] = a.lane[x] < b.lane[x] ? a.lane[x] : b.lane[x];
    }
    return row;
  }
  static std::uint32_t nonzero(const Row& a) {
    std::uint32_t bits = 0;
    for (std::uint32_t x = 0; x < kBrickEdge; ++x) bits |= std::uint32_t{a.lane[x] != 0} << x;
    return bits;
  }
  static bool any_greater(const Row& a, const Row& b) {
    L any = 0;
    for (int x = 0; x < kBrickEdge; ++x) {
      any = static_cast<L>(any | (a.lane[x] > b.lane[x] ? L{1} : L{0}));
    }
    return any != 0;
  }
  template <int k>
  static Row shift_up(const Row& a) {
    Row row{};
    __builtin_memcpy(row.lane + k, a.lane, (kBrickEdge - k) * sizeof(L));
    return row;
  }
  template <int k>
  static Row shift_down(const Row& a) {
    Row row{};
    __builtin_memcpy(row.lane, a.lane + k, (kBrickEdge - k) * sizeof(L));
    return row;
  }
  static Lanes first_lanes(int count) {
    Row row{};
    for (int x = 0; x < count; ++x) row.lane[x] = static_cast<L>(~L{0});
    return row;
  }
  static Row mask(const Row& a, const Lanes& lanes) {
    Row row;
    for (int x = 0; x < kBrickEdge; ++x) row.lane[x] = static_cast<L>(a.lane[x] & lanes.lane[x]);
    return row;
  }
};

// What closes a row along x: a prefix scan of 5 doubling steps each way.
template <class Rows, int k>
inline typename Rows::Row scan_up_from(typename Rows::Row d, typename Rows::Row slack) {
  if constexpr (k == 32) {
    return d;
  } else {
    d = Rows::greater(d, Rows::subtract(Rows::template shift_up<k>(d), slack));
    return scan_up_from<Rows, 2 * k>(d, Rows::add(slack, Rows::template shift_up<k>(slack)));
  }
}
template <class Rows, int k>
inline typename Rows::Row scan_down_from(typename Rows::Row d, typename Rows::Row slack) {
  if constexpr (k == 32) {
    return d;
  } else {
    d = Rows::greater(d, Rows::subtract(Rows::template shift_down<k>(d), slack));
    return scan_down_from<Rows, 2 * k>(d, Rows::add(slack, Rows::template shift_down<k>(slack)));
  }
}

// One slack an axis and direction.
template <class Rows, class L>
class UniformLinks {
 public:
  using Row = typename Rows::Row;
  // The closure of a row stays closed under the pushes of closed rows beside it, so that only rows
  // that something has pushed into from outside need a scan.
  static constexpr bool kScanAll = false;

  explicit UniformLinks(const BrickSlack<L>& slack) {
    for (int axis = 1; axis < 3; ++axis) {
      up_[axis - 1] = Rows::splat(slack.uniform_up(axis));
      down_[axis - 1] = Rows::splat(slack.uniform_down(axis));
    }
    along_up_ = Rows::splat(slack.uniform_up(0));
    along_down_ = Rows::splat(slack.uniform_down(0));
  }
  void prepare(int, int) const {}
  Row up(int axis, int) const { return up_[axis - 1]; }
  Row down(int axis, int) const { return down_[axis - 1]; }
  Row scan(Row d, int) const { return scan_down<1>(scan_up<1>(d, along_up_), along_down_); }

 private:
  template <int k>
  Row scan_up(Row d, Row slack) const {
    if constexpr (k == 32) {
      return d;
    } else {
      d = Rows::greater(d, Rows::subtract(Rows::template shift_up<k>(d), slack));
      return scan_up<2 * k>(d, Rows::add(slack, slack));
    }
  }
  template <int k>
  Row scan_down(Row d, Row slack) const {
    if constexpr (k == 32) {
      return d;
    } else {
      d = Rows::greater(d, Rows::subtract(Rows::template shift_down<k>(d), slack));
      return scan_down<2 * k>(d, Rows::add(slack, slack));
    }
  }

  Row up_[2];
  Row down_[2];
  Row along_up_;
  Row along_down_;
};

// A slack of its own for every link.
template <class Rows, class L>
class VaryingLinks {
 public:
  using Row = typename Rows::Row;
  static constexpr bool kScanAll = true;

  explicit VaryingLinks(BrickSlack<L>& slack) : slack_(slack) {}
  void prepare(int y, int z) {
    slack_.prepare(y, z);
    if (y > 0) slack_.prepare(y - 1, z);
    if (z > 0) slack_.prepare(y, z - 1);
  }
  Row up(int axis, int row) const { return Rows::load(slack_.up(axis, row)); }
  Row down(int axis, int row) const { return Rows::load(slack_.down(axis, row)); }
  Row scan(Row d, int row) const {
    // Link x runs from lane x to lane x + 1: what comes into a lane from below is one lane up.
    const Row from_below = Rows::template shift_up<1>(up(0, row));
    d = scan_up_from<Rows, 1>(d, from_below);
    return scan_down_from<Rows, 1>(d, down(0, row));
  }

 private:
  BrickSlack<L>& slack_;
};

template <class Rows, class L, class Links>
class Closure {
 public:
  using Row = typename Rows::Row;

  Closure(L* labels, Size3 extent, Links& links, DirtyRows& dirty, DirtyRows& reached)
      : labels_(labels),
        extent_(extent),
        links_(links),
        dirty_(dirty),
        reached_(reached),
        unscanned_(dirty),
        in_volume_(Rows::first_lanes(extent.x)) {}

  void run() {
    for (bool forward = true, any = true; any; forward = !forward) {
      any = false;
      for (int i = 0; i < extent_.z; ++i) {
        const int z = forward ? i : extent_.z - 1 - i;
        while (dirty_.rows[static_cast<std::size_t>(z)] != 0) {
          any = true;
          ascend(z);
          descend(z);
        }
      }
    }
  }

 private:
  void ascend(int z) {
    std::uint32_t& dirty = dirty_.rows[static_cast<std::size_t>(z)];
    std::uint32_t ahead = ~std::uint32_t{0};
    while ((dirty & ahead) != 0) {
      const int y = __builtin_ctz(dirty & ahead);
      ahead = y == 31 ? 0 : ~std::uint32_t{0} << (y + 1);
      pass_on(y, z);
    }
  }
  void descend(int z) {
    std::uint32_t& dirty = dirty_.rows[static_cast<std::size_t>(z)];
    std::uint32_t ahead = ~std::uint32_t{0};
    while ((dirty & ahead) != 0) {
      const int y = 31 - __builtin_clz(dirty & ahead);
      ahead = (std::uint32_t{1} << y) - 1;
      pass_on(y, z);
    }
  }

  void pass_on(int y, int z) {
    const auto plane = static_cast<std::size_t>(z);
    const std::uint32_t bit = std::uint32_t{1} << y;
    const int row = z * kBrickEdge + y;
    dirty_.rows[plane] &= ~bit;
    reached_.rows[plane] |= bit;
    links_.prepare(y, z);
    L* const here = labels_ + static_cast<std::size_t>(row) * kBrickEdge;
    Row d = Rows::load(here);
    if (Links::kScanAll || (unscanned_.rows[plane] & bit)) {
      unscanned_.rows[plane] &= ~bit;
      d = Rows::mask(links_.scan(d, row), in_volume_);
      Rows::store(here, d);
    }
    if (y + 1 < extent_.y) push(here + kRow, Rows::subtract(d, links_.up(1, row)), y + 1, z);
    if (y > 0) push(here - kRow, Rows::subtract(d, links_.down(1, row - 1)), y - 1, z);
    if (z + 1 < extent_.z) push(here + kPlane, Rows::subtract(d, links_.up(2, row)), y, z + 1);
    if (z > 0) push(here - kPlane, Rows::subtract(d, links_.down(2, row - kBrickEdge)), y, z - 1);
  }

  void push(L* there, Row pushed, int y, int z) {
    const Row d = Rows::load(there);
    if (!Rows::any_greater(pushed, d)) return;
    Rows::store(there, Rows::greater(pushed, d));
    dirty_.mark(y, z);
  }

  static constexpr int kRow = kBrickEdge;
  static constexpr int kPlane = kBrickEdge * kBrickEdge;

  L* labels_;
  Size3 extent_;
  Links& links_;
  DirtyRows& dirty_;
  DirtyRows& reached_;
  DirtyRows unscanned_;
  typename Rows::Lanes in_volume_;
};

template <class Rows, class L>
inline void close_with(L* labels, Size3 extent, BrickSlack<L>& slack, DirtyRows& dirty,
                       DirtyRows& reached) {
  if (slack.uniform()) {
    UniformLinks<Rows, L> links(slack);
    Closure<Rows, L, UniformLinks<Rows, L>>(labels, extent, links, dirty, reached).run();
  } else {
    VaryingLinks<Rows, L> links(slack);
    Closure<Rows, L, VaryingLinks<Rows, L>>(labels, extent, links, dirty, reached).run();
  }
}

template <class Rows, class L>
inline MovedLabels<L> lower_with(L* labels, Size3 extent, const DirtyRows& reached, L overshoot,
                                 std::uint32_t* moved_rows) {
  using Row = typename Rows::Row;
  const Row by = Rows::splat(overshoot);
  Row lowest = Rows::splat(static_cast<L>(~L{0}));
  Row highest = Rows::splat(0);
  MovedLabels<L> found;
  std::uint32_t lanes = 0;
  int rows_seen = 0;
  for (int z = 0; z < extent.z; ++z) {
    std::uint32_t moved_y = 0;
    for (std::uint32_t rows = reached.rows[static_cast<std::size_t>(z)]; rows != 0;
         rows &= rows - 1) {
      const int y = __builtin_ctz(rows);
      const int row = z * kBrickEdge + y;
      L* const here = labels + row * kBrickEdge;
      Row d = Rows::load(here);
      if (overshoot != 0) {
        d = Rows::subtract(d, by);
        Rows::store(here, d);
      }
      lowest = Rows::lesser(lowest, d);
      highest = Rows::greater(highest, d);
      ++rows_seen;
      const std::uint32_t moved = Rows::nonzero(d);
      if (moved == 0) continue;
      lanes |= moved;
      moved_y |= std::uint32_t{1} << y;
      std::uint32_t fresh = moved;
      if (moved_rows) {
        fresh &= ~moved_rows[row];
        moved_rows[row] |= moved;
      }
      found.newly_moved += __builtin_popcount(fresh);
    }
    if (moved_y == 0) continue;
    found.box.lo = glm::min(found.box.lo, VoxelIndex(0, __builtin_ctz(moved_y), z));
    found.box.hi = glm::max(found.box.hi, VoxelIndex(0, 32 - __builtin_clz(moved_y), z + 1));
  }
  if (lanes == 0) return found;
  found.any = true;
  found.box.lo.x = __builtin_ctz(lanes);
  found.box.hi.x = 32 - __builtin_clz(lanes);
  alignas(64) L low[kBrickEdge];
  alignas(64) L high[kBrickEdge];
  Rows::store(low, lowest);
  Rows::store(high, highest);
  found.lowest = rows_seen < extent.y * extent.z ? L{0} : low[0];
  for (int x = 0; x < extent.x; ++x) {
    if (low[x] < found.lowest) found.lowest = low[x];
    if (high[x] > found.highest) found.highest = high[x];
  }
  return found;
}
