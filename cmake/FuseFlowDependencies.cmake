# What the headers need, for the build and for those who find the package: PCL's common, filters, kdtree and search, with
# Eigen and FLANN behind them, and threads; OpenMP for Thrust on the CPU, where there is one.
include(CMakeFindDependencyMacro)
find_package(Threads QUIET)
find_package(OpenMP QUIET COMPONENTS CXX)

if(NOT TARGET FuseFlow::pcl)
  # PCL's own config finds VTK and a dozen others even for these four, and needs MPI::MPI_C for it.
  get_property(fuse_flow_languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  if("C" IN_LIST fuse_flow_languages)
    find_package(MPI QUIET COMPONENTS C)
  endif()
  if(CMAKE_FIND_PACKAGE_NAME)  # they said whether it is required; where it is missing, this file ends here
    find_dependency(PCL 1.12 COMPONENTS common filters kdtree search)
  else()
    find_package(PCL 1.12 REQUIRED COMPONENTS common filters kdtree search)
  endif()
  add_library(FuseFlow::pcl INTERFACE IMPORTED)
  target_include_directories(FuseFlow::pcl SYSTEM INTERFACE ${PCL_INCLUDE_DIRS})
  target_link_libraries(FuseFlow::pcl INTERFACE ${PCL_COMMON_LIBRARIES} ${PCL_FILTERS_LIBRARIES} ${PCL_KDTREE_LIBRARIES}
                                                ${PCL_SEARCH_LIBRARIES})
  separate_arguments(fuse_flow_pcl_definitions UNIX_COMMAND "${PCL_DEFINITIONS}")
  target_compile_options(FuseFlow::pcl INTERFACE ${PCL_COMPILE_OPTIONS} ${fuse_flow_pcl_definitions})
endif()

# Thrust on the CPU, for the GPU classes where the compiler is not nvcc, which brings its own.
if(NOT TARGET FuseFlow::thrust)
  find_path(FUSE_FLOW_THRUST_INCLUDE_DIR thrust/version.h
            PATHS /usr/local/cuda/include/cccl /usr/local/cuda/include DOC "The folder that has Thrust's headers")
  add_library(FuseFlow::thrust INTERFACE IMPORTED)
  if(FUSE_FLOW_THRUST_INCLUDE_DIR)
    target_include_directories(FuseFlow::thrust SYSTEM
                               INTERFACE $<$<COMPILE_LANGUAGE:CXX>:${FUSE_FLOW_THRUST_INCLUDE_DIR}>)
  endif()
endif()
