#include "router/link/bundle.h"

namespace tims::link {

bool Bundle::valid() const {
  std::size_t rest = bytes_.size();
  while (rest >= kBundleSizeBytes) {
    const std::size_t size = size_at(bytes_, bytes_.size() - rest);
    rest -= kBundleSizeBytes;
    if (size == 0 || size > rest) return false;
    rest -= size;
  }
  return rest == 0 && !bytes_.empty();
}

}  // namespace tims::link
