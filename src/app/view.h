// The picture of a document: one renderer, one camera, what the scene says of colours.
//
// Owned by one thread (the render thread, where there is a window). Once it is made it takes
// nothing of the document but what Document::take_view hands out, and shares its pool of workers.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "app/document.h"
#include "app/statistics.h"
#include "render/renderer.h"

namespace maille {

struct ViewOptions {
  RendererOptions renderer;
  PictureSize size{512, 512};
};

// The scene's camera, or what it leaves open from a camera that frames the whole volume.
Camera camera_of(const CameraSettings& settings, const Volume& volume, PictureSize size);

class View {
 public:
  // Nothing is uploaded yet. Errors: device, out_of_memory.
  static Result<std::unique_ptr<View>> create(Document& document, const ViewOptions& options);

  // Resamples and uploads the update's bricks, and whatever else the picture wants, as one batch.
  Result<void> show(ViewUpdate update);
  // Uploads what the picture wants of the state shown last: other settings may show more of it.
  Result<void> show_wanted();
  // What was shown last. Waits for it.
  Result<Picture> picture();
  Result<std::optional<PickHit>> pick(glm::ivec2 pixel, PictureSize size);
  // Rest position of a voxel position in what was shown last; the same where nothing is deformed.
  glm::dvec3 rest_voxel(glm::dvec3 voxel) const;

  PictureSize size() const { return size_; }
  const Camera& camera() const { return camera_; }
  void set_camera(const Camera& camera) { camera_ = camera; }
  Renderer& renderer() { return *renderer_; }

  // Adds what this view did to a run's statistics.
  void report(RunStatistics& statistics);

 private:
  View(Document& document, const ViewOptions& options);
  Result<void> stream(const std::vector<std::int64_t>& bricks);

  Volume volume_;
  VoxelBox extent_;  // of its voxels, and of those beyond it, that are shown
  WorkerPool& pool_;
  bool picks_;
  PictureSize size_;
  Camera camera_;
  std::unique_ptr<Renderer> renderer_;
  std::shared_ptr<const Resampler> resampler_;
  RunStatistics::Resample resample_;
  RunStatistics::Upload upload_;
  RunStatistics::Frames frames_;
  RunStatistics::Pick pick_;
};

}  // namespace maille
