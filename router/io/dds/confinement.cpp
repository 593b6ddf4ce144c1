#include "router/io/dds/confinement.h"

#include <array>
#include <cerrno>
#include <cstddef>
#include <system_error>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/audit.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "os/file.h"

namespace tims::io {
namespace {

#if defined(__x86_64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_X86_64;
#elif defined(__aarch64__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_AARCH64;
#elif defined(__ARM_EABI__)
constexpr std::uint32_t kArchitecture = AUDIT_ARCH_ARM;
#else  // s390x: its sockets are made by a call whose arguments are in memory, where no filter sees
       // them
constexpr std::uint32_t kArchitecture = 0;
#endif

// What the C library and Fast DDS open while they run. /proc is not among them: the memory and the
// environment of other processes of the user are there. Nor is all of /etc, where keys may be.
constexpr std::array kReadable{"/usr",
                               "/lib",
                               "/lib64",
                               "/sys/class/net",
                               "/sys/devices/system/cpu",
                               "/dev/urandom",
                               "/dev/null",
                               "/etc/ld.so.cache",
                               "/etc/hosts",
                               "/etc/host.conf",
                               "/etc/nsswitch.conf",
                               "/etc/resolv.conf",
                               "/etc/localtime"};

// Other programs and processes, the kernel's larger surfaces, and ways around the rules on files.
constexpr std::array<std::uint32_t, 27> kForbidden{SYS_execve,
                                                   SYS_execveat,
                                                   SYS_ptrace,
                                                   SYS_process_vm_readv,
                                                   SYS_process_vm_writev,
                                                   SYS_kill,
                                                   SYS_tkill,
                                                   SYS_pidfd_open,
                                                   SYS_pidfd_getfd,
                                                   SYS_pidfd_send_signal,
                                                   SYS_bpf,
                                                   SYS_mount,
                                                   SYS_umount2,
                                                   SYS_pivot_root,
                                                   SYS_chroot,
                                                   SYS_unshare,
                                                   SYS_setns,
                                                   SYS_keyctl,
                                                   SYS_add_key,
                                                   SYS_request_key,
                                                   SYS_io_uring_setup,
                                                   SYS_perf_event_open,
                                                   SYS_userfaultfd,
                                                   SYS_open_by_handle_at,
                                                   SYS_init_module,
                                                   SYS_finit_module,
                                                   SYS_kexec_load};

Error failed(const char* what) {
  return {Errc::kSystem, fmt::format("{}: {}", what, std::generic_category().message(errno))};
}

// BPF: loads the 32 bits at `offset` of the system call's description.
sock_filter load(std::size_t offset) {
  return BPF_STMT(BPF_LD | BPF_W | BPF_ABS, static_cast<std::uint32_t>(offset));
}
sock_filter jump_if(std::uint32_t equals, std::size_t then, std::size_t otherwise) {
  return BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, equals, static_cast<std::uint8_t>(then),
                  static_cast<std::uint8_t>(otherwise));
}
sock_filter answer(std::uint32_t what) { return BPF_STMT(BPF_RET | BPF_K, what); }

std::vector<sock_filter> filter() {
  constexpr std::uint32_t kDeny = SECCOMP_RET_ERRNO | EPERM;
  std::vector<sock_filter> program{
      load(offsetof(seccomp_data, arch)), jump_if(kArchitecture, 1, 0),
      answer(SECCOMP_RET_KILL_PROCESS), load(offsetof(seccomp_data, nr)),
      // The second set of numbers on x86-64 (x32).
      BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, 0x40000000, 0, 1), answer(kDeny)};
  for (const std::uint32_t call : kForbidden) {
    program.push_back(jump_if(call, 0, 1));
    program.push_back(answer(kDeny));
  }
  program.insert(program.end(), {jump_if(SYS_socket, 1, 0), answer(SECCOMP_RET_ALLOW),
                                 load(offsetof(seccomp_data, args)), jump_if(AF_INET, 3, 0),
                                 jump_if(AF_INET6, 2, 0), jump_if(AF_NETLINK, 1, 0), answer(kDeny),
                                 answer(SECCOMP_RET_ALLOW)});
  return program;
}

Result<void> restrict_calls() {
  if (kArchitecture == 0) return Error(Errc::kSystem, "seccomp: unknown architecture");
  std::vector<sock_filter> program = filter();
  const sock_fprog all{static_cast<unsigned short>(program.size()), program.data()};
  if (::prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &all) != 0) return failed("seccomp");
  return {};
}

void allow_reading(int rules, const char* path) {
  const os::File file(::open(path, O_PATH | O_CLOEXEC));
  if (!file) return;  // not on this host
  landlock_path_beneath_attr rule{};
  rule.parent_fd = file.get();
  rule.allowed_access = LANDLOCK_ACCESS_FS_READ_FILE;
  (void)::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
  rule.allowed_access |= LANDLOCK_ACCESS_FS_READ_DIR;  // fails for a file, which is no matter
  (void)::syscall(SYS_landlock_add_rule, rules, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
}

Result<void> restrict_files(std::span<const std::string> readable) {
  landlock_ruleset_attr all{};
  all.handled_access_fs = (LANDLOCK_ACCESS_FS_MAKE_SYM << 1U) - 1;  // of the first version, all
  const os::File rules(
      static_cast<int>(::syscall(SYS_landlock_create_ruleset, &all, sizeof(all), 0)));
  if (!rules) return failed("landlock");
  for (const char* path : kReadable) allow_reading(rules.get(), path);
  for (const std::string& path : readable) allow_reading(rules.get(), path.c_str());
  if (::syscall(SYS_landlock_restrict_self, rules.get(), 0) != 0) return failed("landlock");
  return {};
}

}  // namespace

Result<void> confine(std::span<const std::string> readable) {
  if (::prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return failed("no_new_privs");
  const rlimit none{};
  if (::setrlimit(RLIMIT_CORE, &none) != 0) return failed("setrlimit");
  const auto files = restrict_files(readable);
  const auto calls = restrict_calls();
  return files ? calls : files;
}

}  // namespace tims::io
