#include "tests/support/inbox.h"

#include <algorithm>
#include <utility>

namespace tims::test {
namespace {

MessageView recorded_message(const Inbox::Expected& expected) {
  return std::get<recorded::Message>(expected.line->event).view();
}

bool fits(const Inbox::Expected& expected, const Inbox::Arrival& arrival) {
  return is_equivalent(recorded_message(expected), arrival.message.view(),
                       expected.origin == kFromRouter);
}

}  // namespace

void Inbox::arrive(OwnedMessage message, int line) {
  Arrival arrival{std::move(message), line, ++arrivals_};
  const auto found =
      std::ranges::find_if(expected_, [&](const Waiting& w) { return fits(w.expected, arrival); });
  if (found == expected_.end()) {
    early_.push_back(std::move(arrival));
    return;
  }
  for (auto older = expected_.begin(); older != found; ++older) {
    if (older->expected.origin == found->expected.origin) older->overtaken = true;
  }
  const Waiting waiting = *found;
  expected_.erase(found);
  match(waiting.expected, std::move(arrival), !waiting.overtaken);
}

void Inbox::expect(const Expected& expected) {
  const auto found =
      std::ranges::find_if(early_, [&](const Arrival& a) { return fits(expected, a); });
  if (found == early_.end()) {
    expected_.push_back({expected});
    return;
  }
  for (Waiting& older : expected_) {
    if (older.expected.origin == expected.origin) older.overtaken = true;
  }
  const bool in_order = found->number > last_matched_[expected.origin];
  Arrival arrival = std::move(*found);
  early_.erase(found);
  match(expected, std::move(arrival), in_order);
}

void Inbox::match(const Expected& expected, Arrival arrival, bool in_order) {
  std::uint64_t& last = last_matched_[expected.origin];
  last = std::max(last, arrival.number);
  if (in_order) {
    ++matched_;
  } else {
    findings_.push_back({expected, std::move(arrival), true});
  }
}

// A surplus message between the same mailboxes is reported together with the missing one: most
// likely it is the same message, changed.
void Inbox::give_up() {
  for (const auto& [expected, overtaken] : std::exchange(expected_, {})) {
    const Header& header = recorded_message(expected).header;
    const auto similar = std::ranges::find_if(early_, [&](const Arrival& a) {
      return a.message.header.dest == header.dest && a.message.header.src == header.src;
    });
    Finding finding{expected, std::nullopt};
    if (similar != early_.end()) {
      finding.got = std::move(*similar);
      early_.erase(similar);
    }
    findings_.push_back(std::move(finding));
  }
}

void Inbox::finish() {
  give_up();
  for (Arrival& surplus : early_) findings_.push_back({std::nullopt, std::move(surplus)});
  early_.clear();
}

std::vector<Inbox::Finding> Inbox::take_findings() { return std::exchange(findings_, {}); }

bool is_equivalent(const MessageView& recorded, const MessageView& got, bool by_router) {
  const int flags_that_count = by_router ? 0 : ~flag::kHeaderLittleEndian;
  const Header& a = recorded.header;
  const Header& b = got.header;
  return ((a.flags ^ b.flags) & flags_that_count) == 0 && a.type == b.type &&
         a.priority == b.priority && a.seq_nr == b.seq_nr && a.dest == b.dest && a.src == b.src &&
         a.length == b.length && std::ranges::equal(recorded.body, got.body);
}

}  // namespace tims::test
