#include "recordings/readers/trajectory_file.h"

#include "recordings/calibrations/calibration.h"
#include "recordings/files/json_file.h"

#include <fuse_flow/recordings/error.h>

#include <cmath>
#include <vector>

namespace fuse_flow::io {
namespace {

constexpr const char* kTrajectory = "a camera trajectory as Open3D writes it";

/** \brief Sixteen numbers row by row, of what is column by column. */
std::vector<double> rowMajorOf(const std::string& owner, const nlohmann::json& extrinsic) {
  if (!extrinsic.is_array() || extrinsic.size() != 16)
    throw InputError(owner + ": extrinsic must be 16 numbers, world to camera, column by column");
  std::vector<double> numbers(16);
  for (std::size_t k = 0; k < 16; ++k) {
    const nlohmann::json& number = extrinsic[k];
    if (!number.is_number()) throw InputError(owner + ": extrinsic has " + quoted(number) + ", must be 16 numbers");
    numbers[k % 4 * 4 + k / 4] = number.get<double>();
  }
  return numbers;
}

}  // namespace

Trajectory readTrajectoryLog(const std::string& path) {
  const std::vector<double> numbers = readNumbers(path);
  constexpr std::size_t block = 3 + 16;
  if (numbers.empty() || numbers.size() % block != 0)
    throw InputError(path + ": has " + std::to_string(numbers.size()) +
                     " numbers, must be 19 a frame: three integers and a 4x4 pose");
  Trajectory trajectory;
  for (auto at = numbers.begin(); at != numbers.end(); at += block) {
    if (!(at[0] >= 0 && at[0] <= 1e9 && at[0] == std::floor(at[0])))
      throw InputError(path + ": pose number " + std::to_string((at - numbers.begin()) / block) +
                       " has no frame number");
    const auto number = static_cast<std::size_t>(at[0]);
    try {
      trajectory.poses[number] =
          rigidPose(path + ": pose of frame " + std::to_string(number), std::vector<double>(at + 3, at + block));
    } catch (const InputError& error) {  // where tracking was lost; an error only if this frame is selected
      trajectory.poses.erase(number);
      trajectory.invalid[number] = error.what();
    }
  }
  return trajectory;
}

Trajectory readTrajectoryJson(const std::string& path) {
  const auto json = readJson<nlohmann::json>(path, kTrajectory);
  if (!json.is_object() || !json.contains("parameters") || !json["parameters"].is_array() || json["parameters"].empty())
    throw InputError(path + ": is not " + kTrajectory +
                     ": must have a list parameters, with an extrinsic for each frame");
  Trajectory trajectory;
  std::size_t number = 0;
  for (const nlohmann::json& entry : json["parameters"]) {
    const std::string owner = path + ": pose of frame " + std::to_string(number);
    if (!entry.is_object() || !entry.contains("extrinsic"))
      throw InputError(owner + ": has no extrinsic, must be 16 numbers, world to camera, column by column");
    const std::vector<double> numbers = rowMajorOf(owner, entry["extrinsic"]);
    try {
      trajectory.poses[number] = rigidPose(owner, numbers).inverse();
    } catch (const InputError& error) {
      trajectory.invalid[number] = error.what();
    }
    ++number;
  }
  return trajectory;
}

}  // namespace fuse_flow::io
