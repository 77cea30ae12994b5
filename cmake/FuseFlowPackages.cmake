# Debian packages, by `./build.sh deb`, or by cpack in a build folder that was configured with -DCMAKE_INSTALL_PREFIX=/usr: a component of
# the install is a package. Included last, when it is known what is built.
find_program(FUSE_FLOW_DPKG dpkg)
find_program(FUSE_FLOW_GZIP gzip)
find_package(Git QUIET)
mark_as_advanced(FUSE_FLOW_DPKG FUSE_FLOW_GZIP)
if(NOT FUSE_FLOW_DPKG OR NOT FUSE_FLOW_GZIP)
  return()
endif()

# A version before its release sorts below it, and says of which commit it is. One package is for one release of one distribution.
set(deb_version ${PROJECT_VERSION})
if(Git_FOUND)
  execute_process(COMMAND ${GIT_EXECUTABLE} describe --exact-match --match v${PROJECT_VERSION} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  RESULT_VARIABLE is_no_release OUTPUT_QUIET ERROR_QUIET)
  execute_process(COMMAND ${GIT_EXECUTABLE} log -1 --date=format:%Y%m%d --format=%cd.%h WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                  RESULT_VARIABLE has_no_commit OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  if(NOT is_no_release EQUAL 0 AND has_no_commit EQUAL 0)
    string(APPEND deb_version "~${commit}")
  endif()
endif()
set(distribution "")
if(EXISTS /etc/os-release)
  file(STRINGS /etc/os-release os_release REGEX "^(ID|VERSION_ID)=")
  list(SORT os_release)  # ID first
  string(REGEX REPLACE "[A-Z_]+=|[\"';]" "" distribution "~${os_release}")
endif()
set(deb_release 1${distribution})

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME fuse-flow)
set(CPACK_PACKAGE_VENDOR "FUSE-Flow contributors")
set(FUSE_FLOW_MAINTAINER "FUSE-Flow contributors <maintainers@fuse-flow.invalid>" CACHE STRING "Whom the packages name as their maintainer")
set(CPACK_PACKAGE_CONTACT "${FUSE_FLOW_MAINTAINER}")
set(CPACK_PACKAGE_VERSION ${deb_version})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${deb_release})
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL headers)

# Licences, in the form that Debian asks for.
function(fuse_flow_copyright variable files holders licence file)
  file(READ ${file} text)
  string(STRIP "${text}" text)
  string(REPLACE "\n" "\n " text "${text}")
  string(REGEX REPLACE "\n *\n" "\n .\n" text "${text}")
  set(${variable} "${${variable}}\nFiles: ${files}\nCopyright: ${holders}\nLicense: ${licence}\n ${text}\n" PARENT_SCOPE)
endfunction()
set(copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: FUSE-Flow\n")
fuse_flow_copyright(copyright * "2026, FUSE-Flow contributors" BSD-3-Clause ${PROJECT_SOURCE_DIR}/LICENSE)

# fuse_flow_deb(COMPONENT PACKAGE SECTION SUMMARY TEXT): a package's description, and its licence and changelogs, which only a package has.
function(fuse_flow_deb component package section summary text)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  set(folder ${PROJECT_BINARY_DIR}/deb_documents/${package})
  file(MAKE_DIRECTORY ${folder})
  file(WRITE ${folder}/copyright "${copyright}")
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # of SOURCE_DATE_EPOCH, where it is set
  file(WRITE ${folder}/changelog.Debian "fuse-flow (${deb_version}-${deb_release}) unstable; urgency=medium

  * Built by cpack; changelog.gz says what has changed.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  file(COPY_FILE ${PROJECT_SOURCE_DIR}/CHANGELOG.md ${folder}/changelog)
  execute_process(COMMAND ${FUSE_FLOW_GZIP} -9nf ${folder}/changelog.Debian ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${folder}/copyright ${folder}/changelog.Debian.gz ${folder}/changelog.gz DESTINATION share/doc/${package}
          COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()

set(what "FUSE-Flow fuses the depth images of several calibrated cameras into one\npoint cloud, frame by frame, by the confidence of each measurement.")
fuse_flow_deb(headers libfuse-flow-dev libdevel "fusion of many depth cameras (development files)"
              "${what}\n\nThis package has the headers (C++17, in the style of the Point Cloud Library),\nthe files for CMake and pkg-config, and, \
if they were built, static libraries\nthat read and write recordings and that stream clouds.")
install(FILES cmake/packaging/debian/lintian_overrides DESTINATION share/lintian/overrides RENAME libfuse-flow-dev COMPONENT headers
        EXCLUDE_FROM_ALL)
# Libraries hold inline code of the PCL that they were compiled with. With headers alone there is nothing of one architecture.
set(pcl_minor ${PCL_VERSION_MAJOR}.${PCL_VERSION_MINOR})
if(TARGET fuse_flow_compiled)
  math(EXPR next_minor "${PCL_VERSION_MINOR} + 1")
  set(pcl_range "libpcl-dev (>= ${pcl_minor}), libpcl-dev (<< ${PCL_VERSION_MAJOR}.${next_minor})")
  set(libraries libvtk9-dev libjpeg-dev libpng-dev libtiff-dev zlib1g-dev libyaml-cpp-dev libssl-dev)
  set(packages_of_libav libavformat-dev libavcodec-dev libavutil-dev libswscale-dev)
  set(packages_of_bzip2 libbz2-dev)
  set(packages_of_fastcdr libfastcdr-dev)
  set(packages_of_sqlite libsqlite3-dev)
  set(packages_of_lz4 liblz4-dev)
  set(packages_of_zstd libzstd-dev)
  set(packages_of_openexr libopenexr-dev)
  foreach(library libav bzip2 fastcdr sqlite lz4 zstd openexr)
    if(FUSE_FLOW_HAS_${library})
      list(APPEND libraries ${packages_of_${library}})
    endif()
  endforeach()
  list(JOIN libraries ", " libraries)
  set(CPACK_DEBIAN_HEADERS_PACKAGE_RECOMMENDS "cmake, pkg-config, ${libraries}")
else()
  set(pcl_range "libpcl-dev (>= 1.12)")
  set(CPACK_DEBIAN_HEADERS_PACKAGE_RECOMMENDS "cmake, pkg-config")
  if(NOT CMAKE_INSTALL_LIBDIR MATCHES "/")  # a folder of one architecture
    set(CPACK_DEBIAN_HEADERS_PACKAGE_ARCHITECTURE all)
  endif()
endif()
set(CPACK_DEBIAN_HEADERS_PACKAGE_DEPENDS "${pcl_range}, libeigen3-dev, libflann-dev")
set(CPACK_DEBIAN_HEADERS_PACKAGE_SUGGESTS "libopenmpi-dev, libthrust-dev")

if(FUSE_FLOW_PAGE)  # in the module, and in fuse_flow_serve
  fuse_flow_copyright(copyright "build/third_party/three/*" "2010-2025, three.js authors" Expat ${FUSE_FLOW_THREE}/LICENSE)
  fuse_flow_copyright(copyright "build/third_party/zstddec/*" "2020, Don McCurdy; 2016, Yann Collet, Facebook, Inc."
                      "Expat and BSD-3-Clause" ${FUSE_FLOW_ZSTDDEC}/LICENSE)
endif()
if(FUSE_FLOW_HAS_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  fuse_flow_deb(python python3-fuse-flow python "fusion of many depth cameras (Python 3)"
                "${what}\n\nThis package has the module fuse_flow for Python 3: images and clouds are\narrays of numpy.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  # The module's file is named after one version of Python.
  math(EXPR next_python "${FUSE_FLOW_PYTHON_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= 3.${FUSE_FLOW_PYTHON_MINOR}~), python3 (<< 3.${next_python}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
      "${PROJECT_SOURCE_DIR}/cmake/packaging/debian/postinst;${PROJECT_SOURCE_DIR}/cmake/packaging/debian/prerm")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
endif()

if(FUSE_FLOW_BUILD_APPS)
  list(APPEND CPACK_COMPONENTS_ALL tools)
  fuse_flow_deb(tools fuse-flow-tools science "fusion of many depth cameras (programs)"
                "${what}\n\nThis package has the programs: fuse recordings and cameras as they run,\ncalibrate, judge, simulate, look, and \
stream to browsers.")
  set(CPACK_DEBIAN_TOOLS_PACKAGE_SHLIBDEPS ON)
endif()
include(CPack)

# What the package of the module asks for is found elsewhere, and must have come here.
if(FUSE_FLOW_HAS_python AND FUSE_FLOW_BUILD_TESTS)
  add_test(NAME Packages.ThatOfTheModuleNamesItsPython
           COMMAND grep -E "python3 .>= 3[.][0-9]+~., python3 .<< 3[.][0-9]+., python3-numpy" CPackConfig.cmake)
  set_tests_properties(Packages.ThatOfTheModuleNamesItsPython PROPERTIES LABELS packaging WORKING_DIRECTORY ${PROJECT_BINARY_DIR})
endif()
