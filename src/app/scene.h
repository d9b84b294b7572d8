// What to open and what to do with it: the scene file, as assets/scene.schema.json describes it.
// Everything has a default but the volume.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/result.h"
#include "core/spaces.h"
#include "deform/anchors.h"
#include "material/material_table.h"
#include "render/transfer_function.h"
#include "render/volume_texture.h"
#include "resample/resampler.h"

namespace maille {

struct PhantomSource {
  std::string name;
  Size3 size{128};
  std::optional<std::uint64_t> seed;  // else the command line's
};
using VolumeSource = std::variant<std::filesystem::path, PhantomSource>;

// automatic: ct for Hounsfield units (a signed type whose lowest value is at most -500), else
// relative to the volume's range.
enum class MaterialPreset : std::uint8_t { automatic, ct, relative };
struct PresetMaterials {
  MaterialPreset preset = MaterialPreset::automatic;
  Interpolation interpolation = Interpolation::step;
};

// A name of TransferFunction::preset; empty: ct-skin or relative, chosen as materials are.
struct TransferPreset {
  std::string name;
};

struct PictureSettings {
  RenderMode mode = RenderMode::composite;
  std::optional<double> iso_value;  // else the transfer function's surface
  double step_voxels = 1.0;
  bool shading = true;
  bool preintegration = true;
  glm::dvec3 background{0.1, 0.11, 0.13};
  int margin_voxels = 0;  // of what was pulled out of the volume, on every side
};

// What is not given frames the whole volume from the front.
struct CameraSettings {
  std::optional<glm::dvec3> eye_mm;
  std::optional<glm::dvec3> target_mm;
  glm::dvec3 up{0, 0, 1};
  double vertical_fov_degrees = 30.0;
};

struct RelaxationSettings {
  bool enabled = true;  // false leaves every relax action out
  double tolerance_voxels = 0.01;
};

struct FromVoxel {
  glm::dvec3 voxel;  // the nearest element is meant
};
struct FromPixel {
  glm::dvec2 pixel;  // the element seen there is meant
};

struct DragAction {
  std::variant<FromVoxel, FromPixel> from;
  double radius_voxels = 4.0;
  glm::dvec3 by{0.0};
  bool by_is_mm = false;  // else voxels
  int steps = 1;
  std::string name;
};
struct RelaxAction {
  std::optional<double> until_voxels;  // else the scene's tolerance
  double at_most_seconds = 5.0;
};
struct RenderAction {
  std::filesystem::path to;
};
struct ReleaseAction {
  std::string name;
};
struct UndoAction {
  int count = 1;
};
struct RedoAction {
  int count = 1;
};
// Which voxels are saved: as many more as it takes to hold all that was pulled out of the volume,
// or those of the volume alone.
enum class SavedExtent : std::uint8_t { grow, keep };

std::optional<SavedExtent> saved_extent_named(std::string_view name);

struct SaveAction {
  std::optional<std::filesystem::path> volume;
  std::optional<std::filesystem::path> field;
  SavedExtent extent = SavedExtent::grow;
};

// What is cut and carved lies where a person sees it: in the volume as it is deformed then.
struct ScenePoint {
  glm::dvec3 at{0.0};
  bool is_mm = false;  // in the world; else voxels
};
struct CutPolygon {
  std::vector<ScenePoint> corners;
};
struct CutDisc {
  ScenePoint center;
  glm::dvec3 normal{0, 0, 1};  // in the world, as the direction of a sweep
  double radius_mm = 1.0;
};
struct CutSweep {
  std::vector<ScenePoint> path;
  glm::dvec3 direction{0, 0, 1};
  double depth_mm = 1.0;
};
struct CutAction {
  std::variant<CutPolygon, CutDisc, CutSweep> surface;
};
struct Ball {
  ScenePoint center;
  double radius_voxels = 1.0;
};
struct CarveAction {
  Ball ball;
};
struct RestoreAction {
  Ball ball;
};
using Action = std::variant<DragAction, RelaxAction, RenderAction, ReleaseAction, UndoAction,
                            RedoAction, SaveAction, CutAction, CarveAction, RestoreAction>;

std::string_view name_of(const Action& action);  // "drag", "relax" ...

struct Scene {
  std::filesystem::path file;  // where it was read from; empty for a scene around a bare volume
  VolumeSource volume;
  std::variant<PresetMaterials, MaterialTable> materials;
  AnchorRules anchors;
  RelaxationSettings relaxation;
  ResampleMethod resampling = ResampleMethod::linear;
  std::variant<TransferPreset, TransferFunction> transfer_function;
  PictureSettings render;
  CameraSettings camera;
  std::vector<Action> actions;
};

// Paths in the text are taken relative to file's folder; file also names the text in messages.
// Errors: bad_input, "FILE: PATH.OF.KEY: expected ..., got ..." or "FILE: line L, column C: ...".
Result<Scene> parse_scene(std::string_view text, const std::filesystem::path& file);

// A scene file (.json), or a volume, which gets the default scene around it. The volume itself is
// not opened. Errors: as above; file_system.
Result<Scene> open_scene(const std::filesystem::path& input);

}  // namespace maille
