#pragma once

#include <fuse_flow/distributed/communicator.h>

#include <cstdint>
#include <cstring>
#include <type_traits>

namespace fuse_flow {
namespace distributed {

/** \brief Puts values one after the other into a message. Ranks have the same byte order and the same build: PartSummary::kVersion says so. */
class MessageWriter {
 public:
  /** \brief Begins an empty message; keeps its memory. */
  explicit MessageWriter(Message& message) : message_(message) { message_.clear(); }

  template <typename T>
  void put(const T& value) {
    put(&value, 1);
  }

  template <typename T>
  void put(const T* values, std::size_t n) {
    static_assert(std::is_trivially_copyable<T>::value, "goes over the wire as it lies in memory");
    char* const to = room(n * sizeof(T));
    if (n > 0) std::memcpy(to, values, n * sizeof(T));  // of nothing there may be no pointer
  }

  /** \brief Its length, and then it. */
  void put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size()));
    put(text.data(), text.size());
  }

  /** \brief Room for so many bytes more, valid until the next. */
  char* room(std::size_t bytes) {
    const std::size_t begin = message_.size();
    message_.resize(begin + bytes);
    return message_.data() + begin;
  }

 private:
  Message& message_;
};

/** \brief Takes them out again; believes no size before it has looked. */
class MessageReader {
 public:
  /** \param from the rank that sent it, for messages about it */
  MessageReader(const Message& message, int from)
      : next_(message.data()), end_(message.data() + message.size()), from_(from) {}

  template <typename T>
  T get() {
    T value;
    get(&value, 1);
    return value;
  }

  template <typename T>
  void get(T* values, std::size_t n) {
    static_assert(std::is_trivially_copyable<T>::value, "comes over the wire as it lies in memory");
    if (n > 0) std::memcpy(values, take(n, sizeof(T)), n * sizeof(T));
  }

  std::string getText() {
    const auto size = get<std::uint32_t>();
    const char* text = take(size, 1);
    return std::string(text, text + size);
  }

  /** \brief n values of so many bytes each, where they lie. */
  const char* take(std::size_t n, std::size_t bytes_each) {
    const auto left = static_cast<std::size_t>(end_ - next_);
    if (n > left / bytes_each) fail("a message that is too short");
    const char* here = next_;
    next_ += n * bytes_each;
    return here;
  }

  /** \brief After the last value. */
  void finish() const {
    if (next_ != end_) fail("a message that is too long");
  }

  [[noreturn]] void fail(const char* what) const { throw RankError(from_, std::string("sent ") + what); }

 private:
  const char* next_;
  const char* end_;
  int from_;
};

}  // namespace distributed
}  // namespace fuse_flow
