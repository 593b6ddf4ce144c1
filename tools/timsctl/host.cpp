#include "tools/timsctl/host.h"

#include "tools/timsctl/failure.h"

namespace timsctl {

Host parse_host(std::string_view text) {
  auto host = tims::wire::parse_endpoint(text);
  if (!host) throw usage_error(host.error().detail());
  return std::move(*host);
}

}  // namespace timsctl
