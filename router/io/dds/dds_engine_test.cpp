#include "router/io/dds/dds_engine.h"

#include <gtest/gtest.h>
