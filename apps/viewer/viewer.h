#pragma once

#include "viewer/capture.h"
#include "viewer/controls/fusion_controls.h"
#include "viewer/controls/overlay.h"
#include "viewer/controls/parameter_sliders.h"
#include "viewer/controls/rubber_band.h"
#include "viewer/controls/status_text.h"
#include "viewer/controls/timeline.h"
#include "viewer/fusing/fusion_worker.h"
#include "viewer/fusing/running_rate.h"
#include "viewer/panes.h"
#include "viewer/playback.h"
#include "viewer/window.h"
#include "viewer/world/crop_box.h"
#include "viewer/world/frusta.h"
#include "viewer/world/probe.h"
#include "viewer/world/viewpoint.h"
#include "viewer/world/world_axes.h"

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

/** \brief Of most depth cameras. */
constexpr double kFramesPerSecond = 30;

/** \brief How the viewer starts. */
struct ViewerOptions {
  std::string method{"fuse_flow"};  ///< as io::makeMethod() names it
  io::MethodOptions method_options;
  /** \brief At which frames were taken, in place of what the source says; where neither does, kFramesPerSecond. */
  std::optional<double> frames_per_second;
  double speed{1};
  bool play{true};
  bool loop{true};
  std::size_t first_frame{0};
  bool measure{true};             ///< the figures of what is shown
  bool refine_extrinsics{false};  ///< poses follow what the cameras see
  bool fixed_rig{true};           ///< false: the cameras move from frame to frame, and there is nothing to follow
  std::string compare{"none"};    ///< one of FusionControls::comparisonNames()
  Layout layout{Layout::SideBySide};
  double split{0.5};
  ColorBy color_by{ColorBy::Rgb};
  double point_size{2};              ///< pixels
  std::vector<double> from, at, up;  ///< viewpoint, metres; empty: startViewpoint()
  double zoom{1};
  int width{1280};  ///< pixels
  int height{800};
  bool offscreen{false};
  std::string folder{"."};         ///< of what the keys export
  std::string format{"ply"};       ///< of exported clouds: one of cloudFormats()
  std::string film_format{"ogv"};  ///< of films by key: "ogv", or "png" for numbered pictures
  int orbit_pictures{120};
};

/** \brief Plays a source in a window: asks the worker for what should be seen, shows what comes, and does what the keys say. */
class Viewer {
 public:
  Viewer(std::unique_ptr<FrameSource> source, const ViewerOptions& options);
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  /** \brief Until the window is closed, or someone quits or interrupts, or ended, asked again and again, says so. */
  void run(const std::function<bool()>& ended = {});
  /** \brief Waits until what is asked for is shown. */
  void settle();
  /** \brief Lets that much time pass, as run() does between events; seconds. */
  void tick(double seconds);
  /** \brief While tick() draws all points, it asks this again and again, and abandons the picture when it hears yes: somebody waits
   *  for something else. run() asks for the window's events. */
  void setInterrupt(std::function<bool()> somebody_waits) { somebody_waits_ = std::move(somebody_waits); }
  /** \brief See FusionWorker::stopWithin(). */
  bool stopWithin(std::chrono::milliseconds limit) { return worker_.stopWithin(limit); }
  /** \brief What went wrong with the frame that was asked for last; empty: nothing. */
  const std::string& error() const { return error_; }
  /** \brief All that went wrong with frames since the start, files that cannot be read included; each once. */
  const std::vector<std::string>& problems() const { return problems_; }
  /** \brief Null until the first one came. */
  const std::shared_ptr<const FusedFrame>& shown() const { return shown_; }

  Window& window() { return window_; }
  Playback& playback() { return playback_; }
  FusionControls& controls() { return controls_; }
  Panes& panes() { return panes_; }
  Overlay& overlay() { return overlay_; }
  ParameterSliders& sliders() { return sliders_; }
  Timeline& timeline() { return timeline_; }
  ColorBy coloredBy() const { return color_by_; }
  double pointSize() const { return point_size_; }
  /** \brief Between the two marked points, metres. */
  std::optional<double> markedDistance() const { return probe_.distance(); }
  bool filming() const { return orbit_ != nullptr; }
  bool quitting() const { return quitting_; }
  /** \brief What the overlay said last. */
  const std::string& message() const { return message_; }

  ///@{
  /** \brief What the keys do. */
  void changeSpeed(double factor);
  void seekEnd();
  void toggle(Component component);
  /** \brief Says so, where clouds come fused and there is nothing to change. */
  bool refuseForFinished();
  void resetParameters();
  void toggleRefinement();
  void toggleSliders();
  void toggleCropBox();
  void compareWith(const std::string& name);
  void compareWithNext();
  void keepSetting();
  void toggleLayout();
  void colorBy(ColorBy what);
  void listColors();
  void toggleLegend();
  void resetView();
  void lookFromNextCamera();
  void flyToCursor();
  void changePointSize(double pixels);
  void drawAs(Form form);
  void toggleAxes();
  void toggleGrid();
  void toggleBackground();
  void toggleFrusta();
  void toggleImages();
  void toggleText();
  void toggleHelp();
  void passKeyToPcl();
  void markCursor();
  void clearMarks();
  void toggleSelecting();
  void exportClouds();
  void exportScreenshot();
  void toggleOrbit();
  void quit();
  ///@}

  /** \brief Draws the window as it now is. */
  void render();
  /** \brief Draws it for a picture to keep, and takes that. */
  void withoutMessage(const std::function<void()>& take_picture);
  /** \brief The next tick() draws the window. */
  void redraw() { dirty_ = outdated_ = true; }
  /** \brief Says something in the overlay. */
  void say(const std::string& message);
  /** \brief Films a camera path around the cloud, a frame further with each picture if it plays. Throws io::OutputError. */
  void film(const std::string& path);

 private:
  using Clock = std::chrono::steady_clock;

  void connectEvents();
  void onKey();
  bool onPress();
  bool onMove();
  bool onRelease();
  void onExit(vtkObject*, unsigned long, void*);
  void onLeave(vtkObject*, unsigned long, void*);
  void onInteractionStart(vtkObject*, unsigned long, void*);
  void onInteractionEnd(vtkObject*, unsigned long, void*);
  void onRenderStart(vtkObject*, unsigned long, void*);
  void onRenderEnd(vtkObject*, unsigned long, void*);

  FusionRequest wanted() const;
  void postWhatIsWanted();
  void onSlice();
  /** \brief Draws the window, or abandons it where all points take so long that somebody waits. */
  void renderUnlessInterrupted();
  /** \brief Fewer points until it has stood for a while. */
  void viewMoves();
  void show(const std::shared_ptr<const FusedFrame>& answer);
  /** \brief Something was asked for that is not shown yet. */
  bool awaited() const;
  void await(double elapsed);
  void probeCursor();
  void updateReadout(const std::optional<PickedPoint>& point);
  void arrange();
  void showOverlay();
  void updateHeadings();
  void updateStatus();
  void complain(const std::string& problem);
  void stepOrbit();
  void changeParameters(const std::function<void(FuseFlowParameters&)>& apply);
  std::string unusedPath(const std::string& stem, const std::string& extension) const;

  ViewerOptions options_;
  bool knows_truth_;
  bool finished_;  ///< the clouds come fused
  Playback playback_;
  FusionControls controls_;
  Window window_;
  Panes panes_;
  Overlay overlay_;
  Frusta frusta_;
  WorldAxes axes_;
  Probe probe_;
  RubberBand rubber_band_;
  ParameterSliders sliders_;
  CropBox crop_box_;
  Timeline timeline_;
  FusionWorker worker_;

  bool refine_extrinsics_;
  ColorBy color_by_;
  double point_size_;
  bool show_axes_{false}, show_grid_{false}, show_frusta_{true}, show_images_{true}, show_text_{true},
      show_legend_{true};
  bool show_help_{false}, show_sliders_{false}, day_{false};
  bool selecting_{false};       ///< the left button drags a rectangle
  std::size_t next_camera_{0};  ///< from which lookFromNextCamera() looks
  std::unique_ptr<Orbit> orbit_;

  std::optional<FusionRequest> posted_;
  std::uint64_t answered_{0};
  std::shared_ptr<const FusedFrame> shown_;
  std::string error_;
  std::vector<std::string> problems_;
  std::string message_;
  double message_seconds_{0};  ///< for which the message is still shown

  double coarse_points_{100000};  ///< that a moving view may have
  RunningRate cloud_rate_, picture_rate_;
  Rates rates_;  ///< of what played last
  Clock::time_point render_start_, last_tick_, last_cloud_;
  double awaited_seconds_{0};
  double rest_seconds_{0};    ///< since the cursor moved
  bool cursor_probed_{true};  ///< since then
  bool cursor_seen_{false};   ///< it was over the window
  double refine_in_{-1};      ///< seconds until all points are drawn again; negative: they are
  bool dragging_split_{false};
  bool interacting_{false};
  bool quitting_{false};
  bool dirty_{true};
  bool outdated_{true};        ///< the world in the window is no longer as it was drawn; else only what lies over it
  bool interruptible_{false};  ///< the picture that is being drawn
  std::function<bool()> somebody_waits_;
  std::array<int, 2> arranged_size_{0, 0};
};

}  // namespace fuse_flow::viewing
