// Transport to USB devices without a kernel driver: bytes in bulk transfers of libusb.
//
//   usb:15d1:0000            usb:15d1:0000/H0712345   (vendor:product, serial number)
//
// Uses the first interface with a bulk endpoint for each direction. A kernel driver bound to it is
// detached while the device is open.
#include <algorithm>
#include <array>
#include <cerrno>
#include <optional>
#include <utility>
#include <vector>

#include <libusb.h>
#include <poll.h>
#include <sys/epoll.h>

#include "base/text.h"
#include "components/devices/io/transports.h"
#include "os/clock.h"
#include "os/file.h"

namespace rack::device {
namespace {

using tims::Errc;
using tims::Error;
using tims::Result;
using tims::os::File;
using tims::os::system_error;

constexpr std::size_t kTransferBytes = 16384;
constexpr std::size_t kReads = 4;  // pending read transfers
constexpr std::size_t kWrites = 16;

Error usb_error(const std::string& what, int code) {
  std::string text = what + ": " + ::libusb_strerror(code);
  if (code == LIBUSB_ERROR_ACCESS) text += "; a udev rule must grant the user access";
  if (code == LIBUSB_ERROR_BUSY) text += "; another program uses the device";
  return {Errc::kSystem, std::move(text)};
}

struct Endpoints {
  int interface = 0;
  unsigned char in = 0;
  unsigned char out = 0;
};

std::optional<Endpoints> bulk_endpoints(libusb_device* device) {
  libusb_config_descriptor* config = nullptr;
  if (::libusb_get_active_config_descriptor(device, &config) != 0) return std::nullopt;
  std::optional<Endpoints> found;
  for (const libusb_interface& interface : std::span(config->interface, config->bNumInterfaces)) {
    if (interface.num_altsetting < 1 || found) continue;
    const libusb_interface_descriptor& first = interface.altsetting[0];
    Endpoints ends{.interface = first.bInterfaceNumber};
    for (const libusb_endpoint_descriptor& end : std::span(first.endpoint, first.bNumEndpoints)) {
      if ((end.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_BULK) continue;
      const bool is_in = (end.bEndpointAddress & LIBUSB_ENDPOINT_DIR_MASK) == LIBUSB_ENDPOINT_IN;
      (is_in ? ends.in : ends.out) = end.bEndpointAddress;
    }
    if (ends.in != 0 && ends.out != 0) found = ends;
  }
  ::libusb_free_config_descriptor(config);
  return found;
}

std::string serial_number(libusb_device_handle* handle, std::uint8_t index) {
  std::array<unsigned char, 256> text{};
  if (index == 0) return "";
  const int size = ::libusb_get_string_descriptor_ascii(handle, index, text.data(), text.size());
  return size <= 0 ? "" : std::string(text.begin(), text.begin() + size);
}

// Contains the libusb context. Callbacks keep a pointer to this object, so it cannot be moved.
class UsbDevice final : public Transport {
 public:
  explicit UsbDevice(std::string description) : description_(std::move(description)) {}
  ~UsbDevice() override { close(); }

  Result<void> open(const DeviceAddress& address) {
    if (const int bad = ::libusb_init(&context_); bad != 0) return usb_error("USB", bad);
    const std::string& place = address.place;
    const auto vendor = *tims::base::parse_number<std::uint16_t>(place.substr(0, 4), 16);
    const auto product = *tims::base::parse_number<std::uint16_t>(place.substr(5, 4), 16);
    const std::string serial = place.size() > 10 ? place.substr(10) : "";
    if (auto found = find(vendor, product, serial); !found) return found;
    ::libusb_set_auto_detach_kernel_driver(handle_, 1);
    const auto ends = bulk_endpoints(::libusb_get_device(handle_));
    if (!ends)
      return Error(Errc::kInvalidArgument, description_ + " has no interface for bulk transfers");
    ends_ = *ends;
    if (const int bad = ::libusb_claim_interface(handle_, ends_.interface); bad != 0)
      return usb_error(description_, bad);
    is_claimed_ = true;
    if (auto watched = watch(); !watched) return watched;
    return start_reading();
  }

  [[nodiscard]] int descriptor() const override { return epoll_.get(); }
  [[nodiscard]] Time next_timeout() const override { return next_timeout_; }
  [[nodiscard]] std::string description() const override { return description_; }

  Result<void> receive(Time now, const Receive& receive) override {
    handle_events();
    // Transfers complete in the order in which they were submitted.
    while (reads_[next_read_].is_done) {
      Transfer& transfer = reads_[next_read_];
      transfer.is_done = false;
      const auto size = static_cast<std::size_t>(std::max(0, transfer.transfer->actual_length));
      if (size > 0)
        receive({.bytes = std::span(transfer.bytes).first(size), .first = now, .last = now});
      if (transfer.transfer->status == LIBUSB_TRANSFER_NO_DEVICE) return gone();
      if (transfer.transfer->status == LIBUSB_TRANSFER_STALL)
        (void)::libusb_clear_halt(handle_, ends_.in);
      submit(transfer);
      next_read_ = (next_read_ + 1) % kReads;
    }
    next_timeout_ = now + timeout_of_library();
    if (is_gone_) return gone();
    return {};
  }

  Result<bool> send(Time, std::span<const std::byte> bytes, std::uint32_t) override {
    if (is_gone_) return gone();
    const auto free = std::ranges::find(writes_, false, &Transfer::is_pending);
    if (free == writes_.end() || bytes.size() > kTransferBytes) {
      handle_events();
      return false;
    }
    std::ranges::copy(bytes, free->bytes.begin());
    free->transfer->length = static_cast<int>(bytes.size());
    submit(*free);
    return free->is_pending;
  }

 private:
  struct Transfer {
    UsbDevice* device = nullptr;
    libusb_transfer* transfer = nullptr;
    std::vector<std::byte> bytes = std::vector<std::byte>(kTransferBytes);
    bool is_pending = false;
    bool is_done = false;  // complete but not yet processed
  };

  Result<void> find(std::uint16_t vendor, std::uint16_t product, const std::string& serial) {
    libusb_device** list = nullptr;
    const ssize_t count = ::libusb_get_device_list(context_, &list);
    if (count < 0) return usb_error("USB", static_cast<int>(count));
    Error problem(Errc::kSystem,
                  "no " + description_ + "; check that it is plugged in: timsctl device list");
    for (libusb_device* const device : std::span(list, static_cast<std::size_t>(count))) {
      libusb_device_descriptor about{};
      if (handle_ != nullptr || ::libusb_get_device_descriptor(device, &about) != 0 ||
          about.idVendor != vendor || about.idProduct != product)
        continue;
      if (const int bad = ::libusb_open(device, &handle_); bad != 0) {
        problem = usb_error(description_, bad);
        continue;
      }
      const std::string its_own = serial_number(handle_, about.iSerialNumber);
      if (serial.empty() || its_own == serial) continue;
      problem =
          Error(Errc::kSystem, "no " + description_ + "; the device found has serial number " +
                                   tims::base::in_quotes(its_own));
      ::libusb_close(std::exchange(handle_, nullptr));
    }
    ::libusb_free_device_list(list, 1);
    if (handle_ == nullptr) return problem;
    return {};
  }

  // Combines all descriptors of libusb in one epoll descriptor.
  Result<void> watch() {
    epoll_ = File(::epoll_create1(EPOLL_CLOEXEC));
    if (!epoll_) return system_error("epoll");
    const libusb_pollfd** const files = ::libusb_get_pollfds(context_);
    for (const libusb_pollfd** file = files; file != nullptr && *file != nullptr; ++file)
      add_file((*file)->fd, (*file)->events, this);
    ::libusb_free_pollfds(files);
    ::libusb_set_pollfd_notifiers(context_, add_file, remove_file, this);
    return {};
  }
  static void add_file(int file, short events, void* self) {
    epoll_event event{};
    event.events =
        ((events & POLLIN) != 0 ? EPOLLIN : 0U) | ((events & POLLOUT) != 0 ? EPOLLOUT : 0U);
    ::epoll_ctl(static_cast<UsbDevice*>(self)->epoll_.get(), EPOLL_CTL_ADD, file, &event);
  }
  static void remove_file(int file, void* self) {
    ::epoll_ctl(static_cast<UsbDevice*>(self)->epoll_.get(), EPOLL_CTL_DEL, file, nullptr);
  }

  Result<void> start_reading() {
    for (auto* const all : {&reads_, &writes_}) {
      const unsigned char end = all == &reads_ ? ends_.in : ends_.out;
      all->resize(all == &reads_ ? kReads : kWrites);
      for (Transfer& transfer : *all) {
        transfer.device = this;
        transfer.transfer = ::libusb_alloc_transfer(0);
        if (transfer.transfer == nullptr)
          return Error(Errc::kSystem, "no memory for USB transfers");
        ::libusb_fill_bulk_transfer(transfer.transfer, handle_, end,
                                    reinterpret_cast<unsigned char*>(transfer.bytes.data()),
                                    static_cast<int>(kTransferBytes), on_done, &transfer, 0);
      }
    }
    for (Transfer& transfer : reads_) submit(transfer);
    if (is_gone_) return gone();
    return {};
  }

  void submit(Transfer& transfer) {
    const int bad = ::libusb_submit_transfer(transfer.transfer);
    transfer.is_pending = bad == 0;
    if (bad != 0) is_gone_ = true;
  }
  static void LIBUSB_CALL on_done(libusb_transfer* transfer) {
    auto& done = *static_cast<Transfer*>(transfer->user_data);
    done.is_pending = false;
    done.is_done = true;
    if (transfer->status == LIBUSB_TRANSFER_NO_DEVICE) done.device->is_gone_ = true;
  }

  void handle_events() {
    timeval none{};
    (void)::libusb_handle_events_timeout_completed(context_, &none, nullptr);
  }
  Duration timeout_of_library() {
    timeval next{};
    if (::libusb_get_next_timeout(context_, &next) != 1) return std::chrono::hours(1);
    return std::chrono::seconds(next.tv_sec) + std::chrono::microseconds(next.tv_usec);
  }
  [[nodiscard]] Error gone() const { return {Errc::kSystem, description_ + " is gone"}; }

  void close() {
    for (auto* const all : {&reads_, &writes_})
      for (Transfer& transfer : *all)
        if (transfer.is_pending) (void)::libusb_cancel_transfer(transfer.transfer);
    const auto pending = [](const Transfer& transfer) { return transfer.is_pending; };
    const Time end = tims::os::now() + std::chrono::milliseconds(200);
    while ((std::ranges::any_of(reads_, pending) || std::ranges::any_of(writes_, pending)) &&
           tims::os::now() < end) {
      timeval short_while{.tv_sec = 0, .tv_usec = 10'000};
      (void)::libusb_handle_events_timeout_completed(context_, &short_while, nullptr);
    }
    for (auto* const all : {&reads_, &writes_})
      for (Transfer& transfer : *all)
        if (transfer.transfer != nullptr && !transfer.is_pending)
          ::libusb_free_transfer(transfer.transfer);
    if (is_claimed_) (void)::libusb_release_interface(handle_, ends_.interface);
    if (handle_ != nullptr) ::libusb_close(handle_);
    if (context_ != nullptr) {
      ::libusb_set_pollfd_notifiers(context_, nullptr, nullptr, nullptr);
      ::libusb_exit(context_);
    }
  }

  std::string description_;
  libusb_context* context_ = nullptr;
  libusb_device_handle* handle_ = nullptr;
  Endpoints ends_;
  bool is_claimed_ = false;
  bool is_gone_ = false;
  File epoll_;
  Time next_timeout_ = tims::kNever;
  std::vector<Transfer> reads_;
  std::size_t next_read_ = 0;
  std::vector<Transfer> writes_;
};

}  // namespace

Result<std::unique_ptr<Transport>> open_usb(const DeviceAddress& address) {
  auto device = std::make_unique<UsbDevice>("USB device " + address.place);
  if (auto opened = device->open(address); !opened) return opened.error();
  return std::unique_ptr<Transport>(std::move(device));
}

}  // namespace rack::device
