#include "docstrings.h"

#include <algorithm>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

namespace fuse_flow::python {
namespace {

struct Docstring {
  std::string_view name;
  const char* text;
};

constexpr Docstring kDocstrings[] = {
#include "docstrings.inc"
};

}  // namespace

const char* doc(const char* name) {
  const auto* found =
      std::find_if(std::begin(kDocstrings), std::end(kDocstrings), [&](const Docstring& d) { return d.name == name; });
  if (found == std::end(kDocstrings)) throw std::logic_error(std::string("the headers say nothing of ") + name);
  return found->text;
}

}  // namespace fuse_flow::python
