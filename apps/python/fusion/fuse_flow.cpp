#include "../bindings.h"
#include "../docstrings.h"
#include "../frames.h"
#include "../gpu/gpu_fusion.h"
#include "../warn.h"
#include "fusion.h"
#include "in_flight.h"
#include "input_checks/depth_in_range.h"

#include <memory>
#include <sstream>
#include <string>
#include <utility>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief FuseFlow of Python. */
class FrameFusion {
 private:
  /** \brief Lets go of the arrays of a frame once it is fused, or refused. */
  struct Release {
    explicit Release(FrameInput& filled) : input(filled) {}
    ~Release() { input.release(); }
    Release(const Release&) = delete;
    Release& operator=(const Release&) = delete;
    FrameInput& input;
  };

  template <typename Fuse>
  auto use(const FrameLists& lists, const Fuse& fuse) {
    const Busy::Inside inside(busy_, "fuse_flow.FuseFlow");
    const Release release(input_);
    fill(lists);
    fusion_->setParameters(*parameters_);
    fusion_->setNumberOfThreads(threads_);
    auto cloud = [&] {
      const InFlight in_flight;
      return fuse(input_.frame);
    }();
    statistics_ = fusion_->statistics();
    if (!statistics_.out_of_range.empty()) warnOfRange(input_.named());
    return cloud;
  }

 public:
  FrameFusion(const std::string& device, unsigned int threads, const PointExtras& extras,
              std::shared_ptr<FuseFlowParameters> parameters)
      : parameters_(parameters ? std::move(parameters) : std::make_shared<FuseFlowParameters>()), threads_(threads) {
    checkParameters(*parameters_);
    if (device == "gpu") {
      fusion_ = makeGpuFusion(extras);
      gpu_ = static_cast<GpuFusion*>(fusion_.get());
    } else if (device == "cpu") {
      fusion_ = makeHostFusion(extras);
    } else {
      throw py::value_error("fuse_flow.FuseFlow: device is '" + device + "', must be 'cpu' or 'gpu'");
    }
  }

  Cloud fuse(const FrameLists& lists) {
    return use(lists, [&](const RigFrame& frame) { return fusion_->fuse(frame); });
  }

  GpuCloud fuseOnDevice(const FrameLists& lists) {
    if (gpu_ == nullptr)
      throw py::value_error(
          "fuse_flow.FuseFlow: clouds stay on a device with FuseFlow(device='gpu'), and this one is on the CPU");
    return use(lists, [&](const RigFrame& frame) { return gpu_->fuseOnDevice(frame); });
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
  void fill(const FrameLists& lists) {
    if (gpu_ == nullptr) {
      input_.fill(lists);
      return;
    }
    DeviceReader reader{gpu_->device(), gpu_->stream(), {}};
    input_.fill(lists, &reader);
    for (const std::uintptr_t other : reader.waiting) gpu_->waitFor(other);
  }

  /** \brief What the tools say: a wrong unit of depth gives a cloud too, of nothing or of nonsense. */
  void warnOfRange(const RigFrame& frame) const {
    if (gpu_ != nullptr) {  // the images may be where nobody can look at them from here
      const PreprocessingParameters& range = parameters_->preprocessing;
      for (const DepthOutOfRange& depth : statistics_.out_of_range) {
        std::ostringstream line;
        line << "camera '" << frame.cameras[depth.camera].name << "' measures only " << depth.in_range << " of "
             << depth.measured << " pixels within " << range.min_range << " to " << range.max_range << " m, but "
             << depth.nearest << " to " << depth.farthest << " m";
        warn(line.str());
      }
      return;
    }
    io::DepthInRange check(parameters_->preprocessing);
    check.look(frame);
    for (const std::string& line : check.complaints()) warn(line);
  }

  Busy busy_;
  FrameInput input_;
  std::shared_ptr<FuseFlowParameters> parameters_;
  unsigned int threads_;
  std::unique_ptr<Fusion> fusion_;
  GpuFusion* gpu_{nullptr};  ///< the same, if it is on a GPU
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
           "device: 'cpu', or 'gpu' where the module was built with CUDA. threads: 0, one per core. normals, "
           "camera_mask: whether clouds have them, which takes time "
           "and memory.")
      .def("fuse", &FrameFusion::fuse, py::arg("frame"),
           "Fuses one frame, without the interpreter's lock. A camera whose view is None is skipped, and statistics "
           "name it. Warns of "
           "cameras whose depth is nearly all out of range.\n\nRaises ValueError if a camera or a view contradicts "
           "itself.")
      .def("fuse_on_device", &FrameFusion::fuseOnDevice, py::arg("frame"),
           "As fuse(), but the cloud stays in the memory of the GPU. Only of FuseFlow(device='gpu').")
      .def_property_readonly("statistics", &FrameFusion::statistics, py::return_value_policy::copy,
                             doc("FuseFlow::getStatistics"))
      .def_property("parameters", &FrameFusion::parameters, &FrameFusion::setParameters, doc("FuseFlowParameters"))
      .def_property("threads", &FrameFusion::threads, &FrameFusion::setThreads, doc("FuseFlow::setNumberOfThreads"));
}

}  // namespace fuse_flow::python
