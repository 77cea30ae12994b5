#pragma once

#include <pybind11/pybind11.h>

#include <utility>

namespace fuse_flow::python {

/** \brief The C++ object of a Python object; null before it is constructed. */
template <typename T>
T* valueOf(PyObject* self) {
  const auto value = reinterpret_cast<pybind11::detail::instance*>(self)->get_value_and_holder();
  return value.holder_constructed() ? static_cast<T*>(value.value_ptr()) : nullptr;
}

/** \brief Shows Python's garbage collector what a T holds, so that cycles through it are found. T has
 *  `template <typename Visit> int visit(Visit)`, which calls visit(pybind11::object&) for each object until a result is not 0. */
template <typename T>
pybind11::custom_type_setup collected() {
  return pybind11::custom_type_setup([](PyHeapTypeObject* heap_type) {
    PyTypeObject* type = &heap_type->ht_type;
    type->tp_flags |= Py_TPFLAGS_HAVE_GC;
    type->tp_dealloc = [](PyObject* self) {
      PyObject_GC_UnTrack(
          self);  // which pybind11 before 2.11 leaves out: a collection must not meet what is half destroyed
      pybind11::detail::pybind11_object_dealloc(self);
    };
    type->tp_traverse = [](PyObject* self, visitproc visit, void* arg) {
      Py_VISIT(Py_TYPE(self));
      T* value = valueOf<T>(self);
      if (value == nullptr) return 0;
      return value->visit([&](pybind11::object& object) { return object ? visit(object.ptr(), arg) : 0; });
    };
    type->tp_clear = [](PyObject* self) {
      T* value = valueOf<T>(self);
      if (value == nullptr) return 0;
      return value->visit([](pybind11::object& object) {
        const pybind11::object gone = std::move(object);
        return 0;
      });
    };
  });
}

}  // namespace fuse_flow::python
