// The header is used by C++, too.
#include "codec_test.c"  // NOLINT(bugprone-suspicious-include)
