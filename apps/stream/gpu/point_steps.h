#pragma once

#include "stream/codec/placement.h"
#include "stream/gpu/layer_grid.h"

#include <fuse_flow/gpu/runtime/system.h>
#include <fuse_flow/stream/cloud_view.h>

#include <cmath>
#include <cstdint>
#include <cstring>

/** \file
 *  \brief From a cloud to points in the order of their codes. */

namespace fuse_flow::stream {

/** \brief What is found out of a cloud before it is encoded. All zeros is that of no point. */
struct CloudExtent {
  std::uint32_t below[3];     ///< the complement of the least coordinate as ordered()
  std::uint32_t greatest[3];  ///< likewise
  std::uint32_t finite;       ///< points
  std::uint32_t mask[2];      ///< cameras of any point

  /** \brief Floats as integers of the same order; not NaN. */
  FUSE_FLOW_HD static std::uint32_t ordered(float value) {
    std::uint32_t bits;
    std::memcpy(&bits, &value, 4);
    return bits >> 31 ? ~bits : bits | 0x80000000u;
  }
  static float back(std::uint32_t word) {
    const std::uint32_t bits = word >> 31 ? word & 0x7fffffffu : ~word;
    float value;
    std::memcpy(&value, &bits, 4);
    return value;
  }
  float least(int axis) const { return back(~below[axis]); }
  float most(int axis) const { return back(greatest[axis]); }
};

/** \brief A team for some of the points. */
struct MeasureCloud {
  static constexpr std::uint32_t kPoints = 8 * kTeamThreads;
  using Shared = CloudExtent;

  CloudView cloud;
  bool cameras;
  CloudExtent* extent;

  FUSE_FLOW_CALLS_ANY
  template <typename Team>
  FUSE_FLOW_HD void operator()(const Team& team, std::uint32_t number, Shared& shared) const {
    team.once([&] { shared = {}; });
    team.forEach(kTeamThreads, [&](std::uint32_t thread) {
      CloudExtent own{};
      for (std::uint32_t k = 0; k < kPoints / kTeamThreads; ++k) {
        const std::uint32_t i = number * kPoints + k * kTeamThreads + thread;
        if (i >= cloud.size) break;
        if (cameras) {
          const auto* words = cloud.field<std::uint32_t>(cloud.camera_mask, i);
          own.mask[0] |= words[0];
          own.mask[1] |= words[1];
        }
        const float* p = cloud.position(i);
        if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) continue;
        ++own.finite;
        for (int axis = 0; axis < 3; ++axis) {
          const std::uint32_t value = CloudExtent::ordered(p[axis]);
          if (own.below[axis] < ~value) own.below[axis] = ~value;
          if (own.greatest[axis] < value) own.greatest[axis] = value;
        }
      }
      join(team, own, shared);
    });
    team.once([&] { join(team, shared, *extent); });
  }

 private:
  FUSE_FLOW_CALLS_ANY
  template <typename Team>
  FUSE_FLOW_HD static void join(const Team& team, const CloudExtent& from, CloudExtent& to) {
    for (int axis = 0; axis < 3; ++axis) {
      team.raise(&to.below[axis], from.below[axis]);
      team.raise(&to.greatest[axis], from.greatest[axis]);
    }
    team.add(&to.finite, from.finite);
    for (int word = 0; word < 2; ++word)
      if (from.mask[word] != 0) team.setBits(&to.mask[word], from.mask[word]);
  }
};

/** \brief The code of a point, and its number. */
struct CodePoint {
  CloudView cloud;
  double per_metre;
  Few<double, 3> first;   ///< the origin in steps
  std::uint64_t nowhere;  ///< above all codes
  std::uint64_t* codes;
  std::uint32_t* numbers;

  FUSE_FLOW_HD void operator()(std::uint32_t i) const {
    Lattice lattice{};
    codes[i] = toLattice(cloud.position(i), per_metre, first, lattice) ? mortonCode(lattice) : nowhere;
    numbers[i] = i;
  }
};

/** \brief What a point has beside its position, in a word: three bytes of colour, confidence, number of views, normal. */
struct PackedValues {
  std::uint64_t word;

  FUSE_FLOW_HD std::uint8_t byte(int k) const { return static_cast<std::uint8_t>(word >> (8 * k)); }
  FUSE_FLOW_HD void set(int k, std::uint8_t value) { word |= static_cast<std::uint64_t>(value) << (8 * k); }
};

/** \brief A point in the order of the codes; equal codes in that of the other fields, as SortedPoints has them. */
struct GatherPoint {
  /** \brief As many points may have the same code: each looks at all of them. */
  static constexpr std::uint32_t kMostAlike = 4096;

  CloudView cloud;
  std::uint32_t fields;
  int chroma_step;
  std::uint32_t points;
  const std::uint64_t* codes;
  const std::uint32_t* numbers;
  PackedValues* values;
  std::uint64_t* masks;
  std::uint32_t* too_many_alike;

  FUSE_FLOW_HD void operator()(std::uint32_t i) const {
    const std::uint32_t number = numbers[i], to = placeAmongAlike(i, number);
    if (fields == 0) return;
    PackedValues packed{0};
    if (fields & kColor) {
      const auto* bgr = cloud.field<std::uint8_t>(cloud.color, number);
      Triple color{{bgr[2], bgr[1], bgr[0]}};
      if (chroma_step > 0) color = toChroma(color, chroma_step);
      for (int k = 0; k < 3; ++k) packed.set(k, color[static_cast<std::size_t>(k)]);
    }
    if (fields & kConfidence) packed.set(3, confidenceByte(*cloud.field<float>(cloud.confidence, number)));
    if (fields & kViewCount) packed.set(4, viewCountByte(*cloud.field<std::uint32_t>(cloud.view_count, number)));
    if (fields & kNormal) {
      const Octahedral normal = toOctahedral(cloud.field<float>(cloud.normal, number));
      packed.set(5, normal[0]);
      packed.set(6, normal[1]);
    }
    values[to] = packed;
    if (fields & kCameras) {
      const auto* words = cloud.field<std::uint32_t>(cloud.camera_mask, number);
      masks[to] = words[0] | static_cast<std::uint64_t>(words[1]) << 32;
    }
  }

 private:
  FUSE_FLOW_HD std::uint32_t placeAmongAlike(std::uint32_t i, std::uint32_t number) const {
    const std::uint64_t code = codes[i];
    std::uint32_t begin = i, end = i + 1;
    while (begin > 0 && i - begin < kMostAlike && codes[begin - 1] == code) --begin;
    while (end < points && end - i < kMostAlike && codes[end] == code) ++end;
    if (end - begin == 1) return i;
    if (end - begin >= kMostAlike) {
      *too_many_alike = 1;
      return i;
    }
    std::uint32_t place = begin;
    for (std::uint32_t other = begin; other < end; ++other) {
      const int order = compare(numbers[other], number);
      if (order < 0 || (order == 0 && other < i)) ++place;
    }
    return place;
  }

  FUSE_FLOW_HD int compare(std::uint32_t a, std::uint32_t b) const {
    if (a == b) return 0;
    const int offsets[] = {cloud.color, cloud.confidence, cloud.view_count, cloud.normal, cloud.camera_mask};
    const std::uint32_t sizes[] = {3, 4, 4, 12, 8};
    for (int field = 0; field < 5; ++field) {
      if (offsets[field] < 0) continue;
      const auto *of_a = cloud.field<std::uint8_t>(offsets[field], a),
                 *of_b = cloud.field<std::uint8_t>(offsets[field], b);
      for (std::uint32_t k = 0; k < sizes[field]; ++k)
        if (of_a[k] != of_b[k]) return of_a[k] < of_b[k] ? -1 : 1;
    }
    return 0;
  }
};

/** \brief The box of a chunk: a team for a part of it. All zeros is the box of no point. */
struct ChunkBox {
  std::uint32_t below[3];  ///< the complement of the least coordinate, in steps
  std::uint32_t greatest[3];
};

struct MeasureChunk {
  static constexpr std::uint32_t kPoints = 16 * kTeamThreads;
  using Shared = ChunkBox;

  std::uint32_t points, chunk_points;
  const std::uint64_t* codes;
  ChunkBox* boxes;

  FUSE_FLOW_HD std::uint32_t teamsOfChunk() const { return (chunk_points + kPoints - 1) / kPoints; }

  FUSE_FLOW_CALLS_ANY
  template <typename Team>
  FUSE_FLOW_HD void operator()(const Team& team, std::uint32_t number, Shared& shared) const {
    const std::uint32_t chunk = number / teamsOfChunk(), part = number % teamsOfChunk() * kPoints;
    team.once([&] { shared = {}; });
    team.forEach(kTeamThreads, [&](std::uint32_t thread) {
      ChunkBox own{};
      for (std::uint32_t rank = part + thread; rank < chunk_points && rank < part + kPoints; rank += kTeamThreads) {
        const std::uint32_t i = chunk * chunk_points + rank;
        if (i >= points) break;
        const Lattice position = fromMortonCode(codes[i]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (own.below[axis] < ~position[axis]) own.below[axis] = ~position[axis];
          if (own.greatest[axis] < position[axis]) own.greatest[axis] = position[axis];
        }
      }
      join(team, own, shared);
    });
    team.once([&] { join(team, shared, boxes[chunk]); });
  }

 private:
  FUSE_FLOW_CALLS_ANY
  template <typename Team>
  FUSE_FLOW_HD static void join(const Team& team, const ChunkBox& from, ChunkBox& to) {
    for (int axis = 0; axis < 3; ++axis) {
      team.raise(&to.below[axis], from.below[axis]);
      team.raise(&to.greatest[axis], from.greatest[axis]);
    }
  }
};

}  // namespace fuse_flow::stream
