#include "material/material_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille {
namespace {

// Keeps limits far inside what 32-bit displacements and sums of them can hold.
constexpr double kLargestLimit = 1e5;

Error refuse(const Material& material, const std::string& expected) {
  return {ErrorKind::bad_input, "material \"" + material.name + "\": " + expected};
}

std::string number(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

bool all_within(glm::dvec3 v, double low, double high) {
  for (int c = 0; c < 3; ++c) {
    if (!(v[c] >= low && v[c] <= high)) return false;  // a NaN is not within
  }
  return true;
}

// Towards zero: a limit never becomes wider than what was asked for. The nudge keeps a limit that
// is a whole number of units from losing one to the binary form of its decimal.
std::int32_t inside(double limit_voxels) {
  return static_cast<std::int32_t>(limit_voxels * kUnitsPerVoxel +
                                   std::copysign(1e-9, limit_voxels));
}

LinkLimits limits_between(const Material& i, const Material& j) {
  LinkLimits limits;
  for (int axis = 0; axis < 3; ++axis) {
    for (int component = 0; component < 3; ++component) {
      const bool along = axis == component;
      const int shear = (inside(i.shear[component]) + inside(j.shear[component])) / 2;
      const int least = (inside(1 - i.compress[axis]) + inside(1 - j.compress[axis])) / 2;
      const int most = (inside(i.stretch[axis] - 1) + inside(j.stretch[axis] - 1)) / 2;
      limits.lower[axis][component] = along ? -least : -shear;
      limits.upper[axis][component] = along ? most : shear;
    }
  }
  return limits;
}

}  // namespace

Result<MaterialTable> MaterialTable::create(std::vector<Material> materials) {
  if (materials.empty() || materials.size() > kMaxMaterials) {
    return Error{ErrorKind::bad_input, "material table: expected 1 to 256 materials, got " +
                                           std::to_string(materials.size())};
  }
  for (const Material& m : materials) {
    if (!(m.value_low < m.value_high))
      return refuse(m, "expected a value range [low, high) with low < high");
    if (!all_within(m.compress, 0.0, 1.0)) return refuse(m, "expected compress within 0 to 1");
    if (!all_within(m.stretch, 1.0, kLargestLimit))
      return refuse(m, "expected stretch within 1 to 100000");
    if (!all_within(m.shear, 0.0, kLargestLimit))
      return refuse(m, "expected shear within 0 to 100000");
    if (!(m.stiffness > 0.0) || !(m.stiffness >= 1e-12 && m.stiffness <= 1e12)) {
      return refuse(m, "expected a stiffness within 1e-12 to 1e12");
    }
  }
  std::stable_sort(materials.begin(), materials.end(),
                   [](const Material& a, const Material& b) { return a.value_low < b.value_low; });
  for (std::size_t i = 1; i < materials.size(); ++i) {
    if (materials[i].value_low < materials[i - 1].value_high) {
      return refuse(materials[i], "expected a value range that does not overlap that of \"" +
                                      materials[i - 1].name + "\"");
    }
  }
  MaterialTable table;
  table.links_.reserve(materials.size() * materials.size());
  for (const Material& i : materials) {
    for (const Material& j : materials) table.links_.push_back(limits_between(i, j));
    table.compliances_.push_back(static_cast<float>(1.0 / i.stiffness));
  }
  table.materials_ = std::move(materials);
  return table;
}

MaterialTable MaterialTable::ct() {
  const auto table = [](std::vector<Material> m) {
    return std::move(create(std::move(m))).value();
  };
  return table({
      {"air", -1024, -300, glm::dvec3(0.2), glm::dvec3(4.0), glm::dvec3(1.0), 0.001, false},
      {"fat", -300, -20, glm::dvec3(0.4), glm::dvec3(3.0), glm::dvec3(1.0), 0.5, false},
      {"soft tissue", -20, 250, glm::dvec3(0.4), glm::dvec3(3.0), glm::dvec3(0.9), 1.0, false},
      {"bone", 250, 4096, glm::dvec3(1.0), glm::dvec3(1.0), glm::dvec3(0.0), 1000.0, true},
  });
}

MaterialTable MaterialTable::relative(double lowest, double highest) {
  const Material soft{"soft",          lowest,           highest, glm::dvec3(0.5),
                      glm::dvec3(3.0), glm::dvec3(0.24), 0.1,     false};
  const Material firm{"firm",          lowest,          highest, glm::dvec3(0.7),
                      glm::dvec3(1.8), glm::dvec3(0.3), 1.0,     false};
  std::vector<Material> materials{soft, firm};
  materials[0].value_high = materials[1].value_low = lowest + (highest - lowest) / 3.0;
  materials[1].value_high = std::nextafter(highest, std::numeric_limits<double>::infinity());
  if (auto table = create(std::move(materials))) return *std::move(table);
  // One value, or a range too narrow for a double to cut: all of it is firm.
  Material all = firm;
  all.value_low = -std::numeric_limits<double>::infinity();
  all.value_high = std::numeric_limits<double>::infinity();
  return std::move(create({all})).value();
}

MaterialId MaterialTable::id_of(double value) const {
  if (!(value >= materials_.front().value_low)) return 0;
  // The last material that begins at or below the value.
  const auto after = std::upper_bound(materials_.begin(), materials_.end(), value,
                                      [](double v, const Material& m) { return v < m.value_low; });
  const auto here = static_cast<MaterialId>(after - materials_.begin() - 1);
  if (after == materials_.end() || value < materials_[here].value_high) return here;
  const double below = value - materials_[here].value_high;
  const double above = after->value_low - value;
  return below <= above ? here : static_cast<MaterialId>(here + 1);
}

bool MaterialTable::any_fixed() const {
  return std::any_of(materials_.begin(), materials_.end(),
                     [](const Material& m) { return m.fixed; });
}

std::vector<std::string> MaterialTable::warnings() const {
  std::vector<std::string> sentences;
  for (const Material& m : materials_) {
    for (int axis = 0; axis < 3; ++axis) {
      // Row `axis` of a cell's Jacobian: its own entry is at least compress, the two others at most
      // shear each; diagonal dominance rules out a fold.
      if (m.compress[axis] > 2.0 * m.shear[axis] || m.shear[axis] == 0.0) continue;
      sentences.push_back("material \"" + m.name + "\": compress " + number(m.compress[axis]) +
                          " is not above twice shear " + number(m.shear[axis]) +
                          ": a drag may fold its cells");
      break;
    }
  }
  return sentences;
}

}  // namespace maille
