// Sockets: whole records between programs of one host, and TCP connections to remote routers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <sys/socket.h>
#include <sys/types.h>

#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::os {

void set_option(int socket, int level, int option, int value);

// How TCP finds out that the other host has disappeared, without data to send: after `idle_s` of
// silence, `probes` questions, one every `probe_s`.
struct KeepAlive {
  int idle_s = 0;
  int probe_s = 0;
  int probes = 0;
};
void keep_alive(int socket, const KeepAlive& settings);

// --- Unix sockets that carry whole records (SEQPACKET) together with file descriptors

inline constexpr std::size_t kRecordFilesMax = 64;  // with one record

// Connects to a listener at `path`. The system limits paths to 107 bytes.
Result<File> connect_unix(const std::string& path);
// Two ends of one connection within this process.
struct RecordPair {
  File one;
  File other;
};
Result<RecordPair> make_record_pair();
// Starts listening. Replaces a stale socket that has no listener; refuses if a program listens
// there (kAddressInUse). `mode`: who may connect. Creates a missing parent directory. Refuses a
// directory that another user created in a world-writable place such as /tmp, because that user
// could replace the socket.
Result<File> listen_unix(const std::string& path, mode_t mode);
// Identifies the file at a path, to detect that it was replaced.
struct FileId {
  dev_t device = 0;
  ino_t inode = 0;  // 0: there is no file
  bool operator==(const FileId&) const = default;
};
FileId file_at(const std::string& path);
// Accepts the next connection, non-blocking; kEmpty when none waits.
Result<File> accept_unix(const File& listener);

// kEmpty: the socket accepts nothing at the moment. kClosed: the peer is gone.
Result<void> send_record(int socket, std::span<const std::byte> record,
                         std::span<const int> files = {}, bool wait = true);

struct Received {
  std::size_t size = 0;     // 0: the peer has closed
  bool truncated = false;   // longer than the buffer
  bool files_lost = false;  // descriptors arrived, but this process has no free descriptor for them
  std::vector<File> files;
};
// kEmpty: nothing has arrived (never when `wait`).
Result<Received> receive_record(int socket, std::span<std::byte> buffer, bool wait);

struct PeerCredentials {
  pid_t pid = 0;
  uid_t uid = 0;
};
PeerCredentials peer_credentials(int socket);
// Whether the peer has closed, even if data is still to be read.
bool has_hung_up(int socket);

// --- TCP

// Non-blocking, with keep-alive, so that the system ends the connection when the remote host is
// gone. Tries each address of the name in turn until one answers, the deadline passes, or `cancel`
// (-1: none) becomes readable. The error detail states the reason, without the host. The name
// look-up is limited only by the system's own timeout.
Result<File> connect_tcp(const std::string& host, std::uint16_t port, Time deadline,
                         int cancel = -1);

// Binds also to an address that this host does not have yet: a router may start before the
// interface exists.
enum class Bound { kNo, kYes, kAddressNotHereYet };  // kNo: errno states the reason
Bound bind_even_early(int socket, const sockaddr* address, socklen_t size);

// Bytes acknowledged by the other host since the connection began. When its receive buffer is full,
// this grows only as fast as the program there reads.
std::uint64_t bytes_acknowledged(int socket);

// --- Control messages that come with received bytes

template <typename T>
std::optional<T> control_value(const msghdr& message, int level, int type) {
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr;
       c = CMSG_NXTHDR(const_cast<msghdr*>(&message), c)) {
    if (c->cmsg_level != level || c->cmsg_type != type || c->cmsg_len < CMSG_LEN(sizeof(T)))
      continue;
    T value;
    std::memcpy(&value, CMSG_DATA(c), sizeof value);
    return value;
  }
  return std::nullopt;
}

}  // namespace tims::os
