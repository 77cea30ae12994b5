#pragma once

#include <fuse_flow/recordings/recording.h>  // its place until tests that name the former one have changed
