#pragma once

#include "recordings/file_io.h"  // its place until tests that name the former one have changed
