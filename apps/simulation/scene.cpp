#include "simulation/scene.h"

#include "simulation/scenes/scenes.h"

#include <fuse_flow/recordings/error.h>

namespace fuse_flow::simulation {

Objects Scene::movingObjects(double) const { return {}; }

std::vector<std::string> sceneNames() { return {"room", "person", "thin", "table"}; }

std::unique_ptr<Scene> makeScene(const std::string& name, std::uint32_t seed) {
  if (name == "room") return makeRoomScene(seed);
  if (name == "person") return makePersonScene(seed);
  if (name == "thin") return makeThinScene(seed);
  if (name == "table") return makeTableScene(seed);
  std::string known;
  for (const std::string& scene : sceneNames()) known += (known.empty() ? "" : ", ") + scene;
  throw io::InputError("scene '" + name + "' is not known; must be one of " + known);
}

}  // namespace fuse_flow::simulation
