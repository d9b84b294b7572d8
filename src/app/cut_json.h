// What is cut and carved, as a scene file says it.
#pragma once

#include "app/json_document.h"
#include "app/scene.h"

namespace maille {

// The members of "cut", and of "carve" and "restore". Errors go where the reader's do.
Action read_cut(const JsonReader& value);
Ball read_ball(const JsonReader& value);

}  // namespace maille
