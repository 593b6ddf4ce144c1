#include "router/io/dds/writer.h"

#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>

#include "router/io/dds/qos.h"
#include "router/io/dds/require.h"

namespace tims::io {

namespace {

// The library's own, which are few, do not count beside ours.
constexpr std::uint32_t kFirstHeartbeat = 1 << 16;

}  // namespace

namespace fast = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;

// Called by the library's threads.
class DdsWriter::Match final : public fast::DataWriterListener {
 public:
  Match(std::shared_ptr<DdsPeer> peer, std::shared_ptr<DdsNews> news)
      : peer_(std::move(peer)), news_(std::move(news)) {}
  void on_publication_matched(fast::DataWriter*,
                              const fast::PublicationMatchedStatus& status) override {
    peer_->matched = status.current_count > 0;
    news_->has_moved();
  }
  void forget() { peer_->matched = false; }

 private:
  const std::shared_ptr<DdsPeer> peer_;
  const std::shared_ptr<DdsNews> news_;
};

DdsWriter::DdsWriter(const Place& place, std::shared_ptr<DdsPeer> peer,
                     std::shared_ptr<DdsNews> news, std::shared_ptr<UserTraffic> traffic)
    : participant_(place.participant),
      traffic_(std::move(traffic)),
      heartbeat_{.to = peer->address.participant(), .count = kFirstHeartbeat},
      history_(place.settings.history) {
  fast::PublisherQos where = fast::PUBLISHER_QOS_DEFAULT;
  where.partition().push_back(partition_of(peer->address).c_str());
  match_ = std::make_unique<Match>(std::move(peer), std::move(news));
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

// A full history is told as "timeout" or "out of resources", and has not kept the sample.
Written DdsWriter::write(const OctetsOut& sample) {
  const UserTraffic::Cork cork(*traffic_);
  OctetsOut octets = sample;  // the library takes no const
  const ReturnCode_t code = writer_->write(&octets, eprosima::fastrtps::rtps::InstanceHandle_t());
  if (code == ReturnCode_t::RETCODE_OK) {
    // As many as the history takes stay in it.
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

}  // namespace tims::io
