#include "simulation/scene.h"

#include "simulation/scenes/scenes.h"

#include <fuse_flow/recordings/error.h>

namespace fuse_flow::simulation {

Objects Scene::movingObjects(double) const { return {}; }

namespace {

struct Named {
  const char* name;
  std::unique_ptr<Scene> (*make)(std::uint32_t seed);
};

constexpr Named kScenes[] = {{"room", makeRoomScene},        {"person", makePersonScene},       {"thin", makeThinScene},
                             {"table", makeTableScene},      {"punch", makePunchScene},         {"hop", makeHopScene},
                             {"sit", makeSitScene},          {"hand", makeHandScene},           {"ball", makeBallScene},
                             {"skirt", makeSkirtScene},      {"handshake", makeHandshakeScene}, {"pass", makePassScene},
                             {"passerby", makePasserbyScene}};

}  // namespace

std::vector<std::string> sceneNames() {
  std::vector<std::string> names;
  for (const Named& scene : kScenes) names.emplace_back(scene.name);
  return names;
}

std::unique_ptr<Scene> makeScene(const std::string& name, std::uint32_t seed) {
  for (const Named& scene : kScenes)
    if (scene.name == name) return scene.make(seed);
  std::string known;
  for (const std::string& scene : sceneNames()) known += (known.empty() ? "" : ", ") + scene;
  throw io::InputError("scene '" + name + "' is not known; must be one of " + known);
}

}  // namespace fuse_flow::simulation
