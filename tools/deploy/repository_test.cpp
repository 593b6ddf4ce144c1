#include "tools/deploy/repository.h"
