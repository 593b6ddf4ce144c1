// The engine: the part on the loop (DdsEngine::Running) and its thread (DdsWorker). The loop
// writes and reads samples and keeps the list of routers; the thread performs the library's slow
// operations: creating and destroying entities.
#include "router/io/dds/dds_engine.h"

#include <algorithm>
#include <deque>
#include <map>
#include <thread>
#include <utility>

#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fmt/core.h>
#include <poll.h>

#include "os/clock.h"
#include "router/io/dds/participant.h"
#include "router/io/dds/writer.h"
#include "router/io/loop.h"
#include "router/io/net/addresses.h"
#include "router/link/transport.h"

namespace tims::io {
namespace {

using namespace std::chrono_literals;
using eprosima::fastrtps::types::ReturnCode_t;
using link::NetAddress;

constexpr std::size_t kSamplesATurn = 32;
constexpr Duration kDdsEngineTryAgain = 3s;
constexpr Duration kFinishLimit = 200ms;  // for the last messages
constexpr Duration kEndLimit = 3s;
constexpr Duration kSweep = 1s;  // interval of checks for routers whose lease has expired

NetAddress sender(const eprosima::fastdds::dds::SampleInfo& info) {
  link::DdsParticipant id{};
  const auto& prefix = info.sample_identity.writer_guid().guidPrefix;
  std::copy_n(prefix.value, id.size(), id.begin());
  return NetAddress::dds(id);
}

// The engine's thread: creates and destroys participants and their writers, which may take long.
class DdsWorker {
 public:
  DdsWorker(const DdsSettings& settings, const eprosima::fastdds::dds::DomainParticipantQos& qos,
            std::shared_ptr<DdsEvents> events, std::shared_ptr<DdsCommands> commands)
      : settings_(settings),
        qos_(qos),
        events_(std::move(events)),
        commands_(std::move(commands)) {}

  void run() {
    send_library_log_to(events_);
    for (DdsCommands::Wanted wanted = commands_->wait(); !wanted.end; wanted = commands_->wait()) {
      // The library throws exceptions. After one, the state stays until another generation is
      // wanted.
      try {
        carry_out(wanted);
      } catch (const std::exception& e) {
        events_->post_failure({generation_, e.what()});
      }
    }
    writers_.clear();
    participant_.reset();
  }
  // until shutdown is requested

 private:
  void carry_out(const DdsCommands::Wanted& wanted) {
    if (wanted.generation != generation_) make_participant(wanted);
    keep_writers(wanted);
  }

  void make_participant(const DdsCommands::Wanted& wanted) {
    writers_.clear();
    participant_.reset();
    generation_ = wanted.generation;
    std::vector<NetAddress> host = host_addresses();  // the library reads them next
    participant_ = std::make_unique<DdsParticipant>(settings_, qos_, wanted, events_);
    events_->post_up(
        {generation_, participant_->address(), std::move(host), participant_->reader()});
  }

  void keep_writers(const DdsCommands::Wanted& wanted) {
    std::erase_if(writers_, [&](const auto& writer) {
      return std::ranges::find(wanted.peers, writer.first) == wanted.peers.end();
    });
    if (!participant_) return;
    for (const auto& peer : wanted.peers) {
      if (writers_.contains(peer)) continue;
      const auto made = writers_.emplace(peer, participant_->make_writer(peer)).first;
      events_->post_writer({generation_, peer, made->second.get()});
    }
  }

  const DdsSettings settings_;
  const eprosima::fastdds::dds::DomainParticipantQos qos_;
  const std::shared_ptr<DdsEvents> events_;
  const std::shared_ptr<DdsCommands> commands_;
  std::uint64_t generation_ = 0;
  std::unique_ptr<DdsParticipant> participant_;
  // Must be destroyed before the participant.
  std::map<std::shared_ptr<DdsPeer>, std::unique_ptr<DdsWriter>> writers_;
};

}  // namespace

// The state between start() and stop().
class DdsEngine::Running {
 public:
  Running(DdsEngine& engine, const eprosima::fastdds::dds::DomainParticipantQos& qos,
          std::shared_ptr<DdsEvents> events)
      : engine_(engine),
        events_(std::move(events)),
        port_(user_traffic_port(qos, engine.settings_.domain)),
        retry_(engine.loop_, [this] { begin_again(); }),
        sweep_(engine.loop_, [this] { forget_the_silent(); }),
        serve_(engine.loop_, [this] { serve(); }) {
    events_watch_.emplace(engine.loop_, events_->fd(), [this](Ready) { take_events(); });
    thread_ =
        std::thread([settings = engine.settings_, qos, events = events_, commands = commands_] {
          DdsWorker(settings, qos, events, commands).run();
          commands->ended();
        });
  }

  ~Running() {
    guarded([this] { finish(); });
    leave();
    commands_->change([](DdsCommands::Wanted& wanted) { wanted.end = true; });
    if (commands_->wait_for_end(kEndLimit)) {
      thread_.join();
    } else {
      engine_.log_.error("dds: Fast DDS does not shut down; it is left running");
      thread_.detach();
    }
  }

  void begin(const link::Announcement& self) {
    leave();
    ++generation_;
    self_ = self;
    retry_.cancel();
    auto traffic = UserTraffic::open(engine_.settings_.interface, port_);
    if (!traffic) return fail(traffic.error().detail());
    traffic_ = *traffic;
    // A discovery server does not forward everything to every participant.
    const bool filtered = engine_.settings_.discovery_server.empty();
    metatraffic_ =
        filtered ? std::make_shared<Metatraffic>(self, generation_, events_, traffic_) : nullptr;
    commands_->change([&](DdsCommands::Wanted& wanted) {
      wanted.generation = generation_;
      wanted.self = self;
      wanted.traffic = traffic_;
      wanted.metatraffic = metatraffic_;
    });
  }

  [[nodiscard]] State state() const { return reader_ != nullptr ? State::kUp : State::kStarting; }
  [[nodiscard]] const NetAddress& address() const { return address_; }
  [[nodiscard]] const std::vector<NetAddress>& host() const { return host_; }

  DdsRoute* connect(const NetAddress& to) {
    const auto known = known_.find(to);
    if (known == known_.end()) return nullptr;
    std::unique_ptr<DdsRoute>& route = known->second.route;
    if (!route) {
      route = std::make_unique<DdsRoute>(to, engine_.settings_.heartbeat);
      routes_.push_back(route.get());
      order_peers();
    }
    return route.get();
  }

  bool send(const link::Burst& burst) {
    DdsRoute* const route = connect(burst.to);
    if (route != nullptr && route->put(burst)) {
      guarded([&] { serve_by(route->serve(os::now(), written_)); });
      return true;
    }
    counters_.refused += burst.count();
    return false;
  }

  [[nodiscard]] Counters counters() const {
    Counters all = counters_;
    all.samples_out = written_.samples;
    all.bytes_out = written_.bytes;
    all.datagrams_out = written_.datagrams;
    all.unmatched = written_.unmatched;
    for (const DdsRoute* route : routes_) all.waiting_bytes += route->waiting_bytes();
    return all;
  }

 private:
  struct Router {
    std::uint64_t generation = 0;       // in which it was last announced
    std::unique_ptr<DdsRoute> route{};  // set when we send to it
  };

  // Runs library calls, which may throw.
  template <typename Work>
  void guarded(Work work) {
    try {
      work();
    } catch (const std::exception& e) {
      fail(e.what());
    }
  }

  // Must be called before the thread destroys the library's entities.
  void leave() {
    socket_watch_.reset();
    reader_ = nullptr;
    address_ = {};
    host_.clear();
    for (DdsRoute* route : routes_) route->set_writer(nullptr);
  }

  // --- events of the threads

  void take_events() {
    DdsEvents::All events = events_->take();
    for (const DdsEvents::Line& line : events.lines) complain(line);
    for (auto& [id, router] : events.routers) on_router(NetAddress::dds(id), router);
    if (events.up && events.up->generation == generation_) on_up(std::move(*events.up));
    for (const DdsEvents::WriterReady& ready : events.writers) on_writer(ready);
    if (events.failure && events.failure->generation == generation_) fail(events.failure->text);
    take_samples();
    serve();
    engine_.listener_.on_turn_end();
  }

  void receive() {
    guarded([this] { hand_on_arrivals(); });
    take_events();
  }

  // Acknowledgements are among the arrivals.
  void hand_on_arrivals() {
    events_->without_notifying([this] {
      const Time now = os::now();
      for (const link::DdsParticipant& from : traffic_->receive()) {
        const auto known = known_.find(NetAddress::dds(from));
        if (known != known_.end() && known->second.route) known->second.route->on_received(now);
      }
    });
  }

  void complain(const DdsEvents::Line& line) {
    if (!line.error) return engine_.log_.debug("dds: " + line.text);
    engine_.log_.warning("dds: " + line.text);
    if (std::exchange(engine_.last_error_, line.text) != line.text) engine_.listener_.on_state();
  }

  void on_router(const NetAddress& address, const DdsEvents::Router& router) {
    if (router.generation != generation_) return;
    if (!router.announcement) {
      forget(address);
      return;
    }
    known_[address].generation = generation_;
    engine_.listener_.on_announced(*router.announcement);
  }

  void on_writer(const DdsEvents::WriterReady& ready) {
    const auto known = known_.find(ready.peer->address);
    if (ready.generation != generation_ || known == known_.end()) return;
    DdsRoute* const route = known->second.route.get();
    if (route != nullptr && route->peer() == ready.peer) route->set_writer(ready.writer);
  }

  void on_up(DdsEvents::Up&& up) {
    reader_ = up.reader;
    address_ = up.address;
    host_ = std::move(up.host);
    socket_watch_.emplace(engine_.loop_, traffic_->fd(), [this](Ready) { receive(); });
    engine_.last_error_.clear();
    // The departure of a router is not noticed while there is no participant.
    former_until_ = os::now() + engine_.settings_.lease + 1s;
    sweep_.set(os::now() + kSweep);
    engine_.listener_.on_state();
  }

  void fail(const std::string& text) {
    leave();
    engine_.last_error_ = text;
    engine_.log_.warning(
        fmt::format("dds: {}; tried again in {} s", text, kDdsEngineTryAgain / 1s));
    retry_.set(os::now() + kDdsEngineTryAgain);
    engine_.listener_.on_state();
  }

  void begin_again() { begin(link::Announcement(self_)); }

  // --- routers of the fleet

  void order_peers() {
    std::vector<std::shared_ptr<DdsPeer>> peers;
    peers.reserve(routes_.size());
    for (const DdsRoute* route : routes_) peers.push_back(route->peer());
    commands_->change([&](DdsCommands::Wanted& wanted) { wanted.peers = std::move(peers); });
  }

  void forget(const NetAddress& address) {
    const auto known = known_.extract(address);
    if (!known) return;
    if (std::erase(routes_, known.mapped().route.get()) > 0) order_peers();
    engine_.listener_.on_gone(address);
  }

  void forget_the_silent() {
    const Time now = os::now();
    sweep_.set(now + kSweep);
    std::vector<NetAddress> silent;
    for (const auto& [address, router] : known_) {
      if (router.generation != generation_ && now >= former_until_) silent.push_back(address);
    }
    if (metatraffic_)
      for (const link::DdsParticipant& participant : metatraffic_->expire(now))
        silent.push_back(NetAddress::dds(participant));
    for (const NetAddress& address : silent) forget(address);
    if (!silent.empty()) engine_.listener_.on_turn_end();
  }

  // --- outgoing datagrams

  void serve() {
    const Time now = os::now();
    Time next = serve_at_ = kNever;
    guarded([&] {
      for (DdsRoute* route : routes_) next = std::min(next, route->serve(now, written_));
    });
    serve_by(next);
  }

  void serve_by(Time next) {
    if (next < serve_at_) serve_.set(serve_at_ = next);
  }

  // Writes the queues and waits for acknowledgements, with a time limit.
  void finish() {
    const Time limit = os::now() + kFinishLimit;
    const auto is_finished = [this] {
      return std::ranges::all_of(routes_, [](DdsRoute* route) { return route->is_finished(); });
    };
    while (reader_ != nullptr && os::now() < limit && !is_finished()) {
      pollfd acknowledgements{traffic_->fd(), POLLIN, 0};
      ::poll(&acknowledgements, 1, 1);
      hand_on_arrivals();
      for (DdsRoute* route : routes_) route->serve(os::now(), written_);
    }
  }

  // --- incoming datagrams

  void take_samples() {
    for (std::size_t taken = 0; reader_ != nullptr; ++taken) {
      if (taken == kSamplesATurn) return continue_later();
      if (taken == buffers_.size()) buffers_.emplace_back();
      if (!take_sample(buffers_[taken])) return;
    }
  }

  bool take_sample(OctetsIn& buffer) {
    eprosima::fastdds::dds::SampleInfo info;
    bool taken = false;
    guarded([&] { taken = reader_->take_next_sample(&buffer, &info) == ReturnCode_t::RETCODE_OK; });
    if (!taken) return false;
    if (info.valid_data) hand_out(sender(info), buffer.bytes());
    return true;
  }

  void hand_out(const NetAddress& from, std::span<std::byte> bytes) {
    ++counters_.samples_in;
    const link::Batch batch(bytes);
    if (!batch.valid()) {
      ++counters_.strange;
      return;
    }
    batch.for_each([&](std::span<std::byte> datagram) {
      ++counters_.datagrams_in;
      counters_.bytes_in += datagram.size();
      engine_.listener_.on_datagram(from, datagram);
    });
  }

  // Lets other components have their turn first.
  void continue_later() { events_->wake(); }

  DdsEngine& engine_;
  const std::shared_ptr<DdsEvents> events_;
  const std::shared_ptr<DdsCommands> commands_ = std::make_shared<DdsCommands>();
  const std::uint16_t port_;
  std::optional<Watch> events_watch_;
  std::optional<Watch> socket_watch_;  // set while there is a participant
  Timer retry_;
  Timer sweep_;
  Timer serve_;
  Time serve_at_ = kNever;
  Time former_until_{};  // until then routers known to the previous generation are kept
  std::thread thread_;

  std::uint64_t generation_ = 0;
  link::Announcement self_{};
  NetAddress address_{};
  std::vector<NetAddress> host_;
  std::shared_ptr<UserTraffic> traffic_;
  std::shared_ptr<Metatraffic> metatraffic_;
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
  std::map<NetAddress, Router> known_;
  std::vector<DdsRoute*> routes_;  // routes of the routers in known_ that we send to
  std::deque<OctetsIn> buffers_;   // valid for one turn
  Counters counters_{};
  DdsRoute::Counters written_{};
};

bool DdsEngine::built_in() { return true; }

DdsEngine::DdsEngine(Loop& loop, Log& log, DdsSettings settings, Listener& listener)
    : loop_(loop), log_(log), settings_(std::move(settings)), listener_(listener) {}

DdsEngine::~DdsEngine() { stop(); }

Result<void> DdsEngine::start(const link::Announcement& self) {
  auto qos = participant_qos(settings_);
  if (!qos) return qos.error();
  auto events = DdsEvents::make();
  if (!events) return events.error();
  running_ = std::make_unique<Running>(*this, *qos, std::move(*events));
  running_->begin(self);
  return {};
}

void DdsEngine::restart(const link::Announcement& self) {
  if (running_) running_->begin(self);
}

void DdsEngine::stop() { running_.reset(); }

DdsEngine::State DdsEngine::state() const { return running_ ? running_->state() : State::kOff; }

link::NetAddress DdsEngine::address() const {
  return running_ ? running_->address() : link::NetAddress();
}

std::vector<link::NetAddress> DdsEngine::host() const {
  return running_ ? running_->host() : std::vector<link::NetAddress>();
}

const std::string& DdsEngine::last_error() const { return last_error_; }

DdsEngine::Counters DdsEngine::counters() const {
  return running_ ? running_->counters() : Counters();
}

void DdsEngine::connect(const link::NetAddress& to) {
  if (running_) running_->connect(to);
}

bool DdsEngine::send(const link::Burst& burst) { return running_ && running_->send(burst); }

}  // namespace tims::io
