// From two samples of counters to rates, client by client. Pure.
#pragma once

#include <cstdint>
#include <map>
#include <span>

#include "tims/time.h"
#include "tools/timsctl/json.h"

namespace timsctl {

class TopRates {
 public:
  // The clients of `clients`, each with in_per_s, out_per_s, in_bytes_per_s, out_bytes_per_s, and
  // taken_per_s: what it took from its mailboxes, also what came past the router. No rates for a
  // client that is new.
  json::array update(tims::Time now, std::span<const json::value> clients,
                     std::span<const json::value> mailboxes);

 private:
  struct Sample {
    double in = 0;
    double out = 0;
    double in_bytes = 0;
    double out_bytes = 0;
    double taken = 0;
  };
  tims::Time last_{};
  std::map<std::int64_t, Sample> samples_;  // by client
};

}  // namespace timsctl
