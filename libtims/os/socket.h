// Sockets: whole records between programs of one host, and TCP connections to routers elsewhere.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <sys/socket.h>
#include <sys/types.h>

#include "os/file.h"
#include "tims/result.h"
#include "tims/time.h"

namespace tims::os {

// --- Unix sockets of whole records (SEQPACKET), with file descriptors beside them

inline constexpr std::size_t kRecordFilesMax = 64;  // beside one record

// Connected to a listener at `path`. Paths are limited by the system to 107 bytes.
Result<File> connect_unix(const std::string& path);
// Two ends of one connection within this process.
struct RecordPair {
  File one;
  File other;
};
Result<RecordPair> make_record_pair();
// Listening. Takes the place of a socket nobody listens at any more; refuses a living one
// (kAddressInUse). `mode`: who may connect. Makes the parent folder when it is missing; refuses one
// that somebody else has made where everybody may, as in /tmp: he could put his own socket there.
Result<File> listen_unix(const std::string& path, mode_t mode);
// Which file lies at a path, to know it again.
struct FileId {
  dev_t device = 0;
  ino_t inode = 0;  // 0: there is none
  bool operator==(const FileId&) const = default;
};
FileId file_at(const std::string& path);
// The next connection, non-blocking; nothing when none waits (kEmpty).
Result<File> accept_unix(const File& listener);

// kEmpty: the socket takes nothing at the moment. kClosed: the other side is gone.
Result<void> send_record(int socket, std::span<const std::byte> record,
                         std::span<const int> files = {}, bool wait = true);

struct Received {
  std::size_t size = 0;     // 0: the other side has closed
  bool truncated = false;   // longer than the buffer
  bool files_lost = false;  // descriptors came for which this process has no room
  std::vector<File> files;
};
// kEmpty: nothing there (never when `wait`).
Result<Received> receive_record(int socket, std::span<std::byte> buffer, bool wait);

struct PeerCredentials {
  pid_t pid = 0;
  uid_t uid = 0;
};
PeerCredentials peer_credentials(int socket);
// The other side has closed, whatever of it is still to be read.
bool has_hung_up(int socket);

// --- TCP

// Non-blocking, and given up by the system when the other side's machine has gone. Tries each
// address of the name in turn, until one answers, the deadline, or `cancel` (-1: nothing) is
// readable. The detail of the error: why not, without the host. Only the look-up of a name has no
// end but the system's.
Result<File> connect_tcp(const std::string& host, std::uint16_t port, Time deadline,
                         int cancel = -1);

// Binds also to an address that this host does not have yet: a router may be started before the
// interface is there.
enum class Bound { kNo, kYes, kAddressNotHereYet };  // kNo: errno says why
Bound bind_even_early(int socket, const sockaddr* address, socklen_t size);

}  // namespace tims::os
