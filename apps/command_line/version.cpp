#include "command_line/version.h"

#include "command_line/build_facts.h"
#include "methods/gpu_report.h"

#include <pcl/pcl_config.h>
#include <sys/utsname.h>

#include <Eigen/Core>

#include <fstream>
#include <sstream>
#include <thread>

namespace fuse_flow::command_line {
namespace {

/** \brief The value of the first line of a file that begins with a key, as in "key : value" or key="value"; empty: there is none. */
std::string valueIn(const char* file, const std::string& key) {
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind(key, 0) != 0) continue;
    const std::size_t begin = line.find_first_not_of(" \t:=\"", key.size());
    if (begin == std::string::npos) return {};
    return line.substr(begin, line.find_last_not_of(" \t\"") + 1 - begin);
  }
  return {};
}

std::string systemLine() {
  utsname name{};
  uname(&name);
  const std::string distribution = valueIn("/etc/os-release", "PRETTY_NAME");
  return std::string(name.sysname) + " " + name.release + " " + name.machine +
         (distribution.empty() ? "" : ", " + distribution);
}

/** \brief The processor, and which of the instruction sets it has that change how fast vector code is. */
std::string cpuLine() {
  std::string model = valueIn("/proc/cpuinfo", "model name");
  if (model.empty()) model = "of unknown model";
  std::string flags = valueIn("/proc/cpuinfo", "flags");
  if (flags.empty()) flags = valueIn("/proc/cpuinfo", "Features");  // ARM
  std::string sets;
  std::istringstream words(flags);
  for (std::string word; words >> word;)
    for (const char* set : {"sse4_2", "avx", "avx2", "fma", "f16c", "avx512f", "asimd", "sve"})
      if (word == set) sets += " " + word;
  return model + ";" + (sets.empty() ? " no instruction set known" : sets) + "; " +
         std::to_string(std::thread::hardware_concurrency()) + " threads";
}

/** \brief The instruction set that the compiler was allowed to use: other than the processor's, where -march was given. */
const char* compiledFor() {
#if defined(__AVX512F__)
  return "AVX-512";
#elif defined(__AVX2__)
  return "AVX2";
#elif defined(__AVX__)
  return "AVX";
#elif defined(__x86_64__)
  return "plain x86-64";
#elif defined(__aarch64__)
  return "plain ARM64";
#else
  return "another processor";
#endif
}

std::string buildLine() {
  const std::string flags = kFlags;
  return std::string(kBuildType[0] ? kBuildType : "no build type") + ", " + kCompiler + ", C++" +
         std::to_string(__cplusplus / 100 % 100) + ", for " + compiledFor() + (flags.empty() ? "" : ", " + flags);
}

}  // namespace

std::string versionOf(const std::string& tool) { return tool + " " + kVersion; }

std::string describeBuild() {
  std::ostringstream text;
  text << "build      " << buildLine() << "\nsystem     " << systemLine() << "\nCPU        " << cpuLine()
       << "\nGPU        " << io::gpuReport() << "\nlibraries  PCL " << PCL_VERSION_PRETTY << ", Eigen "
       << EIGEN_WORLD_VERSION << "." << EIGEN_MAJOR_VERSION << "." << EIGEN_MINOR_VERSION << kLibraries
       << "\nwith       " << kFound << "\nwithout    " << kNotFound;
  return text.str();
}

}  // namespace fuse_flow::command_line
