#include "../plain.h"
#include "../recordings/open_ends.h"
#include "../recordings/paths.h"
#include "published.h"
#include "streams.h"

#include <fuse_flow/recordings/error.h>
#include <fuse_flow/stream/stream_file.h>

#include <pybind11/stl.h>

#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace fuse_flow::python {
namespace {

namespace py = pybind11;

/** \brief What a stream file throws as what a recording throws. */
template <typename Error, typename Work>
auto throwing(const Work& work) {
  try {
    return work();
  } catch (const std::runtime_error& error) {
    throw Error(error.what());
  }
}

/** \brief StreamWriter of the library, with an encoder. */
class FileWriter {
 public:
  FileWriter(std::string path, const stream::Description& description, const stream::EncodingOptions& encoding)
      : step_(encoding.step), encoder_(encoding) {
    const InFlight in_flight;
    throwing<io::OutputError>([&] { writer_.emplace(path, description); });
  }

  void describe(const std::string& name, const std::vector<Camera>& cameras, const std::string& frame) {
    const Busy::Inside inside(busy_, kName);
    stream::StreamWriter& writer = open();
    const stream::Description description = describedAs(name, cameras, frame, step_);
    const InFlight in_flight;
    throwing<io::OutputError>([&] { writer.describe(description); });
  }
  void write(const py::object& cloud, const std::optional<std::uint64_t>& number,
             const std::optional<std::int64_t>& captured, const PublishedCloud::Fields& fields) {
    const Busy::Inside inside(busy_, kName);
    stream::StreamWriter& writer = open();
    PublishedCloud published(cloud, fields);
    stream::FrameTimes times = numbers_.timesOf(cloud, number, captured);
    if (times.encoded == 0)
      times.encoded =
          std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch())
              .count();
    const InFlight in_flight;
    const std::shared_ptr<const stream::EncodedFrame> frame = encoder_.encode(published.view(), times);
    throwing<io::OutputError>([&] { writer.write(stream::messageOf(frame)); });
  }
  void close() {
    const Busy::Inside inside(busy_, kName);
    writer_.reset();
  }

 private:
  static constexpr const char* kName = "fuse_flow.StreamWriter";
  stream::StreamWriter& open() {
    if (!writer_) throw std::runtime_error(std::string(kName) + " is closed");
    return *writer_;
  }

  double step_;
  stream::FrameEncoder encoder_;
  std::optional<stream::StreamWriter> writer_;
  FrameNumbers numbers_;
  Busy busy_;
};

/** \brief StreamReader of the library, with a decoder. */
class FileReader {
 public:
  explicit FileReader(std::string path) : path_(std::move(path)) {
    const InFlight in_flight;
    throwing<io::InputError>([&] { reader_.emplace(path_); });
  }

  stream::StreamReader& reader() { return *reader_; }
  stream::Description description() {
    const Busy::Inside inside(busy_, kName);  // reading changes it
    return reader_->description();
  }

  Received read(std::size_t frame) {
    if (frame >= reader_->frames())
      throw py::index_error("frame " + std::to_string(frame) + " does not exist: the file has " +
                            std::to_string(reader_->frames()));
    const Busy::Inside inside(busy_, kName);
    auto cloud = std::make_shared<stream::StreamedCloud>();
    const InFlight in_flight;
    throwing<io::InputError>([&] { reader_->read(frame, message_); });
    try {
      decoder_.decode(message_.data(), message_.size(), *cloud);
    } catch (const stream::FormatError& error) {
      throw io::InputError(path_ + ": frame " + std::to_string(frame) + " is damaged: " + error.what());
    }
    return cloud;
  }

 private:
  static constexpr const char* kName = "fuse_flow.StreamReader";
  std::string path_;
  std::optional<stream::StreamReader> reader_;
  stream::FrameDecoder decoder_;
  std::vector<std::uint8_t> message_;
  Busy busy_;
};

class CloudIterator {
 public:
  explicit CloudIterator(std::shared_ptr<FileReader> file) : file_(std::move(file)) {}
  Received next() {
    if (at_ == file_->reader().frames()) throw py::stop_iteration();
    return file_->read(at_++);
  }

 private:
  std::shared_ptr<FileReader> file_;
  std::size_t at_{0};
};

void bindWriter(py::module_& module) {
  py::class_<FileWriter> writer(module, "StreamWriter", doc("StreamWriter"));
  writer
      .def(py::init([](const py::object& path, const std::string& name, const std::vector<Camera>& cameras,
                       const std::string& frame, const std::optional<double>& step,
                       const std::optional<stream::EncodingOptions>& encoding) {
             stream::EncodingOptions options = encoding.value_or(stream::EncodingOptions());
             if (step) options.step = *step;
             return std::make_unique<FileWriter>(pathOf(path), describedAs(name, cameras, frame, options.step),
                                                 options);
           }),
           py::arg("path"), py::kw_only(), py::arg("name") = "", py::arg("cameras") = std::vector<Camera>(),
           py::arg("frame") = stream::Description().frame, py::arg("step") = py::none(),
           py::arg("encoding") = py::none(),
           (std::string("Writes a file, NAME.ffs, in place of one that is there. name, cameras, frame: as for "
                        "StreamServer.describe(). step, encoding: as for StreamServer.") +
            "\n\nRaises OSError naming the file, if it cannot be written.")
               .c_str())
      .def("describe", &FileWriter::describe, py::arg("name"), py::arg("cameras") = std::vector<Camera>(),
           py::arg("frame") = stream::Description().frame, "From here on, another description holds.")
      .def(
          "write",
          [](FileWriter& w, const py::object& cloud, const std::optional<std::uint64_t>& number,
             const std::optional<std::int64_t>& captured, const py::object& colors, const py::object& confidence,
             const py::object& view_count, const py::object& normals, const py::object& camera_mask) {
            w.write(cloud, number, captured, {colors, confidence, view_count, normals, camera_mask});
          },
          py::arg("cloud"), py::arg("number") = py::none(), py::arg("captured") = py::none(), py::kw_only(),
          py::arg("colors") = py::none(), py::arg("confidence") = py::none(), py::arg("view_count") = py::none(),
          py::arg("normals") = py::none(), py::arg("camera_mask") = py::none(),
          "Writes a cloud, with arguments as those of StreamServer.publish().\n\nRaises OSError, as for a full disk; "
          "what was written before plays.");
  bindClosing(writer, "Ends the file. The end of a with block does so, too.");
}

void bindReader(py::module_& module) {
  py::class_<CloudIterator>(module, "StreamIterator", "The clouds of a StreamReader, one after the other.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__", &CloudIterator::next);
  py::class_<FileReader, std::shared_ptr<FileReader>>(module, "StreamReader",
                                                      "Reads a stream file, .ffs. Iterating gives its clouds.")
      .def(py::init([](const py::object& path) { return std::make_shared<FileReader>(pathOf(path)); }), py::arg("path"),
           "Raises ValueError naming the file, if it is no stream file, or cannot be read.")
      .def("__len__", [](FileReader& file) { return file.reader().frames(); })
      .def("__iter__", [](const std::shared_ptr<FileReader>& file) { return CloudIterator(file); })
      .def("read", &FileReader::read, py::arg("frame"),
           "The cloud of a frame, from 0 to len() - 1.\n\nRaises ValueError if it is damaged.")
      .def(
          "time",
          [](FileReader& file, std::size_t frame) {
            if (frame >= file.reader().frames()) throw py::index_error("frame " + std::to_string(frame));
            return file.reader().time(frame);
          },
          py::arg("frame"), doc("StreamReader::time"))
      .def_property_readonly("description", &FileReader::description, doc("StreamReader::description"))
      .def_property_readonly(
          "cut_off", [](FileReader& file) { return file.reader().cutOff(); }, doc("StreamReader::cutOff"));
}

}  // namespace

void bindStreamFiles(py::module_& module) {
  bindWriter(module);
  bindReader(module);
}

}  // namespace fuse_flow::python
