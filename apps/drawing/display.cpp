#include "drawing/display.h"

#include <fuse_flow/recordings/error.h>

#include <vtkRenderWindow.h>

#include <GL/glx.h>

#include <cstdlib>
#include <memory>
#include <utility>

namespace fuse_flow::drawing {

void requireDisplay(const std::string& program) {
  const std::string remedy = ": start it as 'xvfb-run -a " + program + " …'";
  const char* name = std::getenv("DISPLAY");
  if (!name || !*name) throw io::InputError("DISPLAY is not set, must name a display" + remedy);
  std::unique_ptr<Display, int (*)(Display*)> display(XOpenDisplay(name), XCloseDisplay);
  if (!display) throw io::InputError(std::string("DISPLAY is ") + name + ", which cannot be opened" + remedy);
  int depth_buffer[] = {GLX_RENDER_TYPE, GLX_RGBA_BIT, GLX_DOUBLEBUFFER, True, GLX_DEPTH_SIZE, 16, None};
  int count = 0;
  if (glXQueryExtension(display.get(), nullptr, nullptr))
    XFree(glXChooseFBConfig(display.get(), DefaultScreen(display.get()), depth_buffer, &count));
  if (count == 0) throw io::InputError(std::string("DISPLAY is ") + name + ", which has no OpenGL (GLX)" + remedy);
  // Open until the program ends: a server whose last client goes, as one of xvfb-run's would here, begins anew, and a window
  // that is opened meanwhile ends the program.
  static std::unique_ptr<Display, int (*)(Display*)> kept(nullptr, XCloseDisplay);
  kept = std::move(display);
}

bool eventsWait(vtkRenderWindow* window) {
  auto* display = static_cast<Display*>(window->GetGenericDisplayId());
  return display && XEventsQueued(display, QueuedAfterReading) > 0;
}

void hide(vtkRenderWindow* window) {
  auto* display = static_cast<Display*>(window->GetGenericDisplayId());
  if (!display) return;
  XUnmapWindow(display, reinterpret_cast<Window>(window->GetGenericWindowId()));
  XFlush(display);
}

}  // namespace fuse_flow::drawing
