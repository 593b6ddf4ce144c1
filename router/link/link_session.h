// The state two routers keep for each other while both are running: the lanes with their
// messages, the packets in flight, the sending rate and the datagram size. It outlives the loss
// of the path and knows no addresses: link.h passes datagrams in and sends those built here.
//
// Sources: uniquely numbered packets acknowledged in ranges, loss detection and probe timeout
// from QUIC (RFC 9000, RFC 9002); streams of which the sender may skip a part from SCTP (RFC
// 4960, RFC 3758); sending in bursts and reassembly in place from Aeron.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/rate_limiter.h"
#include "router/link/congestion.h"
#include "router/link/estimators.h"
#include "router/link/frame.h"
#include "router/link/handover.h"
#include "router/link/lanes.h"
#include "router/link/packets.h"
#include "router/link/paths.h"
#include "router/link/samples.h"
#include "router/link/session_keys.h"
#include "router/link/transport.h"

namespace tims::link {

struct LinkSessionSettings {
  std::uint32_t message_max = kMessageMaxDefault;  // maximum size of a received message
  std::uint64_t queue_bytes_max = 16U << 20;
  Duration lifetime = std::chrono::seconds(30);  // of a message waiting to be sent or acknowledged
  std::uint64_t rate = 0;                        // bytes per second, headers included; 0: no limit
  std::uint8_t reserve = 10;                     // percentage of it reserved for the upper classes
  core::PriorityClasses classes{};
  policy::Lifetimes lifetimes{};  // of commands

  bool operator==(const LinkSessionSettings&) const = default;
};

struct LinkSessionCounters {
  std::uint64_t packets_in = 0;
  std::uint64_t packets_out = 0;
  std::uint64_t bytes_in = 0;  // of datagrams
  std::uint64_t bytes_out = 0;
  std::uint64_t packets_lost = 0;      // sent packets that were lost
  std::uint64_t packets_replayed = 0;  // received again, or too late to tell
  std::uint64_t packets_forged = 0;    // do not open with our keys: from somebody else, or altered
  std::uint64_t packets_old_key = 0;   // sealed with keys that are not used any more
  std::uint64_t packets_refused = 0;   // received packets refused for lack of memory
  std::uint64_t sample_repeats = 0;    // parts of samples sent again
  // Of frames of messages by lane, also of those that are sent again; without what is around them.
  std::array<std::uint64_t, kLanes> lane_bytes_out{};
};

class LinkSession final : private PacketObserver {
 public:
  LinkSession(core::BlockPool& pool, MessageMemory& memory, std::vector<MessageBuffer>& done,
              const LinkSessionSettings& settings, ArrivalObserver& arrivals, LossObserver& losses);

  void configure(const LinkSessionSettings& settings);

  // --- sending. The message's header is in host byte order. Returns kDelivered or kQueueFull.
  core::Outcome send(Time now, const RecordPrefix& prefix, const Header& header,
                     std::span<const std::byte> message);
  void send_control(Time now, std::span<const std::byte> message);

  // Builds the next packet into `out` and returns its size, 0 when nothing is to be sent now.
  // `keep_alive`: included in the packet unless it is null.
  std::size_t build(Time now, std::uint64_t token, std::span<std::byte> out,
                    const KeepAlive* keep_alive = nullptr);
  // A datagram of its own that probes a larger size; 0: none is due. `to` has kDatagramMax bytes.
  std::size_t build_probe(Time now, std::uint64_t token, std::span<std::byte> to);
  // A packet containing only this frame, for the given address.
  std::size_t build_nonce(Time now, std::uint64_t token, FrameType type, std::uint64_t nonce,
                          std::span<std::byte> out);
  std::size_t build_last(Time now, std::uint64_t token, const LastFrame& frame,
                         std::span<std::byte> out);

  // --- receiving
  enum class Verdict : std::uint8_t { kTaken, kBroken };
  // True when no packet with this number has been received.
  [[nodiscard]] bool is_new(std::uint32_t packet) const {
    return window_.is_new(window_.expand(packet));
  }
  // A number is used once, so nothing is lost that an answer could bring back: none is sent.
  void note_replay() { ++counters_.packets_replayed; }
  // Decrypts the frames. Precondition: is_new(). False: the packet is not from the other router.
  [[nodiscard]] bool open(Time now, Data& data);
  Verdict on_data(Time now, const Data& data);  // precondition: open()

  // --- time
  [[nodiscard]] Time next_timeout(Time now);
  void on_timeout(Time now);

  // The path was replaced or works again after it was dead: everything learnt about it is
  // forgotten, and everything in flight is sent again.
  void on_new_path(Time now, PathKind kind);
  // The other router has lost its state: everything waiting is lost, and the session restarts.
  void reset(Time now, core::Outcome why);
  // Send time of the newest acknowledged packet.
  [[nodiscard]] Time newest_acked_sent() const { return newest_acked_sent_; }

  [[nodiscard]] SessionKeys& keys() { return keys_; }
  [[nodiscard]] const SessionKeys& keys() const { return keys_; }

  // For the next router (handover.h). What is in flight is sent again there; samples are not kept:
  // newer ones follow.
  void save(StateWriter& to) const;
  // Precondition: the session is new, or reset. False: no such state, or no memory for it; reset
  // it.
  [[nodiscard]] bool restore(Time now, StateReader& from);

  // Closed while the path is dead: only keep-alives are built.
  void set_open(bool open) { open_ = open; }

  // --- read access
  [[nodiscard]] const RttEstimator& rtt() const { return rtt_; }
  [[nodiscard]] const Congestion& congestion() const { return congestion_; }
  [[nodiscard]] std::size_t mtu() const { return mtu_.size(); }
  // Bytes per second that the link takes now.
  [[nodiscard]] std::uint64_t rate() const;
  // Size of full datagrams: small on a slow link, so that urgent messages do not wait long for
  // one.
  [[nodiscard]] std::size_t datagram_size() const;
  [[nodiscard]] std::uint64_t queued_bytes() const;
  [[nodiscard]] std::uint64_t queued_bytes(std::size_t lane) const;
  [[nodiscard]] std::uint64_t in_flight() const { return sent_.bytes_in_flight(); }
  [[nodiscard]] const LinkSessionCounters& counters() const { return counters_; }
  [[nodiscard]] const SampleReceiver& samples_in() const { return sample_receiver_; }
  [[nodiscard]] std::uint16_t loss_permille() const { return loss_permille_; }
  // Called with a keep-alive, which states how many path challenges were sent before it.
  void measure_loss(std::uint8_t questions);
  [[nodiscard]] std::uint8_t questions_out() const {
    return static_cast<std::uint8_t>(questions_out_ % kQuestionsModulo);
  }
  // The most urgent lane in the most recently built packet.
  [[nodiscard]] std::size_t last_lane() const { return last_lane_; }

 private:
  void on_packet_acked(const SentPacket& packet) override;
  void on_packet_lost(const SentPacket& packet) override;

  void on_acked(const SentPacket::Piece& piece);
  void on_lost(const SentPacket::Piece& piece);
  void forget_path(Time now);

  // --- received frames
  Verdict on_frames(Time now, const Data& data, bool& eliciting, bool& keep);
  bool on_ack(Time now, const Ack& ack);
  void on_not_ready(Time now, std::uint16_t lanes);
  void after_ack(Time now, const SentPackets::AckResult& result, Duration rtt,
                 std::uint64_t in_flight);

  // --- choice of what to send
  struct Packet;  // a packet being built
  bool make_room(Time now, std::size_t lane, std::size_t message);
  bool drop_one(Time now, std::size_t lane);
  void set_rates();
  [[nodiscard]] std::size_t datagram_max() const;
  [[nodiscard]] Time ready_at(Time now, std::size_t lane);
  [[nodiscard]] bool has_something_to_send() const;
  [[nodiscard]] bool wants_to_send(std::size_t lane) const;
  [[nodiscard]] bool has_samples(std::size_t lane) const;
  [[nodiscard]] bool is_idle(std::size_t lane) const;
  void forget_idle_lanes();
  void put_ack(Time now, Packet& packet);
  void put_not_ready(Packet& packet);
  void put_skip(Packet& packet);
  [[nodiscard]] std::size_t size_for(bool keeps_alive) const;
  [[nodiscard]] Packet packet_in(std::span<std::byte> out) const;
  static void put_ping(Packet& packet);
  void put_lanes(Time now, Packet& packet);
  bool put_stream(Time now, Packet& packet, std::size_t lane);
  bool put_sample(Time now, Packet& packet, std::size_t message_class);
  std::size_t finish(Time now, std::uint64_t token, Packet& packet);
  [[nodiscard]] std::uint64_t committed_max() const;
  [[nodiscard]] Time probe_deadline() const;

  LinkSessionSettings settings_;
  ArrivalObserver& arrivals_;
  LossObserver& losses_;
  bool open_ = true;

  std::array<LaneSender, kLanes> lanes_;
  std::array<SampleSender, core::kClasses> samples_;
  LaneSet occupied_;  // all others are idle
  std::uint32_t last_sample_ = 0;
  bool sample_first_ = false;  // samples and messages of a class take turns
  SentPackets sent_;
  RttEstimator rtt_;
  Congestion congestion_{kDatagramBase};
  PathMtu mtu_;
  base::RateLimiter pacer_;
  base::RateLimiter cap_;                    // the link's rate
  base::RateLimiter lower_cap_;              // the share of the rate that the lower classes may use
  std::array<Time, kLanes> paused_until_{};  // the other side has no memory for these lanes
  int probes_ = 0;                           // consecutive probe timeouts
  int probe_packets_ = 0;                    // packets that may exceed the window
  Time next_expiry_{};
  std::uint64_t queued_at_most_ = 0;
  Time newest_acked_sent_{};
  std::size_t last_lane_ = kControlLane;

  Reassembly reassembly_;
  std::array<LaneReceiver, kLanes> receivers_;
  SampleReceiver sample_receiver_;
  PacketWindow window_;
  SessionKeys keys_;
  Time newest_at_{};           // arrival time of the packet with the highest number
  std::uint32_t unacked_ = 0;  // packets that need an acknowledgement
  bool ack_now_ = false;
  std::uint16_t not_ready_ = 0;  // lanes without memory, to be reported
  Time ack_at_ = kNever;

  LinkSessionCounters counters_;
  std::uint64_t measured_next_ = 0;
  std::uint64_t measured_in_ = 0;  // without path challenges
  std::uint8_t measured_questions_ = 0;
  std::uint64_t questions_in_ = 0;
  std::uint64_t questions_out_ = 0;
  std::uint16_t loss_permille_ = 0;
};

}  // namespace tims::link
