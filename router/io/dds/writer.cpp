#include "router/io/dds/writer.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>

#include "router/io/dds/participant.h"
#include "router/link/transport.h"

namespace tims::io {
namespace {

namespace fast = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;
using namespace std::chrono_literals;

constexpr std::array<unsigned char, 4> kLittleEndianCdr{0, 1, 0, 0};

std::size_t serialized_size(const OctetsOut& sample) {
  return kLittleEndianCdr.size() + sample.parts[0].size() + sample.parts[1].size();
}

// The library's own heartbeats have lower counts, so readers ignore them.
constexpr std::uint32_t kFirstHeartbeat = 1 << 16;

constexpr Duration kReaderLimit = 2s;  // time limit for the receiver to appear
constexpr Duration kPauseMax = 250ms;
constexpr Duration kWriterTryAgain = 100us;

}  // namespace

// --- samples

void OctetsIn::assign(std::span<const std::byte> bytes) {
  if (!memory_) memory_ = std::make_unique_for_overwrite<std::byte[]>(kSampleBytesMax);
  size_ = bytes.size() <= kSampleBytesMax ? bytes.size() : 0;
  if (size_ > 0) std::memcpy(memory_.get(), bytes.data(), size_);
}

OctetsType::OctetsType() {
  setName(kName);
  m_typeSize = kSampleBytesMax + kLittleEndianCdr.size();
  m_isGetKeyDefined = false;
  auto_fill_type_object(false);
  auto_fill_type_information(false);
}

bool OctetsType::serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) {
  const auto& sample = *static_cast<const OctetsOut*>(data);
  const std::size_t size = serialized_size(sample);
  if (size > payload->max_size) return false;
  payload->encapsulation = CDR_LE;
  payload->length = static_cast<std::uint32_t>(size);
  unsigned char* to = std::ranges::copy(kLittleEndianCdr, payload->data).out;
  for (const auto part : sample.parts) {
    if (!part.empty()) std::memcpy(to, part.data(), part.size());
    to += part.size();
  }
  return true;
}

bool OctetsType::deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* payload, void* data) {
  const std::span all(payload->data, payload->length);
  const std::size_t header = std::min(all.size(), kLittleEndianCdr.size());
  static_cast<OctetsIn*>(data)->assign(std::as_bytes(all.subspan(header)));
  return true;
}

std::function<std::uint32_t()> OctetsType::getSerializedSizeProvider(void* data) {
  return [data] {
    return static_cast<std::uint32_t>(serialized_size(*static_cast<const OctetsOut*>(data)));
  };
}

using link::kBatchSizeBytes;

// --- the queue

bool SendQueue::put(const link::Burst& burst) {
  if (burst.bytes.empty() || burst.datagram_size == 0) return true;
  if (burst.bytes.size() + burst.count() * kBatchSizeBytes > size_ - used_) return false;
  if (!ring_) ring_ = std::make_unique_for_overwrite<std::byte[]>(size_);
  burst.for_each([this](std::span<const std::byte> datagram) {
    const std::array size{static_cast<std::byte>(datagram.size() & 0xFF),
                          static_cast<std::byte>(datagram.size() >> 8)};
    write(size);
    write(datagram);
  });
  return true;
}

void SendQueue::write(std::span<const std::byte> bytes) {
  const std::size_t before_wrap = std::min(bytes.size(), size_ - end_);
  std::memcpy(ring_.get() + end_, bytes.data(), before_wrap);
  std::memcpy(ring_.get(), bytes.data() + before_wrap, bytes.size() - before_wrap);
  end_ = (end_ + bytes.size()) % size_;
  used_ += bytes.size();
}

std::size_t SendQueue::datagram_size_at(std::size_t position) const {
  return std::to_integer<std::size_t>(ring_[position % size_]) |
         std::to_integer<std::size_t>(ring_[(position + 1) % size_]) << 8;
}

SendQueue::Front SendQueue::front(std::size_t bytes_max) const {
  Front front;
  while (front.bytes < used_) {
    const std::size_t next = kBatchSizeBytes + datagram_size_at(first_ + front.bytes);
    if (front.datagrams > 0 && front.bytes + next > bytes_max) break;
    front.bytes += next;
    ++front.datagrams;
  }
  if (front.bytes == 0) return front;
  const std::size_t before_wrap = std::min(front.bytes, size_ - first_);
  front.parts = {std::span<const std::byte>(ring_.get() + first_, before_wrap),
                 std::span<const std::byte>(ring_.get(), front.bytes - before_wrap)};
  return front;
}

void SendQueue::remove(const Front& front) {
  used_ -= front.bytes;
  first_ = (first_ + front.bytes) % size_;
  // Restart at the beginning, so that a queue with little use touches few pages.
  if (used_ == 0) first_ = end_ = 0;
}

// --- the writer

// Called by the library's threads.
class DdsWriter::Match final : public fast::DataWriterListener {
 public:
  Match(std::shared_ptr<DdsPeer> peer, std::shared_ptr<DdsEvents> events)
      : peer_(std::move(peer)), events_(std::move(events)) {}
  void on_publication_matched(fast::DataWriter*,
                              const fast::PublicationMatchedStatus& status) override {
    peer_->matched = status.current_count > 0;
    events_->wake();
  }
  void forget() { peer_->matched = false; }

 private:
  const std::shared_ptr<DdsPeer> peer_;
  const std::shared_ptr<DdsEvents> events_;
};

DdsWriter::DdsWriter(const Place& place, std::shared_ptr<DdsPeer> peer,
                     std::shared_ptr<DdsEvents> events, std::shared_ptr<UserTraffic> traffic)
    : participant_(place.participant),
      traffic_(std::move(traffic)),
      heartbeat_{.to = peer->address.participant(), .count = kFirstHeartbeat},
      history_(place.settings.history) {
  fast::PublisherQos where = fast::PUBLISHER_QOS_DEFAULT;
  where.partition().push_back(partition_of(peer->address).c_str());
  match_ = std::make_unique<Match>(std::move(peer), std::move(events));
  publisher_ = require(participant_.create_publisher(where), "publisher");
  fast::DataWriterQos qos = publisher_->get_default_datawriter_qos();
  const bool is_profile =
      !place.settings.profiles.empty() &&
      publisher_->get_datawriter_qos_from_profile(kDdsProfile, qos) == ReturnCode_t::RETCODE_OK;
  asks_ = !is_profile && traffic_->has_receiver();
  complete(qos, place.settings, is_profile, asks_);
  writer_ = publisher_->create_datawriter(&place.topic, qos, match_.get(),
                                          fast::StatusMask::publication_matched());
  if (writer_ == nullptr) participant_.delete_publisher(publisher_);
  require(writer_, "writer");
  const auto& guid = writer_->guid();
  std::copy_n(guid.guidPrefix.value, heartbeat_.from.size(), heartbeat_.from.begin());
  std::copy_n(guid.entityId.value, heartbeat_.writer.size(), heartbeat_.writer.begin());
}

DdsWriter::~DdsWriter() {
  publisher_->delete_datawriter(writer_);
  participant_.delete_publisher(publisher_);
  match_->forget();
}

// With a full history, write() returns "timeout" or "out of resources", and the sample is not
// stored.
Written DdsWriter::write(const OctetsOut& sample) {
  const UserTraffic::Cork cork(*traffic_);
  OctetsOut octets = sample;  // the library's parameter is not const
  const ReturnCode_t code = writer_->write(&octets, eprosima::fastrtps::rtps::InstanceHandle_t());
  if (code == ReturnCode_t::RETCODE_OK) {
    // The history keeps this many samples.
    if (++heartbeat_.last > history_) ++heartbeat_.first;
    traffic_->last_to(to_);
    return Written::kYes;
  }
  const bool full =
      code == ReturnCode_t::RETCODE_TIMEOUT || code == ReturnCode_t::RETCODE_OUT_OF_RESOURCES;
  return full ? Written::kNotNow : Written::kNever;
}

void DdsWriter::ask() {
  if (!asks_) return;
  ++heartbeat_.count;
  traffic_->send(encode(heartbeat_), to_);
}

bool DdsWriter::has_arrived() {
  return writer_->wait_for_acknowledgments({0, 0}) == ReturnCode_t::RETCODE_OK;
}

// --- the route

Duration DdsRoute::pause(Duration silent, Duration least) {
  return std::clamp(silent, least, std::max(least, kPauseMax));
}

void DdsRoute::on_received(Time now) {
  if (silent_since_ == kNever) return;
  answers_in_ = (3 * answers_in_ + silence(now)) / 4;
  silent_since_ = kNever;
  again_at_ = {};
  if (heartbeat_at_ != kNever) heartbeat_at_ = std::min(heartbeat_at_, next_heartbeat(now));
}

// Twice the usual answering time, doubled with each heartbeat.
Time DdsRoute::next_heartbeat(Time now) {
  const Duration silence = silent_since_ == kNever ? Duration() : now - silent_since_;
  return now + pause(std::max(silence, 2 * answers_in_), heartbeat_);
}

// Starts or continues a period of silence.
Duration DdsRoute::silence(Time now) {
  silent_since_ = std::min(silent_since_, now);
  return now - silent_since_;
}

Time DdsRoute::serve(Time now, Counters& counters) {
  const Time next = write_next(now, counters);
  return std::min(next, ask(now));
}

Time DdsRoute::ask(Time now) {
  if (!writer_ || now < heartbeat_at_) return heartbeat_at_;
  if (writer_->has_arrived()) return heartbeat_at_ = kNever;
  writer_->ask();
  (void)silence(now);
  return heartbeat_at_ = next_heartbeat(now);
}

Time DdsRoute::write_next(Time now, Counters& counters) {
  if (!writer_ || !peer_->matched) return wait_for_reader(now, counters);
  waits_since_ = kNever;
  if (queue_.waiting_bytes() == 0) return kNever;
  if (now < again_at_) return again_at_;
  const SendQueue::Front front = queue_.front(kSampleBytesMax);
  const Written written = writer_->write({.parts = front.parts});
  if (written == Written::kNever) throw std::runtime_error("a sample could not be written");
  if (written == Written::kNotNow) return again_at_ = now + pause(silence(now), kWriterTryAgain);
  // During silence, the next heartbeat is already scheduled.
  heartbeat_at_ = std::min(heartbeat_at_, now + (silent_since_ == kNever ? heartbeat_ : kPauseMax));
  queue_.remove(front);
  counters.samples += 1;
  counters.datagrams += front.datagrams;
  counters.bytes += front.bytes - front.datagrams * link::kBatchSizeBytes;
  return queue_.waiting_bytes() > 0 ? now : kNever;
}

Time DdsRoute::wait_for_reader(Time now, Counters& counters) {
  if (queue_.waiting_bytes() == 0) {
    waits_since_ = kNever;
    return kNever;
  }
  if (waits_since_ == kNever) waits_since_ = now;
  if (now < waits_since_ + kReaderLimit) return waits_since_ + kReaderLimit;
  const SendQueue::Front all = queue_.front(SendQueue::kBytes);
  queue_.remove(all);
  counters.unmatched += all.datagrams;
  waits_since_ = kNever;
  return kNever;
}

}  // namespace tims::io
