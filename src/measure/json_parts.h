// Parts that the JSON of every page of this room has in common. The keys are a contract; units
// stand in their names.
#pragma once

#include <nlohmann/json.hpp>

#include "core/spaces.h"
#include "measure/machine.h"
#include "measure/timing.h"

namespace maille {

nlohmann::ordered_json json_of(const Machine& machine);
nlohmann::ordered_json json_of(const Timing& timing);  // in milliseconds
nlohmann::ordered_json json_of(Size3 size);
nlohmann::ordered_json json_of(glm::dvec3 v);
std::string text_of(const nlohmann::ordered_json& json);

}  // namespace maille
