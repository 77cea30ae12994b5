// How long a picture of a turning view takes while fusion runs beside it, how long one of all points, and how soon a drag that
// begins while that one is drawn is seen.

#include "command_line/arguments/option_checks.h"
#include "command_line/tool.h"
#include "drawing/display.h"
#include "viewer/viewer.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <thread>

namespace {

using namespace fuse_flow;

struct Options {
  std::string rig{"ring-9"};
  int pictures{60};
};

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

double turnOnce(viewing::Viewer& viewer) {
  const auto start = Clock::now();
  viewer.panes().camera()->Azimuth(1);
  viewer.render();
  return millisecondsSince(start);
}

/** \brief From the press of the button, some time into the picture of all points, to the first picture of the turned view. */
double dragWhileDrawing(viewing::Viewer& viewer, double after_ms) {
  viewer.window().style()->InvokeEvent(vtkCommand::EndInteractionEvent);
  const auto pressed = Clock::now() + std::chrono::microseconds(static_cast<long>(1000 * after_ms));
  viewer.setInterrupt([pressed] { return Clock::now() >= pressed; });
  viewer.tick(1);  // the view has stood long enough: draws all points, unless interrupted
  std::this_thread::sleep_until(pressed);
  viewer.window().style()->InvokeEvent(vtkCommand::StartInteractionEvent);
  turnOnce(viewer);
  return millisecondsSince(pressed);
}

void report(const std::string& name, std::size_t points, std::vector<double> times) {
  std::sort(times.begin(), times.end());
  std::cout << std::fixed << std::setprecision(1) << name << ": " << points << " points a picture, median "
            << times[times.size() / 2] << " ms, 95 % within " << times[times.size() * 95 / 100] << " ms" << std::endl;
}

int run(const Options& options) {
  drawing::requireDisplay("fuse_flow_viewer_bench");
  simulation::SimulationOptions simulation;
  simulation.rig = options.rig;
  simulation.threads = host::resolveThreads(0);
  viewing::ViewerOptions how;
  how.method = "concatenate";  // every measurement stays a point
  how.offscreen = true;
  viewing::Viewer viewer(viewing::makeSimulatedSource(simulation), how);
  viewer.settle();
  viewer.settle();  // with as many coarse points as the first picture allows
  const viewing::FusedCloud& cloud = *viewer.panes().cloud(0);
  const std::size_t first = viewer.shown()->frame;
  std::vector<double> all, coarse, drags;
  for (int k = 0; k < options.pictures / 6 + 1; ++k) all.push_back(turnOnce(viewer));
  report("all points, fusion idle", cloud.cloud->size(), all);
  viewing::Probe probe(viewer.panes());
  const auto start = Clock::now();
  probe.pick(how.width / 2, how.height / 2);
  std::cout << "point under the cursor: " << millisecondsSince(start) << " ms" << std::endl;
  viewer.playback().pause();
  const double whole_ms = *std::min_element(all.begin(), all.end());
  for (int k = 0; k < options.pictures; ++k)
    drags.push_back(dragWhileDrawing(viewer, whole_ms * (k + 0.5) / options.pictures));
  report("drag during a picture of all points, fusion idle", viewer.panes().drawnPoints(), drags);
  drags.clear();
  viewer.playback().play();
  viewer.window().style()->InvokeEvent(vtkCommand::StartInteractionEvent);
  while (static_cast<int>(coarse.size()) < options.pictures || viewer.shown()->frame == first) {
    viewer.tick(1.0 / 30);  // plays: asks for frames, and shows what comes
    coarse.push_back(turnOnce(viewer));
  }
  report("turning, fusion running", viewer.panes().drawnPoints(), coarse);
  for (int k = 0; k < options.pictures; ++k)
    drags.push_back(dragWhileDrawing(viewer, whole_ms * (k + 0.5) / options.pictures));
  report("drag during a picture of all points, fusion running", viewer.panes().drawnPoints(), drags);
  if (!viewer.stopWithin(std::chrono::seconds(2))) std::_Exit(command_line::kSuccess);
  return command_line::kSuccess;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app("Times the viewer's pictures while its view turns and fusion runs.", "fuse_flow_viewer_bench");
  app.add_option("--rig", options.rig, "simulated cameras")->capture_default_str();
  app.add_option("--pictures", options.pictures, "of the turning view")->check(command_line::wholeNumber(1, 100000));
  return command_line::runTool(app, argc, argv, [&] { return run(options); });
}
