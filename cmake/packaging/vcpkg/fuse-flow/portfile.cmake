# An overlay port: it builds the repository that it lies in. vcpkg install fuse-flow --overlay-ports=cmake/packaging/vcpkg
get_filename_component(SOURCE_PATH "${CURRENT_PORT_DIR}/../../../.." ABSOLUTE)
vcpkg_check_features(OUT_FEATURE_OPTIONS features FEATURES recordings FUSE_FLOW_BUILD_RECORDINGS compiled FUSE_FLOW_BUILD_COMPILED)
vcpkg_cmake_configure(
  SOURCE_PATH "${SOURCE_PATH}"
  OPTIONS ${features}
          -DFUSE_FLOW_BUILD_APPS=OFF
          -DFUSE_FLOW_BUILD_TESTS=OFF
          -DFUSE_FLOW_BUILD_GPU_TESTS=OFF
          -DFUSE_FLOW_BUILD_BENCH=OFF
          -DFUSE_FLOW_PYTHON=OFF
          -DFUSE_FLOW_CUDA=OFF
          -DFUSE_FLOW_MPI=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME FuseFlow CONFIG_PATH lib/cmake/FuseFlow)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
if(NOT "recordings" IN_LIST FEATURES AND NOT "compiled" IN_LIST FEATURES)  # headers alone
  file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug")
endif()
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
