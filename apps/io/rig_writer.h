#pragma once

#include <fuse_flow/recordings/rig_writer.h>  // its place until tests that name the former one have changed
