#include "evaluation/truth.h"

#include "clouds/cloud_io.h"
#include "clouds/ply_header.h"
#include "recordings/files/cut_short.h"
#include "recordings/files/file_io.h"
#include "recordings/files/json_file.h"
#include "recordings/readers/view_files.h"

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/recordings/rig_json.h>

#include <nlohmann/json.hpp>
#include <pcl/PolygonMesh.h>
#include <pcl/io/ply_io.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <sstream>

namespace fuse_flow::simulation {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Eigen::Vector3f;

constexpr const char* kPatterns[] = {"plain", "checker", "stripes", "wood", "noise", "marker"};

Json colorJson(const Rgb8& c) { return {c.r, c.g, c.b}; }

Json objectJson(const Object& object, bool moving) {
  const Material& m = object.material;
  return {{"name", object.name},
          {"part", object.part.empty() ? object.name : object.part},
          {"moving", moving},
          {"pattern", kPatterns[m.pattern]},
          {"first", colorJson(m.first)},
          {"second", colorJson(m.second)},
          {"size", m.size},
          {"infrared", m.infrared}};
}

/** \brief One object of simulation.json, and what messages call it. */
struct JsonEntry {
  Json json;
  std::string owner;

  template <typename T>
  T value(const char* key, const char* expected, bool (Json::*is_right)() const noexcept) const {
    if (!json.is_object() || !json.contains(key))
      throw io::InputError(owner + ": " + key + " is missing, must be " + expected);
    const Json& found = json[key];
    if (!(found.*is_right)())
      throw io::InputError(owner + ": " + key + " is " + io::quoted(found) + ", must be " + expected);
    return found.get<T>();
  }
  float number(const char* key) const { return value<float>(key, "a number", &Json::is_number); }
  std::string text(const char* key) const { return value<std::string>(key, "a word", &Json::is_string); }
  Json list(const char* key) const { return value<Json>(key, "a list", &Json::is_array); }
  Rgb8 color(const char* key) const {
    const Json channels = list(key);
    const auto is_channel = [](const Json& c) { return c.is_number_unsigned() && c.get<std::uint64_t>() <= 255; };
    if (channels.size() != 3 || !std::all_of(channels.begin(), channels.end(), is_channel))
      throw io::InputError(owner + ": " + key + " is " + io::quoted(channels) + ", must be three of 0 to 255");
    return {channels[0].get<std::uint8_t>(), channels[1].get<std::uint8_t>(), channels[2].get<std::uint8_t>()};
  }
};

Object objectOf(const JsonEntry& entry) {
  Object object;
  object.name = entry.text("name");
  if (entry.json.contains("part")) object.part = entry.text("part");
  const std::string pattern = entry.text("pattern");
  const auto known = std::find(std::begin(kPatterns), std::end(kPatterns), pattern);
  if (known == std::end(kPatterns))
    throw io::InputError(entry.owner + ": pattern is '" + io::cutShort(pattern) +
                         "', which is none of fuse_flow_simulate");
  object.material.pattern = static_cast<Material::Pattern>(known - std::begin(kPatterns));
  object.material.first = entry.color("first");
  object.material.second = entry.color("second");
  object.material.size = entry.number("size");
  object.material.infrared = entry.number("infrared");
  return object;
}

/** \brief With a normal at every vertex: flat triangles get vertices of their own. */
TriangleMesh withNormals(const TriangleMesh& mesh) {
  if (!mesh.normals.empty()) return mesh;
  TriangleMesh flat;
  for (const auto& t : mesh.triangles) {
    const Vector3f &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vector3f normal = (b - a).cross(c - a).normalized();
    const auto first = static_cast<std::uint32_t>(flat.vertices.size());
    flat.triangles.push_back({first, first + 1, first + 2});
    for (const std::uint32_t corner : t) {
      flat.vertices.push_back(mesh.vertices[corner]);
      flat.rest.push_back(mesh.rest.empty() ? mesh.vertices[corner] : mesh.rest[corner]);
      if (!mesh.velocities.empty()) flat.velocities.push_back(mesh.velocities[corner]);
      flat.normals.push_back(normal);
    }
  }
  return flat;
}

template <typename T>
void append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

constexpr const char* kVelocity[] = {"velocity_x", "velocity_y", "velocity_z"};

/** \brief The bytes of one vertex, in the order of the header in meshFile(). */
void appendVertex(std::string& bytes, const Object& object, const TriangleMesh& mesh, std::size_t k,
                  std::uint16_t number) {
  const Vector3f& rest = mesh.rest.empty() ? mesh.vertices[k] : mesh.rest[k];
  std::vector<Vector3f> vectors{mesh.vertices[k], mesh.normals[k], rest};
  if (!mesh.velocities.empty()) vectors.push_back(mesh.velocities[k]);
  for (const Vector3f& v : vectors)
    for (int axis = 0; axis < 3; ++axis) append(bytes, v[axis]);
  const Vector3f color = litColor(object.material, mesh.normals[k], rest);
  for (int channel = 0; channel < 3; ++channel) append(bytes, static_cast<std::uint8_t>(color[channel]));
  append(bytes, number);
}

/** \brief A binary PLY of objects; object k has the number first + k. */
std::string meshFile(const std::vector<Object>& objects, std::size_t first) {
  std::string vertices, faces;
  std::uint32_t vertex_count = 0, face_count = 0;
  for (std::size_t k = 0; k < objects.size(); ++k) {
    const TriangleMesh mesh = withNormals(objects[k].mesh);
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
      appendVertex(vertices, objects[k], mesh, v, static_cast<std::uint16_t>(first + k));
    for (const auto& t : mesh.triangles) {
      append(faces, std::uint8_t{3});
      for (const std::uint32_t corner : t) append(faces, vertex_count + corner);
    }
    vertex_count += static_cast<std::uint32_t>(mesh.vertices.size());
    face_count += static_cast<std::uint32_t>(mesh.triangles.size());
  }
  std::ostringstream header;
  header << "ply\nformat binary_little_endian 1.0\nelement vertex " << vertex_count << '\n';
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz", "rest_x", "rest_y", "rest_z"})
    header << "property float " << name << '\n';
  if (!objects.empty() && !objects[0].mesh.velocities.empty())
    for (const char* name : kVelocity) header << "property float " << name << '\n';
  for (const char* name : {"red", "green", "blue"}) header << "property uchar " << name << '\n';
  header << "property ushort object\nelement face " << face_count
         << "\nproperty list uchar uint vertex_indices\nend_header\n";
  return header.str() + vertices + faces;
}

/** \brief One field of a PCL blob, by name. */
class Field {
 public:
  /** \param datatype of pcl::PCLPointField, which at() is asked for */
  Field(const pcl::PCLPointCloud2& cloud, const std::string& name, std::uint8_t datatype, const std::string& path)
      : cloud_(cloud) {
    for (const pcl::PCLPointField& field : cloud.fields)
      if (field.name == name && field.datatype == datatype) offset_ = field.offset, found_ = true;
    if (!found_)
      throw io::InputError(path + ": has no " + name +
                           " of the right type, must be a mesh as fuse_flow_simulate writes it");
  }
  template <typename T>
  T at(std::size_t point) const {
    T value;
    std::memcpy(&value, &cloud_.data[point * cloud_.point_step + offset_], sizeof(T));
    return value;
  }

 private:
  const pcl::PCLPointCloud2& cloud_;
  std::size_t offset_{0};
  bool found_{false};
};

/** \brief Fills the meshes of objects, whose numbers start at first. */
void readMeshes(const std::string& path, std::size_t first, std::vector<Object>& objects) {
  pcl::PolygonMesh file;
  {
    const io::SilencePcl silence;
    if (!fs::is_regular_file(path))
      throw io::InputError(path + ": not found, must be a mesh as fuse_flow_simulate writes it");
    io::checkPlyHeader(path);
    if (pcl::io::loadPLYFile(path, file) < 0)
      throw io::InputError(path + ": cannot be read, must be a mesh as fuse_flow_simulate writes it");
  }
  const Field number(file.cloud, "object", pcl::PCLPointField::UINT16, path);
  std::vector<Field> fields;
  for (const char* name : {"x", "y", "z", "normal_x", "normal_y", "normal_z", "rest_x", "rest_y", "rest_z"})
    fields.emplace_back(file.cloud, name, pcl::PCLPointField::FLOAT32, path);
  const auto& all = file.cloud.fields;
  const bool moves = std::any_of(all.begin(), all.end(), [](const auto& field) { return field.name == kVelocity[0]; });
  if (moves)
    for (const char* name : kVelocity) fields.emplace_back(file.cloud, name, pcl::PCLPointField::FLOAT32, path);
  const auto vector = [&](std::size_t point, std::size_t field) {
    return Vector3f(fields[field].at<float>(point), fields[field + 1].at<float>(point),
                    fields[field + 2].at<float>(point));
  };
  for (Object& object : objects) object.mesh = {};
  const std::size_t count = static_cast<std::size_t>(file.cloud.width) * file.cloud.height;
  std::vector<std::uint32_t> local(count);
  const auto objectAt = [&](std::size_t point) -> Object& {
    const std::size_t k = number.at<std::uint16_t>(point);
    if (k < first || k >= first + objects.size())
      throw io::InputError(path + ": object " + std::to_string(k) + " is not in simulation.json");
    return objects[k - first];
  };
  for (std::size_t point = 0; point < count; ++point) {
    TriangleMesh& mesh = objectAt(point).mesh;
    local[point] = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.push_back(vector(point, 0));
    mesh.normals.push_back(vector(point, 3));
    mesh.rest.push_back(vector(point, 6));
    if (moves) mesh.velocities.push_back(vector(point, 9));
  }
  for (const pcl::Vertices& face : file.polygons) {
    if (face.vertices.size() != 3) throw io::InputError(path + ": has a face that is not a triangle");
    std::array<std::uint32_t, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(face.vertices[k]);  // a negative one becomes a large one
      if (corner >= count) throw io::InputError(path + ": has a face whose corners are none of its vertices");
      corners[k] = local[corner];
    }
    Object& object = objectAt(static_cast<std::size_t>(face.vertices[0]));
    for (std::size_t k = 1; k < 3; ++k)
      if (&objectAt(static_cast<std::size_t>(face.vertices[k])) != &object)
        throw io::InputError(path + ": has a face of more than one object");
    object.mesh.triangles.push_back(corners);
  }
  for (const Object& object : objects)
    if (object.mesh.triangles.empty() && !object.mesh.vertices.empty())
      throw io::InputError(path +
                           ": has vertices of an object without faces, must be a mesh as fuse_flow_simulate "
                           "writes it");
}

std::string movingPath(const std::string& recording, std::size_t frame) {
  return (fs::path(recording) / "truth" / "moving" / (io::frameStem(frame) + ".ply")).string();
}

}  // namespace

Truth::Truth(const std::string& recording) : folder_(recording) {
  const fs::path truth = fs::path(recording) / "truth";
  const std::string path = (truth / "simulation.json").string();
  if (!fs::exists(path))
    throw io::InputError(recording + ": holds no ground truth; fuse_flow_simulate writes it into the folder truth");
  for (const io::RigCamera& camera : io::readRigJson((truth / "rig.json").string()).cameras)
    cameras_.push_back(camera.camera);
  const JsonEntry json{io::readJson<Json>(path, "what fuse_flow_simulate writes"), path};
  min_range_ = json.number("min_range");
  max_range_ = json.number("max_range");
  for (const Json& object : json.list("objects")) {
    const JsonEntry entry{object, path + ": object number " + std::to_string(fixed_.size() + moving_.size())};
    const bool moving = entry.value<bool>("moving", "true or false", &Json::is_boolean);
    (moving ? moving_ : fixed_).push_back(objectOf(entry));
    names_parts_ = names_parts_ && !(moving ? moving_ : fixed_).back().part.empty();
  }
  readMeshes((truth / "fixed.ply").string(), 0, fixed_);
  scene_.setFixed(fixed_);
}

bool Truth::isIn(const std::string& recording) { return missingIn(recording).empty() && hasFolder(recording); }

std::vector<std::string> Truth::missingIn(const std::string& recording) {
  std::vector<std::string> missing;
  if (!hasFolder(recording)) return missing;
  std::error_code error;
  for (const char* name : {"simulation.json", "rig.json", "fixed.ply"})
    if (const fs::path file = fs::path(recording) / "truth" / name; !fs::is_regular_file(file, error))
      missing.push_back(file.string());
  return missing;
}

bool Truth::hasFolder(const std::string& recording) {
  std::error_code error;
  return fs::is_directory(fs::path(recording) / "truth", error);
}

const RayScene& Truth::frame(std::size_t frame) {
  if (frame != loaded_ && !moving_.empty()) {
    readMeshes(movingPath(folder_, frame), fixed_.size(), moving_);
    scene_.setMoving(moving_);
  }
  loaded_ = frame;
  return scene_;
}

void writeTruth(const std::string& recording, const Simulator& simulator) {
  const fs::path truth = fs::path(recording) / "truth";
  io::makeFolder(truth);
  const SimulationOptions& o = simulator.options();
  Json json = {{"scene", o.scene},
               {"rig", o.rig},
               {"sensor", o.sensor},
               {"scale", o.scale},
               {"seed", o.seed},
               {"frames_per_second", o.frames_per_second},
               {"position_error", o.faults.position_error},
               {"rotation_error", o.faults.rotation_error},
               {"depth_bias", o.faults.depth_bias},
               {"drop_rate", o.faults.drop_rate},
               {"out_of_sync", o.faults.out_of_sync},
               {"out_of_step", o.faults.out_of_step},
               {"readout_time", o.faults.readout_time},
               {"exposure_time", o.faults.exposure_time},
               {"image_noise", o.faults.image.noise},
               {"exposure", o.faults.image.exposure},
               {"vignetting", o.faults.image.vignetting},
               {"min_range", simulator.sensor().minRange()},
               {"max_range", simulator.sensor().maxRange()}};
  for (std::size_t k = 0; k < simulator.cameras().size(); ++k) {
    const ImageErrors& errors = simulator.imageErrors(k);
    json["exposure_delays"].push_back(simulator.exposureDelay(k));
    json["image_errors"].push_back(
        {{"gain", errors.gain}, {"black_level", errors.black_level}, {"vignetting", errors.vignetting}});
  }
  for (const Object& object : simulator.fixedObjects()) json["objects"].push_back(objectJson(object, false));
  for (const Object& object : simulator.movingObjects(0)) json["objects"].push_back(objectJson(object, true));
  io::RigDescription rig{{}, o.frames_per_second};
  for (const Camera& camera : simulator.trueCameras()) rig.cameras.push_back({camera});
  io::writeFile((truth / "fixed.ply").string(), meshFile(simulator.fixedObjects(), 0));
  io::writeRigJson((truth / "rig.json").string(), rig);
  io::writeFile((truth / "simulation.json").string(), json.dump(2) + "\n");
}

void writeTruth(const std::string& recording, const Simulator& simulator, std::size_t frame) {
  const std::vector<Object> moving = simulator.movingObjects(frame);
  if (moving.empty()) return;
  io::makeFolder(fs::path(recording) / "truth" / "moving");
  io::writeFile(movingPath(recording, frame), meshFile(moving, simulator.fixedObjects().size()));
}

}  // namespace fuse_flow::simulation
