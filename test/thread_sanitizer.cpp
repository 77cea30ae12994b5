// What the thread sanitizer must not report: nothing of ours. Compiled in, because the binary is also run where no
// environment is set, to list its tests.

extern "C" const char* __tsan_default_suppressions();

extern "C" const char* __tsan_default_suppressions() {
  // A driver that PCL's io library loads. It unlocks a mutex of its own that it has destroyed, before main().
  return "mutex:libOpenNI2.so\n";
}
