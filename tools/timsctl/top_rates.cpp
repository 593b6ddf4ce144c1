#include "tools/timsctl/top_rates.h"

#include <algorithm>

namespace timsctl {

json::array TopRates::update(tims::Time now, std::span<const json::value> clients,
                             std::span<const json::value> mailboxes) {
  std::map<std::int64_t, double> taken;
  for (const json::value& value : mailboxes) {
    const json::object& mailbox = value.as_object();
    taken[static_cast<std::int64_t>(number_or_zero(mailbox, "owner.client"))] +=
        number_or_zero(mailbox, "received");
  }
  const double elapsed = std::chrono::duration<double>(now - last_).count();
  std::map<std::int64_t, Sample> samples;
  json::array items;
  for (const json::value& value : clients) {
    json::object item = value.as_object();
    const auto id = static_cast<std::int64_t>(number_or_zero(item, "id"));
    const Sample sample{.in = number_or_zero(item, "in_messages"),
                        .out = number_or_zero(item, "out_messages"),
                        .in_bytes = number_or_zero(item, "in_bytes"),
                        .out_bytes = number_or_zero(item, "out_bytes"),
                        .taken = taken[id]};
    samples[id] = sample;
    const auto before = samples_.find(id);
    if (before != samples_.end() && elapsed > 0) {
      // Counters of a mailbox go with it.
      const auto rate = [&](double Sample::*field) {
        return std::max(0.0, (sample.*field - before->second.*field) / elapsed);
      };
      item["in_per_s"] = rate(&Sample::in);
      item["out_per_s"] = rate(&Sample::out);
      item["in_bytes_per_s"] = rate(&Sample::in_bytes);
      item["out_bytes_per_s"] = rate(&Sample::out_bytes);
      item["taken_per_s"] = rate(&Sample::taken);
    }
    items.push_back(std::move(item));
  }
  samples_ = std::move(samples);
  last_ = now;
  return items;
}

}  // namespace timsctl
