#pragma once

#include "methods/method.h"

#include <string>

namespace fuse_flow::io {

/** \brief How whyEmpty() calls a setting: as the viewer's sliders, or as the options of command lines. */
enum class SettingNames { Sliders, Options };

/** \brief Why a frame gave no point: "no point passes tau = 1", or "no point passes --tau 1". The setting is found by fusing again without it,
 *  once for each that can drop points. \param method as makeMethod() names it */
std::string whyEmpty(const std::string& method, const MethodOptions& options, const RigFrame& frame,
                     SettingNames names);

}  // namespace fuse_flow::io
