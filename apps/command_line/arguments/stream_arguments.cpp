#include "command_line/arguments/stream_arguments.h"

#include "command_line/arguments/option_checks.h"
#include "command_line/arguments/recording_arguments.h"
#include "methods/method.h"
#include "stream/page/serve_page.h"

#include <fuse_flow/recordings/error.h>

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <stdexcept>
#include <utility>

namespace fuse_flow::command_line {

std::string readToken(const std::string& path) {
  std::ifstream file(path);
  std::string token, more;
  if (!std::getline(file, token)) throw io::InputError("--token-file " + path + ": cannot be read, or is empty");
  while (!token.empty() && (token.back() == '\r' || token.back() == ' ')) token.pop_back();
  if (std::getline(file, more) && !more.empty())
    throw io::InputError("--token-file " + path + ": has more than one line, must be the token alone");
  return token;
}

namespace {

/** \brief Each client takes a file descriptor, of which a shell gives a program 1024, and the system more if it asks. */
void requireDescriptors(std::size_t clients) {
  constexpr rlim_t others = 300;  // connections beyond clients, images, cameras
  const rlim_t wanted = clients + others;
  rlimit files{};
  if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= wanted) return;
  if (files.rlim_max <= others) return;  // few even for one client: whatever fits
  if (files.rlim_max < wanted)
    throw io::OptionError("--clients " + std::to_string(clients) + ": a process may have " +
                          std::to_string(files.rlim_max) + " open files here, must be " +
                          std::to_string(files.rlim_max - others) + " or fewer, or ulimit -Hn raised");
  files.rlim_cur = wanted;
  setrlimit(RLIMIT_NOFILE, &files);  // never more than the limit, which needs no right
}

}  // namespace

StreamArguments::StreamArguments(CLI::App& app) {
  const auto number = [](int low, int high) { return wholeNumber(low, high); };
  app.add_option("--port", options_.port, "where browsers and other programs find the stream; 0: one that is free")
      ->check(number(0, 65535))
      ->capture_default_str();
  app.add_option(
         "--address", options_.address,
         "an IP address of this machine to listen at; 127.0.0.1, the default, is for this machine alone, 0.0.0.0 "
         "for all networks; any but the first needs --token-file")
      ->capture_default_str();
  app.add_option("--token-file", token_file_,
                 "a file with one line, of 16 letters or digits at least: only who knows it gets the stream")
      ->check(path());
  app.add_option("--certificate", certificate_, "a PEM file: with it and --key nobody on the way can read the stream")
      ->check(path());
  app.add_option("--key", key_, "of the certificate, a PEM file")->check(path());
  app.add_option("--allow-origin", options_.allowed_origins,
                 "a page of another server that may show the stream, as https://viewer.example");
  app.add_option("--allow-host", options_.allowed_hosts,
                 "without a token: a name, beside localhost, by which browsers may ask for this machine");
  app.add_option("--clients", options_.clients, "at a time, at most")->check(number(1, 100000))->capture_default_str();
  app.add_option("--step", step_mm_,
                 "mm between the positions that a point can have: it is off by half of that at most")
      ->check(numberFromTo(0.01, 1000))
      ->capture_default_str();
  app.add_option(
         "--chroma-step", options_.encoding.chroma_step,
         "0: colours are exact; 4: their tints are off by 2 of 255, and a frame has a fifth fewer bytes; up to 64")
      ->check(number(0, 64))
      ->capture_default_str();
  app.add_flag("!--no-confidence", options_.encoding.confidence, "stream no confidence of each point");
  app.add_flag("!--no-view-count", options_.encoding.view_count, "stream no number of cameras of each point");
  app.add_flag("!--no-images", images_,
               "keep the cameras' images to yourself: without it Foxglove's clients may have them");
}

std::shared_ptr<stream::Server> StreamArguments::open(const std::string& method) const {
  stream::ServerOptions options = options_;
  options.encoding.step = step();
  options.encoding.confidence = options.encoding.confidence && io::knowsConfidence(method);
  options.encoding.view_count = options.encoding.view_count && io::countsViews(method);
  if (!token_file_.empty()) options.token = readToken(token_file_);
  options.certificate = certificate_;
  options.key = key_;
  if (certificate_.empty() != key_.empty())
    throw io::OptionError(certificate_.empty() ? "--key: needs --certificate" : "--certificate: needs --key");
  requireDescriptors(options.clients);
  std::shared_ptr<stream::Server> server;
  try {
    server = std::make_shared<stream::Server>(options);
  } catch (const std::invalid_argument& error) {
    throw io::OptionError(withOptionNames(error.what(), {{"address", "--address"},
                                                         {"token", "--token-file"},
                                                         {"port", "--port"},
                                                         {"allowed_origins", "--allow-origin"},
                                                         {"allowed_hosts", "--allow-host"}}));
  } catch (const std::runtime_error& error) {
    throw io::InputError(error.what());
  }
  stream::servePage(*server);
  return server;
}

void printLink(const std::string& tool, const stream::Server& server) {
  printWarnings(tool, server.warnings());
  if (stream::pageFiles().empty())
    printWarnings(
        tool, {"has no page for browsers, as three.js was not there when it was built; other programs get the stream"});
  std::cout << server.link() << std::endl;
}

std::string StreamLog::describe(const stream::ServerStatus& status) {
  const auto now = std::chrono::steady_clock::now();
  const double seconds = std::max(std::chrono::duration<double>(now - at_).count(), 1e-3);
  at_ = now;
  std::map<std::string, std::uint64_t> bytes;
  std::uint64_t sent = 0;
  for (const stream::ClientReport& client : status.clients) {
    bytes[client.address] = client.bytes;
    const auto before = bytes_.find(client.address);
    sent += client.bytes - (before == bytes_.end() ? 0 : before->second);
  }
  bytes_ = std::move(bytes);
  if (status.clients.empty()) return ", no client";
  // Of the client that gets least.
  const auto least = std::min_element(status.clients.begin(), status.clients.end(), [](const auto& a, const auto& b) {
    return static_cast<double>(a.points) * b.points_of_frame < static_cast<double>(b.points) * a.points_of_frame;
  });
  char text[160];
  std::snprintf(text, sizeof text, ", %zu client%s, %.1f Mbit/s, %s%u of %u points", status.clients.size(),
                status.clients.size() == 1 ? "" : "s", 8e-6 * static_cast<double>(sent) / seconds,
                status.clients.size() == 1 ? "" : "at least ", least->points, least->points_of_frame);
  return text;
}

}  // namespace fuse_flow::command_line
