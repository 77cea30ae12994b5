#pragma once

#include <fuse_flow/recordings/error.h>

#include <cstdint>
#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief Whether there is a file or folder. Throws InputError if this cannot be determined, for example without permission. */
bool isThere(const std::string& path);

/** \brief The names of what a folder holds, sorted; none where there is no such folder. Throws InputError if it cannot be read. */
std::vector<std::string> filesIn(const std::string& folder);

/** \brief More than any image or cloud has that these tools can work on. */
constexpr std::uint64_t kMostBytes = std::uint64_t{16} << 30;
/** \brief More than any text has: of a list of poses a hundred bytes a line. */
constexpr std::uint64_t kMostTextBytes = std::uint64_t{256} << 20;
/** \brief More than the calibration of any rig has. */
constexpr std::uint64_t kMostCalibrationBytes = std::uint64_t{64} << 20;

/** \brief The bytes of a file. Throws InputError if it is not there, is a folder, a pipe, a socket or a device, is larger than most, or cannot be read. */
std::string readFile(const std::string& path, std::uint64_t most = kMostBytes);

/** \brief The same of a text. Throws InputError, too, if it has bytes that are 0: then it is damaged, or no text in UTF-8. */
std::string readText(const std::string& path, std::uint64_t most = kMostTextBytes);

/** \brief Its first bytes, as many as there are up to most. Throws InputError as readFile(). */
std::string readFileStart(const std::string& path, std::uint64_t most);

std::uint64_t fileSize(const std::string& path);

/** \brief The name under which a file is written until it is whole: in its folder, no longer than names may be there. */
std::string unfinishedName(const std::string& path);

/** \brief Makes a folder, and those around it; nothing where it is there, or has no name. Throws OutputError where that fails. */
void makeFolder(const std::string& folder);

/** \brief The same with the folder that a file is to lie in. */
void makeFolderOf(const std::string& path);

/** \brief Writes a file so that it appears complete or not at all: beside its place under another name, flushed to the
 *  disk, then renamed. A device or pipe is written directly. Throws OutputError, leaving nothing behind. */
void writeFile(const std::string& path, const std::string& bytes);

}  // namespace fuse_flow::io
