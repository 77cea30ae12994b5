# cmake -Dtarget=… -Dbinary=… -Dfilter=… -Dsuites=… [-Demulator=…] -P FuseFlowListSuites.cmake: writes the file of CTest's that has the suites of a
# GoogleTest binary. Suites of one template, such as Filter/PointXYZ and Filter/PointXYZI, are one.
cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND ${emulator} ${binary} --gtest_list_tests "--gtest_filter=${filter}" OUTPUT_VARIABLE lines COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n[A-Za-z0-9_]+[./]" names "\n${lines}")  # not ^, which matches after each match, too
string(REGEX REPLACE "[\n./]" "" names "${names}")
list(REMOVE_DUPLICATES names)
set(command "")  # for another processor the program is run by the emulator
foreach(word ${emulator} ${binary})
  string(APPEND command " \"${word}\"")
endforeach()
set(tests "")
foreach(name ${names})
  string(APPEND tests "add_test(${target}.${name}${command} \"--gtest_filter=${name}.*:${name}/*\")\n"
         "set_tests_properties(${target}.${name} PROPERTIES TIMEOUT 1200 ENVIRONMENT OMP_WAIT_POLICY=passive)\n")
endforeach()
file(WRITE ${suites} "${tests}")
