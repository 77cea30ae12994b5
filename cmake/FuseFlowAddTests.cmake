include(GoogleTest)

# fuse_flow_add_tests(TARGET [FILTER PATTERN]): the tests of a GoogleTest binary. It takes longer to start a
# process than to run most of them, under sanitizers most of all: so the binary is run in two parts, or where
# FUSE_FLOW_TESTS_IN_PARTS is off every test in a process of its own, under a name of its own. Threads sleep while they wait for others:
# those that spin take the processor from what CTest runs beside them, a sixth of it.
function(fuse_flow_add_tests target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "FILTER" "")
  if(NOT FUSE_FLOW_TESTS_IN_PARTS)
    gtest_discover_tests(${target} DISCOVERY_TIMEOUT 120 TEST_FILTER "${arg_FILTER}"
                         PROPERTIES TIMEOUT 300 ENVIRONMENT OMP_WAIT_POLICY=passive)
    return()
  endif()
  if(arg_FILTER)
    set(filter "--gtest_filter=${arg_FILTER}")
  elseif(FUSE_FLOW_SANITIZE MATCHES "thread" AND target STREQUAL "fuse_flow_tests")
    # What starts threads of its own, and for all that divides its work among helpers a test that it does.
    set(filter "--gtest_filter=*Thread*:Parallel*:TaskFlow*:FrameTasks*:ExtrinsicTracking.*:ViewSynchronizer*:FuseFlow*")
  endif()
  foreach(part RANGE 1)
    add_test(NAME ${target}.part_${part} COMMAND ${target} ${filter})
    set_tests_properties(${target}.part_${part} PROPERTIES TIMEOUT 1200
                         ENVIRONMENT "GTEST_TOTAL_SHARDS=2;GTEST_SHARD_INDEX=${part};OMP_WAIT_POLICY=passive")
  endforeach()
endfunction()
