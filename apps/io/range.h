#pragma once

#include "recordings/range.h"  // its place until tests that name the former one have changed
