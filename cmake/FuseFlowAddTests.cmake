include(GoogleTest)

# fuse_flow_add_tests(TARGET [ENVIRONMENT NAME=VALUE]): every test of a GoogleTest binary, in a process of its own. Under sanitizers
# processes take longer to start than most tests to run, so that there the binary is run in four parts.
function(fuse_flow_add_tests target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" ENVIRONMENT "")
  if(NOT FUSE_FLOW_SANITIZE)
    gtest_discover_tests(${target} DISCOVERY_TIMEOUT 120 PROPERTIES TIMEOUT 300 ENVIRONMENT "${arg_ENVIRONMENT}")
    return()
  endif()
  if(FUSE_FLOW_SANITIZE MATCHES "thread")
    set(filter "--gtest_filter=-CoarseAlignment.*")  # takes minutes; CoarseAlignmentThreads remains
  endif()
  foreach(part RANGE 3)
    add_test(NAME ${target}.part_${part} COMMAND ${target} --gtest_brief=1 ${filter})
    set_tests_properties(${target}.part_${part} PROPERTIES TIMEOUT 1200
                         ENVIRONMENT "GTEST_TOTAL_SHARDS=4;GTEST_SHARD_INDEX=${part};${arg_ENVIRONMENT}")
  endforeach()
endfunction()
