// Lines of 32 labels, a label an element: what passes between bricks.
#pragma once

#include <cstdint>

#include "volume/brick.h"

namespace maille {

// Raises each label of `to` to what the one of `from` pushes it to. Whether any rose.
bool push_line(const std::uint16_t* from, const std::uint16_t* slack, std::uint16_t* to);
bool push_line(const std::uint32_t* from, const std::uint32_t* slack, std::uint32_t* to);

// The highest label that push_line() would give, 0 if none would rise.
std::uint16_t highest_push(const std::uint16_t* from, const std::uint16_t* slack,
                           const std::uint16_t* to);
std::uint32_t highest_push(const std::uint32_t* from, const std::uint32_t* slack,
                           const std::uint32_t* to);

bool any_greater(const std::uint16_t* a, const std::uint16_t* b);
bool any_greater(const std::uint32_t* a, const std::uint32_t* b);

// The highest of those whose bit is set.
std::uint16_t highest_of(const std::uint16_t* labels, std::uint32_t which);
std::uint32_t highest_of(const std::uint32_t* labels, std::uint32_t which);

}  // namespace maille
