// The product's methods by name.
#pragma once

#include <array>
#include <string_view>

#include "resample/resampler.h"

namespace maille {

inline constexpr std::array kResampleMethods = {ResampleMethod::nearest, ResampleMethod::linear};

constexpr std::string_view name_of(ResampleMethod method) {
  return method == ResampleMethod::nearest ? "nearest" : "linear";
}

}  // namespace maille
