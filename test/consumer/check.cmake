# cmake -Dmode=install|build_tree|add_subdirectory -Dsource=… -Dbinary=… -Dgenerator=… -Dc_compiler=… -Dcxx_compiler=…
#       -Dlauncher=… -P check.cmake
set(work ${binary}/consumer/${mode})
file(REMOVE_RECURSE ${work})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed with ${status}: ${ARGN}")
  endif()
endfunction()
function(configure from to)
  run(${CMAKE_COMMAND} -S ${from} -B ${to} -G ${generator} -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_COMPILER=${c_compiler}
      -DCMAKE_CXX_COMPILER=${cxx_compiler} -DCMAKE_CXX_COMPILER_LAUNCHER=${launcher}
      "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Wshadow -Werror" ${ARGN})
endfunction()

if(mode STREQUAL "install")
  set(prefix ${work}/prefix)
  run(${CMAKE_COMMAND} --install ${binary} --prefix ${prefix})
  run(${prefix}/bin/fuse_flow_fuse --help OUTPUT_QUIET)
  foreach(project test/consumer doc/examples)
    configure(${source}/${project} ${work}/${project} -DCMAKE_PREFIX_PATH=${prefix})
    run(${CMAKE_COMMAND} --build ${work}/${project})
  endforeach()
  run(${work}/test/consumer/consumer)
  run(${work}/doc/examples/fuse_frame)
  run(${work}/doc/examples/filters_in_a_pipeline)
elseif(mode STREQUAL "build_tree")  # differs in how it is found, not in what is compiled; so does the next
  configure(${source}/test/consumer ${work} -DFuseFlow_DIR=${binary})
else()
  configure(${source}/test/consumer ${work} -DFUSE_FLOW_SOURCE=${source})
endif()
