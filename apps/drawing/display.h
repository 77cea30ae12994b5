#pragma once

#include <string>

namespace fuse_flow::drawing {

/** \brief Throws io::InputError where there is no display, or one without OpenGL: VTK would abort. \param program who asks */
void requireDisplay(const std::string& program);

}  // namespace fuse_flow::drawing
