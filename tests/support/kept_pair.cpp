#include "tests/support/kept_pair.h"

#include <chrono>
#include <thread>
#include <utility>

#include <fcntl.h>

#include "os/clock.h"
#include "os/shared_memory.h"
#include "router/link/handover.h"
#include "tests/support/patience.h"

namespace tims::test {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kVersionAt = 8;  // in what a router leaves (router/link/handover.h)
constexpr int kFirstFree = 200;        // descriptors: inherited by what is started

std::vector<std::string> settings_of(std::vector<std::string> settings, const std::string& link,
                                     const std::string& keys, const std::string& path) {
  settings.push_back("link=" + link + (path.empty() ? "" : ",paths=" + path));
  settings.push_back(keys.empty() ? "security.insecure=true" : keys);
  return settings;
}

}  // namespace

KeptPair::KeptPair(const TwoNetworks& networks, const Settings& settings)
    : networks_(networks),
      base_(base_folder_.path(),
            settings_of({"router.name=base", "router.role=top", "router.system=0", "router.id=1",
                         std::string("udp.listen=") + TwoNetworks::kLeft + ":2010"},
                        "kind=sub,system=*", settings.keys_base, settings.path)),
      robot_(
          robot_folder_.path(),
          settings_of({"router.name=robot", "router.role=system", "router.system=1", "router.id=1",
                       std::string("udp.listen=") + TwoNetworks::kRight + ":2010"},
                      std::string("kind=super,to=") + TwoNetworks::kLeft + ":2010",
                      settings.keys_robot, settings.path)) {}

Result<void> KeptPair::start() {
  for (KeptRouter* router : {&base_, &robot_})
    if (auto started = on(*router, [&] { return router->start(); }); !started) return started;
  return begin_traffic();
}

Result<void> KeptPair::begin_traffic() {
  const NumberedTraffic::End ladar{robot_.socket_path(), Address(0x01140000)};
  const NumberedTraffic::End pilot{robot_.socket_path(), Address(0x01150000)};
  const NumberedTraffic::End gui{base_.socket_path(), Address(0x00020000)};
  const NumberedTraffic::End joystick{base_.socket_path(), Address(0x00030000)};
  traffic_ = {};
  auto up = NumberedTraffic::begin(ladar, gui, 1ms);
  if (!up) return up.error();
  auto down = NumberedTraffic::begin(joystick, pilot, 1ms);
  if (!down) return down.error();
  traffic_ = {std::move(*up), std::move(*down)};
  return wait_for_more(1);
}

Result<void> KeptPair::restart(KeptRouter& router, int signal) {
  return on(router, [&] { return router.restart(signal); });
}

Result<void> KeptPair::restart_with_other_layout(KeptRouter& router) {
  const auto ended = router.keeper().end(router.process(), SIGUSR2);
  if (!ended) return ended.error();
  const auto left = router.keeper().kept().find("links");
  if (left == router.keeper().kept().end()) return Error(Errc::kSystem, "it has left nothing");
  auto bytes = os::read_memfd(left->second, link::Handover::kBytesMax);
  if (!bytes) return bytes.error();
  bytes->at(kVersionAt) = static_cast<std::byte>(link::Handover::kVersion + 1);
  const auto newer = os::make_memfd("links", *bytes);
  if (!newer) return newer.error();
  left->second = os::File(::fcntl(newer->get(), F_DUPFD, kFirstFree));
  return on(router, [&] { return router.start(); });
}

Result<void> KeptPair::wait_for_more(std::uint64_t count) {
  const Time deadline = os::deadline_after(kPatience);
  for (const auto& traffic : traffic_) {
    const std::uint64_t wanted = traffic->arrived() + count;
    while (traffic->arrived() < wanted) {
      if (os::now() >= deadline)
        return Error(Errc::kTimeout, "nothing arrives any more\n" + output());
      std::this_thread::sleep_for(1ms);
    }
  }
  return {};
}

void KeptPair::end(Duration patience) {
  for (const auto& traffic : traffic_) traffic->end(patience);
}

std::string KeptPair::output() const {
  return "base:\n" + base_.output() + "robot:\n" + robot_.output();
}

}  // namespace tims::test
