#include "recordings/readers/view_files.h"
#include "viewer/controls/key_bindings.h"
#include "viewer/viewer.h"

#include <fuse_flow/recordings/error.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

namespace fuse_flow::viewing {
namespace {

namespace fs = std::filesystem;

std::string fileNameOf(std::string title) {
  for (char& c : title)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return title;
}

}  // namespace

void Viewer::changeSpeed(double factor) { playback_.setSpeed(factor * playback_.speed()); }

void Viewer::seekEnd() {
  if (!playback_.frames()) return say("cameras that run have no last frame");
  playback_.seekEnd();
}

void Viewer::changeParameters(const std::function<void(FuseFlowParameters&)>& apply) {
  controls_.change(apply);
  viewMoves();  // a slider is dragged, and each move is drawn
  updateStatus();
  dirty_ = true;
}

bool Viewer::refuseForFinished() {
  if (!finished_) return false;
  say("these clouds come fused: how is up to who fuses them");
  return true;
}

void Viewer::toggle(Component component) {
  if (!refuseForFinished()) controls_.toggle(component);
}

void Viewer::resetParameters() {
  if (refuseForFinished()) return;
  controls_.reset();
  sliders_.setValues(controls_.parameters());
}

void Viewer::toggleRefinement() {
  if (refuseForFinished()) return;
  if (!options_.fixed_rig) return say("the views of this recording slide: there is no rig to follow");
  refine_extrinsics_ = !refine_extrinsics_;
  say(refine_extrinsics_ ? "poses follow what the cameras see" : "poses as given");
}

void Viewer::toggleSliders() {
  if (refuseForFinished()) return;
  show_sliders_ = !show_sliders_;
  sliders_.setValues(controls_.parameters());
  showOverlay();
}

void Viewer::toggleCropBox() {
  if (crop_box_.visible()) {
    crop_box_.hide();
    changeParameters([&](FuseFlowParameters& p) { p.crop_box = options_.method_options.parameters.crop_box; });
  } else if (shown_ && shown_->clouds[0] && !shown_->clouds[0]->cloud->empty()) {
    const std::optional<Eigen::AlignedBox3f>& box = controls_.parameters().crop_box;
    crop_box_.show(box ? *box : panes_.boxInView());
  }
}

void Viewer::compareWith(const std::string& name) {
  controls_.compareWith(name);
  panes_.setComparing(controls_.comparison() != nullptr);
  if (!controls_.comparison()) panes_.setCloud(1, nullptr);
  say(controls_.comparison() ? "to compare with: " + controls_.comparison()->title : "");
  arrange();
}

void Viewer::compareWithNext() {
  if (refuseForFinished()) return;
  controls_.compareWithNext();
  compareWith(controls_.comparedWith());
}

void Viewer::keepSetting() {
  if (refuseForFinished()) return;
  controls_.keep();
  compareWith("kept");
}

void Viewer::toggleLayout() {
  panes_.setLayout(panes_.layout() == Layout::Split ? Layout::SideBySide : Layout::Split);
  arrange();
}

void Viewer::colorBy(ColorBy what) {
  if (what == ColorBy::TruthDistance && !knows_truth_) return say("the truth of this recording is not known");
  color_by_ = what;
  if (what == ColorBy::Normal) say("normal: red along x, green along y, blue along z");
}

void Viewer::listColors() {
  constexpr std::size_t first_key = 4;
  std::string list;
  for (std::size_t k = 0; k < colorByNames().size(); ++k)
    list += (k > 0 ? ", " : "") + colorByNames()[k] + " (" + std::to_string(first_key + k) + ")";
  std::cout << "colours: " << list << std::endl;
  say("colours: " + list);
}

void Viewer::toggleLegend() {
  show_legend_ = !show_legend_;
  overlay_.showLegend(show_legend_);
  const bool has_legend = color_by_ != ColorBy::Rgb && color_by_ != ColorBy::Normal;
  say(!show_legend_ ? "legend off" : has_legend ? "legend on" : "legend on; of these colours there is none");
  arrange();
}

void Viewer::resetView() {
  if (!shown_ || !shown_->clouds[0]) return;
  Viewpoint view = startViewpoint(*shown_->clouds[0]->cloud, shown_->cameras);
  if (crop_box_.visible()) view = lookingAtAllOf(crop_box_.box(), view);
  if (!options_.from.empty() || !options_.at.empty()) view.angle = Viewpoint().angle;
  const auto given = [](const std::vector<double>& v, Eigen::Vector3d& place) {
    if (v.size() == 3) place = Eigen::Vector3d(v[0], v[1], v[2]);
  };
  given(options_.from, view.from);
  given(options_.at, view.at);
  given(options_.up, view.up);
  vtkCamera* camera = panes_.camera();
  camera->SetPosition(view.from.data());
  camera->SetFocalPoint(view.at.data());
  camera->SetViewUp(view.up.data());
  camera->SetViewAngle(view.angle / options_.zoom);
  panes_.fitClippingRange();
  redraw();
}

void Viewer::lookFromNextCamera() {
  if (!shown_ || shown_->cameras.empty()) return;
  const Camera& from = shown_->cameras[next_camera_++ % shown_->cameras.size()];
  const Eigen::Isometry3d& T = from.T_world_camera;
  const Eigen::Vector3d centre = T.translation(), at = T * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d up = -(T.linear() * Eigen::Vector3d::UnitY());
  vtkCamera* camera = panes_.camera();
  camera->SetPosition(centre.data());
  camera->SetFocalPoint(at.data());
  camera->SetViewUp(up.data());
  const double rows = from.intrinsics.height, focal = static_cast<double>(from.intrinsics.fy);
  camera->SetViewAngle(2 * std::atan(rows / (2 * focal)) * 180 / M_PI);
  panes_.fitClippingRange();
  say("from " + from.name);
}

void Viewer::flyToCursor() {
  const int* at = window_.interactor()->GetEventPosition();
  const std::optional<PickedPoint> point = probe_.pick(at[0], at[1]);
  if (!point) return say("there is no point under the cursor");
  viewMoves();
  window_.interactor()->FlyTo(panes_.renderer(point->pane), static_cast<double>(point->position.x()),
                              static_cast<double>(point->position.y()), static_cast<double>(point->position.z()));
}

void Viewer::changePointSize(double pixels) {
  point_size_ = std::clamp(point_size_ + pixels, 1.0, 20.0);
  panes_.setPointSize(point_size_);
}

void Viewer::drawAs(Form form) { panes_.setForm(form); }

void Viewer::toggleAxes() {
  show_axes_ = !show_axes_;
  axes_.showAxes(show_axes_);
}

void Viewer::toggleGrid() {
  show_grid_ = !show_grid_;
  axes_.showGrid(show_grid_);
}

void Viewer::toggleBackground() {
  day_ = !day_;
  day_ ? panes_.setBackground(0.93, 0.93, 0.93) : panes_.setBackground(0.08, 0.09, 0.11);
  axes_.setColor(day_ ? 0.0 : 1.0);
  day_ ? crop_box_.setColor(0, 0.4, 0.5) : crop_box_.setColor(0.2, 0.9, 1);
}

void Viewer::toggleFrusta() {
  show_frusta_ = !show_frusta_;
  frusta_.setVisible(show_frusta_);
}

void Viewer::toggleImages() {
  show_images_ = !show_images_;
  showOverlay();
}

void Viewer::toggleText() {
  show_text_ = !show_text_;
  showOverlay();
}

void Viewer::toggleHelp() {
  show_help_ = !show_help_;
  overlay_.setHelp(show_help_ ? helpText() : "");
  showOverlay();
}

/** \brief While the help is there, nothing else is to be read. */
void Viewer::showOverlay() {
  overlay_.showStatus(show_text_ && !show_help_);
  overlay_.showImages(show_images_ && !show_help_);
  timeline_.setVisible(show_text_ && !show_help_);
  sliders_.setVisible(show_sliders_ && !show_help_);
  arrange();
}

void Viewer::passKeyToPcl() {
  viewMoves();  // PCL draws, more than once
  window_.style()->passKeyToPcl();
}

void Viewer::markCursor() {
  const int* at = window_.interactor()->GetEventPosition();
  const std::optional<PickedPoint> point = probe_.pick(at[0], at[1]);
  if (!point) return say("there is no point under the cursor");
  probe_.mark(*point);
  probeCursor();
}

void Viewer::clearMarks() {
  probe_.clear();
  selecting_ = false;
  say("");
  probeCursor();
}

void Viewer::toggleSelecting() {
  selecting_ = !selecting_;
  if (!selecting_) say("the left button turns the view");
  probeCursor();
}

std::string Viewer::unusedPath(const std::string& stem, const std::string& extension) const {
  for (int number = 0;; ++number) {
    char name[16];
    std::snprintf(name, sizeof(name), "_%03d", number);
    const fs::path path = fs::path(options_.folder) / (stem + name + extension);
    if (!fs::exists(path)) return path.string();
  }
}

void Viewer::exportClouds() {
  if (!shown_) return say("there is no cloud yet");
  std::string written;
  for (const auto& cloud : shown_->clouds) {
    if (!cloud) continue;
    const std::string path = unusedPath(
        "frame_" + io::frameStem(shown_->frame) + "_" + fileNameOf(cloud->setting->title), "." + options_.format);
    writeShownCloud(path, *cloud->cloud);
    written += (written.empty() ? "wrote " : " and ") + path;
  }
  say(written);
}

void Viewer::exportScreenshot() {
  const std::string path = unusedPath("screenshot", ".png");
  withoutMessage([&] { writeScreenshot(path, window_.renderWindow()); });
  const std::string camera = fs::path(path).replace_extension(".cam").string();
  if (!window_.style()->saveCameraParameters(camera)) throw io::OutputError(camera + ": cannot be written");
  say("wrote " + path);
}

void Viewer::toggleOrbit() {
  if (orbit_) {
    orbit_->goBack(panes_.camera());
    orbit_.reset();
    panes_.fitClippingRange();
    return say("the film ends here");
  }
  const std::string path = unusedPath("film", options_.film_format == "ogv" ? ".ogv" : "");
  orbit_ = std::make_unique<Orbit>(path, options_.orbit_pictures);
  say("filming into " + path);
}

void Viewer::film(const std::string& path) {
  orbit_ = std::make_unique<Orbit>(path, options_.orbit_pictures);
  while (orbit_) {
    settle();
    stepOrbit();
  }
}

/** \brief Transient messages are only for the user at the window. */
void Viewer::withoutMessage(const std::function<void()>& take_picture) {
  struct Shown {
    Viewer& viewer;
    ~Shown() {
      viewer.overlay_.showMessage(true);
      viewer.dirty_ = true;
    }
  } const again{*this};
  overlay_.showMessage(false);
  render();
  take_picture();
}

/** \brief A film shows each frame as long as the recording does, however long it takes to fuse. */
void Viewer::stepOrbit() {
  if (answered_ != posted_->number) return;
  panes_.setCoarse(false);
  refine_in_ = -1;
  try {
    withoutMessage([&] { orbit_->step(window_.renderWindow(), panes_.camera()); });
  } catch (const std::exception&) {
    orbit_.reset();
    throw;
  }
  panes_.fitClippingRange();
  playback_.advance(1.0 / kVideoRate);
  redraw();
  if (!orbit_->done()) return;
  orbit_.reset();
  say("the film is done");
}

void Viewer::quit() { quitting_ = true; }

}  // namespace fuse_flow::viewing
