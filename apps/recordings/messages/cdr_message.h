#pragma once

#include "recordings/streams/frame_sets.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace fuse_flow::io {

/** \brief A message of ROS 2 in CDR, field after field. */
class CdrMessage {
 public:
  /** \param room bytes that are zero at first: Fast CDR leaves what pads its fields as the memory was */
  explicit CdrMessage(std::size_t room = 4096)
      : buffer_(room),
#if FASTCDR_VERSION_MAJOR >= 2
        cdr_(buffer_, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::CdrVersion::XCDRv1) {
    cdr_.set_encoding_flag(eprosima::fastcdr::EncodingAlgorithmFlag::PLAIN_CDR);
#else
        cdr_(buffer_, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR) {
#endif
    cdr_.serialize_encapsulation();
  }

  template <typename Value>
  CdrMessage& operator<<(const Value& value) {
    cdr_ << value;
    return *this;
  }
  CdrMessage& header(Nanoseconds time, const std::string& frame) {
    constexpr Nanoseconds second = 1'000'000'000;
    return *this << static_cast<std::int32_t>(time / second) << static_cast<std::uint32_t>(time % second) << frame;
  }
  /** \brief The whole message, whose last field is a list of bytes, which are copied once. */
  std::string endingWith(const void* data, std::size_t size) {
    *this << static_cast<std::uint32_t>(size);
    const std::string_view head = view();
    std::string message;
    message.reserve(head.size() + size);
    message.append(head).append(static_cast<const char*>(data), size);
    return message;
  }
  std::string_view view() {
#if FASTCDR_VERSION_MAJOR >= 2
    return std::string_view(buffer_.getBuffer(), cdr_.get_serialized_data_length());
#else
    return std::string_view(buffer_.getBuffer(), cdr_.getSerializedDataLength());
#endif
  }

 private:
  struct ZeroBuffer : eprosima::fastcdr::FastBuffer {
    explicit ZeroBuffer(std::size_t room) {
      if (reserve(room)) std::memset(getBuffer(), 0, room);
    }
  };

  ZeroBuffer buffer_;
  eprosima::fastcdr::Cdr cdr_;
};

}  // namespace fuse_flow::io
