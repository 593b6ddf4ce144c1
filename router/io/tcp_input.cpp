// TcpPort, the part that reads.
#include "os/clock.h"
#include "router/io/tcp_port.h"

namespace tims::io {
namespace {

using core::CloseReason;
using core::Outcome;
using Status = wire::StreamReader::Status;

// Up to here, copying a message is cheaper than flushing all ports for it.
constexpr std::size_t kCopiedBytesMax = 4 << 10;

CloseReason reason_for(Status status) {
  return status == Status::kTooShort ? CloseReason::kTooShort : CloseReason::kTooLong;
}

}  // namespace

void TcpPort::on_ready(TcpConnection& connection, Ready ready) {
  const Time now = os::now();
  touch(connection);
  if (ready.to_write) write_more(connection);
  if (ready.to_read) read_some(now, connection);
  end_turn_(now);
}

void TcpPort::read_some(Time now, TcpConnection& connection) {
  const std::uint32_t token = connection.token;
  const core::ClientId id = connection.id;
  const TcpConnection::Read read = connection.read(scratch_->bytes);
  switch (read.status) {
    case TcpConnection::ReadStatus::kSome:
      take_messages(now, connection, read.chunk);
      bound_half_messages(now, token, id);
      break;
    case TcpConnection::ReadStatus::kNothing:
      break;
    case TcpConnection::ReadStatus::kClosed:
      on_end_of_input(now, connection, CloseReason::kPeerClosed);
      break;
    case TcpConnection::ReadStatus::kLost:
      on_end_of_input(now, connection, CloseReason::kConnectionLost);
      break;
  }
}

void TcpPort::take_messages(Time now, TcpConnection& connection, std::span<std::byte> chunk) {
  const std::uint32_t token = connection.token;
  const core::ClientId id = connection.id;
  for (;;) {
    const wire::StreamReader::Item item = connection.reader.next(chunk);
    if (item.status == Status::kNeedMore) return;
    if (item.status != Status::kMessage) return refuse_length(now, connection, item);
    take_message(now, connection, item);
    if (find(token, id) == nullptr || connection.closing) return;
    touch(connection);  // again: the ports may have been flushed meanwhile
  }
}

void TcpPort::bound_half_messages(Time now, std::uint32_t token, core::ClientId id) {
  const TcpConnection* connection = find(token, id);
  if (connection == nullptr || connection->closing) return;
  half_messages_.set(now, token, connection->reader.pending());
  while (const auto victim = half_messages_.victim()) {
    half_messages_.set(now, victim->token, 0);
    touch(*connections_[victim->token]);
    on_end_of_input(now, *connections_[victim->token], CloseReason::kStalled);
  }
}

// A message in the scratch buffer stays where it is until the flush; one that the reader has
// gathered does not outlive its next call.
void TcpPort::take_message(Time now, TcpConnection& connection,
                           const wire::StreamReader::Item& item) {
  const std::byte* begin = item.message.data();
  const bool in_scratch = begin >= scratch_->bytes && begin < scratch_->bytes + kScratchBytes;
  const bool copied = !in_scratch && item.message.size() <= kCopiedBytesMax;
  core::Message message{item.header, copied ? keep(item.message) : item.message};
  router_.on_message(now, connection.id, message);
  if (!in_scratch && !copied) end_turn_(now);
}

void TcpPort::refuse_length(Time now, TcpConnection& connection,
                            const wire::StreamReader::Item& item) {
  router_.on_lost(now, core::PortKind::kTcp, connection.id, Outcome::kBadLength,
                  item.header.priority, kHeaderSize);
  forget(now, connection, reason_for(item.status));
}

void TcpPort::on_end_of_input(Time now, TcpConnection& connection, CloseReason reason) {
  const std::size_t pending = connection.reader.pending();
  if (pending > 0) {
    router_.on_lost(now, core::PortKind::kTcp, connection.id, Outcome::kIncomplete, 0, pending);
  }
  forget(now, connection, reason);
}

}  // namespace tims::io
