#pragma once

#include <fuse_flow/fusion/parameters.h>

#include <string>
#include <vector>

namespace fuse_flow::io {

/** \brief One line where depth that a program estimated from photographs is fused as if a camera had measured it; else nothing.
 *  \param kind of the recording, see Recording::kind()  \param method that fuses it, see makeMethod() */
std::vector<std::string> estimatedDepthAdvice(const std::string& kind, const std::string& method,
                                              const FuseFlowParameters& parameters);

}  // namespace fuse_flow::io
