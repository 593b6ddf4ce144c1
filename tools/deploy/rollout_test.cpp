#include "tools/deploy/rollout.h"
