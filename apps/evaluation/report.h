#pragma once

#include "methods/instances.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::io {

/** \brief Counts added up, errors weighted with theirs: over all points and all measurements of all frames. */
class QualityOfSequence {
 public:
  void add(const ReprojectionQuality& quality);
  /** \brief An error is NaN where nobody saw a point. */
  ReprojectionQuality result() const;

 private:
  ReprojectionQuality sum_;
  double error_{0}, multi_view_error_{0};
};

/** \brief Collects what a run did, frame by frame; errors in millimetres, shares from 0 to 1. */
class Report {
 public:
  /** \param cameras their names, for summary() */
  explicit Report(std::string method, std::vector<std::string> cameras = {})
      : method_(std::move(method)), cameras_(std::move(cameras)) {}
  /** \brief Without a quality, its figures are null. */
  void addFrame(std::size_t frame, const FrameStatistics& statistics, const std::optional<ReprojectionQuality>& quality,
                const std::optional<SurfaceQuality>& surface = std::nullopt);

  /** \brief Adds an entry to json(). */
  void note(const std::string& key, nlohmann::json value) { notes_[key] = std::move(value); }

  /** \brief Per frame and in total; medians and 95th percentiles of the times; the
   *  quality over the points and measurements of all frames, null if there are none. */
  nlohmann::json json() const;
  /** \brief A few lines for people, one for each camera that missed a frame. */
  std::string summary() const;

 private:
  struct Frame {
    std::size_t number;
    FrameStatistics statistics;
    std::optional<ReprojectionQuality> quality;
    std::optional<SurfaceQuality> surface;
    double peak_memory_mib;  ///< of the process, up to the end of this frame
  };
  std::string method_;
  std::vector<std::string> cameras_;
  std::vector<Frame> frames_;
  nlohmann::json notes_ = nlohmann::json::object();
};

/** \brief A JSON file's text. Names of files need not be UTF-8, which JSON is: what is not becomes "�". */
std::string jsonText(const nlohmann::json& json);

/** \brief The quality figures as the tools print them; null where there was nothing to measure. */
nlohmann::json qualityJson(const ReprojectionQuality& quality);
/** \brief What can be said of the surface without the truth, in the same way. */
nlohmann::json surfaceJson(const SurfaceQuality& quality);
/** \brief The header and a row of the table of either, "-" where there was nothing to measure. */
std::string surfaceHeader(std::size_t name_width);
std::string surfaceRow(const std::string& name, std::size_t name_width, const SurfaceQuality& quality);
std::string qualityHeader(std::size_t name_width);
std::string qualityRow(const std::string& name, std::size_t name_width, const ReprojectionQuality& quality);

}  // namespace fuse_flow::io
