#include "render/transfer_function.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace maille {
namespace {

constexpr std::array<std::string_view, 4> kNames{"ct-skin", "ct-bone", "ct-airway", "relative"};

// Skin is the thin layer where air turns into tissue; it takes most of the light, but not all. What
// is under it absorbs little, so that bone, which absorbs nearly everything, shines through.
std::vector<TransferPoint> ct_skin() {
  return {{-1024, {0.80, 0.56, 0.45}, 0.0}, {-450, {0.80, 0.56, 0.45}, 0.0},
          {-300, {0.84, 0.60, 0.48}, 0.12}, {-150, {0.88, 0.64, 0.51}, 0.16},
          {-50, {0.86, 0.56, 0.44}, 0.08},  {150, {0.80, 0.42, 0.35}, 0.08},
          {250, {0.96, 0.90, 0.80}, 0.35},  {700, {1.00, 0.97, 0.91}, 0.80},
          {3000, {1.00, 1.00, 0.98}, 0.95}};
}

std::vector<TransferPoint> ct_bone() {
  return {{-1024, {0.55, 0.35, 0.28}, 0.0},
          {150, {0.72, 0.50, 0.38}, 0.0},
          {250, {0.90, 0.82, 0.68}, 0.15},
          {600, {0.97, 0.92, 0.82}, 0.60},
          {3000, {1.00, 1.00, 0.98}, 0.95}};
}

// Shells between air and tissue, clear on both sides: airways are seen through the chest and, from
// within, as walls.
std::vector<TransferPoint> ct_airway() {
  return {{-1024, {0.55, 0.72, 0.85}, 0.0}, {-950, {0.55, 0.72, 0.85}, 0.0},
          {-750, {0.62, 0.78, 0.88}, 0.06}, {-500, {0.95, 0.62, 0.56}, 0.30},
          {-250, {0.90, 0.50, 0.45}, 0.08}, {-100, {0.85, 0.45, 0.40}, 0.0},
          {3000, {0.85, 0.45, 0.40}, 0.0}};
}

std::vector<TransferPoint> relative(double lowest, double highest) {
  const auto at = [&](double part) { return lowest + part * (highest - lowest); };
  return {{at(0.00), {0.30, 0.20, 0.16}, 0.00},
          {at(0.12), {0.40, 0.25, 0.18}, 0.00},
          {at(0.35), {0.66, 0.42, 0.28}, 0.05},
          {at(0.65), {0.92, 0.76, 0.54}, 0.25},
          {at(1.00), {1.00, 0.98, 0.94}, 0.70}};
}

bool in_unit(double x) { return x >= 0.0 && x <= 1.0; }  // false for NaN

}  // namespace

std::span<const std::string_view> TransferFunction::preset_names() { return kNames; }

Result<TransferFunction> TransferFunction::of(std::vector<TransferPoint> points) {
  if (points.empty()) return Error{ErrorKind::bad_input, "a transfer function needs a point"};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const TransferPoint& p = points[i];
    const std::string where = "transfer function point " + std::to_string(i) + ": ";
    if (!std::isfinite(p.value)) {
      return Error{ErrorKind::bad_input, where + "the value must be a finite number"};
    }
    if (i > 0 && p.value < points[i - 1].value) {
      return Error{ErrorKind::bad_input, where + "values must not fall"};
    }
    if (!in_unit(p.color.r) || !in_unit(p.color.g) || !in_unit(p.color.b) || !in_unit(p.opacity)) {
      return Error{ErrorKind::bad_input, where + "colour and opacity must be 0 to 1"};
    }
  }
  TransferFunction transfer(std::move(points));
  const auto first = std::find_if(transfer.points_.begin(), transfer.points_.end(),
                                  [](const TransferPoint& p) { return p.opacity > 0.0; });
  transfer.surface_value_ =
      first != transfer.points_.end() ? first->value : transfer.points_.back().value;
  return transfer;
}

Result<TransferFunction> TransferFunction::preset(std::string_view name, double lowest,
                                                  double highest) {
  std::vector<TransferPoint> points;
  double surface = 0.0;
  if (name == "ct-skin") {
    points = ct_skin();
    surface = -300.0;
  } else if (name == "ct-bone") {
    points = ct_bone();
    surface = 250.0;
  } else if (name == "ct-airway") {
    points = ct_airway();
    surface = -500.0;
  } else if (name == "relative") {
    points = relative(lowest, highest);
    surface = points[2].value;
  } else {
    std::string known;
    for (const std::string_view each : kNames) {
      known += (known.empty() ? "" : ", ") + std::string(each);
    }
    return Error{ErrorKind::usage,
                 "no transfer function preset '" + std::string(name) + "'; there are " + known};
  }
  auto transfer = of(std::move(points));
  if (transfer) transfer->surface_value_ = surface;
  return transfer;
}

double TransferFunction::surface_value() const { return surface_value_; }

glm::dvec4 TransferFunction::at(double value) const {
  // The first point beyond the value; at a step, the upper one of the two counts for the value
  // itself.
  const auto after = std::upper_bound(points_.begin(), points_.end(), value,
                                      [](double v, const TransferPoint& p) { return v < p.value; });
  if (after == points_.begin()) return {points_.front().color, points_.front().opacity};
  const TransferPoint& low = *(after - 1);
  if (after == points_.end()) return {low.color, low.opacity};
  const double part = (value - low.value) / (after->value - low.value);
  return glm::mix(glm::dvec4(low.color, low.opacity), glm::dvec4(after->color, after->opacity),
                  part);
}

std::vector<glm::vec4> TransferFunction::table(int entries, double step_voxels) const {
  std::vector<glm::vec4> result;
  result.reserve(static_cast<std::size_t>(entries));
  for (int i = 0; i < entries; ++i) {
    const double part = entries > 1 ? static_cast<double>(i) / (entries - 1) : 0.0;
    glm::dvec4 entry = at(lowest() + part * (highest() - lowest()));
    entry.a = 1.0 - std::pow(1.0 - entry.a, step_voxels);
    result.emplace_back(entry);
  }
  return result;
}

std::vector<glm::vec4> TransferFunction::integrated_table(int entries, double step_voxels) const {
  // What lets nothing through would have an infinite depth.
  constexpr double kClearest = 1e-6;
  std::vector<glm::dvec4> depths;
  for (int i = 0; i < entries; ++i) {
    const double part = entries > 1 ? static_cast<double>(i) / (entries - 1) : 0.0;
    glm::dvec4 entry = at(lowest() + part * (highest() - lowest()));
    entry.a = -step_voxels * std::log(std::max(1.0 - entry.a, kClearest));
    depths.push_back(entry);
  }
  std::vector<glm::vec4> result(depths.begin(), depths.end());
  std::vector<glm::vec4> places;
  glm::dvec4 sum(0.0);
  double place = 0.0;
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (i > 0) {
      // Of products of two lines.
      const auto product = [](auto a, double at_a, auto b, double at_b) {
        return (a * at_a + b * at_b) / 3.0 + (a * at_b + b * at_a) / 6.0;
      };
      const glm::dvec4& a = depths[i - 1];
      const glm::dvec4& b = depths[i];
      sum += glm::dvec4(product(glm::dvec3(a), a.a, glm::dvec3(b), b.a), 0.5 * (a.a + b.a));
      const auto end = static_cast<double>(i);
      place += product(end - 1.0, a.a, end, b.a);
    }
    result.emplace_back(sum);
    places.emplace_back(0.0, 0.0, 0.0, place);
  }
  result.insert(result.end(), places.begin(), places.end());
  return result;
}

}  // namespace maille
