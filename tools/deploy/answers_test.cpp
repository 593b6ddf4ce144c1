#include "tools/deploy/answers.h"
