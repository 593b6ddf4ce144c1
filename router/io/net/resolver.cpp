#include "router/io/net/resolver.h"

#include <algorithm>
#include <csignal>
#include <optional>
#include <system_error>
#include <utility>

#include <netdb.h>
#include <resolv.h>

#include "os/wakeup.h"
#include "router/io/net/addresses.h"

namespace tims::io {
namespace {

using link::NetAddress;

constexpr int kNameServerSeconds = 1;  // timeout of one query; the caller retries
constexpr int kNameServersMax = 2;

// For this thread. Read again each time: name servers change when a robot joins another network.
void limit_name_servers() {
  ::res_init();
  _res.retrans = kNameServerSeconds;
  _res.retry = 1;
  _res.nscount = std::min(_res.nscount, kNameServersMax);
}

Error not_found(const std::string& host, int code) {
  const std::string what = "host name " + host;
  return code == EAI_SYSTEM ? os::system_error(what)
                            : Error(Errc::kSystem, what + ": " + ::gai_strerror(code));
}

Result<Resolver::Addresses> look_up(const std::string& host, std::uint16_t port) {
  limit_name_servers();
  addrinfo hints{};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int code = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
  if (code != 0) return not_found(host, code);
  Resolver::Addresses addresses;
  for (const addrinfo* info = found; info != nullptr; info = info->ai_next) {
    NetAddress address = net_address(*info);
    address.port = port;
    if (std::ranges::find(addresses, address) == addresses.end()) addresses.push_back(address);
  }
  ::freeaddrinfo(found);
  return addresses;
}

// Rejects texts that cannot be names.
std::optional<Error> refusal(const std::string& host) {
  if (host.empty()) return Error(Errc::kInvalidArgument, "host name: empty");
  if (host.find_first_of(":%") != std::string::npos) {
    return Error(
        Errc::kInvalidArgument,
        "host name " + host + ": neither a name nor an address; does its interface exist?");
  }
  return std::nullopt;
}

}  // namespace

Resolver::~Resolver() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  asked_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Resolver::resolve(const std::string& host, std::uint16_t port, Callback callback) {
  if (const auto address = numeric_address(host, port)) return callback(Addresses{*address});
  if (const auto error = refusal(host)) return callback(*error);
  if (!thread_.joinable()) {
    if (const auto started = start_thread(); !started) return callback(started.error());
  }
  const Question question{host, port};
  auto& callbacks = waiting_[question];
  callbacks.push_back(std::move(callback));
  if (callbacks.size() == 1) ask(question);
}

void Resolver::ask(const Question& question) {
  {
    const std::lock_guard lock(mutex_);
    questions_.push_back(question);
  }
  asked_.notify_one();
}

Result<void> Resolver::start_thread() {
  if (!answered_) {
    auto file = os::make_event_fd();
    if (!file) return file.error();
    answered_ = std::move(file).value();
    watch_.emplace(loop_, answered_.get(), [this](Ready) { take_answers(); });
  }
  // Signals belong to the loop's thread: this thread starts with all of them blocked.
  sigset_t all;
  sigset_t before;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &before);
  Result<void> started;
  try {
    thread_ = std::thread([this] { work(); });
  } catch (const std::system_error& error) {
    started = Error(Errc::kSystem,
                    std::string("cannot start the thread for host names: ") + error.what());
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return started;
}

void Resolver::take_answers() {
  os::drain_event_fd(answered_.get());
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mutex_);
    answers.swap(answers_);
  }
  for (const Answer& answer : answers) {
    const auto node = waiting_.extract(answer.question);
    for (const Callback& callback : node.mapped()) callback(answer.result);
  }
}

void Resolver::work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    asked_.wait(lock, [this] { return ending_ || !questions_.empty(); });
    if (ending_) return;
    Question question = std::move(questions_.front());
    questions_.pop_front();
    lock.unlock();
    auto result = look_up(question.host, question.port);
    lock.lock();
    answers_.push_back({std::move(question), std::move(result)});
    os::signal_event_fd(answered_.get());
  }
}

}  // namespace tims::io
