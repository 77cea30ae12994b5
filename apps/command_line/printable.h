#pragma once

#include <ostream>
#include <streambuf>
#include <string>
#include <string_view>

namespace fuse_flow::command_line {

/** \brief Text in which a terminal finds nothing to obey: what is a control character, of ASCII or of Unicode, but for the line end and
 *  the tabulator, reads as in C: names of files and cameras come from whoever made the recording. */
std::string printable(std::string_view text);

/** \brief A message of no more than a thousand bytes: of a longer one the beginning and the end. */
std::string shortened(const std::string& message);

/** \brief What is written to a stream while this lives is printable(). */
class PrintableStream : private std::streambuf {
 public:
  explicit PrintableStream(std::ostream& stream) : stream_(stream), to_(stream.rdbuf(this)) {}
  ~PrintableStream() override { stream_.rdbuf(to_); }
  PrintableStream(const PrintableStream&) = delete;
  PrintableStream& operator=(const PrintableStream&) = delete;

 private:
  int_type overflow(int_type character) override;
  std::streamsize xsputn(const char* text, std::streamsize count) override;
  int sync() override { return to_->pubsync(); }

  std::ostream& stream_;
  std::streambuf* to_;
};

}  // namespace fuse_flow::command_line
