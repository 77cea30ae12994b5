#pragma once

#include "methods/method.h"

#include <fuse_flow/distributed/communicator.h>

#include <memory>
#include <string>

namespace fuse_flow::io {

/** \brief Ours, over several ranks, each with the views of some cameras; rank 0 gets the cloud, and what it weighed on the wire. On the CPU. */
class DistributedMethod : public Method {
 public:
  /** \brief What all ranks did since the beginning, a line; empty at all but rank 0. Every rank calls it, after the same frame. */
  virtual std::string summary() = 0;
};

/** \brief How a rank takes part. */
struct RankShare {
  bool fuses{true};        ///< takes a share of the cells; at least one rank must
  bool compresses{false};  ///< what it sends, by Zstandard; all ranks or none
};

/** \param communicator must outlive it  \throws InputError for what this was built without */
std::unique_ptr<DistributedMethod> makeDistributedFusion(distributed::Communicator& communicator,
                                                         const MethodOptions& options, const RankShare& share = {});

}  // namespace fuse_flow::io
