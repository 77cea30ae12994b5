#pragma once

#include "evaluation/truth_parts.h"
#include "evaluation/truth_quality.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace fuse_flow::simulation {

/** \brief The mean of each figure over the frames in which it is known; points and samples: rounded means. */
TruthQuality meanOf(const std::vector<TruthQuality>& frames);

/** \brief Millimetres, shares from 0 to 1, degrees; null where a figure is not known. */
nlohmann::json truthJson(const TruthQuality& quality);

/** \brief The header and a row of the table of figures against the truth. \param flicker millimetres, NaN: one frame only */
std::string truthHeader(std::size_t name_width);
std::string truthRow(const std::string& name, std::size_t name_width, const TruthQuality& quality, double flicker);

/** \brief By name; parts without visible samples are left out. */
nlohmann::json partsJson(const std::vector<PartQuality>& parts);

/** \brief A table of the parts that have visible samples, a row for each of the clouds. */
std::string partsTable(const std::vector<std::string>& clouds, std::size_t name_width,
                       const std::vector<std::vector<PartQuality>>& parts);

}  // namespace fuse_flow::simulation
