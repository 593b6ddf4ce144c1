#include "tools/camera_calibrate/living_camera.h"

#include <algorithm>

#include <fmt/core.h>

#include "os/clock.h"
#include "os/environment.h"
#include "rack/proxies/generic.h"
#include "tims/session.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"

namespace rack::camera_calibrate {
namespace {

using timsctl::Exit;
using timsctl::Failure;

std::unique_ptr<timsctl::Connection> connect(const std::string& host, tims::Duration timeout) {
  std::string router_text = host.empty() ? tims::os::environment("TIMS_HOST") : host;
  if (router_text.empty()) router_text = tims::default_router();
  const timsctl::Host router = timsctl::parse_host(router_text);
  const timsctl::MailboxRequest request{
      .address = {}, .slots = 2, .body_max = body_max<CameraData>()};
  if (const auto* tcp = std::get_if<timsctl::TcpHost>(&router))
    return timsctl::connect_tcp(*tcp, request, timeout);
  return timsctl::connect_local(std::get<timsctl::UnixHost>(router), request, timeout,
                                [](const std::string&) {});
}

}  // namespace

LivingCamera::LivingCamera(const std::string& camera, const std::string& host,
                           tims::Duration timeout, const timsctl::Signals& signals)
    : signals_(signals),
      timeout_(timeout),
      connection_(connect(host, timeout)),
      camera_(timsctl::need_address(camera, connection_->widths())) {
  if (camera_.fields(connection_->widths()).class_id != tims::class_id::kCamera)
    throw timsctl::usage_error(name() + " is not a Camera",
                               "`timsctl component list` shows all components");
  picture_.image.reserve_all();
  refuse_rectified();
}

std::string LivingCamera::name() const {
  return timsctl::shell_name(camera_, connection_->widths());
}

timsctl::Message LivingCamera::ask(std::int8_t type) {
  const std::uint8_t seq_nr = connection_->next_seq_nr();
  const std::uint64_t losses = connection_->losses();
  timsctl::value_or_fail(
      connection_->send({.dest = camera_, .type = type, .seq_nr = seq_nr, .report_reason = true},
                        {}),
      name());
  const tims::Time deadline = tims::os::deadline_after(timeout_);
  while (auto message = timsctl::receive(*connection_, signals_, deadline, losses)) {
    if (message->header.src != camera_ || message->header.seq_nr != seq_nr) continue;
    if (message->header.type == tims::type::kNotAvailable)
      throw timsctl::no_such_mailbox(name(), "`timsctl component list` shows all");
    return std::move(*message);
  }
  throw Failure(Exit::kTimeout, "timeout", name() + " did not answer",
                "try a longer --timeout; `timsctl explain` shows whether it can be reached");
}

// The calibration of rectified pictures would describe a lens that the pictures do not have.
void LivingCamera::refuse_rectified() {
  const timsctl::Message answer = ask(tims::type::kGetParam);
  const auto list = decode<ParameterList>(answer.view());
  if (!list) return;  // an original program
  const auto found = std::ranges::find_if(
      list->parameters, [](const Parameter& one) { return one.name.view() == "calibration"; });
  if (found == list->parameters.end() || found->valueString.view().empty()) return;
  throw Failure(
      Exit::kNo, "rectified",
      fmt::format("{} rectifies its pictures already: calibration={}", name(),
                  found->valueString.view()),
      fmt::format("set it to an empty text: timsctl component param set {} calibration \"\", "
                  "then turn the camera off and on",
                  name()));
}

const CameraData& LivingCamera::next() {
  const timsctl::Message answer = ask(tims::type::kGetNextData);
  if (answer.header.type != tims::type::kData) {
    const std::string_view reason = reason_of(answer.body);
    throw Failure(
        Exit::kNo, "off",
        fmt::format("{} sends no pictures{}{}", name(), reason.empty() ? "" : ": ", reason),
        fmt::format("turn it on: timsctl component on {}", name()));
  }
  timsctl::value_or_fail(decode_data(answer.view(), camera_, picture_), name());
  return picture_;
}

}  // namespace rack::camera_calibrate
