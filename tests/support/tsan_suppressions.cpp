// Reports of the thread sanitizer to suppress: Debian's Fast DDS is not instrumented, so its
// atomics are not recognised; the order of its locks is not checked here.
extern "C" const char* __tsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)

extern "C" const char* __tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "race:libfastrtps.so\n"
         "mutex:libfastrtps.so\n"
         "deadlock:libfastrtps.so\n";
}
