#include "measure/stability_case.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>

#include "measure/drag_scene.h"

namespace maille {
namespace {

constexpr double kSoft = 0.2;     // slack, voxels
constexpr double kStiff = 0.004;  // two units of the lattice
constexpr double kLongest = 1e5;  // that a material may stretch

std::string decade(const char* what, int exponent) {
  return std::string(what) + (exponent == 0 ? "1" : "1e" + std::to_string(exponent));
}

// The value of a voxel is the id of its material.
template <class F>
Volume volume_of(Size3 size, glm::dvec3 spacing_mm, F&& material) {
  std::vector<std::uint8_t> samples;
  samples.reserve(static_cast<std::size_t>(voxel_count(size)));
  for (int z = 0; z < size.z; ++z) {
    for (int y = 0; y < size.y; ++y) {
      for (int x = 0; x < size.x; ++x) {
        samples.push_back(static_cast<std::uint8_t>(material(VoxelIndex(x, y, z))));
      }
    }
  }
  return Volume::of(size, VoxelType::uint8, axis_aligned(spacing_mm), std::move(samples));
}

Volume uniform(Size3 size, glm::dvec3 spacing_mm = glm::dvec3(1)) {
  return volume_of(size, spacing_mm, [](VoxelIndex) { return 0; });
}

Material soft(double stiffness = 1.0) { return slack_material("soft", 0, kSoft, stiffness); }

// Links may go `give` voxels in every way that they can.
Material wide(double give) {
  Material material = soft();
  material.compress = glm::dvec3(std::max(0.0, 1.0 - give));
  material.stretch = glm::dvec3(std::min(1.0 + give, kLongest));
  material.shear = glm::dvec3(std::min(give, kLongest));
  return material;
}

class Sweep {
 public:
  Sweep(int edge, std::uint64_t seed, const std::vector<std::string>& groups)
      : edge_(edge), middle_(edge / 2), seed_(seed), groups_(groups) {}

  std::vector<StabilityCase> all() {
    for (const auto& [name, add] : parts()) {
      if (!groups_.empty() && std::find(groups_.begin(), groups_.end(), name) == groups_.end()) {
        continue;
      }
      group_ = name;
      (this->*add)();
    }
    return std::move(cases_);
  }

  using Part = std::pair<const char*, void (Sweep::*)()>;
  static const std::vector<Part>& parts() {
    static const std::vector<Part> kParts = {{"stiffness_ratio", &Sweep::stiffness_ratios},
                                             {"limits", &Sweep::limits},
                                             {"drag", &Sweep::drags},
                                             {"pull", &Sweep::pulls},
                                             {"spacing", &Sweep::spacings},
                                             {"thin", &Sweep::thin_ones},
                                             {"random", &Sweep::random_ones},
                                             {"opposed", &Sweep::opposed_handles},
                                             {"blend", &Sweep::blends},
                                             {"folded", &Sweep::folded_starts},
                                             {"coincident", &Sweep::coincident_elements},
                                             {"cut", &Sweep::cut_ones},
                                             {"anchors", &Sweep::anchor_rules},
                                             {"few", &Sweep::few_elements}};
    return kParts;
  }

 private:
  StabilityCase& add(std::string title, Volume volume, std::vector<Material> materials) {
    cases_.push_back(
        {group_, std::move(title), std::move(volume), std::move(materials), {}, {}, {}, {}});
    return cases_.back();
  }
  StabilityCase& add_block(std::string title, std::vector<Material> materials) {
    return add(std::move(title), uniform(Size3(edge_)), std::move(materials));
  }
  // A ball of material 1 (radius a fifth of the edge) in material 0.
  Volume ball(glm::dvec3 spacing_mm = glm::dvec3(1)) const {
    const double radius = edge_ / 5.0;
    return volume_of(Size3(edge_), spacing_mm, [&](VoxelIndex v) {
      return glm::length(glm::dvec3(v - VoxelIndex(middle_))) <= radius ? 1 : 0;
    });
  }
  // The design's drag, as long as a seventh of the edge.
  glm::dvec3 oblique() const { return glm::dvec3(14, 6, -3) * (edge_ / 96.0); }
  Grab grab_middle(glm::dvec3 by, double radius = 0.0) const {
    return {VoxelIndex(middle_), radius, by};
  }

  void stiffness_ratios() {
    for (int exponent = 0; exponent <= 9; ++exponent) {
      StabilityCase& c =
          add(decade("ball 1 : ", exponent), ball(),
              {soft(), slack_material("stiff", 1, kStiff, std::pow(10.0, exponent))});
      c.grabs = {grab_middle(oblique())};
    }
    for (const int exponent : {3, 9}) {
      // The other way round: a soft middle in stiff surroundings.
      StabilityCase& c =
          add(decade("hollow 1 : ", -exponent), ball(),
              {soft(), slack_material("softer", 1, kSoft, std::pow(10.0, -exponent))});
      c.grabs = {grab_middle(oblique())};
    }
  }

  void limits() {
    for (const double slack : {0.4, 0.1, 0.01, 0.002, 0.0}) {
      StabilityCase& c =
          add_block("slack " + number(slack), {slack_material("all", 0, slack, 1.0)});
      c.grabs = {grab_middle(oblique())};
    }
    Material rigid = slack_material("rigid", 1, 0.0, 1.0);
    rigid.rigid = true;
    StabilityCase& in_soft = add("rigid ball in soft", ball(), {soft(), rigid});
    in_soft.grabs = {grab_middle(oblique())};
    StabilityCase& grabbed_beside = add("rigid ball pushed", ball(), {soft(), rigid});
    grabbed_beside.grabs = {
        {VoxelIndex(middle_) - VoxelIndex(edge_ / 5 + 2, 1, 0), 1.0, {edge_ / 8.0, 0, 0}}};
    rigid.value_low = 0;
    rigid.value_high = 1;
    StabilityCase& all_rigid = add_block("all rigid", {rigid});
    all_rigid.grabs = {grab_middle(oblique())};
  }

  // The middle of a block dragged, through limits as wide as it takes to have moved a quarter of
  // the way to its border: from 1 voxel on that folds cells, and ChainMail is allowed to.
  void drags() {
    for (int exponent = -6; exponent <= 6; ++exponent) {
      const double far = std::pow(10.0, exponent);
      StabilityCase& c = add_block(decade("", exponent) + " voxels",
                                   {wide(std::max(kSoft, far / (0.25 * edge_)))});
      c.grabs = {grab_middle(far * glm::dvec3(0.8, 0.5, -0.2))};
    }
  }

  // A bar that one end face holds, pulled at the other: nothing has to fold, however far.
  void pulls() {
    for (int exponent = -6; exponent <= 6; ++exponent) {
      const double far = std::pow(10.0, exponent);
      const Size3 size{5, 5, 2 * edge_};
      StabilityCase& c = add(decade("", exponent) + " voxels", uniform(size),
                             {wide(std::max(kSoft, 2.0 * far / size.z))});
      c.anchors.faces = face_low_z;
      c.grabs = {{VoxelIndex(2, 2, size.z - 1), 3.0, {0, 0, far}}};
    }
  }

  void spacings() {
    for (const glm::dvec3 spacing :
         {glm::dvec3(1, 1, 1), glm::dvec3(1, 1, 2), glm::dvec3(1, 1, 5), glm::dvec3(1, 1, 10),
          glm::dvec3(10, 1, 1), glm::dvec3(1, 10, 10), glm::dvec3(1, 3, 10),
          glm::dvec3(1e-3, 1e-3, 1e-2), glm::dvec3(1e3, 1e3, 1e4)}) {
      const std::string sides =
          number(spacing.x) + ":" + number(spacing.y) + ":" + number(spacing.z);
      StabilityCase& plain = add(sides + " mm", uniform(Size3(edge_), spacing), {soft()});
      plain.grabs = {grab_middle(oblique(), 1.5)};
      if (spacing.z != 10) continue;
      StabilityCase& mixed = add(sides + " mm, ball 1 : 1e3", ball(spacing),
                                 {soft(), slack_material("stiff", 1, kStiff, 1e3)});
      mixed.grabs = {grab_middle(oblique())};
    }
  }

  void thin_ones() {
    const int length = 2 * edge_;
    for (int thick = 1; thick <= 3; ++thick) {
      for (const bool sideways : {false, true}) {
        StabilityCase& slab =
            add("slab of " + std::to_string(thick) + (sideways ? ", bent" : ", pulled"),
                uniform({length, edge_, thick}), {soft()});
        slab.anchors.faces = face_low_x;
        slab.grabs = {{VoxelIndex(length - 2, edge_ / 2, thick / 2), 2.0,
                       sideways ? glm::dvec3(0, 0, edge_ / 4.0) : glm::dvec3(edge_ / 4.0, 2, 0)}};
        StabilityCase& rod =
            add("rod of " + std::to_string(thick) + (sideways ? ", bent" : ", pressed"),
                uniform({thick, thick, length}), {soft()});
        rod.anchors.faces = face_low_z;
        rod.grabs = {{VoxelIndex(thick / 2, thick / 2, length - 1), double(thick),
                      sideways ? glm::dvec3(edge_ / 4.0, 0, 0) : glm::dvec3(0, 0, -edge_ / 4.0)}};
      }
    }
  }

  void random_ones() {
    for (const int decades : {1, 3, 9}) {
      for (const int block : {1, 4}) {
        auto materials = three_tissues();
        for (std::size_t i = 0; i < materials.size(); ++i) {
          materials[i].stiffness = std::pow(10.0, decades * (static_cast<double>(i) - 1.0));
        }
        add_random("1e-" + std::to_string(decades) + " : 1 : 1e" + std::to_string(decades), block,
                   materials);
      }
    }
    for (const int block : {1, 4}) {
      auto materials = three_tissues();
      materials[2].rigid = true;
      add_random("one of three rigid", block, materials);
    }
    // Folds are allowed here, and stiffness has nothing to do with limits.
    auto materials = three_tissues();
    for (Material& m : materials) m.shear = glm::dvec3(0.8);
    std::swap(materials[0].stiffness, materials[2].stiffness);
    add_random("shear 0.8", 1, materials);
  }
  void add_random(const std::string& title, int block, const std::vector<Material>& materials) {
    DragScene scene = random_scene(edge_, block, materials, seed_, 0.7 * oblique());
    StabilityCase& c =
        add(title + (block == 1 ? ", voxels" : ", blocks"), std::move(scene.volume), materials);
    c.grabs = {scene.grab};
  }

  // Two handles against each other.
  void opposed_handles() {
    for (const double ratio : {1.0, 1e3}) {
      for (const double part : {0.3, 0.5, -0.3}) {
        const auto stiff = slack_material("stiff", 1, kSoft, ratio);
        StabilityCase& c = add((part > 0 ? "squeezed by " : "pulled by ") + number(std::abs(part)) +
                                   ", ball 1 : " + number(ratio),
                               ball(), {soft(), stiff});
        const int apart = edge_ / 4;  // of each from the middle
        for (const int side : {-1, 1}) {
          c.grabs.push_back({VoxelIndex(middle_ + side * apart, middle_, middle_),
                             1.5,
                             {-side * part * apart, 0, 0}});
        }
      }
    }
    StabilityCase& crossed = add_block("dragged past each other", {soft()});
    for (const int side : {-1, 1}) {
      crossed.grabs.push_back(
          {VoxelIndex(middle_, middle_ + 3 * side, middle_), 1.0, {0.15 * edge_ * side, 0, 0}});
    }
  }

  void blends() {
    for (const double blend : {0.0, 0.125, 0.5, 1.0}) {
      Material material = soft();
      material.rest_vector_blend = blend;
      StabilityCase& c = add_block("blend " + number(blend), {material});
      c.grabs = {grab_middle(1.2 * oblique(), 1.5)};
    }
    Material stiff = slack_material("stiff", 1, kStiff, 1e3);
    Material material = soft();
    material.rest_vector_blend = 0.0;
    stiff.rest_vector_blend = 1.0;
    StabilityCase& c = add("0 beside 1, ball 1 : 1e3", ball(), {material, stiff});
    c.grabs = {grab_middle(oblique())};
  }

  // Starts with folded cells: ChainMail's own, of materials that break the rule against folds, and
  // such as no drag leads to.
  void folded_starts() {
    Material loose = soft();
    loose.shear = glm::dvec3(1.0);
    loose.compress = glm::dvec3(0.2);
    StabilityCase& dragged = add_block("shear 1", {loose});
    dragged.grabs = {grab_middle(3.0 * oblique())};
    Material stiff = slack_material("stiff", 1, kStiff, 1e3);
    StabilityCase& around = add("shear 1 around a ball 1 : 1e3", ball(), {loose, stiff});
    around.grabs = {grab_middle(2.0 * oblique())};
    for (const double by : {0.4, 0.7, 2.0}) {
      shaken("shaken by " + number(by), by, {soft()});
    }
    shaken("shaken by 0.7, random stiffness", 0.7, three_tissues());
    StabilityCase& mirrored = add_block("mirrored", {soft()});
    placed(mirrored, [&](VoxelIndex v) { return glm::dvec3(edge_ - 1 - 2 * v.x, 0, 0); });
    StabilityCase& folded = add_block("folded over like paper", {soft()});
    placed(folded, [&](VoxelIndex v) {
      return glm::dvec3(v.x > middle_ ? 2 * (middle_ - v.x) : 0, 0, v.x > middle_ ? 0.3 : 0);
    });
  }
  void shaken(const std::string& title, double by, const std::vector<Material>& materials) {
    std::mt19937_64 random(seed_);
    std::uniform_real_distribution<double> share(-1, 1);
    DragScene scene = random_scene(edge_, 1, materials, seed_, {});
    StabilityCase& c = add(title, std::move(scene.volume), materials);
    placed(c, [&](VoxelIndex) {
      const double x = share(random);
      const double y = share(random);
      return by * glm::dvec3(x, y, share(random));
    });
  }
  // The border stays at rest.
  template <class F>
  static void placed(StabilityCase& c, F&& u_voxels) {
    const Size3 size = c.volume.size();
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          const glm::dvec3 u = u_voxels(VoxelIndex(x, y, z));
          c.start.push_back(faces_of({x, y, z}, size)
                                ? glm::ivec3(0)
                                : glm::ivec3(glm::round(u * double{kUnitsPerVoxel})));
        }
      }
    }
  }

  void coincident_elements() {
    Material flat = soft();
    flat.compress = glm::dvec3(0.0);
    StabilityCase& pushed = add_block("links to no length", {flat});
    pushed.grabs = {grab_middle({edge_ / 4.0, 0, 0}, 2.0)};
    StabilityCase& pair = add_block("one on its neighbour", {soft()});
    placed(pair, [&](VoxelIndex v) {
      return v == VoxelIndex(middle_) ? glm::dvec3(1, 0, 0) : glm::dvec3(0);
    });
    StabilityCase& planes = add_block("planes on planes", {soft()});
    placed(planes, [&](VoxelIndex v) { return glm::dvec3(v.x % 2, 0, 0); });
    StabilityCase& point = add_block("all in one point", {soft()});
    placed(point, [&](VoxelIndex v) { return glm::dvec3(VoxelIndex(middle_) - v); });
    StabilityCase& rod = add("a rod in one point", uniform({1, 1, edge_}), {soft()});
    rod.anchors.faces = face_low_z;
    for (int z = 0; z < edge_; ++z) rod.start.emplace_back(0, 0, -z * kUnitsPerVoxel);
  }

  void cut_ones() {
    const glm::dvec3 center(middle_ + 0.5);
    const auto cut_by = [=](glm::dvec3 normal, double radius_mm) {
      return [=](Deformer& deformer) -> Result<void> {
        auto surface =
            CutSurface::disc(center, normal, radius_mm, deformer.materials().spacing_mm());
        if (!surface) return surface.error();
        return deformer.cut(*surface);
      };
    };
    StabilityCase& half = add_block("half through", {soft()});
    half.before = cut_by({1, 0, 0}, 0.3 * edge_);
    half.grabs = {{VoxelIndex(middle_ + 2, middle_, middle_), 1.0, oblique()}};
    StabilityCase& oblique_cut =
        add("obliquely, ball 1 : 1e6", ball(), {soft(), slack_material("stiff", 1, kStiff, 1e6)});
    oblique_cut.before = cut_by({1, 0.7, 0.3}, 0.3 * edge_);
    oblique_cut.grabs = {grab_middle(oblique())};
    StabilityCase& opened = add_block("wide open", {soft()});
    opened.before = cut_by({1, 0, 0}, 0.3 * edge_);
    for (const int side : {-1, 1}) {
      opened.grabs.push_back({VoxelIndex(middle_ + (side < 0 ? 0 : 1) + side, middle_, middle_),
                              1.0,
                              {0.15 * edge_ * side, 0, 0}});
    }
    StabilityCase& carved = add_block("carved", {soft()});
    carved.before = [=](Deformer& deformer) {
      return deformer.carve(center, edge_of(deformer) / 6.0);
    };
    carved.grabs = {{VoxelIndex(middle_ + edge_ / 4, middle_, middle_), 1.0, oblique()}};
    StabilityCase& loose = add_block("a piece that nothing holds", {soft()});
    loose.before = [=](Deformer& deformer) -> Result<void> {
      // A shell of carved elements around the middle.
      const double outer = edge_of(deformer) / 4.0;
      if (auto done = deformer.carve(center, outer); !done) return done;
      return deformer.restore(center, outer - 2.0);
    };
    loose.grabs = {{VoxelIndex(middle_ + edge_ / 4 + 2, middle_, middle_), 1.0, oblique()}};
  }
  static double edge_of(const Deformer& deformer) { return deformer.materials().size().x; }

  void anchor_rules() {
    StabilityCase& free_block = add_block("none, dragged", {soft()});
    free_block.anchors.free_border = true;
    free_block.grabs = {grab_middle(oblique(), 2.0)};
    StabilityCase& twisted = add("none, two handles", uniform({6, 6, 2 * edge_}), {soft()});
    twisted.anchors.free_border = true;
    twisted.grabs = {{VoxelIndex(3, 3, 1), 1.0, {0, 0, 0}},
                     {VoxelIndex(3, 3, 2 * edge_ - 2), 1.0, {edge_ / 3.0, 0, -edge_ / 5.0}}};
    StabilityCase& face = add_block("one face", {soft()});
    face.anchors.faces = face_low_z;
    face.grabs = {{VoxelIndex(middle_, middle_, edge_ - 1), 2.0, oblique()}};
    StabilityCase& fixed_ball =
        add("a fixed ball", ball(), {soft(), slack_material("bone", 1, 0, 1)});
    fixed_ball.materials[1].fixed = true;
    fixed_ball.grabs = {{VoxelIndex(middle_ + edge_ / 5 + 2, middle_, middle_), 1.0, oblique()}};
    StabilityCase& held_up = add("a drag that anchors stop", ball(), fixed_ball.materials);
    held_up.grabs = {
        {VoxelIndex(middle_ + edge_ / 5 + 2, middle_, middle_), 1.0, glm::dvec3(edge_, 0, 0)}};
  }

  void few_elements() {
    const Size3 three(3);
    StabilityCase& one = add("one free element", uniform(three), {soft()});
    placed(one, [](VoxelIndex) { return glm::dvec3(0.3, -0.2, 0.1); });
    StabilityCase& far = add("one free element, 1e4 voxels off", uniform(three), {soft()});
    placed(far, [](VoxelIndex) { return glm::dvec3(1e4, 0, 0); });
    StabilityCase& stiff = add(
        "one free element, ratio 1e9",
        volume_of(three, glm::dvec3(1), [](VoxelIndex v) { return v == VoxelIndex(1) ? 1 : 0; }),
        {soft(), slack_material("stiff", 1, 0.1, 1e9)});
    placed(stiff, [](VoxelIndex) { return glm::dvec3(0.3, -0.2, 0.1); });
    StabilityCase& none = add("no free element", uniform(Size3(2, 2, 2)), {soft()});
    none.grabs = {{VoxelIndex(0), 0.0, {0.5, 0, 0}}};
    StabilityCase& single = add("a volume of one voxel", uniform(Size3(1)), {soft()});
    single.grabs = {{VoxelIndex(0), 0.0, {5, 0, 0}}};
    add_block("nothing has moved", {soft()});
    StabilityCase& pinned = add_block("all pinned", {soft()});
    pinned.grabs = {grab_middle(oblique(), 2.0 * edge_)};
  }

  static std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%g", value);
    return text;
  }

  int edge_;
  int middle_;
  std::uint64_t seed_;
  const std::vector<std::string>& groups_;
  std::string group_;
  std::vector<StabilityCase> cases_;
};

}  // namespace

const std::vector<std::string>& stability_groups() {
  static const std::vector<std::string> kGroups = [] {
    std::vector<std::string> names;
    for (const auto& part : Sweep::parts()) names.emplace_back(part.first);
    return names;
  }();
  return kGroups;
}

std::vector<StabilityCase> stability_cases(int edge, std::uint64_t seed,
                                           const std::vector<std::string>& groups) {
  return Sweep(edge, seed, groups).all();
}

}  // namespace maille
