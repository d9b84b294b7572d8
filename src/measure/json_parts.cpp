#include "measure/json_parts.h"

namespace maille {

using Json = nlohmann::ordered_json;

Json json_of(const Machine& machine) {
  Json triad = Json::object();
  for (const auto& [threads, gb_per_s] : machine.triad_gb_per_s) {
    triad[std::to_string(threads)] = gb_per_s;
  }
  return {{"processor", machine.processor},
          {"hardware_threads", machine.hardware_threads},
          {"triad_gb_per_s", triad}};
}

Json json_of(const Timing& timing) {
  return {{"median", 1e3 * timing.median_seconds},
          {"least", 1e3 * timing.least_seconds},
          {"most", 1e3 * timing.most_seconds},
          {"runs", timing.runs}};
}

Json json_of(Size3 size) { return {size.x, size.y, size.z}; }

Json json_of(glm::dvec3 v) { return {v.x, v.y, v.z}; }

std::string text_of(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace maille
