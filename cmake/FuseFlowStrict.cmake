# fuse_flow_strict: the warnings and sanitizers of this project's own targets. They do not affect users of the headers.
add_library(fuse_flow_strict INTERFACE)
# PCL's macros for point types have the anonymous structs that clang calls pedantic; GoogleTest's take no last argument.
target_compile_options(
  fuse_flow_strict
  INTERFACE $<$<NOT:$<COMPILE_LANGUAGE:CUDA>>:-Wall$<SEMICOLON>-Wextra$<SEMICOLON>-Wpedantic$<SEMICOLON>-Wshadow>
            $<$<AND:$<NOT:$<COMPILE_LANGUAGE:CUDA>>,$<BOOL:${FUSE_FLOW_WARNINGS_AS_ERRORS}>>:-Werror>
            $<$<COMPILE_LANG_AND_ID:CXX,Clang,AppleClang>:-Wno-gnu-anonymous-struct$<SEMICOLON>-Wno-nested-anon-types$<SEMICOLON>-Wno-gnu-zero-variadic-macro-arguments>)
# nvcc on Eigen: annotations on functions that are defaulted. Its own code is not pedantic.
target_compile_options(fuse_flow_strict INTERFACE
                       "$<$<COMPILE_LANG_AND_ID:CUDA,NVIDIA>:-Xcompiler=-Wall,-Wextra;-diag-suppress=20012,20015>"
                       "$<$<AND:$<COMPILE_LANG_AND_ID:CUDA,NVIDIA>,$<BOOL:${FUSE_FLOW_WARNINGS_AS_ERRORS}>>:-Werror=all-warnings>")

if(FUSE_FLOW_SANITIZE)
  # GCC sees uninitialised memory in its own std::regex when instrumented.
  target_compile_options(fuse_flow_strict INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  # OpenNI's headers bind references to what is not aligned (XnCppWrapper.h, line 762): not UBSan's check for that.
  set(fuse_flow_sanitizers -fsanitize=${FUSE_FLOW_SANITIZE} -fno-sanitize=alignment -fno-sanitize-recover=all
                           -fno-omit-frame-pointer)
  target_compile_options(fuse_flow_strict INTERFACE ${fuse_flow_sanitizers})
  target_link_options(fuse_flow_strict INTERFACE ${fuse_flow_sanitizers})
  if(FUSE_FLOW_FUZZ)  # libFuzzer looks at what each input reaches
    target_compile_options(fuse_flow_strict INTERFACE -fsanitize=fuzzer-no-link)
  endif()
  # What differs between the others is found without sanitizers.
  target_compile_definitions(fuse_flow_strict INTERFACE FUSE_FLOW_TEST_FEW_POINT_TYPES)
endif()
