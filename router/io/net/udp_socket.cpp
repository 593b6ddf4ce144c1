#include "router/io/net/udp_socket.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <new>

#include <netinet/in.h>
#include <netinet/udp.h>
#include <sys/socket.h>

#include "os/socket.h"
#include "router/io/net/addresses.h"

namespace tims::io {
namespace {

using link::Burst;

constexpr std::align_val_t kPage{4096};

// UDP_GRO and SO_RXQ_OVFL, with room for control messages of later kernels.
struct alignas(cmsghdr) ReceiveControl {
  std::array<char, 4 * CMSG_SPACE(sizeof(int))> bytes;
};

bool set(int socket, int level, int option, int value) {
  return ::setsockopt(socket, level, option, &value, sizeof value) == 0;
}

std::uint32_t buffer_size(int socket, int option) {
  int bytes = 0;
  socklen_t size = sizeof bytes;
  ::getsockopt(socket, SOL_SOCKET, option, &bytes, &size);
  return static_cast<std::uint32_t>(bytes) / 2;
}

Error cannot_open(const config::Endpoint& where) {
  const Errc code = errno == EADDRINUSE ? Errc::kAddressInUse : Errc::kSystem;
  return {code, os::system_error("UDP " + where.to_string()).detail()};
}

constexpr std::size_t kPlainMax = 64;

std::size_t datagrams_in(const Burst& burst) { return std::max<std::size_t>(burst.count(), 1); }

iovec part_of(std::span<const std::byte> bytes) {
  return {const_cast<std::byte*>(bytes.data()), bytes.size()};  // only read
}

// The control data of a burst: its class, and the size of its segments.
class SendControl {
 public:
  // The family is the address's, not the socket's: an IPv6 socket sends IPv4 packets like an IPv4
  // socket. IPv4 takes one byte, which passes emulators of another byte order unharmed (qemu-user
  // copies it).
  void add_dscp(std::uint8_t dscp, bool v4) {
    if (dscp == 0) return;
    const auto field = static_cast<std::uint8_t>((dscp & 0x3F) << 2);
    v4 ? add(IPPROTO_IP, IP_TOS, field) : add(IPPROTO_IPV6, IPV6_TCLASS, int{field});
  }
  void add_segment_size(std::size_t size) {
    add(SOL_UDP, UDP_SEGMENT, static_cast<std::uint16_t>(size));
  }
  void put_into(msghdr& message) {
    message.msg_control = size_ > 0 ? bytes_.data() : nullptr;
    message.msg_controllen = size_;
  }

 private:
  template <typename T>
  void add(int level, int type, T value) {
    cmsghdr header{};
    header.cmsg_len = CMSG_LEN(sizeof value);
    header.cmsg_level = level;
    header.cmsg_type = type;
    std::memcpy(bytes_.data() + size_, &header, sizeof header);
    std::memcpy(bytes_.data() + size_ + CMSG_LEN(0), &value, sizeof value);
    size_ += CMSG_SPACE(sizeof value);
  }

  alignas(cmsghdr) std::array<char, 2 * CMSG_SPACE(sizeof(int))> bytes_{};
  std::size_t size_ = 0;
};

// One burst in the form of sendmsg(); `message` points into it.
struct Call {
  SystemAddress to{};
  SendControl control{};
  iovec part{};

  // Returns false when a socket of this family cannot send it.
  bool prepare(const Burst& burst, int family, bool segmented, msghdr& message) {
    const auto address = system_address(burst.to, family);
    if (!address) return false;
    to = *address;
    part = part_of(burst.bytes);
    control.add_dscp(burst.dscp, burst.to.is_v4());
    if (segmented) control.add_segment_size(burst.datagram_size);
    message = {};
    message.msg_name = to.get();
    message.msg_namelen = to.size;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    control.put_into(message);
    return true;
  }
};

bool is_loopback(const link::NetAddress& address) {
  if (address.is_v4()) return address.ip[12] == IN_LOOPBACKNET;
  link::NetAddress loopback{};
  loopback.ip[15] = 1;
  return address.ip == loopback.ip;
}

Sent meaning_of(int error) {
  switch (error) {
    case EAGAIN:
      return Sent::kWouldBlock;
    case EMSGSIZE:
      return Sent::kTooBig;
    case ENETUNREACH:
    case EHOSTUNREACH:
    case ECONNREFUSED:
    case EPERM:   // a firewall
    case EACCES:  // a route that prohibits
    case ENETDOWN:
    case ENODEV:
    case EADDRNOTAVAIL:
    case ENOBUFS:
    case ENOMEM:
      return Sent::kUnreachable;
    default:
      return Sent::kFailed;
  }
}

bool refuses_segments(int error) {
  return error == EIO || error == EINVAL || error == ENOPROTOOPT || error == EOPNOTSUPP;
}

}  // namespace

struct Datagrams::Calls {
  std::array<mmsghdr, kSlots> messages{};
  std::array<iovec, kSlots> parts{};
  std::array<SystemAddress, kSlots> senders{};
  std::array<ReceiveControl, kSlots> controls{};
};

Datagrams::Datagrams(std::size_t slot_bytes)
    : slot_bytes_(slot_bytes),
      pages_(static_cast<std::byte*>(::operator new(kSlots* slot_bytes, kPage))),
      calls_(std::make_unique<Calls>()),
      slots_(std::make_unique<Slot[]>(kSlots)) {}

Datagrams::~Datagrams() = default;

void Datagrams::Release::operator()(std::byte* pages) const { ::operator delete(pages, kPage); }

// The kernel overwrites the sizes in its arguments: those used by the last call are reset.
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
  const msghdr& control = message.msg_hdr;
  if (const auto size = os::control_value<int>(control, SOL_UDP, UDP_GRO); size && *size > 0)
    datagram_size = static_cast<std::size_t>(*size);
  if (const auto drops = os::control_value<std::uint32_t>(control, SOL_SOCKET, SO_RXQ_OVFL))
    outcome.dropped_by_kernel = drops;
  // Port 0 is not a valid sender, since no answer could be sent to it.
  if ((message.msg_hdr.msg_flags & (MSG_TRUNC | MSG_CTRUNC)) != 0 || !from) {
    ++outcome.truncated;
    return;
  }
  slots_[count_++] = {from, {pages_.get() + index * slot_bytes_, message.msg_len}, datagram_size};
}

UdpSocket::UdpSocket(os::File file, int family, const UdpOptions& options)
    : file_(std::move(file)), family_(family), options_(options) {}

Result<UdpSocket> UdpSocket::open(const config::Endpoint& where, const UdpOptions& options,
                                  os::SocketStore* store) {
  const auto address = numeric_address(where.host, where.port);
  if (!address) {
    return Error(Errc::kInvalidArgument,
                 "UDP " + where.to_string() + ": not a numeric address of this host");
  }
  SystemAddress to_bind = system_address(*address);
  const int family = to_bind.family();
  os::File file = store != nullptr ? store->take(SOCK_DGRAM, *to_bind.get()) : os::File();
  const bool is_bound = static_cast<bool>(file);
  if (!is_bound)
    file = os::File(::socket(family, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, IPPROTO_UDP));
  if (!file) return cannot_open(where);
  UdpSocket socket(std::move(file), family, options);
  socket.request_buffers();
  socket.set_options();
  if (!is_bound && !socket.bind(to_bind)) return cannot_open(where);
  if (!socket.read_local_address()) return cannot_open(where);
  if (store != nullptr) store->keep(socket.fd());
  return socket;
}

// Root may exceed net.core.rmem_max and wmem_max.
void UdpSocket::request_buffers() {
  const int bytes = static_cast<int>(options_.buffer_bytes);
  if (!set(fd(), SOL_SOCKET, SO_RCVBUFFORCE, bytes)) set(fd(), SOL_SOCKET, SO_RCVBUF, bytes);
  if (!set(fd(), SOL_SOCKET, SO_SNDBUFFORCE, bytes)) set(fd(), SOL_SOCKET, SO_SNDBUF, bytes);
  receive_buffer_bytes_ = buffer_size(fd(), SO_RCVBUF);
  send_buffer_bytes_ = buffer_size(fd(), SO_SNDBUF);
}

bool UdpSocket::can_reach(const link::NetAddress& to) const {
  const bool any = is_any(local_);
  if (family_ == AF_INET && !to.is_v4()) return false;
  if (!any && local_.is_v4() != to.is_v4()) return false;
  return any || !is_loopback(local_) || is_loopback(to);
}

// PROBE: does not fragment, and ignores ICMP messages about the path, which are easily forged:
// links measure the path themselves. Errors are not requested (IP_RECVERR) for the same reason.
void UdpSocket::set_options() {
  set(fd(), IPPROTO_IP, IP_MTU_DISCOVER, options_.fragments ? IP_PMTUDISC_DONT : IP_PMTUDISC_PROBE);
  if (family_ == AF_INET6) {
    set(fd(), IPPROTO_IPV6, IPV6_V6ONLY, 0);
    set(fd(), IPPROTO_IPV6, IPV6_MTU_DISCOVER,
        options_.fragments ? IPV6_PMTUDISC_DONT : IPV6_PMTUDISC_PROBE);
  }
  set(fd(), SOL_UDP, UDP_GRO, 1);
  set(fd(), SOL_SOCKET, SO_RXQ_OVFL, 1);
  // An older kernel would ignore the segment size and send the burst as one datagram.
  if (!set(fd(), SOL_UDP, UDP_SEGMENT, 0)) options_.segmentation = false;
}

bool UdpSocket::bind(SystemAddress& address) {
  const os::Bound bound = os::bind_even_early(fd(), address.get(), address.size);
  is_early_ = bound == os::Bound::kAddressNotHereYet;
  return bound != os::Bound::kNo;
}

bool UdpSocket::read_local_address() {
  SystemAddress address;
  if (::getsockname(fd(), address.get(), &address.size) != 0) return false;
  local_ = address.net_address();
  return true;
}

bool UdpSocket::receive(Datagrams& into) {
  const Datagrams::Outcome outcome = into.receive(fd());
  counters_.truncated += outcome.truncated;
  if (const auto drops = outcome.dropped_by_kernel) {
    counters_.dropped_by_kernel += *drops - kernel_drops_;  // the kernel's counter wraps around
    kernel_drops_ = *drops;
  }
  return outcome.messages > 0;
}

// --- sending

Sent UdpSocket::send(const Burst& burst) {
  if (datagrams_in(burst) == 1) return send_segmented(burst);
  return is_plain(burst.to) ? send_plain(burst) : send_segmented(burst);
}

// Also for a single datagram, which needs no segmentation.
Sent UdpSocket::send_segmented(const Burst& burst) {
  const bool cut = datagrams_in(burst) > 1;
  Call call;
  msghdr message;
  if (!call.prepare(burst, family_, cut, message)) return Sent::kUnreachable;
  if (::sendmsg(fd(), &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return Sent::kAll;
  const bool needs_fragments = options_.fragments && errno == EMSGSIZE;
  if (!cut || !(refuses_segments(errno) || needs_fragments)) return meaning_of(errno);
  // Kernels before 6.13 report datagrams too large for the interface as invalid: the segmentation
  // was the cause only if sending one by one succeeds.
  const Sent sent = send_plain(burst);
  if (sent == Sent::kAll) remember_plain(burst.to);
  return sent;
}

// Sends one by one, in one call. When the buffer becomes full, the rest is lost, because what was
// sent must not be sent twice.
Sent UdpSocket::send_plain(const Burst& burst) {
  Call call;
  msghdr message;
  if (!call.prepare(burst, family_, false, message)) return Sent::kUnreachable;
  std::array<mmsghdr, link::kBurstDatagramsMax> messages;
  std::array<iovec, link::kBurstDatagramsMax> parts;
  const std::size_t count = datagrams_in(burst);
  if (count > messages.size()) return Sent::kFailed;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = i * burst.datagram_size;
    const std::size_t size = std::min(burst.datagram_size, burst.bytes.size() - at);
    parts[i] = part_of(burst.bytes.subspan(at, size));
    messages[i] = {.msg_hdr = message, .msg_len = 0};
    messages[i].msg_hdr.msg_iov = &parts[i];
  }
  const auto length = static_cast<unsigned>(count);
  const int n = ::sendmmsg(fd(), messages.data(), length, MSG_DONTWAIT | MSG_NOSIGNAL);
  if (n <= 0) return meaning_of(errno);
  counters_.cut_short += count - static_cast<std::size_t>(n);
  return Sent::kAll;
}

bool UdpSocket::is_plain(const link::NetAddress& to) const {
  return !options_.segmentation || std::ranges::find(plain_, to) != plain_.end();
}

void UdpSocket::remember_plain(const link::NetAddress& to) {
  if (plain_.size() < kPlainMax) {
    plain_.push_back(to);
  } else {
    plain_[plain_next_++ % kPlainMax] = to;
  }
}

}  // namespace tims::io
