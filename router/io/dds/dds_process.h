// DDS in a process of its own, with the interface of DdsEngine: the parser of the library, which
// reads what anybody on the network sends, has neither the router's memory nor its keys and rights
// (confinement.h). What it sees are sealed datagrams when the links have keys.
//
// The helper is started by the router and ends with it. When it ends by itself, all routers it knew
// have gone, so their links change to another path at once, and it is started again.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "os/file.h"
#include "os/process.h"
#include "router/io/dds/announced_routers.h"
#include "router/io/dds/dds_engine.h"
#include "router/io/dds/helper_protocol.h"
#include "router/io/log.h"
#include "router/io/loop.h"

namespace tims::io {

class DdsProcess {
 public:
  using State = DdsEngine::State;
  using Counters = DdsEngine::Counters;
  using Listener = DdsEngine::Listener;

  // Its only argument is the descriptor of its socket.
  static constexpr const char* kProgram = "tims-router-dds";
  // Between two starts, doubled up to the second value while it ends soon.
  static constexpr Duration kPause = std::chrono::milliseconds(500);
  static constexpr Duration kPauseMax = std::chrono::seconds(30);

  DdsProcess(Loop& loop, Log& log, DdsSettings settings, Listener& listener);
  DdsProcess(const DdsProcess&) = delete;
  DdsProcess& operator=(const DdsProcess&) = delete;
  ~DdsProcess();

  // As those of DdsEngine. start() waits until the helper has read its settings, 10 s at most. A
  // helper that is not installed is no error: it is looked for again every kPauseMax.
  Result<void> start(const link::Announcement& self);
  void restart(const link::Announcement& self);
  void stop();
  void connect(const link::NetAddress& to) { tell(helper::Connect{to}); }
  // A burst for which there is no room now is not accepted.
  bool send(const link::Burst& burst);

  [[nodiscard]] State state() const { return report_.state; }
  [[nodiscard]] link::NetAddress address() const { return report_.address; }
  [[nodiscard]] const std::vector<link::NetAddress>& host() const { return report_.host; }
  [[nodiscard]] const std::string& last_error() const { return report_.last_error; }
  [[nodiscard]] Counters counters() const;

 private:
  Result<void> launch();
  bool launch_or_retry();
  Result<void> wait_for_answer();
  void on_ready();
  void take(helper::Record&& record);
  // Returns false when there is no room for it.
  bool put(const helper::Record& record);
  // For records that must not be lost.
  void tell(const helper::Record& record);
  void on_end(const std::string& why);
  void end_process();
  void try_again();

  Loop& loop_;
  Log& log_;
  const DdsSettings settings_;
  Listener& listener_;
  link::Announcement self_{};
  std::optional<os::Process> process_;
  os::File socket_;
  std::optional<Watch> watch_;
  Timer retry_;
  Duration pause_ = kPause;
  Time launched_{};
  helper::Report report_{};
  AnnouncedRouters known_;
  std::uint64_t refused_ = 0;  // bursts' datagrams without room
  std::unique_ptr<std::array<std::byte, helper::kRecordMax>> in_;
  std::unique_ptr<std::array<std::byte, helper::kRecordMax>> out_;
};

}  // namespace tims::io
