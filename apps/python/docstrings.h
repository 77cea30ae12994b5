#pragma once

namespace fuse_flow::python {

/** \brief A sentence of the headers, which docstrings.py has collected. \param name "Struct", "Struct::member" or "Enum::Enumerator"
 *  \throws std::logic_error if the headers say nothing of it */
const char* doc(const char* name);

}  // namespace fuse_flow::python
