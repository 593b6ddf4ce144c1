#include "codec_test.c"  // the header is used by C++, too
