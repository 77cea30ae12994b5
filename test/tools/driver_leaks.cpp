// What the leak sanitizer must not report of programs that open an OpenGL context: drivers are unloaded before it looks, so what they
// keep belongs to no module.

extern "C" const char* __lsan_default_suppressions();

extern "C" const char* __lsan_default_suppressions() { return "leak:<unknown module>\n"; }
