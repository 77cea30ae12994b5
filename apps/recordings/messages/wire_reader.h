#pragma once

#include "recordings/logs/message_log.h"

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace fuse_flow::io {

/** \brief Reads the fields of a message one after the other. Every function throws InputError where the message ends before. */
class WireReader {
 public:
  virtual ~WireReader() = default;

  virtual std::uint8_t u8() = 0;
  virtual std::uint32_t u32() = 0;
  virtual std::int32_t i32() = 0;
  virtual float f32() = 0;
  virtual double f64() = 0;
  virtual std::string text() = 0;
  /** \brief A list of bytes, as long as the message's bytes stay. */
  virtual std::string_view bytes() = 0;
  /** \brief What comes behind the last field read. */
  virtual std::string_view rest() = 0;
  /** \brief Whether a std_msgs/Header begins with a sequence number. */
  virtual bool headersAreNumbered() const = 0;
};

/** \brief Throws InputError where the build has no reader for it. \param name what messages call it  \param message must stay */
std::unique_ptr<WireReader> makeWireReader(Wire wire, const std::string& name, const std::string& message);

}  // namespace fuse_flow::io
