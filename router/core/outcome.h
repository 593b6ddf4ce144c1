// Everything that can happen to a message. Each message that enters the router gets exactly one of
// these when it comes; one that was taken and is lost later (queue_replaced, mailbox_replaced,
// client_gone, link_reset, expired) is counted once more under that reason.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "router/core/labels.h"

namespace tims::core {

enum class Outcome : std::uint8_t {
  kDelivered,
  kHandled,
  kNoRoute,
  kMailboxFull,
  kMailboxReplaced,
  kTooBig,
  kQueueFull,
  kQueueReplaced,
  kClientGone,
  kOwnerGone,
  kForgedSource,
  kBadLength,
  kIncomplete,
  kMalformedCommand,
  kUnknownCommand,
  kHopLimit,
  kWouldReturn,
  kLinkReset,
  kExpired,
  kUnread,
};

inline constexpr std::size_t kOutcomeCount = 20;
constexpr std::array kOutcomes{
    Label<Outcome>{Outcome::kDelivered, "delivered",
                   "handed to its receiver's mailbox, connection or queue"},
    Label<Outcome>{Outcome::kHandled, "handled", "meant for the router itself, and carried out"},
    Label<Outcome>{Outcome::kNoRoute, "no_route", "nobody has registered the destination"},
    Label<Outcome>{Outcome::kMailboxFull, "mailbox_full",
                   "the receiver's mailbox holds only more important messages"},
    Label<Outcome>{Outcome::kMailboxReplaced, "mailbox_replaced",
                   "the receiver did not take it in time, and a newer message took its place"},
    Label<Outcome>{Outcome::kTooBig, "too_big", "larger than a slot of the receiver's mailbox"},
    Label<Outcome>{Outcome::kQueueFull, "queue_full",
                   "the receiver reads too slowly, and what waits for it is more important"},
    Label<Outcome>{Outcome::kQueueReplaced, "queue_replaced",
                   "the receiver reads too slowly, and a newer message took its place"},
    Label<Outcome>{Outcome::kClientGone, "client_gone",
                   "the receiver went away before it had read it"},
    Label<Outcome>{Outcome::kOwnerGone, "owner_gone",
                   "the receiver has closed its mailbox, or has died"},
    Label<Outcome>{
        Outcome::kForgedSource, "forged_source",
        "the sender does not own the address the message says it comes from, or the link "
        "it came over is not for that system"},
    Label<Outcome>{Outcome::kBadLength, "bad_length",
                   "its header says less than 16 bytes, or more than message.max"},
    Label<Outcome>{Outcome::kIncomplete, "incomplete",
                   "the sender went away in the middle of it, or the link did not go on with it"},
    Label<Outcome>{Outcome::kMalformedCommand, "malformed_command",
                   "a command to the router that is too short"},
    Label<Outcome>{Outcome::kUnknownCommand, "unknown_command",
                   "a command to the router that it does not know"},
    Label<Outcome>{Outcome::kHopLimit, "hop_limit",
                   "it went through too many routers: they send it round in a loop"},
    Label<Outcome>{Outcome::kWouldReturn, "would_return",
                   "the only way on is the link it came from"},
    Label<Outcome>{Outcome::kLinkReset, "link_reset",
                   "it was on its way over a link whose other router was started anew or is gone"},
    Label<Outcome>{Outcome::kExpired, "expired",
                   "it could not be sent over the link within the link's lifetime for messages"},
    Label<Outcome>{Outcome::kUnread, "unread", "a text for people that nobody keeps or shows"},
};
static_assert(complete(kOutcomes, Outcome::kUnread) && kOutcomes.size() == kOutcomeCount);
std::string_view name(Outcome outcome);
std::string_view sentence(Outcome outcome);

// kMailboxReplaced as the answer of a port: this message was taken, an older one had to go for it.
// Texts may go unread: that is no loss.
constexpr bool taken(Outcome o) {
  return o == Outcome::kDelivered || o == Outcome::kHandled || o == Outcome::kMailboxReplaced ||
         o == Outcome::kUnread;
}

}  // namespace tims::core
