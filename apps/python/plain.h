#pragma once

#include "docstrings.h"

#include <pybind11/pybind11.h>

#include <cctype>
#include <string>

namespace fuse_flow::python {

/** \brief SlopeCompensated as SLOPE_COMPENSATED. */
inline std::string upperSnake(const std::string& name) {
  std::string upper;
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isupper(letter) != 0 && !upper.empty()) upper += '_';
    upper += static_cast<char>(std::toupper(letter));
  }
  return upper;
}

/** \brief Names T in the module, with its sentence of the headers. */
template <typename T, typename... Options>
pybind11::class_<T, Options...> named(pybind11::handle scope, const char* name) {
  return pybind11::class_<T, Options...>(scope, name, doc(name));
}

/** \brief For structs of plain values: they are made with the defaults, or with some of the attributes by name, and copied by copy.copy() and
 *  copy.deepcopy(). */
template <typename Class>
Class& plain(Class& type) {
  namespace py = pybind11;
  using T = typename Class::type;
  type.def(py::init([type](const py::kwargs& values) {
    py::object made = py::cast(T());
    for (const auto& [name, value] : values) {
      if (!py::hasattr(type, name))
        throw py::type_error(std::string(py::str(type.attr("__name__"))) + " has no " + std::string(py::str(name)));
      py::setattr(made, name, value);
    }
    return made.cast<T>();
  }));
  type.def("__copy__", [](const T& value) { return T(value); });
  type.def(
      "__deepcopy__", [](const T& value, const py::dict&) { return T(value); }, py::arg("memo"));
  return type;
}

}  // namespace fuse_flow::python

/** \brief A member as a plain attribute of the same name, with its sentence of the headers. */
#define FUSE_FLOW_FIELD(Struct, member) def_readwrite(#member, &Struct::member, doc(#Struct "::" #member))
/** \brief The same of a result. */
#define FUSE_FLOW_RESULT(Struct, member) def_readonly(#member, &Struct::member, doc(#Struct "::" #member))
/** \brief An enumerator. */
#define FUSE_FLOW_VALUE(Enum, enumerator) \
  value(upperSnake(#enumerator).c_str(), Enum::enumerator, doc(#Enum "::" #enumerator))
