// What study_folds() found, as a part of the relaxation's page.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "measure/fold_study.h"

namespace maille {

nlohmann::ordered_json json_of(const FoldStudy& study);
std::string text_of(const FoldStudy& study);

}  // namespace maille
