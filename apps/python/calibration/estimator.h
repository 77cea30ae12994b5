#pragma once

#include "../docstrings.h"
#include "../frames.h"
#include "../fusion/in_flight.h"

#include <pybind11/pybind11.h>

#include <memory>
#include <utility>

namespace fuse_flow::python {

/** \brief A class that gets frames and then estimates, with its parameters as an attribute, which may be changed in place. */
template <typename Estimation, typename Parameters>
class EstimatorOf {
 public:
  EstimatorOf(std::shared_ptr<Parameters> parameters, unsigned int threads)
      : parameters_(parameters ? std::move(parameters) : std::make_shared<Parameters>()), threads_(threads) {
    estimation_.setParameters(*parameters_);
  }

  void addFrame(const FrameLists& lists) {
    const FrameInput input(lists);
    run([&](Estimation& estimation) {
      estimation.addFrame(input.frame);
      return 0;
    });
  }

  /** \brief Uses the object without the interpreter's lock. */
  template <typename Use>
  auto run(const Use& use) {
    const Busy::Inside inside(busy_, "the object");
    estimation_.setParameters(*parameters_);
    estimation_.setNumberOfThreads(threads_);
    const InFlight in_flight;
    return use(estimation_);
  }

  void clear() {
    const Busy::Inside inside(busy_, "the object");
    estimation_.clear();
  }

  const std::shared_ptr<Parameters>& parameters() const { return parameters_; }
  void setParameters(const std::shared_ptr<Parameters>& parameters) {
    if (!parameters) throw pybind11::type_error("parameters is None");
    parameters_ = parameters;
  }

 private:
  Estimation estimation_;
  std::shared_ptr<Parameters> parameters_;
  unsigned int threads_;
  Busy busy_;
};

/** \brief What all of them have but estimate(). */
template <typename Parameters, typename Class>
Class& bindEstimator(Class& type, const char* parameters, const char* add_frame) {
  namespace py = pybind11;
  using Estimator = typename Class::type;
  return type
      .def(py::init<std::shared_ptr<Parameters>, unsigned int>(), py::arg("parameters") = py::none(), py::kw_only(),
           py::arg("threads") = 0)
      .def("add_frame", &Estimator::addFrame, py::arg("frame"), add_frame)
      .def("clear", &Estimator::clear, "Forgets all frames.")
      .def_property("parameters", &Estimator::parameters, &Estimator::setParameters, doc(parameters));
}

}  // namespace fuse_flow::python
