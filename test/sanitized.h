#pragma once

/** \file
 *  \brief FUSE_FLOW_TEST_SANITIZED is defined where the address or the thread sanitizer looks at the code, and not at what it finds:
 *  tests that only repeat themselves do less there. GCC and clang have different names for it. */

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FUSE_FLOW_TEST_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FUSE_FLOW_TEST_SANITIZED 1
#endif
#endif
