#include "rack/data_module.h"

#include <algorithm>
#include <ctime>
#include <mutex>
#include <optional>

#include "components/runtime/logic/listeners.h"
#include "os/clock.h"

namespace rack {
namespace {

// For the ends of all streams together.
constexpr tims::Duration kEndPatience = std::chrono::seconds(1);

}  // namespace

class DataModuleBase::Publisher {
 public:
  explicit Publisher(DataModuleBase& module)
      : module_(module),
        listeners_(module.data_.listeners),
        due_(module.data_.listeners),
        rare_(module.data_.listeners),
        answer_(module.data_.size_max) {}

  void clear() { listeners_.clear(); }
  // Ends all streams.
  void end_streams();
  void end_stream(const Listener& listener, tims::Time end);
  void send(TimeStamp recorded, std::size_t size);

  Result<void> get_data(const tims::MessageView& message);
  Result<void> get_cont_data(const tims::MessageView& message);
  Result<void> stop_cont_data(const tims::MessageView& message);
  Result<void> get_next_data(const tims::MessageView& message);
  void drop(tims::Address mailbox);
  void drop_reported(tims::Address mailbox);
  [[nodiscard]] ListenersData listeners() const;

  std::uint32_t period_ms_ = 1000;  // protected by mutex_

 private:
  template <typename Add>
  Result<Listeners::Added> add(const tims::Header& request, std::uint32_t ends, Add add);
  Result<void> check_added(Listeners::Added added, tims::Address mailbox);
  [[nodiscard]] std::uint32_t ends_of_streams() const;
  void drop_absent();
  void make_place(const tims::Header& request);
  Result<void> send_data(const Listener& listener, std::span<const std::byte> body);

  DataModuleBase& module_;
  Listeners listeners_;         // protected by mutex_
  std::int64_t data_sets_ = 0;  // protected by mutex_
  // How often all streams have ended; protected by mutex_. It changes after the status: a component
  // that is on, and whose streams have not ended since this was read, ends the stream of a new
  // listener too.
  std::uint32_t ends_ = 0;
  std::vector<Listener> due_;      // used by the data task
  std::vector<Listener> rare_;     // used by the command task
  std::vector<std::byte> answer_;  // used by the command task
};

DataModuleBase::DataModuleBase(const ModuleInfo& info, const DataInfo& data)
    : Module(info),
      data_(data),
      history_(data.history, data.size_max),
      publisher_(std::make_unique<Publisher>(*this)) {}

DataModuleBase::~DataModuleBase() = default;

// --- the data task

Result<void> DataModuleBase::module_on() {
  {
    const std::lock_guard lock(mutex_);
    if (publisher_->period_ms_ == 0) return refused("the period is 0 ms");
    history_.clear();
    publisher_->clear();
  }
  while (history_.size() == 0 && is_wanted()) {
    if (auto looped = module_loop(); !looped) return looped;
  }
  return {};
}

void DataModuleBase::Publisher::end_streams() {
  std::span<Listener> all;
  {
    const std::lock_guard lock(module_.mutex_);
    std::ranges::copy(listeners_.all(), due_.begin());
    all = std::span(due_).first(listeners_.all().size());
    listeners_.clear();
    ++ends_;
  }
  const tims::Time end = tims::os::deadline_after(kEndPatience);
  for (const Listener& listener : all) end_stream(listener, end);
}

// A listener that misses the end of its stream waits for data that never come. So it is sent again
// while there is no room for it, or no router.
void DataModuleBase::Publisher::end_stream(const Listener& listener, tims::Time end) {
  constexpr timespec kPause{0, 5'000'000};
  for (;;) {
    const auto sent = module_.command_mailbox().send({.dest = listener.mailbox,
                                                      .type = tims::type::kError,
                                                      .priority = listener.priority,
                                                      .seq_nr = listener.seq_nr});
    if (sent || sent.error().code() == tims::Errc::kNoMailbox) return;
    if (tims::os::now() >= end)
      return module_.log().warning("Listener {} does not get the end of its stream: {}",
                                   listener.mailbox, sent.error().message());
    ::nanosleep(&kPause, nullptr);
  }
}

void DataModuleBase::set_period(std::chrono::milliseconds period) {
  const std::lock_guard lock(mutex_);
  publisher_->period_ms_ = static_cast<std::uint32_t>(std::max<std::int64_t>(period.count(), 0));
}

std::chrono::milliseconds DataModuleBase::period() const {
  const std::lock_guard lock(mutex_);
  return std::chrono::milliseconds(publisher_->period_ms_);
}

void DataModuleBase::Publisher::send(TimeStamp recorded, std::size_t size) {
  std::span<const std::byte> body;
  std::span<Listener> due;
  {
    const std::lock_guard lock(module_.mutex_);
    module_.history_.publish(recorded, size);
    ++data_sets_;
    body = module_.history_.newest().body;
    due = listeners_.take_due(due_);
  }
  for (const Listener& listener : due) {
    if (const auto sent = send_data(listener, body);
        !sent && sent.error().code() == tims::Errc::kNoMailbox)
      drop(listener.mailbox);
  }
}

Result<void> DataModuleBase::Publisher::send_data(const Listener& listener,
                                                  std::span<const std::byte> body) {
  return module_.command_mailbox().send({.dest = listener.mailbox,
                                         .type = tims::type::kData,
                                         .priority = listener.priority,
                                         .seq_nr = listener.seq_nr,
                                         .stream = module_.data_.samples && !listener.once,
                                         .report_if_gone = true},
                                        body);
}

// The mailbox of a listener does not exist any more.
void DataModuleBase::Publisher::drop(tims::Address mailbox) {
  const std::lock_guard lock(module_.mutex_);
  if (listeners_.remove(mailbox)) module_.log().info("Listener {} is gone", mailbox);
}

// The same by a report that may be old.
void DataModuleBase::Publisher::drop_reported(tims::Address mailbox) {
  const std::lock_guard lock(module_.mutex_);
  if (listeners_.remove_gone(mailbox, tims::os::now()))
    module_.log().info("Listener {} is gone", mailbox);
}

void DataModuleBase::turned_off() { publisher_->end_streams(); }

void DataModuleBase::publish(TimeStamp recorded, std::size_t size) {
  publisher_->send(recorded, size);
}

// --- the command task

Result<void> DataModuleBase::module_command(const tims::MessageView& message) {
  switch (message.header.type) {
    case tims::type::kGetData:
      return publisher_->get_data(message);
    case tims::type::kGetContData:
      return publisher_->get_cont_data(message);
    case tims::type::kStopContData:
      return publisher_->stop_cont_data(message);
    case tims::type::kGetNextData:
      return publisher_->get_next_data(message);
    case tims::type::kGetListeners:
      reply(message.header, tims::type::kListeners, publisher_->listeners());
      return {};
    case tims::type::kNotAvailable:
      publisher_->drop_reported(message.header.src);
      return {};
    default:
      return Module::module_command(message);
  }
}

// Why there are no data while the component is not on.
tims::Error DataModuleBase::no_data() const {
  return refused(is_wanted() ? std::string(kNoDataYet) : "the component is off and has no data");
}

Result<void> DataModuleBase::Publisher::get_data(const tims::MessageView& message) {
  const auto request = decode<GetDataRequest>(message);
  if (!request) return request.error();
  if (!module_.is_on()) return module_.no_data();
  Result<std::size_t> size = std::size_t{0};
  {
    const std::lock_guard lock(module_.mutex_);
    if (module_.history_.size() == 0) return refused(std::string(kNoDataYet));
    if (request->recordingTime.raw() != 0) {
      size = module_.data_at(request->recordingTime, answer_);
    } else {
      std::ranges::copy(module_.history_.newest().body, answer_.begin());
      size = module_.history_.newest().body.size();
    }
  }
  if (!size) return size.error();
  module_.reply(message.header, tims::type::kData, std::span(answer_).first(*size));
  return {};
}

Result<std::size_t> DataModuleBase::data_at(TimeStamp time, std::span<std::byte> to) const {
  const auto found = history_.nearest(time, 2 * std::chrono::milliseconds(publisher_->period_ms_));
  if (const auto* miss = std::get_if<DataHistory::Miss>(&found)) return not_there(*miss, time);
  const auto& body = std::get<DataHistory::Entry>(found).body;
  std::ranges::copy(body, to.begin());
  return body.size();
}

tims::Error DataModuleBase::not_there(DataHistory::Miss miss, TimeStamp time) {
  const std::string at = std::to_string(time.raw());
  switch (miss) {
    case DataHistory::Miss::kTooOld:
      return refused("data of time " + at + " ms are no longer available");
    case DataHistory::Miss::kTooNew:
      return refused("data of time " + at + " ms are not available yet");
    case DataHistory::Miss::kEmpty:
      break;
  }
  return refused(std::string(kNoDataYet));
}

Result<void> DataModuleBase::Publisher::get_cont_data(const tims::MessageView& message) {
  const auto request = decode<GetContDataRequest>(message);
  if (!request) return request.error();
  const std::uint32_t ends = ends_of_streams();
  if (!module_.is_on()) return module_.no_data();
  std::uint32_t granted = 0;
  const auto added = add(message.header, ends, [&](tims::Address source) {
    const std::uint32_t each = reduction(request->periodTime, period_ms_);
    granted = each * period_ms_;
    return listeners_.add(message.header, source, request->dataMbxAdr, each, tims::os::now());
  });
  if (!added) return added.error();
  if (auto good = check_added(*added, request->dataMbxAdr); !good) return good;
  module_.reply(message.header, tims::type::kContData, ContDataReply{granted});
  // The component may have been turned off before this answer was sent. The listener might take an
  // ERROR that came before the answer for one of an earlier stream.
  if (ends_of_streams() != ends)
    end_stream({.mailbox = request->dataMbxAdr,
                .priority = message.header.priority,
                .seq_nr = message.header.seq_nr},
               tims::os::now());
  return {};
}

std::uint32_t DataModuleBase::Publisher::ends_of_streams() const {
  const std::lock_guard lock(module_.mutex_);
  return ends_;
}

// `add` is called with the mutex held. When all places are taken, listeners that do not exist any
// more lose theirs, then the component that has most of them.
template <typename Add>
Result<Listeners::Added> DataModuleBase::Publisher::add(const tims::Header& request,
                                                        std::uint32_t ends, Add add) {
  const tims::Address source = module_.component_of(request.src);
  const auto try_once = [&]() -> Result<Listeners::Added> {
    const std::lock_guard lock(module_.mutex_);
    if (ends_ != ends) return refused("the component was just turned off");
    return add(source);
  };
  auto added = try_once();
  if (!added || *added != Listeners::Added::kFull) return added;
  drop_absent();
  added = try_once();
  if (!added || *added != Listeners::Added::kFull) return added;
  make_place(request);
  return try_once();
}

// Only sending shows whether a mailbox exists: those that get data rarely get the newest data set.
// The answer from another host arrives later, as NOT_AVAILABLE.
void DataModuleBase::Publisher::drop_absent() {
  std::span<Listener> rare;
  std::size_t size = 0;
  {
    const std::lock_guard lock(module_.mutex_);
    if (module_.history_.size() == 0) return;
    rare = listeners_.take_rare(rare_);
    const auto newest = module_.history_.newest().body;
    size = newest.size();
    std::ranges::copy(newest, answer_.begin());
  }
  for (const Listener& listener : rare) {
    const auto sent = send_data(listener, std::span(answer_).first(size));
    if (!sent && sent.error().code() == tims::Errc::kNoMailbox) drop(listener.mailbox);
  }
}

void DataModuleBase::Publisher::make_place(const tims::Header& request) {
  const tims::Address source = module_.component_of(request.src);
  std::optional<Listener> given;
  {
    const std::lock_guard lock(module_.mutex_);
    given = listeners_.make_place(source);
  }
  if (!given) return;
  module_.log().warning("Listener {} of {}, which has most of the {} places, is ended for {}",
                        given->mailbox, given->source, module_.data_.listeners, source);
  end_stream({.mailbox = given->mailbox, .priority = given->priority, .seq_nr = given->seq_nr},
             tims::os::now());
}

Result<void> DataModuleBase::Publisher::check_added(Listeners::Added added, tims::Address mailbox) {
  if (added == Listeners::Added::kFull)
    return refused("the maximum of " + std::to_string(module_.data_.listeners) +
                   " listeners is reached");
  if (added == Listeners::Added::kAgain)
    module_.log().warning("Listener {} is already in list", mailbox);
  return {};
}

Result<void> DataModuleBase::Publisher::stop_cont_data(const tims::MessageView& message) {
  const auto request = decode<StopContDataRequest>(message);
  if (!request) return request.error();
  {
    const std::lock_guard lock(module_.mutex_);
    listeners_.remove(request->dataMbxAdr);
  }
  module_.reply(message.header, tims::type::kOk);
  return {};
}

ListenersData DataModuleBase::Publisher::listeners() const {
  const std::lock_guard lock(module_.mutex_);
  ListenersData data{.periodTime = period_ms_, .dataSets = data_sets_};
  for (const Listener& listener : listeners_.all()) {
    if (data.listeners.size() == decltype(data.listeners)::kMax) break;
    data.listeners.push_back({.mailbox = listener.mailbox,
                              .periodTime = listener.reduction * period_ms_,
                              .priority = listener.priority});
  }
  return data;
}

Result<void> DataModuleBase::Publisher::get_next_data(const tims::MessageView& message) {
  const std::uint32_t ends = ends_of_streams();
  if (!module_.is_on()) return module_.no_data();
  const auto added = add(message.header, ends, [&](tims::Address source) {
    return listeners_.add_once(message.header, source, tims::os::now());
  });
  if (!added) return added.error();
  if (*added == Listeners::Added::kFull) return check_added(*added, message.header.src);
  return {};
}

}  // namespace rack
