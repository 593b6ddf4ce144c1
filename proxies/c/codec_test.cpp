// The header is used by C++, too: without warnings about its casts. Those of the test are C's.
#include <rack_messages.h>

#pragma GCC diagnostic ignored "-Wold-style-cast"
#include "codec_test.c"  // NOLINT(bugprone-suspicious-include)
