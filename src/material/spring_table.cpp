#include "material/spring_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace maille {
namespace {

constexpr double kWidestGap = 1000.0;
constexpr double kRigidAbove = 1000.0;  // the stiffest that is not rigid
constexpr double kSoftest = 1e-6;
constexpr double kStiffest = 1e12;
constexpr double kRounding = 1.0 + 1e-9;  // of powers of ten that a person typed

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.4g", value);
  return text.data();
}

// The widest gap that leaves the product of all gaps, none above it, within `reach`.
double narrowed_gap(std::vector<double> gaps, double reach) {
  for (double& gap : gaps) gap = std::min(gap, kWidestGap);
  std::sort(gaps.begin(), gaps.end());
  double rest = std::log(reach * kRounding);
  auto wider = static_cast<double>(gaps.size());
  for (const double gap : gaps) {
    if (std::log(gap) * wider > rest) return std::exp(rest / wider);
    rest -= std::log(gap);
    wider -= 1.0;
  }
  return kWidestGap;
}

struct Clamp {
  std::vector<double> stiffness;  // by id
  std::optional<std::string> sentence;
};

std::string sentence_of_gaps(const Material& soft, const Material& stiff, double taken,
                             int others) {
  std::string text = "springs take \"" + stiff.name + "\" as " + number(taken) +
                     " times as stiff as \"" + soft.name + "\", not " +
                     number(stiff.stiffness / soft.stiffness) + " times";
  if (others > 0) {
    text += " (and narrow " + std::to_string(others) + (others == 1 ? " gap" : " gaps") + " more)";
  }
  return text;
}

Clamp clamp(const std::vector<Material>& levels) {
  Clamp result{std::vector<double>(levels.size(), 1.0), std::nullopt};
  std::vector<std::size_t> by_stiffness;  // of those that are not rigid
  for (std::size_t id = 0; id < levels.size(); ++id) {
    if (!levels[id].rigid) by_stiffness.push_back(id);
  }
  if (by_stiffness.empty()) return result;
  std::stable_sort(by_stiffness.begin(), by_stiffness.end(), [&](std::size_t a, std::size_t b) {
    return levels[a].stiffness < levels[b].stiffness;
  });

  std::vector<double> gaps;
  for (std::size_t i = 1; i < by_stiffness.size(); ++i) {
    gaps.push_back(levels[by_stiffness[i]].stiffness / levels[by_stiffness[i - 1]].stiffness);
  }
  const bool any_rigid = by_stiffness.size() < levels.size();
  const double widest = narrowed_gap(gaps, kStiffest / kSoftest / (any_rigid ? kRigidAbove : 1.0));

  double share = 1.0;  // of its stiffness that a level keeps; exactly 1 below the first clamped gap
  int narrowed = 0;
  std::size_t worst = 0;
  result.stiffness[by_stiffness.front()] = levels[by_stiffness.front()].stiffness;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (gaps[i] > widest * kRounding) {
      share *= widest / gaps[i];
      if (narrowed++ == 0 || gaps[i] > gaps[worst]) worst = i;
    }
    const std::size_t id = by_stiffness[i + 1];
    result.stiffness[id] = levels[id].stiffness * share;
  }
  if (narrowed > 0) {
    result.sentence = sentence_of_gaps(levels[by_stiffness[worst]], levels[by_stiffness[worst + 1]],
                                       widest, narrowed - 1);
  }
  if (!any_rigid) return result;

  const std::size_t stiffest = by_stiffness.back();
  const double rigid = kRigidAbove * result.stiffness[stiffest];
  for (std::size_t id = 0; id < levels.size(); ++id) {
    if (levels[id].rigid) result.stiffness[id] = rigid;
  }
  const std::string text = "what is rigid is " + number(kRigidAbove) + " times as stiff as \"" +
                           levels[stiffest].name + "\"";
  result.sentence = result.sentence ? *result.sentence + "; " + text : "for springs, " + text;
  return result;
}

// What brings all of them within the bounds; 1 where they are.
double scale_of(const std::vector<double>& stiffness) {
  const auto [softest, stiffest] = std::minmax_element(stiffness.begin(), stiffness.end());
  if (*softest < kSoftest) return kSoftest / *softest;
  return std::min(1.0, kStiffest / *stiffest);
}

}  // namespace

SpringTable SpringTable::of(const MaterialTable& table) {
  auto [stiffness, sentence] = clamp(levels_of(table.materials(), table.interpolation()));
  const double scale = scale_of(stiffness);
  SpringTable springs;
  springs.clamped_ = std::move(sentence);
  springs.smallest_blend_ = springs.largest_blend_ = table.rest_vector_blend(0);
  for (std::size_t i = 0; i < stiffness.size(); ++i) {
    const float blend = table.rest_vector_blend(static_cast<MaterialId>(i));
    springs.springs_.push_back({static_cast<float>(1.0 / (stiffness[i] * scale)), blend});
    springs.smallest_blend_ = std::min(springs.smallest_blend_, blend);
    springs.largest_blend_ = std::max(springs.largest_blend_, blend);
  }
  return springs;
}

}  // namespace maille
