// What the leak sanitizer must not report: nothing of ours. Compiled in, so that no environment needs to be set.

extern "C" const char* __lsan_default_options();
extern "C" const char* __lsan_default_suppressions();

extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }

extern "C" const char* __lsan_default_suppressions() {
  // libomp, clang's OpenMP, keeps what it knows of its threads; what leaks inside a parallel loop goes with it, which gcc's build
  // sees. VTK's JPEG reader jumps over its own clean-up when the data is damaged: it loses the image and the pointers to its rows.
  // OpenNI2's drivers keep what they looked for devices with.
  return "leak:libomp\nleak:libvtkIOImage\nleak:libPSLink\nleak:libPS1080\n";
}
