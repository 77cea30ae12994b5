#include "jpeg_file.h"

#include <cstdlib>

namespace io_test {
namespace {

/** \brief Bits to bytes, most significant bit first; a zero follows each 255, which otherwise begins a marker. */
class BitWriter {
 public:
  void put(unsigned value, int bits) {
    for (int bit = bits - 1; bit >= 0; --bit) putBit(value >> bit & 1);
  }
  std::string finish() {
    while (filled_ != 0) putBit(1);
    return bytes_;
  }

 private:
  void putBit(unsigned bit) {
    byte_ = byte_ << 1 | bit;
    if (++filled_ < 8) return;
    bytes_ += static_cast<char>(byte_);
    if ((byte_ & 0xff) == 0xff) bytes_ += '\0';
    byte_ = 0;
    filled_ = 0;
  }
  std::string bytes_;
  unsigned byte_{0};
  int filled_{0};
};

std::string bigEndian16(std::size_t value) { return {static_cast<char>(value >> 8), static_cast<char>(value & 0xff)}; }

std::string segment(char marker, const std::string& data) {
  return std::string("\xff") + marker + bigEndian16(data.size() + 2) + data;
}

/** \brief How many codes there are of each length, 1 to 16, then their symbols. */
std::string huffmanTable(char id, std::size_t length, const std::string& symbols) {
  std::string counts(16, '\0');
  counts[length - 1] = static_cast<char>(symbols.size());
  return segment('\xc4', id + counts + symbols);
}

/** \brief The difference to the block before: the number of its bits as a code of four bits, then the bits. After it
 *  the code for "no more in this block", a single 0. */
void putBlock(BitWriter& bits, int difference) {
  int size = 0;
  while (std::abs(difference) >> size) ++size;
  bits.put(static_cast<unsigned>(size), 4);
  bits.put(static_cast<unsigned>(difference < 0 ? difference - 1 : difference), size);
  bits.put(0, 1);
}

}  // namespace

std::string jpeg(int blocks_wide, const std::vector<std::vector<std::uint8_t>>& planes) {
  const std::size_t width = 8 * static_cast<std::size_t>(blocks_wide);
  const std::size_t height = 8 * planes[0].size() / static_cast<std::size_t>(blocks_wide);
  const auto count = static_cast<char>(planes.size());
  std::string frame = '\x08' + bigEndian16(height) + bigEndian16(width) + count;
  std::string scan(1, count);
  for (char id = 1; id <= count; ++id) {
    frame += {id, '\x11', '\0'};
    scan += {id, '\0'};
  }
  scan += {'\0', '\x3f', '\0'};

  BitWriter bits;
  std::vector<int> before(planes.size(), 0);
  for (std::size_t block = 0; block < planes[0].size(); ++block)
    for (std::size_t plane = 0; plane < planes.size(); ++plane) {
      const int value = planes[plane][block] - 128;  // times 8 by the transform, divided by 8 by the quantisation
      putBlock(bits, value - before[plane]);
      before[plane] = value;
    }
  const std::string sizes("\0\1\2\3\4\5\6\7\10\11\12\13", 12);
  return "\xff\xd8" + segment('\xdb', '\0' + std::string(64, '\x08')) + segment('\xc0', frame) +
         huffmanTable('\x00', 4, sizes) + huffmanTable('\x10', 1, std::string(1, '\0')) + segment('\xda', scan) +
         bits.finish() + "\xff\xd9";
}

}  // namespace io_test
