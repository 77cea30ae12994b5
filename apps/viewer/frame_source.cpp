#include "viewer/frame_source.h"

#include "evaluation/truth.h"

#include <filesystem>

namespace fuse_flow::viewing {
namespace {

namespace fs = std::filesystem;

class RecordedSource : public FrameSource {
 public:
  RecordedSource(std::unique_ptr<io::Recording> recording, const fs::path& input)
      : recording_(std::move(recording)), frames_(recording_->frames()) {
    const fs::path folder = fs::is_directory(input) ? input : input.parent_path();
    name_ = fs::absolute(folder).lexically_normal().filename().string();
    if (name_.empty()) name_ = folder.string();
    if (fs::exists(folder / "truth" / "simulation.json")) truth_.emplace(folder.string());
  }

  std::string name() const override { return name_; }
  std::optional<std::size_t> frameCount() const override { return frames_.size(); }
  std::optional<double> framesPerSecond() const override { return recording_->framesPerSecond(); }
  std::vector<std::string> inputs() const override { return recording_->inputs(); }
  void read(std::size_t frame, io::LoadedFrame& out) override { recording_->read(frames_[frame], out); }
  bool knowsTruth() const override { return truth_.has_value(); }
  const simulation::RayScene& truth(std::size_t frame) override { return truth_->frame(frames_[frame]); }

 private:
  std::unique_ptr<io::Recording> recording_;
  std::vector<std::size_t> frames_;  ///< their numbers in it
  std::string name_;
  std::optional<simulation::Truth> truth_;
};

class SimulatedSource : public FrameSource {
 public:
  explicit SimulatedSource(const simulation::SimulationOptions& options) : simulator_(options) {}

  std::string name() const override {
    const simulation::SimulationOptions& o = simulator_.options();
    return "simulated " + o.scene + ", " + o.rig + ", " + o.sensor;
  }
  std::optional<std::size_t> frameCount() const override { return std::nullopt; }
  std::optional<double> framesPerSecond() const override { return simulator_.options().frames_per_second; }
  void read(std::size_t frame, io::LoadedFrame& out) override { simulator_.measure(frame, out); }
  bool knowsTruth() const override { return true; }
  const simulation::RayScene& truth(std::size_t frame) override { return simulator_.truth(frame); }

 private:
  simulation::Simulator simulator_;
};

}  // namespace

bool isStream(const std::string& input) {
  for (const char* scheme : {"ws://", "wss://", "http://", "https://"})
    if (input.rfind(scheme, 0) == 0) return true;
  return std::filesystem::path(input).extension() == ".ffs";
}

std::unique_ptr<FrameSource> makeSource(std::unique_ptr<io::Recording> recording, const std::string& input) {
  return std::make_unique<RecordedSource>(std::move(recording), input);
}

std::unique_ptr<FrameSource> makeSimulatedSource(const simulation::SimulationOptions& options) {
  return std::make_unique<SimulatedSource>(options);
}

}  // namespace fuse_flow::viewing
