#pragma once

#include <cstddef>

namespace fuse_flow {
namespace distributed {

/** \brief What one rank did in the last frame; gather() adds what it sends. */
struct PartStatistics {
  std::size_t views{0};           ///< of its own
  std::size_t cells{0};           ///< coarse cells that it fused
  std::size_t points{0};          ///< measured points in them, its own and others'
  std::size_t foreign_points{0};  ///< of these, those of other ranks
  std::size_t bytes_sent{0};      ///< to all other ranks together
  std::size_t bytes_received{0};  ///< from all others
  std::size_t messages{0};        ///< sent
  /** \brief What bytes_sent would be without a codec. */
  std::size_t bytes_plain{0};
  /** \brief Of bytes_plain, what cannot be left out: D^r, C and colour of the points that others fuse; fused points. */
  std::size_t bytes_of_points{0};
  double imbalance{1};    ///< points that the busiest rank fuses over the mean; the same at all ranks
  double summary_ms{0};   ///< depth, confidence and points of its own views, and until all ranks have told of theirs
  double exchange_ms{0};  ///< until what its cells look at has come
};

}  // namespace distributed
}  // namespace fuse_flow
