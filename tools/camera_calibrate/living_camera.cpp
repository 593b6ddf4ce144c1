#include "tools/camera_calibrate/living_camera.h"

#include <algorithm>

#include <fmt/core.h>

#include "rack/proxies/generic.h"
#include "tools/cli/arguments.h"
#include "tools/cli/failure.h"

namespace rack::camera_calibrate {
namespace {

using timsctl::Exit;
using timsctl::Failure;

}  // namespace

LivingCamera::LivingCamera(const std::string& camera, const std::string& host,
                           tims::Duration timeout, const timsctl::Signals& signals)
    : signals_(signals),
      timeout_(timeout),
      connection_(timsctl::connect(timsctl::host_of(host),
                                   {.address = {}, .slots = 2, .body_max = body_max<CameraData>()},
                                   timeout)),
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
  return timsctl::ask(*connection_, signals_, camera_, type, {}, timeout_);
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
