#include "bindings.h"
#include "fusion/in_flight.h"

#include <fuse_flow/recordings/error.h>

#include <pcl/exceptions.h>

#include <cctype>
#include <exception>
#include <string>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

void replaceAll(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
}

/** \brief A message of the library in Python's words. PCL puts ": " before a message without a place in the source. */
std::string messageOf(const std::exception& error) {
  std::string message = error.what();
  if (message.rfind(": ", 0) == 0) message.erase(0, 2);
  replaceAll(message, "fuse_flow::", "fuse_flow.");
  return message;
}

/** \brief The same of an option, which the tools write as --depth-scale and Python as depth_scale. */
std::string optionMessageOf(const std::exception& error) {
  std::string message = messageOf(error);
  if (message.rfind("--", 0) != 0) return message;
  message.erase(0, 2);
  for (char& c : message) {
    if (c == '-') c = '_';
    if (c != '_' && std::isalnum(static_cast<unsigned char>(c)) == 0) break;
  }
  return message;
}

void set(PyObject* type, const std::string& message) { PyErr_SetString(type, message.c_str()); }

// NOLINTNEXTLINE(performance-unnecessary-value-param): the type that pybind11 takes
void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const InterpreterEnds&) {
    stayHere();
  } catch (const io::OptionError& error) {
    set(PyExc_ValueError, optionMessageOf(error));
  } catch (const io::OutputError& error) {
    set(PyExc_OSError, messageOf(error));
  } catch (const io::InputError& error) {
    set(PyExc_ValueError, messageOf(error));
  } catch (const pcl::BadArgumentException& error) {
    set(PyExc_ValueError, messageOf(error));
  } catch (const pcl::PCLException& error) {
    set(PyExc_RuntimeError, messageOf(error));
  }
}

}  // namespace

void bindErrors(py::module_&) { py::register_exception_translator(&translate); }

}  // namespace fuse_flow::python
