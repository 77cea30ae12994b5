# fuse_flow_add_tests(TARGET [FILTER PATTERN]): the suites of a GoogleTest binary as CTest's tests, TARGET.SUITE. Not
# gtest_discover_tests(), which makes each of two thousand tests a process: with PCL's and VTK's libraries it takes longer to start one
# than to run most tests, under sanitizers most of all. The pattern chooses whole suites, as --gtest_filter does.
# Threads sleep while they wait for others: those that spin take the processor from what CTest runs beside them.
function(fuse_flow_add_tests target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "FILTER" "")
  if(NOT arg_FILTER)
    set(arg_FILTER *)
  endif()
  set(suites ${CMAKE_CURRENT_BINARY_DIR}/${target}_suites.cmake)
  add_custom_command(
    TARGET ${target} POST_BUILD
    BYPRODUCTS ${suites}
    COMMAND ${CMAKE_COMMAND} -Dtarget=${target} -Dbinary=$<TARGET_FILE:${target}> "-Dfilter=${arg_FILTER}" -Dsuites=${suites}
            "-Demulator=$<$<BOOL:${CMAKE_CROSSCOMPILING}>:${CMAKE_CROSSCOMPILING_EMULATOR}>" -P ${PROJECT_SOURCE_DIR}/cmake/FuseFlowListSuites.cmake
    VERBATIM)
  set(included ${CMAKE_CURRENT_BINARY_DIR}/${target}_tests.cmake)
  file(WRITE ${included} "if(EXISTS \"${suites}\")\n  include(\"${suites}\")\nelse()\n  add_test(${target}_NOT_BUILT ${target}_NOT_BUILT)\nendif()\n")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${included})
endfunction()
