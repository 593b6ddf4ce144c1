#include "router/io/net/datagrams.h"

#include <array>
#include <cstring>
#include <new>

#include <netinet/udp.h>
#include <sys/socket.h>

#include "router/io/net/system_address.h"

namespace tims::io {
namespace {

constexpr std::align_val_t kPage{4096};

// UDP_GRO and SO_RXQ_OVFL, and room for what a later kernel may add.
struct alignas(cmsghdr) Control {
  std::array<char, 4 * CMSG_SPACE(sizeof(int))> bytes;
};

template <typename T>
std::optional<T> value_of(const cmsghdr& control, int level, int type) {
  if (control.cmsg_level != level || control.cmsg_type != type) return std::nullopt;
  if (control.cmsg_len < CMSG_LEN(sizeof(T))) return std::nullopt;
  T value;
  std::memcpy(&value, CMSG_DATA(&control), sizeof value);
  return value;
}

}  // namespace

struct Datagrams::Calls {
  std::array<mmsghdr, kSlots> messages{};
  std::array<iovec, kSlots> parts{};
  std::array<SystemAddress, kSlots> senders{};
  std::array<Control, kSlots> controls{};
};

Datagrams::Datagrams(std::size_t slot_bytes)
    : slot_bytes_(slot_bytes),
      pages_(static_cast<std::byte*>(::operator new(kSlots* slot_bytes, kPage))),
      calls_(std::make_unique<Calls>()),
      slots_(std::make_unique<Slot[]>(kSlots)) {}

Datagrams::~Datagrams() = default;

void Datagrams::Release::operator()(std::byte* pages) const { ::operator delete(pages, kPage); }

// The kernel writes the sizes it used into what it was given: what it has used is made anew.
void Datagrams::prepare() {
  for (std::size_t i = 0; i < used_; ++i) {
    calls_->parts[i] = {pages_.get() + i * slot_bytes_, slot_bytes_};
    calls_->messages[i] = {.msg_hdr = {.msg_name = calls_->senders[i].get(),
                                       .msg_namelen = sizeof(sockaddr_in6),
                                       .msg_iov = &calls_->parts[i],
                                       .msg_iovlen = 1,
                                       .msg_control = calls_->controls[i].bytes.data(),
                                       .msg_controllen = calls_->controls[i].bytes.size(),
                                       .msg_flags = 0},
                           .msg_len = 0};
  }
}

Datagrams::Outcome Datagrams::receive(int socket) {
  prepare();
  count_ = 0;
  Outcome outcome;
  used_ = 0;
  const int n = ::recvmmsg(socket, calls_->messages.data(), kSlots, MSG_DONTWAIT, nullptr);
  if (n <= 0) return outcome;
  outcome.messages = used_ = static_cast<std::size_t>(n);
  for (std::size_t i = 0; i < outcome.messages; ++i) take(i, outcome);
  return outcome;
}

void Datagrams::take(std::size_t index, Outcome& outcome) {
  const mmsghdr& message = calls_->messages[index];
  const link::NetAddress from = calls_->senders[index].net_address();
  std::size_t datagram_size = message.msg_len;
  for (cmsghdr* c = CMSG_FIRSTHDR(&message.msg_hdr); c != nullptr;
       c = CMSG_NXTHDR(const_cast<msghdr*>(&message.msg_hdr), c)) {
    if (const auto size = value_of<int>(*c, SOL_UDP, UDP_GRO); size && *size > 0)
      datagram_size = static_cast<std::size_t>(*size);
    if (const auto drops = value_of<std::uint32_t>(*c, SOL_SOCKET, SO_RXQ_OVFL))
      outcome.dropped_by_kernel = drops;
  }
  // Port 0 is nobody: no answer could go there.
  if ((message.msg_hdr.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0 || !from) {
    ++outcome.truncated;
    return;
  }
  slots_[count_++] = {from, {pages_.get() + index * slot_bytes_, message.msg_len}, datagram_size};
}

}  // namespace tims::io
