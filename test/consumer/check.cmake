# cmake -Dmode=install|build_tree|add_subdirectory -Dsource=… -Dbinary=… -Dgenerator=… -P check.cmake
set(work ${binary}/consumer/${mode})
file(REMOVE_RECURSE ${work})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "failed with ${status}: ${ARGN}")
  endif()
endfunction()

if(mode STREQUAL "install")
  run(${CMAKE_COMMAND} --install ${binary} --prefix ${work}/prefix)
  set(how -DCMAKE_PREFIX_PATH=${work}/prefix)
elseif(mode STREQUAL "build_tree")
  set(how -DFuseFlow_DIR=${binary})
else()
  set(how -DFUSE_FLOW_SOURCE=${source})
endif()
run(${CMAKE_COMMAND} -S ${source}/test/consumer -B ${work}/build -G ${generator} -DCMAKE_BUILD_TYPE=Release
    -DCMAKE_CXX_COMPILER_LAUNCHER=${launcher} ${how})
if(mode STREQUAL "install")  # the other two differ from it in how they are found, not in what is compiled
  run(${CMAKE_COMMAND} --build ${work}/build)
  run(${work}/build/consumer)
endif()
