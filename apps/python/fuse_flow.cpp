#include "bindings.h"
#include "docstrings.h"
#include "frames.h"
#include "fusion.h"
#include "in_flight.h"
#include "input_checks/depth_in_range.h"

#include <memory>
#include <string>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief FuseFlow of Python. */
class FrameFusion {
 public:
  FrameFusion(const std::string& device, unsigned int threads, const PointExtras& extras,
              std::shared_ptr<FuseFlowParameters> parameters)
      : parameters_(parameters ? std::move(parameters) : std::make_shared<FuseFlowParameters>()), threads_(threads) {
    if (device != "cpu")
      throw py::value_error("fuse_flow.FuseFlow: device is '" + device + "', must be 'cpu': this build has no other");
    checkParameters(*parameters_);
    fusion_ = makeHostFusion(extras);
  }

  Cloud fuse(const FrameLists& lists) {
    const Busy::Inside inside(busy_, "fuse_flow.FuseFlow");
    const Filled filled(input_, lists);
    fusion_->setParameters(*parameters_);
    fusion_->setNumberOfThreads(threads_);
    Cloud cloud;
    {
      const InFlight in_flight;
      cloud = fusion_->fuse(input_.frame);
    }
    statistics_ = fusion_->statistics();
    if (!statistics_.out_of_range.empty()) warnOfRange(input_.frame);
    return cloud;
  }

  const FrameStatistics& statistics() const { return statistics_; }
  const std::shared_ptr<FuseFlowParameters>& parameters() const { return parameters_; }
  void setParameters(const std::shared_ptr<FuseFlowParameters>& parameters) {
    if (!parameters) throw py::type_error("fuse_flow.FuseFlow: parameters is None, must be FuseFlowParameters");
    checkParameters(*parameters);
    parameters_ = parameters;
  }
  unsigned int threads() const { return threads_; }
  void setThreads(unsigned int threads) { threads_ = threads; }

 private:
  /** \brief Keeps the arrays of a frame for as long as it is fused. */
  struct Filled {
    Filled(FrameInput& filled, const FrameLists& lists) : input(filled) { input.fill(lists); }
    ~Filled() { input.release(); }
    Filled(const Filled&) = delete;
    Filled& operator=(const Filled&) = delete;
    FrameInput& input;
  };

  /** \brief What the tools say: a wrong unit of depth gives a cloud too, of nothing or of nonsense. */
  void warnOfRange(const RigFrame& frame) const {
    io::DepthInRange check(parameters_->preprocessing);
    check.look(frame);
    for (const std::string& line : check.complaints())
      if (PyErr_WarnEx(PyExc_UserWarning, line.c_str(), 1) != 0) throw py::error_already_set();
  }

  Busy busy_;
  FrameInput input_;
  std::shared_ptr<FuseFlowParameters> parameters_;
  unsigned int threads_;
  std::unique_ptr<Fusion> fusion_;
  FrameStatistics statistics_;
};

}  // namespace

void bindFusion(py::module_& module) {
  py::class_<FrameFusion>(
      module, "FuseFlow",
      "The frame pipeline: it fuses the views of one instant into one cloud. From frame to frame it keeps memory "
      "buffers, but no data. The same frame gives the same bytes for any number of threads.\n\n"
      "Keep it from frame to frame. Only one thread at a time may use an object: a second one gets a RuntimeError.")
      .def(py::init([](const std::string& device, unsigned int threads, bool normals, bool camera_mask,
                       const std::shared_ptr<FuseFlowParameters>& parameters) {
             return std::make_unique<FrameFusion>(device, threads, PointExtras{normals, camera_mask}, parameters);
           }),
           py::arg("device") = "cpu", py::kw_only(), py::arg("threads") = 0, py::arg("normals") = false,
           py::arg("camera_mask") = false, py::arg("parameters") = py::none(),
           "device: 'cpu'. threads: 0, one per core. normals, camera_mask: whether clouds have them, which takes time "
           "and memory.")
      .def("fuse", &FrameFusion::fuse, py::arg("frame"),
           "Fuses one frame, without the interpreter's lock. A camera whose view is None is skipped, and statistics "
           "name it. Warns of "
           "cameras whose depth is nearly all out of range.\n\nRaises ValueError if a camera or a view contradicts "
           "itself.")
      .def_property_readonly("statistics", &FrameFusion::statistics, py::return_value_policy::copy,
                             doc("FuseFlow::getStatistics"))
      .def_property("parameters", &FrameFusion::parameters, &FrameFusion::setParameters, doc("FuseFlowParameters"))
      .def_property("threads", &FrameFusion::threads, &FrameFusion::setThreads, doc("FuseFlow::setNumberOfThreads"));
}

}  // namespace fuse_flow::python
