// Counts the calls of `new` in this thread. Library `test_counted_new`: it replaces operator new of
// every program that links it.
#pragma once

#include <cstddef>

namespace tims::test {

[[nodiscard]] std::size_t allocations();

}  // namespace tims::test
