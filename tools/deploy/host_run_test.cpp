#include "tools/deploy/host_run.h"
