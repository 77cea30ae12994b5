#include "../plain.h"
#include "../recordings/open_ends.h"
#include "streams.h"

#include <fuse_flow/stream/client.h>

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief Client of the library. */
class StreamClient : public OpenUntilClosed<stream::Client> {
 public:
  StreamClient(const std::string& link, const stream::ClientOptions& options)
      : OpenUntilClosed(std::make_unique<stream::Client>(link, options), "fuse_flow.StreamClient") {}

  std::optional<Received> pull(double seconds) {
    if (!(seconds >= 0))
      throw py::value_error("fuse_flow.StreamClient: timeout is " + std::to_string(seconds) + " s, must be 0 or more");
    constexpr std::chrono::milliseconds kSlice(50);  // between looks for Ctrl-C, and for the interpreter's end
    const Busy::Inside inside(busy_, name());
    auto cloud = std::make_shared<stream::StreamedCloud>();
    auto left = std::chrono::milliseconds(static_cast<std::int64_t>(1e3 * std::min(seconds, 3e7)));
    for (;; left -= kSlice) {
      {
        stream::Client& open = get();
        const InFlight in_flight;
        if (open.pull(*cloud, std::min(left, kSlice))) return cloud;
      }
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (left <= kSlice || get().status().ended) return std::nullopt;
    }
  }
};

using Corner = std::array<double, 3>;

stream::Wishes wishesOf(const std::optional<std::uint64_t>& points, const std::optional<std::uint64_t>& rate,
                        const std::optional<std::pair<Corner, Corner>>& region, const std::optional<Corner>& viewpoint,
                        const std::optional<double>& step) {
  stream::Wishes wishes;
  wishes.points = points;
  wishes.bytes_per_second = rate;
  if (region) wishes.region = stream::Wishes::Box{region->first, region->second};
  wishes.viewpoint = viewpoint;
  wishes.step = step;
  return wishes;
}

void bindClientStatus(py::module_& module) {
  using stream::ClientStatus;
  py::class_<ClientStatus>(module, "StreamClientStatus", "What a StreamClient has received.")
      .def_readonly("connected", &ClientStatus::connected, "Whether it is connected.")
      .FUSE_FLOW_RESULT(ClientStatus, ended)
      .FUSE_FLOW_RESULT(ClientStatus, error)
      .FUSE_FLOW_RESULT(ClientStatus, connections)
      .FUSE_FLOW_RESULT(ClientStatus, frames)
      .FUSE_FLOW_RESULT(ClientStatus, bytes)
      .FUSE_FLOW_RESULT(ClientStatus, dropped)
      .FUSE_FLOW_RESULT(ClientStatus, damaged);
}

}  // namespace

void bindStreamClient(py::module_& module) {
  bindClientStatus(module);
  py::class_<StreamClient> client(module, "StreamClient", doc("Client"));
  client
      .def(py::init([](const std::string& link, const std::string& token, const std::string& certificate_authority,
                       bool verify, bool reconnect) {
             stream::ClientOptions options;
             options.token = token;
             options.certificate_authority = certificate_authority;
             options.verify = verify;
             options.reconnect = reconnect;
             return std::make_unique<StreamClient>(link, options);
           }),
           py::arg("link"), py::kw_only(), py::arg("token") = "", py::arg("certificate_authority") = "",
           py::arg("verify") = true, py::arg("reconnect") = true, doc("Client::Client"))
      .def("pull", &StreamClient::pull, py::arg("timeout"),
           "The newest cloud, if it was not pulled yet. timeout: seconds to wait for one; ≥ 0.\n\nReturns None if none "
           "came in that "
           "time, or none will come any more: see error.")
      .def(
          "wish",
          [](const StreamClient& c, const std::optional<std::uint64_t>& points,
             const std::optional<std::uint64_t>& rate, const std::optional<std::pair<Corner, Corner>>& region,
             const std::optional<Corner>& viewpoint,
             const std::optional<double>& step) { c.get().wish(wishesOf(points, rate, region, viewpoint, step)); },
          py::kw_only(), py::arg("points") = std::optional<std::uint64_t>(),
          py::arg("bytes_per_second") = std::optional<std::uint64_t>(),
          py::arg("region") = std::optional<std::pair<Corner, Corner>>(),
          py::arg("viewpoint") = std::optional<Corner>(), py::arg("step") = std::optional<double>(),
          "Asks the server for less, in place of what was asked for before.\n\npoints: at most, a frame. region: its "
          "two corners, the least x, y, z and the greatest, metres: only this part. viewpoint: metres: nearer points "
          "are denser. step: metres; coarser than the server's.\n\nRaises ValueError if a number is not finite, or a "
          "length not above 0.")
      .def_property_readonly(
          "description", [](const StreamClient& c) { return c.get().description(); }, doc("Client::description"))
      .def_property_readonly(
          "status", [](const StreamClient& c) { return c.get().status(); }, "What it has received until now.")
      .def_property_readonly(
          "connected", [](const StreamClient& c) { return c.get().status().connected; }, "Whether it is connected.")
      .def_property_readonly(
          "ended", [](const StreamClient& c) { return c.get().status().ended; }, doc("ClientStatus::ended"))
      .def_property_readonly(
          "error", [](const StreamClient& c) { return c.get().status().error; }, doc("ClientStatus::error"))
      .def(
          "take_notices", [](const StreamClient& c) { return c.get().takeNotices(); }, doc("Client::takeNotices"));
  bindClosing(client, "Ends its connection. The end of a with block does so, too.");
}

}  // namespace fuse_flow::python
