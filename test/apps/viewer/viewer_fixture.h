#pragma once

#include "drawing/image_of.h"
#include "viewer/viewer.h"
#include "wall_source.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>

namespace viewer_test {

namespace fs = std::filesystem;
using namespace viewing;

/** \brief A viewer without a window, 400 × 300 pixels, that is driven by events as a person would drive it. Needs a display. */
class ViewerWindow : public testing::Test {
 protected:
  static constexpr int kWidth = 400, kHeight = 300;

  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "fuse_flow_viewer_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr) << pattern;
    folder_ = pattern;
    options_.method_options.device = "cpu";
    options_.width = kWidth;
    options_.height = kHeight;
    options_.offscreen = true;
    options_.play = false;
    options_.folder = folder_.string();
    options_.orbit_pictures = 4;
  }
  void TearDown() override {
    viewer_.reset();
    fs::remove_all(folder_);
  }

  /** \brief Two cameras before a wall, seen from (0, 0, 0) along z, 30° of the wall from top to bottom. */
  void openWall(std::optional<std::size_t> frames = 20, std::optional<std::size_t> damaged = std::nullopt) {
    options_.from = {0, 0, 0};
    options_.at = {0, 0, 2};
    options_.up = {0, -1, 0};
    auto wall = std::make_unique<WallSource>(frames, damaged);
    wall->frames_per_second = rate_;
    viewer_ = std::make_unique<Viewer>(std::move(wall), options_);
    viewer_->settle();
  }

  /** \brief All measurements before the wall: 38,400 points, in three slices. */
  void openThreeSlices() {
    options_.method = "concatenate";
    openWall();
    ASSERT_EQ(viewer_->panes().cloud(0)->slices.size(), 3u);
  }

  /** \brief Three simulated structured-light cameras, error_ off, around a table. */
  void openTable() {
    simulation::SimulationOptions simulation;
    simulation.scene = "table";
    simulation.rig = "ring-3";
    simulation.scale = scale_;
    simulation.faults.position_error = error_;
    options_.from = options_.at = options_.up = {};
    viewer_ = std::make_unique<Viewer>(makeSimulatedSource(simulation), options_);
    viewer_->settle();
  }

  /** \brief Presses a key, and waits for what it asks for. */
  void press(const std::string& key) {
    viewer_->window().pressKey(key);
    viewer_->settle();
  }

  void moveTo(int x, int y, bool shift = false) {
    viewer_->window().interactor()->SetEventInformation(x, y, 0, shift ? 1 : 0);
    viewer_->window().interactor()->InvokeEvent(vtkCommand::MouseMoveEvent);
  }
  void pressButton() { viewer_->window().interactor()->InvokeEvent(vtkCommand::LeftButtonPressEvent); }
  void releaseButton() { viewer_->window().interactor()->InvokeEvent(vtkCommand::LeftButtonReleaseEvent); }
  void drag(int from_x, int from_y, int to_x, int to_y) {
    moveTo(from_x, from_y);
    pressButton();
    moveTo((from_x + to_x) / 2, (from_y + to_y) / 2);
    moveTo(to_x, to_y);
    releaseButton();
  }

  /** \brief What is drawn. */
  io::ColorImage picture() {
    viewer_->render();
    return drawing::imageOf(viewer_->window().renderWindow());
  }
  /** \brief Only the clouds, without anything over them. */
  io::ColorImage bare() {
    viewer_->window().overlay()->DrawOff();
    const io::ColorImage image = picture();
    viewer_->window().overlay()->DrawOn();
    return image;
  }

  /** \brief Where a place of the world is drawn in the first pane, pixels from the lower left. */
  std::array<int, 2> drawnAt(const Eigen::Vector3d& p) {
    viewer_->panes().aimCamera(0);
    vtkRenderer* renderer = viewer_->panes().renderer(0);
    renderer->SetWorldPoint(p.x(), p.y(), p.z(), 1);
    renderer->WorldToDisplay();
    const double* display = renderer->GetDisplayPoint();
    return {static_cast<int>(std::lround(display[0])), static_cast<int>(std::lround(display[1]))};
  }

  std::size_t files() const { return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), {})); }

  double error_{0.002};               ///< metres
  double scale_{0.2};                 ///< of the simulated images, which are 640 pixels wide at 1
  std::optional<double> rate_{20.0};  ///< that the wall's recording tells, Hz
  fs::path folder_;
  ViewerOptions options_;
  std::unique_ptr<Viewer> viewer_;
};

/** \brief Share of the pixels, in columns [begin, end), that differ visibly. */
inline double difference(const io::ColorImage& a, const io::ColorImage& b, int begin = 0, int end = -1) {
  if (a.width != b.width || a.height != b.height) return 1;
  if (end < 0) end = a.width;
  std::size_t different = 0;
  for (int v = 0; v < a.height; ++v)
    for (int u = begin; u < end; ++u) {
      const Rgb8 p = a.at(u, v), q = b.at(u, v);
      if (std::abs(p.r - q.r) + std::abs(p.g - q.g) + std::abs(p.b - q.b) > 24) ++different;
    }
  return static_cast<double>(different) / static_cast<double>((end - begin) * a.height);
}

/** \brief Share of the pixels that are not of the first pixel's colour. */
inline double filled(const io::ColorImage& image) {
  io::ColorImage empty = image;
  for (Rgb8& pixel : empty.data) pixel = {20, 23, 28};  // the background at night
  return difference(image, empty);
}

}  // namespace viewer_test
