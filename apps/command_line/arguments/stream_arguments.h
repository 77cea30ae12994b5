#pragma once

#include <fuse_flow/stream/server.h>

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

namespace fuse_flow::command_line {

/** \brief What the file of --token-file has in its one line. \throws InputError */
std::string readToken(const std::string& path);

/** \brief How clouds are streamed, on the command line. */
class StreamArguments {
 public:
  explicit StreamArguments(CLI::App& app);
  StreamArguments(const StreamArguments&) = delete;
  StreamArguments& operator=(const StreamArguments&) = delete;

  /** \brief A server that listens, with the page for browsers. \param method what makes the clouds: what it does not know of a point is
   *  not streamed \throws OptionError, InputError */
  std::shared_ptr<stream::Server> open(const std::string& method) const;
  /** \brief Metres, see EncodingOptions::step. */
  double step() const { return 1e-3 * step_mm_; }
  /** \brief Whether clients may see the images of the cameras, too. */
  bool images() const { return images_; }

 private:
  stream::ServerOptions options_;
  double step_mm_{1};
  bool images_{true};
  std::string token_file_, certificate_, key_;
};

/** \brief "http://127.0.0.1:8080/": where the stream is, for people who run the tool. */
void printLink(const std::string& tool, const stream::Server& server);

/** \brief What a line of the log says of the clients: how many, and what they have been sent since the line before. */
class StreamLog {
 public:
  /** \brief ", 2 clients, 726.0 Mbit/s, 448924 of 448924 points to the last" */
  std::string describe(const stream::ServerStatus& status);

 private:
  std::map<std::string, std::uint64_t> bytes_;  ///< of each client, by its address, at the line before
  std::chrono::steady_clock::time_point at_{std::chrono::steady_clock::now()};
};

}  // namespace fuse_flow::command_line
