// What a guiding state holds, in figures.
#pragma once

#include <nlohmann/json.hpp>

#include "core/guiding/focal_field.h"
#include "core/guiding/radiance_grid.h"
#include "core/guiding/sd_tree.h"

namespace lodestar {

// Quantiles are {"min", "p10", "median", "p90", "max", "mean"}; depths of D-trees also come as "histogram", the number
// of trees of depth 0, 1, ... Members of learned leaves only where a leaf that has learned nothing has none of its own.
nlohmann::json DescribeSdTree(const SdTree& tree);
nlohmann::json DescribeFocal(const FocalField& field);
nlohmann::json DescribeGrid(const RadianceGrid& grid);

// The same as lines for people.
std::string SdTreeTable(const nlohmann::json& description);
std::string FocalTable(const nlohmann::json& description);
std::string GridTable(const nlohmann::json& description);

}  // namespace lodestar
