#include "tools/timsctl/link_faults.h"

#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/measure.h"
#include "tools/cli/output.h"

namespace timsctl {

namespace base = tims::base;
namespace json = boost::json;

std::string injected_faults(const json::object& link) {
  if (text_at(link, "faults.blackout") == "true") return "nothing is sent";
  std::vector<std::string> parts;
  const auto add = [&](const char* field, const auto& text) {
    const double value = number_or_zero(link, fmt::format("faults.{}", field));
    if (value > 0) parts.push_back(text(value));
  };
  const auto share = [](const char* what) {
    return [what](double value) { return fmt::format("{:.3g}% {}", 100 * value, what); };
  };
  add("loss", share("lost"));
  add("duplicate", share("sent twice"));
  add("reorder", share("out of order"));
  add("delay_s", [](double value) { return base::human_duration(value) + " late"; });
  add("jitter_s", [](double value) { return "up to " + base::human_duration(value) + " later"; });
  add("rate", [](double value) { return "at most " + base::human_bytes(value) + "/s"; });
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace timsctl
