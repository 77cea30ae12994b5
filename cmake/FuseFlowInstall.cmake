# The headers and what find_package(FuseFlow) and pkg-config read. Libraries and tools are installed where they are built.
install(DIRECTORY include/ impl/ gpu/ distributed/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp" PATTERN "*.cuh")
set(fuse_flow_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/FuseFlow)
install(TARGETS fuse_flow fuse_flow_gpu fuse_flow_distributed EXPORT FuseFlowTargets)
install(EXPORT FuseFlowTargets NAMESPACE FuseFlow:: DESTINATION ${fuse_flow_package_folder})
export(EXPORT FuseFlowTargets NAMESPACE FuseFlow:: FILE ${PROJECT_BINARY_DIR}/FuseFlowTargets.cmake)

include(CMakePackageConfigHelpers)
configure_package_config_file(cmake/FuseFlowConfig.cmake.in ${PROJECT_BINARY_DIR}/FuseFlowConfig.cmake
                              INSTALL_DESTINATION ${fuse_flow_package_folder} PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/FuseFlowConfigVersion.cmake COMPATIBILITY SameMinorVersion
                                 ARCH_INDEPENDENT)
install(FILES ${PROJECT_BINARY_DIR}/FuseFlowConfig.cmake ${PROJECT_BINARY_DIR}/FuseFlowConfigVersion.cmake
        DESTINATION ${fuse_flow_package_folder})
foreach(dependencies FuseFlowDependencies FuseFlowOptional FuseFlowRecordingsDependencies FuseFlowStreamDependencies)
  configure_file(cmake/${dependencies}.cmake ${PROJECT_BINARY_DIR}/${dependencies}.cmake COPYONLY)
  install(FILES cmake/${dependencies}.cmake DESTINATION ${fuse_flow_package_folder})
endforeach()
include(FuseFlowPkgConfig)

if(NOT FUSE_FLOW_BUILD_APPS)
  install(CODE "message(STATUS \"Without tools: FUSE_FLOW_BUILD_APPS is off\")")
endif()
