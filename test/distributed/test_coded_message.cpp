#include "ranks.h"
#include "run_lengths.h"

#include <fuse_flow/distributed/coded_message.h>

#include <random>

#if defined(FUSE_FLOW_WITH_ZSTD)
#include <fuse_flow/distributed/zstd_codec.h>
#endif

namespace {

using fuse_flow::distributed::ByteKind;
using fuse_flow::distributed::BytePlanes;
using fuse_flow::distributed::CodedMessage;
using fuse_flow::distributed::Message;
using fuse_flow::distributed::MessageParts;
using fuse_flow::distributed::RankError;

std::vector<std::shared_ptr<const fuse_flow::distributed::Codec>> codecs() {
  return {
    std::make_shared<ranks::RunLengths>(),
#if defined(FUSE_FLOW_WITH_ZSTD)
        std::make_shared<fuse_flow::distributed::ZstdCodec>(),
#endif
  };
}

Message randomBytes(std::size_t n, unsigned int seed) {
  std::mt19937 random(seed);
  Message message(n);
  for (char& byte : message) byte = static_cast<char>(random());
  return message;
}

Message coded(const Message& plain, const MessageParts& parts, const fuse_flow::distributed::Codec& codec) {
  Message message;
  CodedMessage().code(codec, plain, parts, 2, message);
  return message;
}

Message decoded(const Message& message, std::size_t limit, const fuse_flow::distributed::Codec* codec) {
  Message plain;
  CodedMessage().decode(codec, message, 3, limit, 2, plain);
  return plain;
}

TEST(BytePlanes, AreDifferencesByteByByte) {
  // Two records of two words: 1, −1 and then 3, −2. Folded differences: 2, 4 and 1, 1.
  const std::int32_t words[] = {1, -1, 3, -2};
  Message from(sizeof words), to(sizeof words), back(sizeof words);
  std::memcpy(from.data(), words, sizeof words);
  const BytePlanes planes(ByteKind::Words, 2);
  planes.order(from.data(), from.size(), to.data());
  EXPECT_EQ(to, (Message{2, 4, 0, 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0}));
  planes.restore(to.data(), to.size(), back.data());
  EXPECT_EQ(back, from);

  const Message colors{10, 20, 30, 11, 22, 33};  // less green: −10 20 10, −11 22 11
  Message ordered(6), again(6);
  const BytePlanes of_colors(ByteKind::Colors, 1);
  of_colors.order(colors.data(), 6, ordered.data());
  EXPECT_EQ(ordered, (Message{-10, -1, 20, 2, 10, 1}));
  of_colors.restore(ordered.data(), 6, again.data());
  EXPECT_EQ(again, colors);
}

TEST(BytePlanes, GiveBackAnyBytesOfAnyLength) {
  for (const ByteKind kind : {ByteKind::Any, ByteKind::Words, ByteKind::Colors, static_cast<ByteKind>(77)})
    for (const std::uint32_t record : {1u, 2u, 7u, 1000u, ~0u})
      for (const std::size_t n : {0u, 1u, 2u, 3u, 4u, 5u, 11u, 27u, 28u, 29u, 4003u}) {
        const Message bytes = randomBytes(n, static_cast<unsigned int>(n) + record);
        Message ordered(n), back(n);
        const BytePlanes planes(kind, record);
        planes.order(bytes.data(), n, ordered.data());
        planes.restore(ordered.data(), n, back.data());
        EXPECT_EQ(back, bytes) << static_cast<int>(kind) << ", " << record << ", " << n;
      }
}

TEST(CodedMessage, IsReadAsItWasWritten) {
  const MessageParts parts = {{100},
                              {1200000, ByteKind::Words},  // several segments
                              {300007, ByteKind::Colors},
                              {0, ByteKind::Words, 8},
                              {96 * 5001, ByteKind::Words, 8}};
  std::size_t most = 0;
  for (const auto& part : parts) most += part.bytes;
  for (const auto& codec : codecs())
    for (const std::size_t n : {std::size_t{0}, std::size_t{60}, std::size_t{700001}, most, most + 17}) {
      const Message plain = randomBytes(n, static_cast<unsigned int>(n));
      const Message message = coded(plain, parts, *codec);
      EXPECT_TRUE(CodedMessage::isOne(message));
      EXPECT_EQ(decoded(message, n, codec.get()), plain) << n << " bytes";
    }
}

TEST(CodedMessage, IsShorterWhereNeighboursAreAlike) {
  Message plain(400000);
  for (std::size_t k = 0; k < plain.size() / 4; ++k) {
    const float slope = 1.5f + 1e-5f * static_cast<float>(k);
    std::memcpy(plain.data() + 4 * k, &slope, 4);
  }
  for (const auto& codec : codecs()) {
    const std::size_t with = coded(plain, {{plain.size(), ByteKind::Words}}, *codec).size(),
                      without = coded(plain, {}, *codec).size();
    EXPECT_LT(with, 0.8 * static_cast<double>(without));
    EXPECT_LT(with, 0.6 * static_cast<double>(plain.size()));
  }
}

TEST(CodedMessage, WhatIsCutOffIsRefusedWithTheRank) {
  const Message plain = randomBytes(5000, 1);
  for (const auto& codec : codecs()) {
    const Message whole = coded(plain, {{4000, ByteKind::Words}}, *codec);
    for (std::size_t size = 4; size < whole.size(); size += 7) {
      const Message part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      try {
        decoded(part, 10000, codec.get());
        ADD_FAILURE() << size << " bytes of " << whole.size() << " were taken";
      } catch (const RankError& error) {
        EXPECT_EQ(error.rank(), 3);
      }
    }
    Message longer = whole;
    longer.push_back(0);
    EXPECT_THROW(decoded(longer, 10000, codec.get()), RankError);
  }
}

TEST(CodedMessage, WhatItSaysOfItsLengthIsNotBelieved) {
  const Message plain(300000, 'x');
  for (const auto& codec : codecs()) {
    const Message whole = coded(plain, {}, *codec);
    EXPECT_THROW(decoded(whole, plain.size() - 1, codec.get()), RankError) << "more than the frame has";
    EXPECT_NO_THROW(decoded(whole, plain.size(), codec.get()));
    // Its table: three numbers, and then a length for each segment.
    Message other = whole;
    const std::uint32_t huge = 0x7fffffff;
    std::memcpy(other.data() + 12, &huge, sizeof huge);
    EXPECT_THROW(decoded(other, std::size_t{1} << 40, codec.get()), RankError) << "a segment too long";
    other = whole;
    std::memcpy(other.data() + 8, &huge, sizeof huge);
    EXPECT_THROW(decoded(other, plain.size(), codec.get()), RankError) << "more segments than bytes";
  }
}

TEST(CodedMessage, AnyChangedByteIsRefusedOrGivesOtherBytes) {
  const Message plain = randomBytes(3000, 2);
  std::mt19937 random(3);
  for (const auto& codec : codecs()) {
    const Message whole = coded(plain, {{1600, ByteKind::Words}, {900, ByteKind::Colors}}, *codec);
    for (int k = 0; k < 2000; ++k) {
      Message changed = whole;
      changed[random() % changed.size()] ^= static_cast<char>(1 << random() % 8);
      if (!CodedMessage::isOne(changed)) continue;
      try {
        EXPECT_LE(decoded(changed, 4000, codec.get()).size(), 4000u);
      } catch (const RankError&) {
      }
    }
  }
}

TEST(CodedMessage, NeedsTheSameCodec) {
  const Message message = coded(randomBytes(100, 4), {}, ranks::RunLengths());
  EXPECT_THROW(decoded(message, 100, nullptr), RankError);
#if defined(FUSE_FLOW_WITH_ZSTD)
  const fuse_flow::distributed::ZstdCodec other;
  EXPECT_THROW(decoded(message, 100, &other), RankError);
#endif
}

}  // namespace
