// Counts every `new` of a program, in this thread. Library `test_counted_new`: who links it has
// another operator new.
#pragma once

#include <cstddef>

namespace tims::test {

[[nodiscard]] std::size_t allocations();

}  // namespace tims::test
