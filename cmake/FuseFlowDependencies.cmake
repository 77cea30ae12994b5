# What the headers need, for the build and for those who find the package: PCL's common, filters, kdtree and search, with
# Eigen and FLANN behind them, and OpenMP where there is one.
find_package(OpenMP QUIET COMPONENTS CXX)

if(NOT TARGET FuseFlow::pcl)
  # PCL's own config finds VTK and a dozen others even for these four, and needs MPI::MPI_C for it.
  get_property(fuse_flow_languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  if("C" IN_LIST fuse_flow_languages)
    find_package(MPI QUIET COMPONENTS C)
  endif()
  find_package(PCL REQUIRED COMPONENTS common filters kdtree search)
  add_library(FuseFlow::pcl INTERFACE IMPORTED)
  target_include_directories(FuseFlow::pcl SYSTEM INTERFACE ${PCL_INCLUDE_DIRS})
  target_link_libraries(FuseFlow::pcl INTERFACE ${PCL_COMMON_LIBRARIES} ${PCL_FILTERS_LIBRARIES} ${PCL_KDTREE_LIBRARIES}
                                                ${PCL_SEARCH_LIBRARIES})
  separate_arguments(fuse_flow_pcl_definitions UNIX_COMMAND "${PCL_DEFINITIONS}")
  target_compile_options(FuseFlow::pcl INTERFACE ${PCL_COMPILE_OPTIONS} ${fuse_flow_pcl_definitions})
endif()
