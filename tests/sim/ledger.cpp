#include "tests/sim/ledger.h"

#include <algorithm>

namespace tims::sim {
namespace {

// A cheap pseudo-random body, different for every message.
void fill(std::size_t number, std::span<std::byte> body) {
  std::uint64_t state = number * 0x9E3779B97F4A7C15U + 1;
  for (std::byte& b : body) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    b = static_cast<std::byte>(state >> 56);
  }
}

}  // namespace

std::string Ledger::describe(const Entry& e) {
  return "message type " + std::to_string(e.header.type) + " class " +
         std::to_string(e.message_class()) + (e.is_sample() ? " sample " : " ") + "seq " +
         std::to_string(e.header.seq_nr) + " " + e.header.src.to_string() + " -> " +
         e.header.dest.to_string() + " of " + std::to_string(e.header.length) + " bytes, sent at " +
         std::to_string(std::chrono::duration<double>(e.at.time_since_epoch()).count()) + " (" +
         std::string(core::name(e.outcome)) + ")";
}

std::size_t Ledger::add(const Entry& entry, std::size_t body_size, std::vector<std::byte>& body) {
  const std::size_t number = entries_.size();
  entries_.push_back(entry);
  Header& header = entries_.back().header;
  header.seq_nr = counts_[{header.src.raw(), header.dest.raw()}]++;
  header.length = static_cast<std::uint32_t>(kHeaderSize + body_size);
  numbers_[{header.src.raw(), header.dest.raw(), header.seq_nr}] = number;
  body.resize(body_size);
  fill(number, body);
  return number;
}

void Ledger::on_arrival(const Arrival& arrival) {
  const Header& header = arrival.header;
  if (header.type == type::kNotAvailable) {
    const auto found = numbers_.find({header.dest.raw(), header.src.raw(), header.seq_nr});
    if (found == numbers_.end()) return fail_("NOT_AVAILABLE for a message that was never sent");
    entries_[found->second].answered = true;
    return;
  }
  const auto found = numbers_.find({header.src.raw(), header.dest.raw(), header.seq_nr});
  if (found == numbers_.end()) return fail_("a message arrived that was never sent");
  Entry& entry = entries_[found->second];
  if (header.type != entry.header.type || header.priority != entry.header.priority ||
      header.length != entry.header.length)
    fail_("header altered: " + describe(entry));
  std::vector<std::byte> body(arrival.body.size());
  fill(found->second, body);
  if (arrival.body.size() + kHeaderSize != header.length || body != arrival.body)
    fail_("body altered: " + describe(entry));
  if (arrival.hops > 6) fail_("too many hops: " + describe(entry));
  if (std::exchange(entry.arrived, true)) fail_("arrived twice: " + describe(entry));
  check_order(found->second);
}

void Ledger::check_order(std::size_t number) {
  if (!keeps_order) return;
  const Entry& entry = entries_[number];
  const Flow flow{entry.header.src.raw(), entry.header.dest.raw(), entry.message_class(),
                  entry.is_sample()};
  const auto [newest, first] = newest_.try_emplace(flow, number);
  if (first) return;
  if (newest->second > number)
    fail_("out of order: " + describe(entry) + " after " + describe(entries_[newest->second]));
  newest->second = std::max(newest->second, number);
}

}  // namespace tims::sim
