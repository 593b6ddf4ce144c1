// Reports of the thread sanitizer to suppress: Debian's libraries are not instrumented, so the
// atomics of Fast DDS, OpenCV and its decoders are not recognised; the order of their locks is not
// checked here.
extern "C" const char* __tsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)

extern "C" const char* __tsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "race:libfastrtps.so\n"
         "mutex:libfastrtps.so\n"
         "deadlock:libfastrtps.so\n"
         "deadlock:libgdal.so\n"
         "race:libav\n"
         "race:libglib-2.0.so\n"
         "race:libgst\n"
         "race:libopencv_\n";
}
