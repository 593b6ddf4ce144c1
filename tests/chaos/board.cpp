#include "tests/chaos/board.h"

namespace tims::chaos {

Result<SharedBoard> SharedBoard::at(const std::string& path) {
  auto memory = bench::map_shared_file(path, sizeof(Board));
  if (!memory) return memory.error();
  return SharedBoard(std::move(*memory));
}

}  // namespace tims::chaos
