#include "drawing/image_of.h"
