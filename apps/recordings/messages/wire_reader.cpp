#include "recordings/messages/wire_reader.h"

#include <cstring>

#ifdef FUSE_FLOW_WITH_FASTCDR
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastcdr/exceptions/Exception.h>
#endif

namespace fuse_flow::io {
namespace {

[[noreturn]] void throwTooShort(const std::string& name, std::size_t size) {
  throw InputError(name + ": is too short with " + std::to_string(size) + " bytes, or damaged");
}

/** \brief Numbers are packed; on this machine they are little endian, too. */
class Ros1Reader : public WireReader {
 public:
  Ros1Reader(std::string name, const std::string& message) : name_(std::move(name)), message_(message) {}

  std::uint8_t u8() override { return number<std::uint8_t>(); }
  std::uint32_t u32() override { return number<std::uint32_t>(); }
  std::int32_t i32() override { return number<std::int32_t>(); }
  float f32() override { return number<float>(); }
  double f64() override { return number<double>(); }
  std::string text() override { return std::string(bytes()); }
  std::string_view bytes() override { return take(u32()); }
  std::string_view rest() override { return take(message_.size() - at_); }
  bool headersAreNumbered() const override { return true; }

 private:
  std::string_view take(std::size_t count) {
    if (count > message_.size() - at_) throwTooShort(name_, message_.size());
    at_ += count;
    return std::string_view(message_).substr(at_ - count, count);
  }
  template <typename Number>
  Number number() {
    Number value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }

  std::string name_;
  const std::string& message_;
  std::size_t at_{0};
};

#ifdef FUSE_FLOW_WITH_FASTCDR

class CdrReader : public WireReader {
 public:
  CdrReader(std::string name, const std::string& message)
      : name_(std::move(name)),
        message_(message),
        buffer_(const_cast<char*>(message.data()), message.size()),  // it does not write to it
#if FASTCDR_VERSION_MAJOR >= 2
        cdr_(buffer_, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::CdrVersion::DDS_CDR)
#else
        cdr_(buffer_, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::Cdr::DDS_CDR)
#endif
  {
    guarded([&] { cdr_.read_encapsulation(); });
  }

  std::uint8_t u8() override { return number<std::uint8_t>(); }
  std::uint32_t u32() override { return number<std::uint32_t>(); }
  std::int32_t i32() override { return number<std::int32_t>(); }
  float f32() override { return number<float>(); }
  double f64() override { return number<double>(); }
  std::string text() override {
    const std::string_view with_zero = bytes();
    return std::string(with_zero.substr(0, with_zero.empty() ? 0 : with_zero.size() - 1));
  }
  std::string_view bytes() override { return take(u32()); }
  std::string_view rest() override { return take(message_.size() - position()); }
  bool headersAreNumbered() const override { return false; }

 private:
  template <typename Function>
  void guarded(Function function) {
    try {
      function();
    } catch (const eprosima::fastcdr::exception::Exception&) {
      throwTooShort(name_, message_.size());
    }
  }
  template <typename Number>
  Number number() {
    Number value{};
    guarded([&] { cdr_ >> value; });
    return value;
  }
  std::size_t position() {
#if FASTCDR_VERSION_MAJOR >= 2
    const char* current = cdr_.get_current_position();
#else
    const char* current = cdr_.getCurrentPosition();
#endif
    return static_cast<std::size_t>(current - message_.data());
  }
  std::string_view take(std::size_t count) {
    const std::size_t at = position();
    if (count > message_.size() - at) throwTooShort(name_, message_.size());
    if (count > 0) {
      cdr_.jump(count - 1);
      number<std::uint8_t>();  // after a jump alone it would not align what follows
    }
    return std::string_view(message_).substr(at, count);
  }

  std::string name_;
  const std::string& message_;
  eprosima::fastcdr::FastBuffer buffer_;
  eprosima::fastcdr::Cdr cdr_;
};

#endif

}  // namespace

std::unique_ptr<WireReader> makeWireReader(Wire wire, const std::string& name, const std::string& message) {
  if (wire == Wire::Ros1) return std::make_unique<Ros1Reader>(name, message);
#ifdef FUSE_FLOW_WITH_FASTCDR
  return std::make_unique<CdrReader>(name, message);
#else
  throw InputError(
      name +
      ": is a message of ROS 2, and FUSE-Flow was built without Fast CDR; install libfastcdr-dev, and build "
      "it again");
#endif
}

}  // namespace fuse_flow::io
