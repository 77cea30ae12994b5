#pragma once

#include <fuse_flow/recordings/recording.h>

#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Finds the cameras whose points stay black, though there is colour: frames without it, and colour images into which no point
 *  falls. */
class ColorCheck {
 public:
  void look(const RigFrame& frame);

  /** \brief A line for each of them. None where no camera has any colour. */
  std::vector<std::string> complaints() const;

 private:
  struct Seen {
    std::string name;
    std::size_t frames{0};     ///< with depth
    std::size_t colored{0};    ///< of those, with colour
    bool own_camera{false};    ///< of colour
    bool any_in_image{false};  ///< a point that falls into the colour image
    double baseline{0};        ///< from depth to colour camera, metres
  };
  std::vector<Seen> cameras_;
};

/** \brief Finds the cameras whose confidence images, taken by the largest value of their type, never say more than half: more often
 *  than not they count in a unit of their own. And those of whose measurements more than half are dropped for their confidence. */
class ConfidenceCheck {
 public:
  /** \param min_confidence FuseFlowParameters::min_confidence; none where the method does not look at confidence
   *  \param tau that of eq. 9 where it looks at the confidence that is given (ConfidenceForm::Given); else none */
  explicit ConfidenceCheck(std::optional<float> min_confidence, std::optional<float> tau = std::nullopt)
      : min_confidence_(min_confidence), tau_(tau) {}

  /** \param estimated of each camera whether stereo made its confidence: that is low where it should be; empty: of none */
  void look(const LoadedFrame& frame, const std::vector<bool>& estimated = {});
  std::vector<std::string> complaints() const;

 private:
  struct Seen {
    std::string name;
    float step{0};             ///< what was assumed
    float largest{0};          ///< confidence
    std::size_t measured{0};   ///< pixels with depth and a confidence image
    std::size_t dropped{0};    ///< of those, with a confidence below min_confidence
    std::size_t under_tau{0};  ///< of the others, with none over tau
  };
  std::optional<float> min_confidence_, tau_;
  std::vector<Seen> cameras_;
};

}  // namespace fuse_flow::io
