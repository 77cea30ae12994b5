#pragma once

#include <functional>
#include <string>
#include <vector>

namespace fuse_flow::viewing {

class Viewer;

/** \brief A key, what it does, and how that is said: the one table that the keyboard, the help overlay and the documentation
 *  follow. */
struct KeyBinding {
  std::string group;              ///< under which the help lists it
  std::string label;              ///< as the help writes it
  std::vector<std::string> keys;  ///< as Window::pressKey() takes them
  std::string help;               ///< in lines, where one is not enough
  std::function<void(Viewer&)> action;
};

const std::vector<KeyBinding>& keyBindings();

/** \brief Null: the key does nothing. */
const KeyBinding* findBinding(const std::string& key);

/** \brief The lines of a text. */
std::vector<std::string> linesOf(const std::string& text);

/** \brief What the mouse does: label and help. */
const std::vector<std::pair<std::string, std::string>>& mouseBindings();

/** \brief Keys and mouse, in two columns. */
std::string helpText();

}  // namespace fuse_flow::viewing
