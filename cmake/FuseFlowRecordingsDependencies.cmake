# What FuseFlow::recordings needs beside FuseFlowDependencies.cmake, for the build and for those who find the package: PCL's io, with
# which clouds are saved, too, and what reads images and calibrations.
include(CMakeFindDependencyMacro)
if(CMAKE_FIND_PACKAGE_NAME)  # see FuseFlowDependencies.cmake
  find_dependency(VTK COMPONENTS CommonCore CommonDataModel IOImage)
  find_dependency(PNG)
  find_dependency(yaml-cpp)
  find_dependency(PCL 1.12 COMPONENTS common io)
else()
  find_package(MPI QUIET COMPONENTS C)
  find_package(VTK REQUIRED COMPONENTS CommonCore CommonDataModel IOImage)
  find_package(PNG REQUIRED)
  find_package(yaml-cpp REQUIRED)
  find_package(PCL 1.12 REQUIRED COMPONENTS common io)
endif()

if(NOT TARGET FuseFlow::pcl_io)
  add_library(FuseFlow::pcl_io INTERFACE IMPORTED)
  target_link_libraries(FuseFlow::pcl_io INTERFACE ${PCL_COMMON_LIBRARIES} ${PCL_IO_LIBRARIES})
endif()
if(NOT TARGET FuseFlow::yaml_cpp)
  add_library(FuseFlow::yaml_cpp INTERFACE IMPORTED)
  if(TARGET yaml-cpp::yaml-cpp)
    target_link_libraries(FuseFlow::yaml_cpp INTERFACE yaml-cpp::yaml-cpp)
  else()  # its name before version 0.8
    target_link_libraries(FuseFlow::yaml_cpp INTERFACE yaml-cpp)
  endif()
endif()
