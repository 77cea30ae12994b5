#include "stream/gpu/content_checksum.h"
#include "stream/gpu/packed_array.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace fuse_flow::stream;
using Bytes = std::vector<std::uint8_t>;

/** \brief What the threads of a team wait at for each other. */
class Gate {
 public:
  explicit Gate(std::uint32_t threads) : threads_(threads) {}
  void pass() {
    std::unique_lock<std::mutex> lock(mutex_);
    const std::uint32_t turn = turn_;
    if (++waiting_ == threads_) {
      waiting_ = 0;
      ++turn_;
      all_here_.notify_all();
    } else {
      all_here_.wait(lock, [&] { return turn_ != turn; });
    }
  }

 private:
  std::mutex mutex_;
  std::condition_variable all_here_;
  std::uint32_t threads_, waiting_{0}, turn_{0};
};

/** \brief A team of threads, as a block of a GPU is one: the thread sanitizer sees where they do not wait for each other. */
struct Crew {
  std::uint32_t thread, threads;
  Gate* gate;

  template <typename Step>
  void forEach(std::uint32_t n, const Step& step) const {
    for (std::uint32_t k = thread; k < n; k += threads) step(k);
    gate->pass();
  }
  template <typename Step>
  void once(const Step& step) const {
    if (thread == 0) step();
    gate->pass();
  }
  void add(std::uint32_t* where, std::uint32_t value) const { __atomic_fetch_add(where, value, __ATOMIC_RELAXED); }
  void raise(std::uint32_t* where, std::uint32_t value) const {
    std::uint32_t seen = __atomic_load_n(where, __ATOMIC_RELAXED);
    while (seen < value &&
           !__atomic_compare_exchange_n(where, &seen, value, true, __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
  }
  void setBits(std::uint32_t* where, std::uint32_t bits) const { __atomic_fetch_or(where, bits, __ATOMIC_RELAXED); }
  std::uint32_t sumUp(std::uint32_t* values, std::uint32_t n) const {
    static std::uint32_t sum;
    if (thread == 0) sum = Alone().sumUp(values, n);
    gate->pass();
    const std::uint32_t all = sum;
    gate->pass();
    return all;
  }
};

/** \brief Arrays as one frame of Zstandard, each in blocks of its own. */
Bytes packed(const std::vector<Bytes>& arrays) {
  Bytes frame{0x28, 0xb5, 0x2f, 0xfd, 0x04, 0x38}, content;
  PackWorkspace work;
  for (std::size_t k = 0; k < arrays.size(); ++k) {
    const auto size = static_cast<std::uint32_t>(arrays[k].size());
    PackedArray array;
    std::vector<std::uint32_t> body(size / 4 + 2, 0xabababab);
    packArray(Alone(), work, arrays[k].data(), size, k + 1 == arrays.size(), body.data(), array);
    frame.insert(frame.end(), array.head, array.head + array.head_bytes);
    const auto* bytes =
        array.kind == PackedArray::kStored ? arrays[k].data() : reinterpret_cast<const std::uint8_t*>(body.data());
    frame.insert(frame.end(), bytes, bytes + array.body_bytes);
    content.insert(content.end(), arrays[k].begin(), arrays[k].end());
  }
  std::uint64_t lanes[4];
  std::uint32_t checksum = 0;
  contentChecksum(Alone(), lanes, content.data(), static_cast<std::uint32_t>(content.size()), &checksum);
  for (int k = 0; k < 4; ++k) frame.push_back(static_cast<std::uint8_t>(checksum >> (8 * k)));
  return frame;
}

/** \brief By Zstandard itself, which checks the checksum. */
void expectUnpacks(const std::vector<Bytes>& arrays, const std::string& what) {
  Bytes content;
  for (const Bytes& array : arrays) content.insert(content.end(), array.begin(), array.end());
  const Bytes frame = packed(arrays);
  Bytes out(content.size() + 64);
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), frame.data(), frame.size());
  ASSERT_FALSE(ZSTD_isError(size)) << what << ": " << ZSTD_getErrorName(size);
  out.resize(size);
  ASSERT_TRUE(out == content) << what;
}

/** \brief As Zstandard packs them. */
std::size_t sizeByZstandard(const Bytes& array) {
  Bytes out(ZSTD_compressBound(array.size()));
  return ZSTD_compress(out.data(), out.size(), array.data(), array.size(), 1);
}

/** \brief Bytes of which small differences, to both sides of 0, are the most frequent. \param spread of them */
Bytes differences(std::size_t size, double spread, unsigned int seed) {
  std::mt19937 random(seed);
  const auto unit = [&] { return (random() + 0.5) / 4294967296.0; };
  Bytes array(size);
  for (std::uint8_t& byte : array) {
    const double magnitude = -spread * std::log(unit());
    byte = static_cast<std::uint8_t>(static_cast<int>(std::min(magnitude, 1e6)) * (random() % 2 ? 1 : -1));
  }
  return array;
}

TEST(PackedArrays, ZstandardUnpacksArraysOfAnySize) {
  std::vector<std::size_t> sizes;
  for (std::size_t size = 1; size < 300; ++size) sizes.push_back(size);
  for (const std::size_t size :
       {511, 512, 1022, 1023, 1024, 1025, 4097, 16383, 16384, 16385, 65535, 65536, 131071, 131072})
    sizes.push_back(size);
  for (const std::size_t size : sizes)
    for (const double spread : {0.3, 3.0, 40.0})
      expectUnpacks({differences(size, spread, static_cast<unsigned int>(size))},
                    std::to_string(size) + " bytes, spread " + std::to_string(spread));
}

TEST(PackedArrays, ZstandardUnpacksWhatIsOneByteOrAll) {
  for (const std::size_t size : {1, 2, 3, 255, 256, 257, 131072}) {
    expectUnpacks({Bytes(size, 7)}, std::to_string(size) + " times the same");
    Bytes all(size), two(size), last(size, 0);
    for (std::size_t k = 0; k < size; ++k) {
      all[k] = static_cast<std::uint8_t>(k);
      two[k] = k % 3 == 0 ? 255 : 0;
    }
    last.back() = 255;
    expectUnpacks({all}, std::to_string(size) + " bytes, all alike often");
    expectUnpacks({two}, std::to_string(size) + " bytes of two kinds");
    expectUnpacks({last}, std::to_string(size) + " bytes, the last another one");
  }
}

TEST(PackedArrays, ZstandardUnpacksWhatIsRandom) {
  std::mt19937 random(4);
  for (int repetition = 0; repetition < 400; ++repetition) {
    // Some of the bytes, each with a frequency that is anything between rare and frequent.
    const std::size_t kinds = 1 + random() % 256, size = 1 + random() % (repetition % 8 == 0 ? 131072 : 3000);
    Bytes bag;
    for (std::size_t k = 0; k < kinds; ++k)
      bag.insert(bag.end(), std::size_t{1} << random() % 10, static_cast<std::uint8_t>(random()));
    Bytes array(size);
    for (std::uint8_t& byte : array) byte = bag[random() % bag.size()];
    expectUnpacks({array}, "repetition " + std::to_string(repetition));
  }
}

TEST(PackedArrays, ZstandardUnpacksCodesThatWouldBeTooLong) {
  // Frequencies as Fibonacci's numbers: each code is longer by one.
  Bytes array;
  std::size_t a = 1, b = 1;
  for (int k = 0; array.size() + a <= 131072; ++k) {
    array.insert(array.end(), a, static_cast<std::uint8_t>(10 * k));
    const std::size_t sum = a + b;
    a = b;
    b = sum;
  }
  std::shuffle(array.begin(), array.end(), std::mt19937(5));
  expectUnpacks({array}, "Fibonacci");
  // And all others once.
  for (int k = 0; k < 256; ++k) array[static_cast<std::size_t>(400 * k)] = static_cast<std::uint8_t>(k);
  expectUnpacks({array}, "Fibonacci and all others");
}

TEST(PackedArrays, FollowOneAnotherInOneFrame) {
  expectUnpacks({differences(5000, 2, 1),
                 Bytes(300, 9),
                 differences(70000, 500, 2),
                 differences(1, 1, 3),
                 {},
                 differences(3001, 6, 4)},
                "several");
}

TEST(PackedArrays, HaveTheSameBytesWhoeverPacksThem) {
  for (const Bytes& from : {differences(200, 3, 1), differences(5000, 3, 2), differences(20000, 60, 3), Bytes(700, 4),
                            differences(40000, 1e5, 4), Bytes()}) {
    const auto size = static_cast<std::uint32_t>(from.size());
    const auto pack = [&](const auto& team, PackWorkspace& work, std::vector<std::uint32_t>& body, PackedArray& array,
                          std::uint64_t* lanes, std::uint32_t& checksum) {
      packArray(team, work, from.data(), size, true, body.data(), array);
      contentChecksum(team, lanes, from.data(), size, &checksum);
    };
    const auto bytes = [&](const std::vector<std::uint32_t>& body, const PackedArray& array, std::uint32_t checksum) {
      Bytes all(array.head, array.head + array.head_bytes);
      const auto* begin = reinterpret_cast<const std::uint8_t*>(body.data());
      if (array.kind == PackedArray::kPacked) all.insert(all.end(), begin, begin + array.body_bytes);
      all.push_back(static_cast<std::uint8_t>(array.kind));
      for (int k = 0; k < 4; ++k) all.push_back(static_cast<std::uint8_t>(checksum >> (8 * k)));
      return all;
    };
    PackWorkspace work;
    PackedArray array;
    std::uint64_t lanes[4];
    std::uint32_t checksum = 0;
    std::vector<std::uint32_t> body(size / 4 + 2);
    pack(Alone(), work, body, array, lanes, checksum);
    const Bytes expected = bytes(body, array, checksum);
    for (const std::uint32_t threads : {2u, 5u}) {
      Gate gate(threads);
      std::vector<std::thread> crew;
      for (std::uint32_t k = 0; k < threads; ++k)
        crew.emplace_back([&, k] { pack(Crew{k, threads, &gate}, work, body, array, lanes, checksum); });
      for (std::thread& thread : crew) thread.join();
      EXPECT_TRUE(bytes(body, array, checksum) == expected) << size << " bytes, " << threads << " threads";
    }
  }
}

TEST(PackedArrays, TakeNoMoreThanZstandardsOwn) {
  for (const double spread : {0.5, 1.0, 2.0, 5.0, 12.0, 30.0, 80.0})
    for (const std::size_t size : {2048, 8192, 16384, 65536}) {
      const Bytes array = differences(size, spread, 7);
      EXPECT_LT(static_cast<double>(packed({array}).size()), 1.005 * static_cast<double>(sizeByZstandard(array)) + 8)
          << size << " bytes, spread " << spread;
    }
}

}  // namespace
