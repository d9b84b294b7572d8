// Scene files, key by key. assets/scene.schema.json says the same for editors; scene_test.cpp holds
// the two together.
#include <algorithm>

#include "app/cut_json.h"
#include "app/json_document.h"
#include "app/paths.h"
#include "app/scene.h"
#include "material/limits_from_stiffness.h"

namespace maille {
namespace {

constexpr double kMaxDragVoxels = 1e6;  // what Deformer takes
constexpr std::string_view kActions =
    "drag, relax, cut, carve, restore, render, release, undo, redo, save";

std::filesystem::path read_path(const JsonReader& value, const std::filesystem::path& base) {
  const std::filesystem::path path = value.string();
  return path.is_absolute() ? path : base / path;
}

VolumeSource read_volume_source(const JsonReader& value, const std::filesystem::path& base) {
  if (value.has("file")) {
    value.expect_object({"file"});
    return read_path(value.at("file"), base);
  }
  if (value.is_object() && !value.has("phantom")) {
    value.refuse("expected a \"file\" or a \"phantom\"");
    return {};
  }
  value.expect_object({"phantom", "size", "seed"});
  PhantomSource phantom;
  phantom.name = value.at("phantom").string();
  if (value.has("size")) phantom.size = value.at("size").integer_vector(1, 65536);
  if (value.has("seed")) phantom.seed = value.at("seed").unsigned_integer();
  return phantom;
}

MaterialPreset read_material_preset(const JsonReader& value) {
  const auto name = value.string();
  if (name == "ct") return MaterialPreset::ct;
  if (name == "relative") return MaterialPreset::relative;
  value.refuse_value("\"ct\" or \"relative\"");
  return MaterialPreset::automatic;
}

// One number for all axes or one an axis.
glm::dvec3 read_limit(const JsonReader& value, Bounds bounds) {
  if (value.is_array()) return value.vector(bounds);
  return glm::dvec3(value.number(bounds));
}

void read_limits(const JsonReader& value, glm::dvec3& compress, glm::dvec3& stretch,
                 glm::dvec3& shear) {
  if (value.has("compress")) compress = read_limit(value.at("compress"), Bounds::between(0, 1));
  if (value.has("stretch")) stretch = read_limit(value.at("stretch"), Bounds::at_least(1));
  if (value.has("shear")) shear = read_limit(value.at("shear"), Bounds::at_least(0));
}

void refuse_limits(const JsonReader& material, std::string_view reason) {
  for (const auto* const key : {"compress", "stretch", "shear"}) {
    if (material.has(key)) material.at(key).refuse(reason);
  }
}

Material read_material(const JsonReader& value, bool limits_from_stiffness) {
  value.expect_object({"name", "values", "compress", "stretch", "shear", "stiffness",
                       "rest_vector_blend", "yield_strain", "fixed", "rigid"});
  Material material;
  if (value.has("name")) material.name = value.at("name").string();
  const auto range = value.at("values");
  std::vector<double> ends;
  range.each("an array of 2 numbers",
             [&](const JsonReader& end, std::size_t) { ends.push_back(end.number()); });
  if (ends.size() != 2) {
    range.refuse_value("an array of 2 numbers");
    return material;
  }
  if (!(ends[0] < ends[1])) range.refuse("expected [low, high) with low < high");
  material.value_low = ends[0];
  material.value_high = ends[1];
  if (value.has("fixed")) material.fixed = value.at("fixed").boolean();
  if (value.has("rigid")) material.rigid = value.at("rigid").boolean();
  if (material.rigid) {
    refuse_limits(value, "a rigid material has no limits of its own");
  } else if (limits_from_stiffness) {
    refuse_limits(value, "given by stiffness, since materials.limits is \"from_stiffness\"");
  }
  read_limits(value, material.compress, material.stretch, material.shear);
  if (value.has("stiffness") || (limits_from_stiffness && !material.rigid)) {
    material.stiffness = value.at("stiffness").number(Bounds::above(0));
  }
  if (value.has("rest_vector_blend")) {
    material.rest_vector_blend = value.at("rest_vector_blend").number(Bounds::between(0, 1));
  }
  if (value.has("yield_strain")) {
    material.yield_strain = value.at("yield_strain").number(Bounds::above(0));
  }
  return material;
}

Interpolation read_interpolation(const JsonReader& value) {
  const auto name = value.string();
  if (name == "linear") return Interpolation::linear;
  if (name != "step") value.refuse_value("\"step\" or \"linear\"");
  return Interpolation::step;
}

// Whether limits come from stiffness.
bool read_limits_origin(const JsonReader& value) {
  const auto name = value.string();
  if (name == "from_stiffness") return true;
  if (name != "given") value.refuse_value("\"given\" or \"from_stiffness\"");
  return false;
}

SoftestLimits read_softest(const JsonReader& value) {
  value.expect_object({"compress", "stretch", "shear"});
  SoftestLimits softest;
  read_limits(value, softest.compress, softest.stretch, softest.shear);
  if (component_that_may_fold(softest.compress, softest.shear)) {
    value.refuse("expected compress above twice shear, so that no cell folds");
  }
  return softest;
}

std::variant<PresetMaterials, MaterialTable> read_materials(const JsonReader& value) {
  value.expect_object({"preset", "interpolation", "limits", "softest", "table"});
  PresetMaterials preset;
  if (value.has("interpolation")) {
    preset.interpolation = read_interpolation(value.at("interpolation"));
  }
  const bool derived = value.has("limits") && read_limits_origin(value.at("limits"));
  SoftestLimits softest;
  if (value.has("softest")) {
    if (!derived) value.at("softest").refuse("needs \"limits\": \"from_stiffness\"");
    softest = read_softest(value.at("softest"));
  }
  if (value.has("preset")) {
    if (value.has("table")) value.refuse("expected a \"preset\" or a \"table\", not both");
    preset.preset = read_material_preset(value.at("preset"));
  }
  if (!value.has("table")) {
    if (derived) value.at("limits").refuse("\"from_stiffness\" needs a \"table\"");
    return preset;
  }
  const auto table = value.at("table");
  std::vector<Material> materials;
  table.each("an array of materials", [&](const JsonReader& item, std::size_t) {
    materials.push_back(read_material(item, derived));
  });
  if (value.failed()) return preset;
  if (derived) {
    auto with_limits = limits_from_stiffness(std::move(materials), softest);
    if (!with_limits) {
      table.refuse(with_limits.error().message);
      return preset;
    }
    materials = *std::move(with_limits);
  }
  auto made = MaterialTable::create(std::move(materials), preset.interpolation);
  if (made) return *std::move(made);
  table.refuse(made.error().message);
  return preset;
}

AnchorRules read_anchors(const JsonReader& value) {
  AnchorRules rules;
  if (value.is_string() && value.string() == "none") {
    rules.free_border = true;
    return rules;
  }
  if (!value.is_object()) {
    value.refuse_value("\"none\" or an object with \"faces\"");
    return rules;
  }
  value.expect_object({"faces"});
  if (!value.has("faces")) return rules;
  value.at("faces").each("an array of faces", [&](const JsonReader& face, std::size_t) {
    static constexpr std::string_view kFaces[] = {"-x", "+x", "-y", "+y", "-z", "+z"};
    const auto name = face.string();
    const auto* const found = std::find(std::begin(kFaces), std::end(kFaces), name);
    if (found == std::end(kFaces)) {
      return face.refuse_value("\"-x\", \"+x\", \"-y\", \"+y\", \"-z\" or \"+z\"");
    }
    rules.faces = static_cast<std::uint8_t>(rules.faces | (1u << (found - std::begin(kFaces))));
  });
  return rules;
}

ResampleMethod read_resampling(const JsonReader& value) {
  const auto method = method_named(value.string());
  if (!method) value.refuse_value("\"nearest\", \"linear\", \"barycentric\" or \"rbf\"");
  return method.value_or(ResampleMethod::linear);
}

TransferPreset read_transfer_preset(const JsonReader& value) {
  const auto name = value.string();
  const auto known = TransferFunction::preset_names();
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    std::string expected;
    for (const auto preset : known) {
      expected += (expected.empty() ? "one of \"" : ", \"") + std::string(preset) + "\"";
    }
    value.refuse_value(expected);
  }
  return {name};
}

std::variant<TransferPreset, TransferFunction> read_transfer_function(const JsonReader& value) {
  value.expect_object({"preset", "points"});
  if (value.has("preset")) {
    if (value.has("points")) value.refuse("expected a \"preset\" or \"points\", not both");
    return read_transfer_preset(value.at("preset"));
  }
  if (!value.has("points")) return TransferPreset{};
  std::vector<TransferPoint> points;
  const auto list = value.at("points");
  list.each("an array of points", [&](const JsonReader& item, std::size_t) {
    std::vector<double> numbers;
    item.each("an array of 5 numbers", [&](const JsonReader& number, std::size_t i) {
      numbers.push_back(number.number(i == 0 ? Bounds::any() : Bounds::between(0, 1)));
    });
    if (numbers.size() != 5) return item.refuse_value("an array of 5 numbers");
    if (!points.empty() && points.back().value > numbers[0]) {
      item.refuse("expected values that do not fall from point to point");
    }
    points.push_back({numbers[0], {numbers[1], numbers[2], numbers[3]}, numbers[4]});
  });
  if (value.failed()) return TransferPreset{};
  auto made = TransferFunction::of(std::move(points));
  if (made) return *std::move(made);
  list.refuse(made.error().message);
  return TransferPreset{};
}

std::string mode_names() {
  std::string names;
  for (const RenderMode mode : kRenderModes) {
    names += (names.empty() ? "" : ", ") + std::string(name_of(mode));
  }
  return names;
}

PictureSettings read_render(const JsonReader& value) {
  value.expect_object({"mode", "iso_value", "step_voxels", "shading", "preintegration",
                       "background", "margin_voxels"});
  PictureSettings settings;
  if (value.has("mode")) {
    const auto mode = value.at("mode");
    const auto name = mode.string();
    if (const auto known = render_mode_named(name)) {
      settings.mode = *known;
    } else if (name == "slice") {
      mode.refuse("\"slice\" is not in this version's format yet (known: " + mode_names() + ")");
    } else {
      mode.refuse_value(mode_names());
    }
  }
  if (value.has("iso_value")) settings.iso_value = value.at("iso_value").number();
  if (value.has("step_voxels")) {
    settings.step_voxels = value.at("step_voxels").number(Bounds::between(0.05, 16));
  }
  if (value.has("shading")) settings.shading = value.at("shading").boolean();
  if (value.has("preintegration")) {
    settings.preintegration = value.at("preintegration").boolean();
  }
  if (value.has("background")) {
    settings.background = value.at("background").vector(Bounds::between(0, 1));
  }
  if (value.has("margin_voxels")) {
    settings.margin_voxels = static_cast<int>(value.at("margin_voxels").integer(0, 4096));
  }
  return settings;
}

CameraSettings read_camera(const JsonReader& value) {
  value.expect_object({"eye_mm", "target_mm", "up", "vertical_fov_degrees"});
  CameraSettings camera;
  const auto reach = Bounds::between(-1e9, 1e9);
  if (value.has("eye_mm")) camera.eye_mm = value.at("eye_mm").vector(reach);
  if (value.has("target_mm")) camera.target_mm = value.at("target_mm").vector(reach);
  if (value.has("up")) camera.up = value.at("up").vector(reach);
  if (value.has("vertical_fov_degrees")) {
    camera.vertical_fov_degrees = value.at("vertical_fov_degrees").number(Bounds::between(1, 170));
  }
  if (value.failed()) return camera;
  if (!(glm::length(camera.up) > 1e-6))
    value.at("up").refuse("expected a direction, got no length");
  if (camera.eye_mm && camera.target_mm && value.has("up")) {
    const auto forward = *camera.target_mm - *camera.eye_mm;
    const auto side = glm::cross(forward, camera.up);
    if (glm::length(side) <= 1e-9 * glm::length(forward) * glm::length(camera.up)) {
      value.refuse(
          "expected an eye away from the target, and an up that is not the view direction");
    }
  }
  if (camera.eye_mm && camera.target_mm && *camera.eye_mm == *camera.target_mm) {
    value.refuse("expected an eye away from the target");
  }
  return camera;
}

RelaxationSettings read_relaxation(const JsonReader& value) {
  value.expect_object({"enabled", "tolerance_voxels"});
  RelaxationSettings settings;
  if (value.has("enabled")) settings.enabled = value.at("enabled").boolean();
  if (value.has("tolerance_voxels")) {
    settings.tolerance_voxels = value.at("tolerance_voxels").number(Bounds::above(0));
  }
  return settings;
}

Action read_drag(const JsonReader& value) {
  value.expect_object({"from", "radius_voxels", "by_voxels", "by_mm", "steps", "name"});
  DragAction drag;
  const auto from = value.at("from");
  from.expect_object({"voxel", "pixel"});
  if (from.is_object() && from.has("voxel") == from.has("pixel")) {
    from.refuse("expected a \"voxel\" or a \"pixel\"");
  } else if (from.has("pixel")) {
    const auto pixel = from.at("pixel");
    std::vector<double> xy;
    pixel.each("an array of 2 numbers", [&](const JsonReader& number, std::size_t) {
      xy.push_back(number.number(Bounds::at_least(0)));
    });
    if (xy.size() != 2) {
      pixel.refuse_value("an array of 2 numbers");
    } else {
      drag.from = FromPixel{{xy[0], xy[1]}};
    }
  } else {
    drag.from = FromVoxel{from.at("voxel").vector()};
  }
  if (value.has("radius_voxels")) {
    drag.radius_voxels = value.at("radius_voxels").number(Bounds::at_least(0));
  }
  if (value.is_object() && value.has("by_voxels") == value.has("by_mm")) {
    value.refuse("expected \"by_voxels\" or \"by_mm\"");
  } else if (value.has("by_mm")) {
    drag.by_is_mm = true;
    drag.by = value.at("by_mm").vector();
  } else {
    drag.by = value.at("by_voxels").vector(Bounds::between(-kMaxDragVoxels, kMaxDragVoxels));
  }
  if (value.has("steps")) drag.steps = static_cast<int>(value.at("steps").integer(1, 100000));
  if (value.has("name")) drag.name = value.at("name").string();
  return drag;
}

Action read_relax(const JsonReader& value) {
  value.expect_object({"until_voxels", "at_most_seconds"});
  RelaxAction relax;
  if (value.has("until_voxels")) {
    relax.until_voxels = value.at("until_voxels").number(Bounds::above(0));
  }
  if (value.has("at_most_seconds")) {
    relax.at_most_seconds = value.at("at_most_seconds").number(Bounds::at_least(0));
  }
  return relax;
}

Action read_save(const JsonReader& value, const std::filesystem::path& base) {
  value.expect_object({"volume", "field", "extent"});
  SaveAction save;
  const auto read = [&](std::string_view key) {
    const auto path = read_path(value.at(key), base);
    if (!is_volume_name(path)) value.at(key).refuse_value(kVolumeName);
    return path;
  };
  if (value.has("volume")) save.volume = read("volume");
  if (value.has("field")) save.field = read("field");
  if (value.has("extent")) {
    const auto extent = saved_extent_named(value.at("extent").string());
    if (!extent) value.at("extent").refuse_value("\"grow\" or \"keep\"");
    save.extent = extent.value_or(SavedExtent::grow);
  }
  if (!save.volume && !save.field) value.refuse("expected a \"volume\" or a \"field\"");
  return save;
}

int read_count(const JsonReader& value) { return static_cast<int>(value.integer(1, 1000000)); }

Action read_action(const JsonReader& value, const std::filesystem::path& base) {
  const auto keys = value.keys();
  if (keys.size() != 1) {
    value.refuse_value("an object of one action (" + std::string(kActions) + ")");
    return {};
  }
  const auto& name = keys[0];
  const auto action = value.at(name);
  if (name == "drag") return read_drag(action);
  if (name == "relax") return read_relax(action);
  if (name == "undo") return UndoAction{read_count(action)};
  if (name == "redo") return RedoAction{read_count(action)};
  if (name == "save") return read_save(action, base);
  if (name == "render") {
    action.expect_object({"to"});
    const auto to = action.at("to");
    const auto path = read_path(to, base);
    if (!is_picture_name(path)) to.refuse_value(kPictureName);
    return RenderAction{path};
  }
  if (name == "release") {
    action.expect_object({"name"});
    return ReleaseAction{action.at("name").string()};
  }
  if (name == "cut") return read_cut(action);
  if (name == "carve") return CarveAction{read_ball(action)};
  if (name == "restore") return RestoreAction{read_ball(action)};
  action.refuse("unknown action (known: " + std::string(kActions) + ")");
  return {};
}

}  // namespace

Result<Scene> parse_scene(std::string_view text, const std::filesystem::path& file) {
  const auto in_file = [&](const Error& error) {
    return Error{error.kind, file.string() + ": " + error.message};
  };
  const auto tree = parse_json(text);
  if (!tree) return in_file(tree.error());

  std::optional<Error> error;
  const JsonReader root(*tree, "", error);
  root.expect_object({"maille_scene", "volume", "materials", "anchors", "relaxation", "resampling",
                      "transfer_function", "render", "camera", "actions"});
  const auto base = file.parent_path();
  Scene scene;
  scene.file = file;
  if (root.has("maille_scene")) root.at("maille_scene").integer(1, 1);
  scene.volume = read_volume_source(root.at("volume"), base);
  if (root.has("materials")) scene.materials = read_materials(root.at("materials"));
  if (root.has("anchors")) scene.anchors = read_anchors(root.at("anchors"));
  if (root.has("relaxation")) scene.relaxation = read_relaxation(root.at("relaxation"));
  if (root.has("resampling")) scene.resampling = read_resampling(root.at("resampling"));
  if (root.has("transfer_function")) {
    scene.transfer_function = read_transfer_function(root.at("transfer_function"));
  }
  if (root.has("render")) scene.render = read_render(root.at("render"));
  if (root.has("camera")) scene.camera = read_camera(root.at("camera"));
  if (root.has("actions")) {
    root.at("actions").each("an array of actions", [&](const JsonReader& item, std::size_t) {
      scene.actions.push_back(read_action(item, base));
    });
  }
  if (error) return in_file(*error);
  return scene;
}

}  // namespace maille
