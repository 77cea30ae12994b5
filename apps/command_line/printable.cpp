#include "command_line/printable.h"

#include <cstdio>

namespace fuse_flow::command_line {
namespace {

/** \brief Whether a byte within a text of UTF-8 continues a character. */
bool continues(char byte) { return (static_cast<unsigned char>(byte) & 0xc0) == 0x80; }

}  // namespace

std::string printable(std::string_view text) {
  std::string result;
  const auto escape = [&result](char byte) {
    char code[8];
    std::snprintf(code, sizeof code, "\\x%02x", static_cast<unsigned int>(static_cast<unsigned char>(byte)));
    result += code;
  };
  for (std::size_t k = 0; k < text.size(); ++k) {
    const auto byte = static_cast<unsigned char>(text[k]);
    const auto next = k + 1 < text.size() ? static_cast<unsigned char>(text[k + 1]) : 0;
    const bool is_control = (byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7f;
    const bool begins_control = byte == 0xc2 && next >= 0x80 && next < 0xa0;  // U+0080 to U+009F in UTF-8
    if (is_control || begins_control) {
      escape(text[k]);
      if (begins_control) escape(text[++k]);
    } else {
      result += text[k];
    }
  }
  return result;
}

std::string shortened(const std::string& message) {
  constexpr std::size_t most = 1000;
  if (message.size() <= most) return message;
  std::size_t begin = most / 2, end = message.size() - most / 3;
  while (begin > 0 && continues(message[begin])) --begin;
  while (end < message.size() && continues(message[end])) ++end;
  return message.substr(0, begin) + " … " + message.substr(end);
}

PrintableStream::int_type PrintableStream::overflow(int_type character) {
  if (traits_type::eq_int_type(character, traits_type::eof())) return traits_type::not_eof(character);
  const char one = traits_type::to_char_type(character);
  return xsputn(&one, 1) == 1 ? character : traits_type::eof();
}

std::streamsize PrintableStream::xsputn(const char* text, std::streamsize count) {
  const std::string safe = printable({text, static_cast<std::size_t>(count)});
  const auto size = static_cast<std::streamsize>(safe.size());
  return to_->sputn(safe.data(), size) == size ? count : 0;
}

}  // namespace fuse_flow::command_line
