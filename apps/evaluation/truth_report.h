#pragma once

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

}  // namespace fuse_flow::simulation
