// The loop's side of the engine.
#include "router/io/dds/dds_engine.h"

#include <deque>
#include <map>
#include <thread>
#include <utility>

#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fmt/core.h>

#include "os/clock.h"
#include "router/io/dds/worker.h"
#include "router/io/timer.h"
#include "router/io/watch.h"
#include "router/link/bundle.h"

namespace tims::io {
namespace {

using namespace std::chrono_literals;
using eprosima::fastrtps::types::ReturnCode_t;
using link::NetAddress;

constexpr std::size_t kSamplesATurn = 32;
constexpr Duration kTryAgain = 3s;
constexpr Duration kEndLimit = 3s;

NetAddress sender(const eprosima::fastdds::dds::SampleInfo& info) {
  link::DdsParticipant id{};
  const auto& prefix = info.sample_identity.writer_guid().guidPrefix;
  std::copy_n(prefix.value, id.size(), id.begin());
  return NetAddress::dds(id);
}

}  // namespace

// From start() to stop().
class DdsEngine::Running {
 public:
  Running(DdsEngine& engine, eprosima::fastdds::dds::DomainParticipantQos qos,
          std::shared_ptr<DdsNews> news)
      : engine_(engine),
        news_(std::move(news)),
        retry_(engine.loop_, [this] { live_again(); }),
        sweep_(engine.loop_, [this] { forget_the_silent(); }) {
    watch_.emplace(engine.loop_, news_->fd(), [this](Ready) { hear(); });
    thread_ = std::thread(
        [settings = engine.settings_, qos = std::move(qos), news = news_, orders = orders_] {
          DdsWorker(settings, qos, news, orders).run();
          orders->ended();
        });
  }

  ~Running() {
    reader_ = nullptr;
    orders_->change([](DdsOrders::Wanted& wanted) { wanted.end = true; });
    if (orders_->wait_for_end(kEndLimit)) {
      thread_.join();
    } else {
      engine_.log_.error("dds: Fast DDS does not end; it is left behind");
      thread_.detach();
    }
  }

  void live(const link::Announcement& self) {
    reader_ = nullptr;  // before the thread may end it
    address_ = {};
    ++life_;
    retry_.cancel();
    orders_->change([&](DdsOrders::Wanted& wanted) {
      wanted.life = life_;
      wanted.self = self;
    });
    self_ = self;
  }

  [[nodiscard]] State state() const { return reader_ != nullptr ? State::kUp : State::kStarting; }
  [[nodiscard]] const NetAddress& address() const { return address_; }

  std::shared_ptr<DdsPeer> connect(const NetAddress& to) {
    const auto known = known_.find(to);
    if (known == known_.end()) return nullptr;
    std::shared_ptr<DdsPeer>& peer = known->second.peer;
    if (!peer) {
      peer = std::make_shared<DdsPeer>(to);
      order_peers();
    }
    return peer;
  }

  bool send(const link::Train& train) {
    const auto peer = connect(train.to);
    if (peer && peer->queue.put(train)) {
      orders_->stir();
      return true;
    }
    if (train.datagram_size > 0)
      counters_.refused += (train.bytes.size() + train.datagram_size - 1) / train.datagram_size;
    return false;
  }

  [[nodiscard]] Counters counters() const {
    Counters all = counters_;
    all.samples_out = orders_->written.samples;
    all.bytes_out = orders_->written.bytes;
    all.datagrams_out = orders_->written.datagrams;
    all.unmatched = orders_->written.unmatched;
    for (const auto& [address, router] : known_) {
      if (router.peer) all.waiting_bytes += router.peer->queue.waiting_bytes();
    }
    return all;
  }

 private:
  struct Router {
    std::uint64_t life = 0;           // in which it was last heard of
    std::shared_ptr<DdsPeer> peer{};  // when it is sent to
  };

  // --- what the threads tell

  void hear() {
    DdsNews::All news = news_->take();
    for (const DdsNews::Line& line : news.lines) complain(line);
    for (auto& [id, router] : news.routers) hear_of(NetAddress::dds(id), router);
    if (news.up && news.up->life == life_) come_up(*news.up);
    if (news.failure && news.failure->life == life_) fail(news.failure->text);
    take_samples();
    engine_.listener_.on_turn_end();
  }

  void complain(const DdsNews::Line& line) {
    if (!line.error) return engine_.log_.debug("dds: " + line.text);
    engine_.log_.warning("dds: " + line.text);
    if (std::exchange(engine_.last_error_, line.text) != line.text) engine_.listener_.on_state();
  }

  void hear_of(const NetAddress& address, const DdsNews::Router& router) {
    if (router.life != life_) return;
    if (!router.announcement) {
      forget(address);
      return;
    }
    known_[address].life = life_;
    engine_.listener_.on_announced(*router.announcement);
  }

  void come_up(const DdsNews::Up& up) {
    reader_ = up.reader;
    address_ = up.address;
    engine_.last_error_.clear();
    // Who went while there was no participant has not been heard going.
    sweep_.set(os::now() + engine_.settings_.lease + 1s);
    engine_.listener_.on_state();
  }

  void fail(const std::string& text) {
    reader_ = nullptr;
    address_ = {};
    engine_.last_error_ = text;
    engine_.log_.warning(fmt::format("dds: {}; tried again in {} s", text, kTryAgain / 1s));
    retry_.set(os::now() + kTryAgain);
    engine_.listener_.on_state();
  }

  void live_again() { live(link::Announcement(self_)); }

  // --- who is there

  void order_peers() {
    std::vector<std::shared_ptr<DdsPeer>> peers;
    for (const auto& [address, router] : known_) {
      if (router.peer) peers.push_back(router.peer);
    }
    orders_->change([&](DdsOrders::Wanted& wanted) { wanted.peers = std::move(peers); });
  }

  void forget(const NetAddress& address) {
    const auto known = known_.extract(address);
    if (!known) return;
    if (known.mapped().peer) order_peers();
    engine_.listener_.on_gone(address);
  }

  void forget_the_silent() {
    std::vector<NetAddress> silent;
    for (const auto& [address, router] : known_) {
      if (router.life != life_) silent.push_back(address);
    }
    for (const NetAddress& address : silent) forget(address);
    if (!silent.empty()) engine_.listener_.on_turn_end();
  }

  // --- datagrams in

  void take_samples() {
    for (std::size_t taken = 0; reader_ != nullptr; ++taken) {
      if (taken == kSamplesATurn) return continue_later();
      if (taken == buffers_.size()) buffers_.emplace_back();
      if (!take_sample(buffers_[taken])) return;
    }
  }

  bool take_sample(OctetsIn& buffer) {
    eprosima::fastdds::dds::SampleInfo info;
    try {
      if (reader_->take_next_sample(&buffer, &info) != ReturnCode_t::RETCODE_OK) return false;
    } catch (const std::exception& e) {
      fail(e.what());
      return false;
    }
    if (info.valid_data) hand_out(sender(info), buffer.bytes());
    return true;
  }

  void hand_out(const NetAddress& from, std::span<std::byte> bytes) {
    ++counters_.samples_in;
    const link::Bundle bundle(bytes);
    if (!bundle.valid()) {
      ++counters_.strange;
      return;
    }
    bundle.for_each([&](std::span<std::byte> datagram) {
      ++counters_.datagrams_in;
      counters_.bytes_in += datagram.size();
      engine_.listener_.on_datagram(from, datagram);
    });
  }

  // Others have their turn first.
  void continue_later() { news_->has_data(); }

  DdsEngine& engine_;
  const std::shared_ptr<DdsNews> news_;
  const std::shared_ptr<DdsOrders> orders_ = std::make_shared<DdsOrders>();
  std::optional<Watch> watch_;
  Timer retry_;
  Timer sweep_;
  std::thread thread_;

  std::uint64_t life_ = 0;
  link::Announcement self_{};
  NetAddress address_{};
  eprosima::fastdds::dds::DataReader* reader_ = nullptr;
  std::map<NetAddress, Router> known_;
  std::deque<OctetsIn> buffers_;  // of one turn
  Counters counters_{};
};

bool DdsEngine::built_in() { return true; }

DdsEngine::DdsEngine(Loop& loop, Log& log, DdsSettings settings, Listener& listener)
    : loop_(loop), log_(log), settings_(std::move(settings)), listener_(listener) {}

DdsEngine::~DdsEngine() { stop(); }

Result<void> DdsEngine::start(const link::Announcement& self) {
  auto qos = participant_qos(settings_);
  if (!qos) return qos.error();
  auto news = DdsNews::make();
  if (!news) return news.error();
  running_ = std::make_unique<Running>(*this, std::move(*qos), std::move(*news));
  running_->live(self);
  return {};
}

void DdsEngine::restart(const link::Announcement& self) {
  if (running_) running_->live(self);
}

void DdsEngine::stop() { running_.reset(); }

DdsEngine::State DdsEngine::state() const { return running_ ? running_->state() : State::kOff; }

link::NetAddress DdsEngine::address() const {
  return running_ ? running_->address() : link::NetAddress();
}

const std::string& DdsEngine::last_error() const { return last_error_; }

DdsEngine::Counters DdsEngine::counters() const {
  return running_ ? running_->counters() : Counters();
}

void DdsEngine::connect(const link::NetAddress& to) {
  if (running_) running_->connect(to);
}

bool DdsEngine::send(const link::Train& train) { return running_ && running_->send(train); }

}  // namespace tims::io
