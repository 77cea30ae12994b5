#pragma once

#include "evaluation/report.h"
#include "sinks/frame_sink.h"

#include <string>
#include <utility>

namespace fuse_flow::io {

/** \brief Measures each frame, and adds up what the run did. */
class QualityReport : public FrameSink {
 public:
  struct Options {
    bool measure{true};  ///< false: times and counts alone
    ReprojectionQualityParameters reprojection;
    SurfaceQualityParameters surface;
    unsigned int threads{0};  ///< 0: one per core
    std::string file;         ///< JSON; empty: none
  };

  /** \param method what made the clouds  \param cameras their names */
  QualityReport(std::string method, std::vector<std::string> cameras, Options options);

  /** \brief Flicker is measured where two frames follow one another. */
  void take(const std::shared_ptr<const FusedFrame>& frame) override;
  /** \brief Writes the file. */
  std::vector<std::string> finish() override;
  /** \brief See Report::note(). */
  void note(const std::string& key, nlohmann::json value) { report_.note(key, std::move(value)); }
  const Report& report() const { return report_; }

 private:
  Options options_;
  Report report_;
  std::shared_ptr<const FusedFrame> before_;
};

}  // namespace fuse_flow::io
