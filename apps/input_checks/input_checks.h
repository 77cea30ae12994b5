#pragma once

#include "input_checks/color_check.h"
#include "input_checks/depth_in_range.h"
#include "input_checks/estimated_depth.h"
#include "input_checks/lens_check.h"
#include "input_checks/noise_check.h"
#include "input_checks/view_overlap.h"

#include <fuse_flow/fusion/parameters.h>
#include <fuse_flow/recordings/recording.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief What is wrong with the input, though it can be read: for the end, when all of it was seen. */
class InputChecks {
 public:
  /** \param method that fuses, see makeMethod()  \param estimated of each camera whether stereo made its depth
   *  \param whole whether frames have the views of all cameras; else nothing is said of how they agree */
  InputChecks(const std::string& method, const FuseFlowParameters& parameters, std::vector<bool> estimated,
              bool whole = true)
      : estimated_(std::move(estimated)),
        whole_(whole),
        depth_(parameters.preprocessing),
        confidence_(method == "fuse_flow" ? std::optional(parameters.min_confidence) : std::nullopt,
                    method == "fuse_flow" && parameters.use_measurement_confidence &&
                            parameters.confidence.form == ConfidenceForm::Given
                        ? std::optional(parameters.confidence.threshold)
                        : std::nullopt),
        overlap_(parameters.preprocessing),
        agreement_(method, parameters) {}

  void look(const LoadedFrame& frame) {
    depth_.look(frame.rig);
    lens_.look(frame.rig);
    color_.look(frame.rig);
    confidence_.look(frame, estimated_);
    if (whole_) overlap_.look(frame.rig);
  }
  /** \brief After look(), with what the fusion has found. */
  void lookAt(const RigFrame& rig, const FrameStatistics& statistics) {
    noise_.look(rig, statistics);
    agreement_.look(rig, statistics);
  }
  std::vector<std::string> complaints() const {
    std::vector<std::string> all;
    for (const std::vector<std::string>& some :
         {depth_.complaints(), lens_.complaints(), confidence_.complaints(), noise_.complaints(), color_.complaints(),
          overlap_.complaints(), agreement_.complaints()})
      all.insert(all.end(), some.begin(), some.end());
    return all;
  }

 private:
  std::vector<bool> estimated_;
  bool whole_;
  DepthInRange depth_;
  LensCheck lens_;
  ColorCheck color_;
  ConfidenceCheck confidence_;
  NoiseCheck noise_;
  OverlapCheck overlap_;
  AgreementCheck agreement_;
};

}  // namespace fuse_flow::io
