#include "stream/codec/sorted_points.h"

#include <fuse_flow/impl/host/parallel.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <utility>

namespace fuse_flow::stream {

namespace {

using Entry = SortedPoints::Entry;
constexpr std::size_t kBlock = 16384;  // points of a task

bool finite(const float* p) { return std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]); }

/** \brief By digits of 8 bits, the lowest first. \param bits that differ between the codes */
void sortByDigits(Entry* entries, Entry* scratch, std::size_t count, int bits) {
  if (count < 64) {
    std::sort(entries, entries + count, [](const Entry& a, const Entry& b) { return a.code < b.code; });
    return;
  }
  Entry *from = entries, *to = scratch;
  for (int shift = 0; shift < bits; shift += 8) {
    std::array<std::uint32_t, 257> begin{};
    for (std::size_t k = 0; k < count; ++k) ++begin[(from[k].code >> shift & 255) + 1];
    for (std::size_t digit = 1; digit < 256; ++digit) begin[digit] += begin[digit - 1];
    for (std::size_t k = 0; k < count; ++k) to[begin[from[k].code >> shift & 255]++] = from[k];
    std::swap(from, to);
  }
  if (from != entries) std::copy(from, from + count, entries);
}

/** \brief Points with the same code, by what else is streamed of them. */
void orderEqual(const CloudView& cloud, Entry* entries, std::size_t count) {
  const auto compare = [&](const Entry& a, const Entry& b) {
    for (const auto& [offset, size] : {std::pair<int, std::size_t>{cloud.color, 3},
                                       {cloud.confidence, 4},
                                       {cloud.view_count, 4},
                                       {cloud.normal, 12},
                                       {cloud.camera_mask, 8}})
      if (offset >= 0)
        if (const int order = std::memcmp(cloud.points + a.point * cloud.stride + offset,
                                          cloud.points + b.point * cloud.stride + offset, size))
          return order < 0;
    return false;
  };
  for (std::size_t i = 0, end; i < count; i = end) {
    end = i + 1;
    while (end < count && entries[end].code == entries[i].code) ++end;
    if (end - i > 1) std::sort(entries + i, entries + end, compare);
  }
}

}  // namespace

void SortedPoints::findOrigin(const CloudView& cloud, double step, int threads) {
  const std::size_t blocks = (cloud.size + kBlock - 1) / kBlock;
  struct Range {
    std::array<float, 3> least, greatest;
    std::size_t count;
  };
  constexpr float far = std::numeric_limits<float>::infinity();
  std::vector<Range> ranges(blocks, Range{{far, far, far}, {-far, -far, -far}, 0});
  host::parallelFor(threads, blocks, [&](std::size_t block, int) {
    Range range = ranges[block];
    for (std::size_t i = block * kBlock; i < std::min(cloud.size, (block + 1) * kBlock); ++i) {
      const float* p = cloud.position(i);
      if (!finite(p)) continue;
      ++range.count;
      for (std::size_t k = 0; k < 3; ++k) {
        range.least[k] = std::min(range.least[k], p[k]);
        range.greatest[k] = std::max(range.greatest[k], p[k]);
      }
    }
    ranges[block] = range;
  });
  Range all{{far, far, far}, {-far, -far, -far}, 0};
  for (const Range& range : ranges) {
    all.count += range.count;
    for (std::size_t k = 0; k < 3; ++k) {
      all.least[k] = std::min(all.least[k], range.least[k]);
      all.greatest[k] = std::max(all.greatest[k], range.greatest[k]);
    }
  }
  finite_ = all.count;
  for (std::size_t k = 0; k < 3; ++k) {
    if (all.count == 0) {
      first_[k] = 0;
    } else if (fitsLattice(all.least[k], all.greatest[k], step)) {
      first_[k] = originInSteps(all.least[k], step);
    } else {
      // Some points are very far from others: those stay that are around the median.
      std::vector<float> values;
      values.reserve(all.count);
      for (std::size_t i = 0; i < cloud.size; ++i)
        if (finite(cloud.position(i))) values.push_back(cloud.position(i)[k]);
      const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
      std::nth_element(values.begin(), middle, values.end());
      first_[k] = std::floor((*middle / step - kMostSteps / 2) / kOriginAlignment) * kOriginAlignment;
    }
    origin_[k] = first_[k] * step;
  }
}

void SortedPoints::sort(const CloudView& cloud, double step, int threads) {
  if (cloud.size > std::numeric_limits<std::uint32_t>::max())
    throw std::length_error("stream: a cloud of more than 2^32 points");
  findOrigin(cloud, step, threads);
  const std::size_t blocks = (cloud.size + kBlock - 1) / kBlock;
  entries_.resize(cloud.size);
  scratch_.resize(cloud.size);

  // Their codes.
  constexpr std::uint64_t nowhere = ~std::uint64_t{0};
  std::vector<std::uint64_t> used(blocks, 0);  // bits that are in any code
  const double per_metre = 1 / step;
  host::parallelFor(threads, blocks, [&](std::size_t block, int) {
    std::uint64_t bits = 0;
    for (std::size_t i = block * kBlock; i < std::min(cloud.size, (block + 1) * kBlock); ++i) {
      Lattice lattice{};
      const bool inside = toLattice(cloud.position(i), per_metre, first_, lattice);
      const std::uint64_t code = inside ? mortonCode(lattice) : nowhere;
      if (inside) bits |= code;
      scratch_[i] = {code, static_cast<std::uint32_t>(i)};
    }
    used[block] = bits;
  });
  std::uint64_t bits = 0;
  for (const std::uint64_t of_block : used) bits |= of_block;

  // Into buckets by their highest bits, which are then sorted each by itself.
  constexpr int bucket_bits = 11;
  constexpr std::size_t buckets = (std::size_t{1} << bucket_bits) + 1;  // the last: nowhere
  const int shift = std::max(0, bitLength(bits) - bucket_bits);
  const auto bucket_of = [&](std::uint64_t code) {
    return code == nowhere ? buckets - 1 : static_cast<std::size_t>(code >> shift);
  };
  counts_.assign(blocks * buckets, 0);
  host::parallelFor(threads, blocks, [&](std::size_t block, int) {
    std::size_t* const count = &counts_[block * buckets];
    for (std::size_t i = block * kBlock; i < std::min(cloud.size, (block + 1) * kBlock); ++i)
      ++count[bucket_of(scratch_[i].code)];
  });
  std::vector<std::size_t> begin(buckets + 1);
  std::size_t sum = 0;
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    begin[bucket] = sum;
    for (std::size_t block = 0; block < blocks; ++block) {
      std::size_t& count = counts_[block * buckets + bucket];
      const std::size_t before = sum;
      sum += count;
      count = before;
    }
  }
  begin[buckets] = sum;
  host::parallelFor(threads, blocks, [&](std::size_t block, int) {
    std::size_t* const next = &counts_[block * buckets];
    for (std::size_t i = block * kBlock; i < std::min(cloud.size, (block + 1) * kBlock); ++i)
      entries_[next[bucket_of(scratch_[i].code)]++] = scratch_[i];
  });
  left_out_ = sum - begin[buckets - 1];
  host::parallelFor(threads, buckets - 1, [&](std::size_t bucket, int) {
    const std::size_t first = begin[bucket], count = begin[bucket + 1] - first;
    if (count > 1) {
      sortByDigits(&entries_[first], &scratch_[first], count, shift);
      orderEqual(cloud, &entries_[first], count);
    }
  });
  entries_.resize(sum - left_out_);
}

}  // namespace fuse_flow::stream
