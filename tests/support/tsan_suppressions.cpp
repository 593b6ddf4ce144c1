// What the thread sanitizer is not to tell of: Fast DDS comes from Debian without instrumentation,
// so its atomics are not seen, and the order it takes its locks in is its own matter.
extern "C" const char* __tsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)

extern "C" const char* __tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "race:libfastrtps.so\n"
         "mutex:libfastrtps.so\n"
         "deadlock:libfastrtps.so\n";
}
