#include "router/link/list_exchange.h"

#include <algorithm>

namespace tims::link {

void ListExchange::set_own(Time now, FleetListBytes list) {
  own_ = std::move(list);
  std::erase_if(transfers_,
                [&](const Transfer& t) { return !t.checking && t.list.number <= own_.number; });
  for (auto& [slot, neighbour] : neighbours_)
    if (neighbour.offer.number <= own_.number) neighbour.until = kNever;
  plan(now);
}

void ListExchange::begin(Time now, std::uint32_t slot, bool above) {
  end(now, slot);
  neighbours_[slot].above = above;
  plan(now);
}

// What is being verified stays: it counts until the keeper is done with it.
void ListExchange::end(Time now, std::uint32_t slot) {
  if (neighbours_.erase(slot) == 0) return;
  std::erase_if(transfers_, [&](const Transfer& t) { return !t.checking && t.slot == slot; });
  plan(now);
}

bool ListExchange::on_control(Time now, std::uint32_t slot, const core::Message& message) {
  const auto from = neighbours_.find(slot);
  ListPlace place;
  std::span<const std::byte> rest;
  if (from == neighbours_.end() || !read_list_place(message.body(), place, rest)) return false;
  bool taken = true;
  switch (message.header.type) {
    case control::kList:
      taken = rest.empty() && on_offer(from->second, slot, place);
      break;
    case control::kListGet:
      taken = rest.empty();
      if (taken) on_get(now, slot, place);
      break;
    case control::kListPart:
      taken = on_part(now, slot, place, rest);
      break;
    default:
      taken = false;
  }
  plan(now);
  return taken;
}

bool ListExchange::on_offer(Neighbour& from, std::uint32_t slot, const ListPlace& offer) {
  if (offer.number == 0 || offer.offset == 0 || offer.offset > kBytesMax) return false;
  from.offer = offer;
  std::erase_if(transfers_, [&](const Transfer& t) {
    return !t.checking && t.slot == slot && t.list != offer;
  });
  return true;
}

// Who asks for another list has been told of this one meanwhile. Without room, it asks again.
void ListExchange::on_get(Time now, std::uint32_t slot, const ListPlace& place) {
  if (place.number != own_.number || own_.number == 0 || place.offset >= own_.bytes->size()) return;
  const auto rest = std::span(*own_.bytes).subspan(place.offset);
  const std::size_t size =
      std::min({carrier_.list_part_size(slot), rest.size(), std::size_t{kPartMax}});
  if (size > 0) send(now, slot, control::kListPart, place, rest.first(size));
}

bool ListExchange::on_part(Time now, std::uint32_t slot, const ListPlace& place,
                           std::span<const std::byte> bytes) {
  Transfer* transfer = receiving(slot);
  // Not asked for any more, or twice.
  if (transfer == nullptr ||
      place != ListPlace{transfer->list.number, static_cast<std::uint32_t>(transfer->bytes.size())})
    return true;
  const std::size_t missing = transfer->list.offset - transfer->bytes.size();
  if (bytes.size() > missing || bytes.size() < std::min(missing, kPartMin)) return false;
  transfer->bytes.insert(transfer->bytes.end(), bytes.begin(), bytes.end());
  transfer->moved = now;
  if (bytes.size() < missing) {
    ask(now, *transfer);
    return true;
  }
  transfer->checking = true;
  carrier_.check_list(transfer->id, transfer->list.number, slot, std::move(transfer->bytes));
  return true;
}

void ListExchange::on_checked(Time now, std::uint64_t transfer, bool is_good) {
  const auto found = std::ranges::find(transfers_, transfer, &Transfer::id);
  if (found == transfers_.end()) return;
  if (is_good) {
    good_ = std::max(good_, found->list.number);
    const auto from = neighbours_.find(found->slot);
    if (from != neighbours_.end()) from->second.until = kNever;
  } else {
    put_aside(now, found->slot);
  }
  transfers_.erase(found);
  plan(now);
}

void ListExchange::put_aside(Time now, std::uint32_t slot) {
  const auto from = neighbours_.find(slot);
  if (from == neighbours_.end()) return;
  from->second.aside_until = now + kTimeMax;
  from->second.until = kNever;
}

void ListExchange::on_timeout(Time now) {
  if (now < next_) return;
  std::erase_if(transfers_, [&](Transfer& transfer) {
    if (transfer.checking) return false;
    if (now >= transfer.moved + kSilenceMax || now >= neighbours_[transfer.slot].until) {
      put_aside(now, transfer.slot);
      return true;
    }
    if (now >= transfer.asked + kAskAgain) ask(now, transfer);
    return false;
  });
  plan(now);
}

// --- what happens next

void ListExchange::plan(Time now) {
  tell(now);
  begin_transfers(now);
  next_ = due();
  for (const auto& [slot, neighbour] : neighbours_) {
    if (neighbour.told != own_.number) next_ = std::min(next_, now + kAskAgain);
    if (neighbour.aside_until > now && neighbour.offer.number > std::max(own_.number, good_))
      next_ = std::min(next_, neighbour.aside_until);
  }
}

Time ListExchange::due() const {
  Time due = kNever;
  for (const Transfer& transfer : transfers_) {
    if (transfer.checking) continue;
    due = std::min({due, transfer.asked + kAskAgain, transfer.moved + kSilenceMax,
                    neighbours_.at(transfer.slot).until});
  }
  return due;
}

void ListExchange::tell(Time now) {
  if (own_.number == 0) return;
  for (auto& [slot, neighbour] : neighbours_) {
    if (neighbour.told == own_.number || carrier_.list_part_size(slot) == 0) continue;
    neighbour.told = own_.number;
    send(now, slot, control::kList, {own_.number, static_cast<std::uint32_t>(own_.bytes->size())});
  }
}

void ListExchange::begin_transfers(Time now) {
  while (auto* next = candidate(now)) {
    auto& [slot, neighbour] = *next;
    if (!make_room(neighbour)) return;
    if (neighbour.until == kNever) neighbour.until = now + kTimeMax;
    ask(now, transfers_.emplace_back(
                 Transfer{.id = ++last_, .slot = slot, .list = neighbour.offer, .moved = now}));
  }
}

// The link above first, then the newest list.
ListExchange::Neighbours::value_type* ListExchange::candidate(Time now) {
  Neighbours::value_type* best = nullptr;
  for (auto& one : neighbours_) {
    const Neighbour& its = one.second;
    const bool wanted =
        its.offer.number > std::max(own_.number, good_) && now >= its.aside_until &&
        std::ranges::find(transfers_, one.first, &Transfer::slot) == transfers_.end();
    if (!wanted) continue;
    const auto rank = [](const Neighbour& n) { return std::pair(n.above, n.offer.number); };
    if (best == nullptr || rank(best->second) < rank(its)) best = &one;
  }
  return best;
}

bool ListExchange::make_room(const Neighbour& neighbour) {
  if (transfers_.size() < kAtOnce) return true;
  const auto other = std::ranges::find_if(transfers_, [&](const Transfer& t) {
    return !t.checking && neighbour.above && !neighbours_.at(t.slot).above;
  });
  if (other == transfers_.end()) return false;
  neighbours_.at(other->slot).until = kNever;
  transfers_.erase(other);
  return true;
}

ListExchange::Transfer* ListExchange::receiving(std::uint32_t slot) {
  const auto found = std::ranges::find_if(
      transfers_, [&](const Transfer& t) { return !t.checking && t.slot == slot; });
  return found == transfers_.end() ? nullptr : &*found;
}

void ListExchange::ask(Time now, Transfer& transfer) {
  transfer.asked = now;
  send(now, transfer.slot, control::kListGet,
       {transfer.list.number, static_cast<std::uint32_t>(transfer.bytes.size())});
}

void ListExchange::send(Time now, std::uint32_t slot, std::int8_t type, const ListPlace& place,
                        std::span<const std::byte> bytes) {
  ControlMessage message(type);
  message.put(place);
  message.put(bytes);
  carrier_.send_list_message(now, slot, message);
}

}  // namespace tims::link
