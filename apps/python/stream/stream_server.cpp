#include "../images.h"
#include "../plain.h"
#include "../recordings/open_ends.h"
#include "published.h"
#include "stream/page/serve_page.h"
#include "streams.h"

#include <fuse_flow/stream/server.h>

#include <pybind11/stl.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief Server of the library, and the page for browsers. */
class StreamServer : public OpenUntilClosed<stream::Server> {
 public:
  StreamServer(const stream::ServerOptions& options, bool page)
      : OpenUntilClosed(opened(options), "fuse_flow.StreamServer"), step_(options.encoding.step) {
    if (page) has_page_ = stream::servePage(get());
    if (page && !has_page_)
      warnings_ = {
          "there is no page for browsers, as three.js was not there when the module was built; other programs get the "
          "stream"};
    for (std::string& line : get().warnings()) warnings_.push_back(std::move(line));
  }

  bool hasPage() const { return has_page_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

  void describe(const std::string& name, const std::vector<Camera>& cameras, const std::string& frame) {
    get().describe(describedAs(name, cameras, frame, step_));
  }
  void publish(const py::object& cloud, const std::optional<std::uint64_t>& number,
               const std::optional<std::int64_t>& captured, const PublishedCloud::Fields& fields) {
    const Busy::Inside inside(busy_, name());
    stream::Server& server = get();
    PublishedCloud published(cloud, fields);
    stream::FrameTimes times = numbers_.timesOf(cloud, number, captured);
    times.encoded = 0;  // now, also if it came from another server
    const InFlight in_flight;
    server.publish(published.view(), times);
  }
  void publishImage(std::size_t camera, const py::object& image, std::int64_t captured) {
    stream::Server& server = get();
    const py::array array = arrayOf(image);
    const ImageView<Rgb8> pixels = colorImageOf(array);
    stream::FrameTimes times;
    times.captured = captured;
    const InFlight in_flight;
    server.publishImage(camera, pixels, times);  // copied, if somebody wants it: Python may change its array
  }

 private:
  static std::unique_ptr<stream::Server> opened(const stream::ServerOptions& options) {
    const InFlight in_flight;
    return std::make_unique<stream::Server>(options);
  }

  double step_;
  bool has_page_{false};
  std::vector<std::string> warnings_;
  FrameNumbers numbers_;
};

void bindServerStatus(py::module_& module) {
  using stream::ClientReport;
  using stream::ServerStatus;
  py::class_<ClientReport>(module, "StreamClientReport", doc("ClientReport"))
      .FUSE_FLOW_RESULT(ClientReport, address)
      .FUSE_FLOW_RESULT(ClientReport, seconds)
      .FUSE_FLOW_RESULT(ClientReport, frames)
      .FUSE_FLOW_RESULT(ClientReport, replaced)
      .FUSE_FLOW_RESULT(ClientReport, images)
      .FUSE_FLOW_RESULT(ClientReport, bytes)
      .FUSE_FLOW_RESULT(ClientReport, bytes_per_second)
      .FUSE_FLOW_RESULT(ClientReport, round_trip)
      .FUSE_FLOW_RESULT(ClientReport, points)
      .FUSE_FLOW_RESULT(ClientReport, points_of_frame);
  py::class_<ServerStatus>(module, "StreamServerStatus", "What a StreamServer has done.")
      .def_readonly("clients", &ServerStatus::clients, "A StreamClientReport of each client.")
      .FUSE_FLOW_RESULT(ServerStatus, connections)
      .FUSE_FLOW_RESULT(ServerStatus, published)
      .FUSE_FLOW_RESULT(ServerStatus, encoded)
      .FUSE_FLOW_RESULT(ServerStatus, encoded_images)
      .FUSE_FLOW_RESULT(ServerStatus, refused)
      .FUSE_FLOW_RESULT(ServerStatus, dropped);
}

std::string serverDocs() {
  std::string text =
      std::string(doc("Server::Server")) + "\n\npage: whether browsers get a page that shows the stream.";
  for (const char* option : {"port", "address", "token", "certificate", "key", "allowed_origins", "allowed_hosts"})
    text += std::string("\n\n") + option + ": " + doc((std::string("ServerOptions::") + option).c_str());
  return text + "\n\nstep: " + doc("EncodingOptions::step") +
         " In place of that of encoding.\n\nencoding: " + doc("EncodingOptions");
}

}  // namespace

void bindStreamServer(py::module_& module) {
  bindServerStatus(module);
  const stream::ServerOptions defaults;
  py::class_<StreamServer> server(module, "StreamServer", doc("Server"));
  server
      .def(py::init([](std::uint16_t port, const std::string& address, const std::string& token,
                       const std::string& certificate, const std::string& key, bool page,
                       const std::vector<std::string>& allowed_origins, const std::vector<std::string>& allowed_hosts,
                       const std::optional<double>& step, const std::optional<stream::EncodingOptions>& encoding) {
             stream::ServerOptions options;
             options.port = port;
             options.address = address;
             options.token = token;
             options.certificate = certificate;
             options.key = key;
             options.allowed_origins = allowed_origins;
             options.allowed_hosts = allowed_hosts;
             if (encoding) options.encoding = *encoding;
             if (step) options.encoding.step = *step;
             return std::make_unique<StreamServer>(options, page);
           }),
           py::arg("port") = defaults.port, py::kw_only(), py::arg("address") = defaults.address,
           py::arg("token") = defaults.token, py::arg("certificate") = defaults.certificate,
           py::arg("key") = defaults.key, py::arg("page") = true, py::arg("allowed_origins") = defaults.allowed_origins,
           py::arg("allowed_hosts") = defaults.allowed_hosts, py::arg("step") = py::none(),
           py::arg("encoding") = py::none(), serverDocs().c_str())
      .def_property_readonly(
          "port", [](const StreamServer& s) { return s.get().port(); }, "The port that it listens at.")
      .def_property_readonly(
          "link", [](const StreamServer& s) { return s.get().link(); }, doc("Server::link"))
      .def_property_readonly("has_page", &StreamServer::hasPage,
                             "Whether a browser that opens link gets a page that shows the stream.")
      .def_property_readonly("warnings", &StreamServer::warnings, doc("Server::warnings"))
      .def_property_readonly(
          "watched", [](const StreamServer& s) { return s.get().watched(); }, doc("Server::watched"))
      .def_property_readonly(
          "status", [](const StreamServer& s) { return s.get().status(); }, "What it has done until now.")
      .def(
          "publish",
          [](StreamServer& s, const py::object& cloud, const std::optional<std::uint64_t>& number,
             const std::optional<std::int64_t>& captured, const py::object& colors, const py::object& confidence,
             const py::object& view_count, const py::object& normals, const py::object& camera_mask) {
            s.publish(cloud, number, captured, {colors, confidence, view_count, normals, camera_mask});
          },
          py::arg("cloud"), py::arg("number") = py::none(), py::arg("captured") = py::none(), py::kw_only(),
          py::arg("colors") = py::none(), py::arg("confidence") = py::none(), py::arg("view_count") = py::none(),
          py::arg("normals") = py::none(), py::arg("camera_mask") = py::none(),
          "Publishes a cloud for whoever is connected; it never waits for a client. One thread may publish at a "
          "time.\n\ncloud: a Cloud, a "
          "StreamedCloud, or points, (N, 3) float32, metres. colors, (N, 3) uint8, confidence, view_count, (N,), "
          "normals, (N, 3), and camera_mask, (N, 2) uint32, go with points.\n\nnumber: of the frame; default: one more "
          "than the one before. captured: when its last image was taken, nanoseconds since 1970; 0: not known.")
      .def(
          "publish_image", &StreamServer::publishImage, py::arg("camera"), py::arg("image"), py::arg("captured") = 0,
          "Publishes an image of a camera for clients of Foxglove's protocol, as JPEG; it never waits for a client. It "
          "is copied and encoded only if somebody has subscribed to it.\n\ncamera: its position among those of "
          "describe(). image: (height, width, 3) uint8, red, green, blue, of the size of the camera's intrinsics, or "
          "of "
          "its colour camera's, if it has one. captured: when it was taken, nanoseconds since 1970, as that of the "
          "cloud; 0: now.\n\nRaises ValueError if there is no such camera, or the image is not its size.")
      .def(
          "image_wanted", [](const StreamServer& s, std::size_t camera) { return s.get().imageWanted(camera); },
          py::arg("camera"), doc("Server::imageWanted"))
      .def("describe", &StreamServer::describe, py::arg("name"), py::arg("cameras") = std::vector<Camera>(),
           py::arg("frame") = stream::Description().frame,
           "Clients learn of it before the next frame. name: for people. frame: the name of the coordinate frame.")
      .def(
          "take_notices", [](const StreamServer& s) { return s.get().takeNotices(); }, doc("Server::takeNotices"));
  bindClosing(server, "Ends its connections. The end of a with block does so, too.");
}

}  // namespace fuse_flow::python
