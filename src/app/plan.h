// What a scene does not need is left out, decided here, before anything is made. What depends on
// the materials follows as soon as they are known: a preset is chosen by the volume.
#pragma once

#include <string>
#include <vector>

#include "app/scene.h"

namespace maille {

// What the command wants besides playing the scene.
struct Purpose {
  bool pictures = false;  // the command draws: render actions and picked drags can be done
  bool window = false;    // a person may do anything
  bool picks = false;     // the command itself asks what is seen at a pixel
};

struct Plan {
  bool chainmail = false;        // drags
  bool cut = false;              // links taken out by cuts
  bool carve = false;            // elements taken out and brought back
  bool undo = false;             // steps are kept
  bool relaxation = false;       // active lists, forces
  bool resampling = false;       // an inverse map; else voxels are copied
  bool material_lookup = false;  // more than one material, and something that asks for it
  bool anchors = false;          // faces or a material that never move
  bool vulkan = false;
  bool pick_pass = false;
  bool render_actions = false;  // false: the scene asks for pictures that this command skips
  bool shading = false;         // gradients
  bool composite = false;
  bool iso = false;
  bool mip = false;
  bool average = false;
  bool window = false;

  // Any of these: a lattice and a deformer.
  bool deforms() const { return chainmail || cut || carve; }
  // Once, with the scene's table or the one its preset stands for; asked for by chainmail only.
  void use(const MaterialTable& materials);
  std::vector<std::string> left_out() const;
};

// All but what depends on the materials.
Plan plan_of(const Scene& scene, const Purpose& purpose);

}  // namespace maille
