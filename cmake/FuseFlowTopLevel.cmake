# What only a build of this project by itself decides, and not one that takes it with add_subdirectory.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# ccache keeps nothing that uses a precompiled header unless it may overlook macros in one; by what the compiler says of its
# dependencies (CCACHE_DEPEND), and not by preprocessed text, which has no macros, it overlooks none. Paths that are relative to this
# folder (CCACHE_BASEDIR) let another clone, such as CI's, find what was compiled here.
find_program(FUSE_FLOW_CCACHE ccache)
if(FUSE_FLOW_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_SLOPPINESS=pch_defines,time_macros CCACHE_DEPEND=1
      ${FUSE_FLOW_CCACHE})
endif()
if(FUSE_FLOW_CCACHE AND NOT CMAKE_CUDA_COMPILER_LAUNCHER)
  set(CMAKE_CUDA_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} ${FUSE_FLOW_CCACHE})
endif()

# PCL and VTK name every library there is, and each takes time to load.
include(CheckLinkerFlag)
check_linker_flag(CXX -Wl,--as-needed FUSE_FLOW_LINKS_AS_NEEDED)
if(FUSE_FLOW_LINKS_AS_NEEDED)
  add_link_options($<$<LINK_LANGUAGE:CXX>:-Wl,--as-needed>)
endif()

# The site: the pages and the reference. Its links are checked.
find_program(FUSE_FLOW_DOXYGEN doxygen)
find_program(FUSE_FLOW_PYTHON_OF_SITE NAMES python3)
mark_as_advanced(FUSE_FLOW_PYTHON_OF_SITE)
if(FUSE_FLOW_DOXYGEN AND FUSE_FLOW_PYTHON_OF_SITE)
  add_custom_target(
    doc
    COMMAND ${CMAKE_COMMAND} -E make_directory build
    COMMAND ${CMAKE_COMMAND} -E rm -rf build/doc/html # what is gone must not be linked to
    COMMAND ${FUSE_FLOW_DOXYGEN} doc/Doxyfile
    COMMAND ${FUSE_FLOW_PYTHON_OF_SITE} doc/site/check_links.py
    COMMAND ${FUSE_FLOW_PYTHON_OF_SITE} doc/site/check_links.py build/doc/html
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    COMMENT "Writing build/doc/html/index.html"
    VERBATIM)
endif()
