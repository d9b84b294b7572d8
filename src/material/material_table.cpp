#include "material/material_table.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "material/default_blend.h"

#include "material/material_warnings.h"

namespace maille {
namespace {

// Down: a limit never becomes wider than what was asked for. The nudge keeps a limit that is a
// whole number of units from losing one to the binary form of its decimal.
glm::ivec3 inside(const glm::dvec3& limit_voxels) {
  return {glm::floor(limit_voxels * double{kUnitsPerVoxel} + 1e-9)};
}

ElementLimits limits_of(const Material& m) {
  return {inside(1.0 - m.compress), inside(m.stretch - 1.0), inside(m.shear)};
}

float yield_strain_of(const Material& m) {
  using Float = std::numeric_limits<float>;
  const double strain = m.yield_strain.value_or(std::numeric_limits<double>::infinity());
  if (strain > double{Float::max()}) return Float::infinity();
  return std::max(static_cast<float>(strain), Float::min());
}

}  // namespace

Result<MaterialTable> MaterialTable::create(std::vector<Material> materials,
                                            Interpolation interpolation) {
  if (materials.empty() || materials.size() > kMaxMaterials) {
    return Error{ErrorKind::bad_input, "material table: expected 1 to 256 materials, got " +
                                           std::to_string(materials.size())};
  }
  for (Material& m : materials) {
    if (m.rigid) {
      m.compress = m.stretch = glm::dvec3(1.0);
      m.shear = glm::dvec3(0.0);
    }
    if (auto refusal = refusal_of(m)) return *std::move(refusal);
  }
  std::stable_sort(materials.begin(), materials.end(),
                   [](const Material& a, const Material& b) { return a.value_low < b.value_low; });
  for (std::size_t i = 1; i < materials.size(); ++i) {
    if (materials[i].value_low < materials[i - 1].value_high) {
      return Error{ErrorKind::bad_input,
                   "material \"" + materials[i].name +
                       "\": expected a value range that does not overlap that of \"" +
                       materials[i - 1].name + "\""};
    }
  }
  give_default_blends(materials);
  MaterialTable table;
  for (const Material& level : levels_of(materials, interpolation)) {
    table.level_begins_.push_back(level.value_low);
    table.levels_.push_back({limits_of(level), static_cast<float>(1.0 / level.stiffness),
                             static_cast<float>(*level.rest_vector_blend), yield_strain_of(level),
                             level.fixed});
  }
  table.materials_ = std::move(materials);
  table.interpolation_ = interpolation;
  return table;
}

MaterialTable MaterialTable::ct(Interpolation interpolation) {
  const auto table = [&](std::vector<Material> m) {
    return std::move(create(std::move(m), interpolation)).value();
  };
  return table({
      {"air", -1024, -300, glm::dvec3(0.2), glm::dvec3(4.0), glm::dvec3(1.0), 0.001, false},
      {"fat", -300, -20, glm::dvec3(0.4), glm::dvec3(3.0), glm::dvec3(1.0), 0.5, false},
      {"soft tissue", -20, 250, glm::dvec3(0.4), glm::dvec3(3.0), glm::dvec3(0.9), 1.0, false},
      {"bone", 250, 4096, glm::dvec3(1.0), glm::dvec3(1.0), glm::dvec3(0.0), 1000.0, true},
  });
}

MaterialTable MaterialTable::relative(double lowest, double highest, Interpolation interpolation) {
  const Material soft{"soft",          lowest,           highest, glm::dvec3(0.5),
                      glm::dvec3(3.0), glm::dvec3(0.24), 0.1,     false};
  const Material firm{"firm",          lowest,          highest, glm::dvec3(0.7),
                      glm::dvec3(1.8), glm::dvec3(0.3), 1.0,     false};
  std::vector<Material> materials{soft, firm};
  materials[0].value_high = materials[1].value_low = lowest + (highest - lowest) / 3.0;
  materials[1].value_high = std::nextafter(highest, std::numeric_limits<double>::infinity());
  if (auto table = create(std::move(materials), interpolation)) return *std::move(table);
  // One value, or a range too narrow for a double to cut: all of it is firm.
  Material all = firm;
  all.value_low = -std::numeric_limits<double>::infinity();
  all.value_high = std::numeric_limits<double>::infinity();
  return std::move(create({all}, interpolation)).value();
}

MaterialId MaterialTable::id_of(double value) const {
  // The last level that begins at or below the value; written so that NaN is below every one.
  const auto after = std::upper_bound(level_begins_.begin() + 1, level_begins_.end(), value,
                                      [](double v, double begin) { return !(v >= begin); });
  return static_cast<MaterialId>(after - level_begins_.begin() - 1);
}

bool MaterialTable::any_yields() const {
  return std::any_of(levels_.begin(), levels_.end(),
                     [](const Level& level) { return std::isfinite(level.yield_strain); });
}

bool MaterialTable::any_fixed() const {
  return std::any_of(materials_.begin(), materials_.end(),
                     [](const Material& m) { return m.fixed; });
}

std::vector<std::string> MaterialTable::warnings() const {
  return warnings_of(materials_, interpolation_);
}

std::int64_t MaterialTable::bytes() const {
  return static_cast<std::int64_t>(sizeof(MaterialTable) + materials_.size() * sizeof(Material) +
                                   levels_.size() * (sizeof(Level) + sizeof(double)));
}

}  // namespace maille
