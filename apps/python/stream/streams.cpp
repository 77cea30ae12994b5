#include "../bindings.h"
#include "../cloud.h"
#include "../in_flight.h"
#include "../plain.h"
#include "open_ends.h"

#include <fuse_flow/stream/client.h>
#include <fuse_flow/stream/server.h>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

using Received = std::shared_ptr<stream::StreamedCloud>;

stream::CloudView viewOf(const Cloud& cloud) {
  stream::CloudView view;
  view.points = reinterpret_cast<const unsigned char*>(cloud.points);
  view.size = cloud.size;
  view.stride = cloud.layout.size;
  view.color = static_cast<int>(cloud.layout.rgba);
  view.confidence = static_cast<int>(cloud.layout.confidence);
  view.view_count = static_cast<int>(cloud.layout.view_count);
  if (cloud.layout.normal) view.normal = static_cast<int>(*cloud.layout.normal);
  if (cloud.layout.camera_mask) view.camera_mask = static_cast<int>(*cloud.layout.camera_mask);
  return view;
}

/** \brief Server of the library, until it is closed. */
class StreamServer : public OpenEnd {
 public:
  explicit StreamServer(const stream::ServerOptions& options) : server_(std::make_unique<stream::Server>(options)) {}
  ~StreamServer() override { closeNow(); }

  void close() {
    const Busy::Inside inside(busy_, "fuse_flow.StreamServer");
    closeNow();
  }
  void closeNow() override {
    const py::gil_scoped_release release;  // it says good-bye to its clients
    server_.reset();
  }
  stream::Server& server() const {
    if (!server_) throw std::runtime_error("fuse_flow.StreamServer is closed");
    return *server_;
  }
  void publish(const Cloud& cloud, std::uint64_t number, std::int64_t captured) {
    stream::Server& open = server();
    const Busy::Inside inside(busy_, "fuse_flow.StreamServer");
    const InFlight in_flight;
    open.publish(viewOf(cloud), stream::FrameTimes{number, captured, 0});
  }

 private:
  std::unique_ptr<stream::Server> server_;
  Busy busy_;
};

/** \brief Client of the library, until it is closed. */
class StreamClient : public OpenEnd {
 public:
  StreamClient(const std::string& link, const stream::ClientOptions& options)
      : client_(std::make_unique<stream::Client>(link, options)) {}
  ~StreamClient() override { closeNow(); }

  void close() {
    const Busy::Inside inside(busy_, "fuse_flow.StreamClient");
    closeNow();
  }
  void closeNow() override {
    const py::gil_scoped_release release;
    client_.reset();
  }
  stream::Client& client() const {
    if (!client_) throw std::runtime_error("fuse_flow.StreamClient is closed");
    return *client_;
  }
  std::optional<Received> pull(double seconds) {
    if (!(seconds >= 0))
      throw py::value_error("fuse_flow.StreamClient: timeout is " + std::to_string(seconds) + " s, must be 0 or more");
    constexpr std::chrono::milliseconds kSlice(50);  // between looks for Ctrl-C, and for the interpreter's end
    const Busy::Inside inside(busy_, "fuse_flow.StreamClient");
    auto cloud = std::make_shared<stream::StreamedCloud>();
    auto left = std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * std::min(seconds, 3e7)));
    for (;; left -= kSlice) {
      {
        stream::Client& open = client();
        const InFlight in_flight;
        if (open.pull(*cloud, std::min(left, kSlice))) return cloud;
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (left <= kSlice || client().status().ended) return std::nullopt;
    }
  }

 private:
  std::unique_ptr<stream::Client> client_;
  Busy busy_;
};

/** \brief An array of what was received; None if the stream does not carry it. */
template <typename T>
py::object arrayIn(const Received& cloud, const std::vector<T>& values, py::ssize_t length) {
  if (values.empty() && cloud->size() > 0) return py::none();
  const py::capsule owner(new Received(cloud), [](void* kept) { delete static_cast<Received*>(kept); });
  std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(cloud->size())};
  if (length > 0) shape.push_back(length);
  return py::array(py::dtype::of<T>(), shape, {}, values.data(), owner);
}

py::object confidenceIn(const Received& cloud) {
  if (cloud->confidence.empty() && cloud->size() > 0) return py::none();
  py::array_t<float> confidence(static_cast<py::ssize_t>(cloud->size()));
  std::transform(cloud->confidence.begin(), cloud->confidence.end(), confidence.mutable_data(),
                 [](std::uint8_t c) { return static_cast<float>(c) / 255.0f; });
  return confidence;
}

void bindReceived(py::module_& module) {
  py::class_<stream::StreamedCloud, Received>(module, "StreamedCloud",
                                              "A cloud as it arrived. Its arrays are not copied.")
      .def("__len__", &stream::StreamedCloud::size)
      .def_property_readonly(
          "points", [](const Received& c) { return arrayIn(c, c->positions, 3); },
          "(N, 3) float32: x, y, z in the world frame, metres; off by at most half of step.")
      .def_property_readonly(
          "colors", [](const Received& c) { return arrayIn(c, c->colors, 3); },
          "(N, 3) uint8: red, green, blue; None if the stream has none.")
      .def_property_readonly("confidence", &confidenceIn,
                             "(N,) float32, 0 … 1, in steps of 1/255; None if the stream has none.")
      .def_property_readonly(
          "view_count", [](const Received& c) { return arrayIn(c, c->view_counts, 0); },
          "(N,) uint8: the number of cameras that contributed; None if the stream has none.")
      .def_property_readonly(
          "normals", [](const Received& c) { return arrayIn(c, c->normals, 3); },
          "(N, 3) float32; 0, 0, 0 where none is known; None if the stream has none.")
      .def_property_readonly(
          "step", [](const Received& c) { return c->step; }, doc("StreamedCloud::step"))
      .def_property_readonly(
          "points_of_frame", [](const Received& c) { return c->points_of_frame; },
          doc("StreamedCloud::points_of_frame"))
      .def_property_readonly(
          "number", [](const Received& c) { return c->times.number; }, "As it was published.")
      .def_property_readonly(
          "captured", [](const Received& c) { return c->times.captured; }, doc("FrameTimes::captured"));
}

template <typename T>
void bindOpenEnd(py::class_<T>& type) {
  type.def("close", &T::close, "Ends its connections. The end of a with block does so, too.")
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](T& self, const py::args&) { self.close(); });
}

}  // namespace

void bindStreams(py::module_& module) {
  bindReceived(module);
  const stream::ServerOptions defaults;
  const std::string sentence =
      std::string(doc("Server")) +
      "\n\nPrograms and fuse_flow_viewer connect to its link; the page for browsers is fuse_flow_serve's.";
  py::class_<StreamServer> server(module, "StreamServer", sentence.c_str());
  server
      .def(py::init([](std::uint16_t port, const std::string& address, const std::string& token,
                       const std::string& certificate, const std::string& key, double step) {
             stream::ServerOptions options;
             options.port = port;
             options.address = address;
             options.token = token;
             options.certificate = certificate;
             options.key = key;
             options.encoding.step = step;
             return std::make_unique<StreamServer>(options);
           }),
           py::arg("port") = defaults.port, py::kw_only(), py::arg("address") = defaults.address,
           py::arg("token") = defaults.token, py::arg("certificate") = defaults.certificate,
           py::arg("key") = defaults.key, py::arg("step") = defaults.encoding.step,
           (std::string("Listens from here on. port: 0, one that is free. address: ") + doc("ServerOptions::address") +
            " token: " + doc("ServerOptions::token") + " certificate, key: " + doc("ServerOptions::certificate") +
            " step: " + doc("EncodingOptions::step"))
               .c_str())
      .def_property_readonly(
          "port", [](const StreamServer& s) { return s.server().port(); }, "The port that it listens at.")
      .def_property_readonly(
          "link", [](const StreamServer& s) { return s.server().link(); }, doc("Server::link"))
      .def_property_readonly(
          "warnings", [](const StreamServer& s) { return s.server().warnings(); }, doc("Server::warnings"))
      .def_property_readonly(
          "watched", [](const StreamServer& s) { return s.server().watched(); }, doc("Server::watched"))
      .def("publish", &StreamServer::publish, py::arg("cloud"), py::arg("number") = 0, py::arg("captured") = 0,
           "Publishes a Cloud for whoever is connected; it never waits for a client. number: of the frame. captured: "
           "when its last image "
           "was taken, nanoseconds since 1970; 0: not known.")
      .def(
          "describe",
          [](const StreamServer& s, const std::string& name, const std::vector<Camera>& cameras) {
            stream::Description description;
            description.name = name;
            description.cameras = cameras;
            s.server().describe(description);
          },
          py::arg("name"), py::arg("cameras") = std::vector<Camera>(), "Clients learn of it before the next frame.")
      .def(
          "take_notices", [](const StreamServer& s) { return s.server().takeNotices(); }, doc("Server::takeNotices"));
  bindOpenEnd(server);

  py::class_<StreamClient> client(module, "StreamClient", doc("Client"));
  client
      .def(py::init([](const std::string& link, const std::string& token, const std::string& certificate_authority,
                       bool verify) {
             stream::ClientOptions options;
             options.token = token;
             options.certificate_authority = certificate_authority;
             options.verify = verify;
             return std::make_unique<StreamClient>(link, options);
           }),
           py::arg("link"), py::kw_only(), py::arg("token") = "", py::arg("certificate_authority") = "",
           py::arg("verify") = true, doc("Client::Client"))
      .def("pull", &StreamClient::pull, py::arg("timeout"),
           "The newest cloud, if it was not pulled yet. timeout: seconds to wait for one; ≥ 0.\n\nReturns None if none "
           "came in that "
           "time, or none will come any more: see error.")
      .def_property_readonly(
          "connected", [](const StreamClient& c) { return c.client().status().connected; }, "Whether it is connected.")
      .def_property_readonly(
          "ended", [](const StreamClient& c) { return c.client().status().ended; }, doc("ClientStatus::ended"))
      .def_property_readonly(
          "error", [](const StreamClient& c) { return c.client().status().error; }, doc("ClientStatus::error"))
      .def(
          "take_notices", [](const StreamClient& c) { return c.client().takeNotices(); }, doc("Client::takeNotices"));
  bindOpenEnd(client);
  beforeExit(&OpenEnd::closeAll);
}

}  // namespace fuse_flow::python
