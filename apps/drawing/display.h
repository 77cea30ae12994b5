#pragma once

#include <string>

class vtkRenderWindow;

namespace fuse_flow::drawing {

/** \brief Throws io::InputError where there is no display, or one without OpenGL: VTK would abort. \param program who asks */
void requireDisplay(const std::string& program);

/** \brief Whether the display has sent something to the window, or another of this program, that nobody has looked at yet. */
bool eventsWait(vtkRenderWindow* window);

/** \brief Takes a window off the screen at once; nothing if it is on none. */
void hide(vtkRenderWindow* window);

}  // namespace fuse_flow::drawing
