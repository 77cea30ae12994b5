#include "../bindings.h"
#include "../frames.h"
#include "../fusion/in_flight.h"
#include "../plain.h"
#include "input_checks/view_overlap.h"

#include <pybind11/stl.h>

#include <sstream>
#include <string>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief What the tools say of options, in words of arrays. */
std::string inWordsOfArrays(std::string line) {
  const auto replace = [&line](const std::string& what, const std::string& by) {
    if (const std::size_t at = line.find(what); at != std::string::npos) line.replace(at, what.size(), by);
  };
  replace("with --pose-convention world_to_camera ",
          "the poses seem to be world to camera: with numpy.linalg.inv(pose) ");
  replace("with --pose-convention opengl ",
          "the poses seem to be of OpenGL's axes: with pose @ numpy.diag([1, -1, -1, 1]) ");
  return line;
}

std::vector<std::string> checkPoses(const FrameLists& lists) {
  const FrameInput input(lists);
  checkRigFrame(input.frame);
  const RigFrame frame = input.named();
  const PreprocessingParameters range;
  io::OverlapCheck check(range);
  std::size_t measuring = 0;
  {
    const InFlight in_flight;  // other threads of Python run meanwhile
    check.look(frame);
    for (const io::CameraOverlap& camera : io::viewOverlap(frame, range)) measuring += camera.points > 0 ? 1 : 0;
  }
  std::vector<std::string> lines;
  if (measuring < 2) {
    std::ostringstream line;
    line << "nothing is known of the poses: fewer than two cameras measure anything within " << range.min_range
         << " to " << range.max_range << " m";
    lines.push_back(line.str());
  }
  for (const std::string& line : check.complaints()) lines.push_back(inWordsOfArrays(line));
  return lines;
}

}  // namespace

void bindPoseCheck(py::module_& module) {
  module.def("check_poses", &checkPoses, py::arg("frame"),
             "Lines about cameras that see nothing that another camera sees, or that contradict the others: most often "
             "their poses are "
             "inverted, of other axes, or in other units. Names the convention of poses with which they would agree. "
             "Empty: nothing "
             "is wrong, as far as these images show.\n\nRaises ValueError if a camera or a view contradicts itself.");
}

}  // namespace fuse_flow::python
