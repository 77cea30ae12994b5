# What --version --verbose says of the build: facts/command_line/build_facts.h, of apps/command_line/build_facts.h.in. Included when all that
# the tools use has been looked for.
string(REGEX REPLACE "-f[a-z]+-prefix-map=[^ ]*" "" fuse_flow_flags "${CMAKE_CXX_FLAGS}")  # folders of who built it
string(REGEX REPLACE "[\"\\\\]" "" fuse_flow_flags "${fuse_flow_flags}")
string(REGEX REPLACE " +" " " fuse_flow_flags "${fuse_flow_flags}")
string(STRIP "${fuse_flow_flags}" fuse_flow_flags)

set(fuse_flow_libraries "")
foreach(fact VTK=VTK_VERSION Embree=embree_VERSION CLI11=CLI11_VERSION Boost=Boost_VERSION_STRING OpenSSL=OPENSSL_VERSION MPI=MPI_C_VERSION)
  string(REGEX MATCH "([^=]+)=(.+)" parts "${fact}")
  if(${CMAKE_MATCH_2})
    string(APPEND fuse_flow_libraries ", ${CMAKE_MATCH_1} ${${CMAKE_MATCH_2}}")
  endif()
endforeach()

set(fuse_flow_has_realsense2 FALSE)
if(TARGET realsense2::realsense2)
  set(fuse_flow_has_realsense2 TRUE)
endif()
set(fuse_flow_has_k4a FALSE)
if(TARGET k4a::k4a)
  set(fuse_flow_has_k4a TRUE)
endif()
set(fuse_flow_has_orbbec FALSE)
if(TARGET ob::OrbbecSDK)
  set(fuse_flow_has_orbbec TRUE)
endif()
set(fuse_flow_found "")
set(fuse_flow_not_found "")
foreach(fact libavformat=FUSE_FLOW_HAS_libav libavdevice=FUSE_FLOW_HAS_libavdevice bzip2=FUSE_FLOW_HAS_bzip2 "Fast CDR=FUSE_FLOW_HAS_fastcdr" SQLite=FUSE_FLOW_HAS_sqlite
             LZ4=FUSE_FLOW_HAS_lz4 Zstandard=FUSE_FLOW_HAS_zstd OpenEXR=FUSE_FLOW_HAS_openexr Draco=FUSE_FLOW_HAS_draco AprilTag=FUSE_FLOW_APRILTAG_LIBRARY
             OpenCV=FUSE_FLOW_HAS_opencv librealsense2=fuse_flow_has_realsense2 libk4a=fuse_flow_has_k4a
             OrbbecSDK=fuse_flow_has_orbbec MPI=FUSE_FLOW_HAS_MPI
             streams=FUSE_FLOW_HAS_stream "the page for browsers=FUSE_FLOW_PAGE" CUDA=FUSE_FLOW_HAS_CUDA)
  string(REGEX MATCH "([^=]+)=(.+)" parts "${fact}")
  if(${CMAKE_MATCH_2})
    list(APPEND fuse_flow_found "${CMAKE_MATCH_1}")
  else()
    list(APPEND fuse_flow_not_found "${CMAKE_MATCH_1}")
  endif()
endforeach()
foreach(list fuse_flow_found fuse_flow_not_found)
  list(JOIN ${list} ", " ${list})
  if(NOT ${list})
    set(${list} nothing)
  endif()
endforeach()
configure_file(${CMAKE_CURRENT_SOURCE_DIR}/command_line/build_facts.h.in ${CMAKE_CURRENT_BINARY_DIR}/facts/command_line/build_facts.h @ONLY)
