# What FuseFlow::stream needs beside FuseFlowDependencies.cmake, for the build and for those who find the package.
include(${CMAKE_CURRENT_LIST_DIR}/FuseFlowOptional.cmake)
find_package(OpenSSL QUIET)
find_package(ZLIB QUIET)
find_package(JPEG QUIET)
fuse_flow_optional(zstd libzstd)
