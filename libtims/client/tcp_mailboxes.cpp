#include "client/tcp_mailboxes.h"

#include <cstring>

#include "os/uplink.h"
#include "wire/header.h"

namespace tims::client {

Result<void> TcpMailboxes::offer(std::uint64_t segment, const os::File& memfd) {
  if (segments_.contains(segment)) return {};  // said twice
  auto mapping = os::Mapping::of(memfd);
  if (!mapping) return mapping.error();
  segments_[segment] = {.mapping = std::move(*mapping)};
  return {};
}

Result<void> TcpMailboxes::add(const wire::OpenEntry& entry, os::File waker,
                               const AddressWidths& widths) {
  if (mailboxes_.contains(entry.address))
    return Error(Errc::kAddressInUse, entry.address.to_string(widths) + " belongs to this session");
  const auto segment = segments_.find(entry.place.segment);
  if (segment == segments_.end()) return Error(Errc::kBadLayout, "no such segment");
  auto view = shm::MailboxView::open(segment->second.mapping.bytes(), entry.place.offset);
  if (!view) return view.error();
  ++segment->second.mailboxes;
  mailboxes_[entry.address] = {segment->first, std::make_unique<shm::Sender>(*view, kTcpWriter),
                               std::move(waker)};
  return {};
}

bool TcpMailboxes::remove(Address address) {
  const auto found = mailboxes_.find(address);
  if (found == mailboxes_.end()) return false;
  const auto segment = segments_.find(found->second.segment);
  mailboxes_.erase(found);
  if (--segment->second.mailboxes == 0) segments_.erase(segment);
  return true;
}

void TcpMailboxes::deliver(const Header& header, std::span<const std::byte> body) {
  const auto found = mailboxes_.find(header.dest);
  if (found == mailboxes_.end()) return;  // closed a moment ago
  shm::Sender& sender = *found->second.sender;
  shm::Claim claim;
  if (!shm::taken(sender.claim(header.length, header.priority, claim))) return;
  wire::encode_header(header, wire::HeaderBytes(claim.header, kHeaderSize));
  if (!body.empty()) std::memcpy(claim.body, body.data(), body.size());
  if (sender.commit(claim) == shm::SendOutcome::kOk)
    os::wake_owner(sender, {found->second.waker.get()});
}

}  // namespace tims::client
