#include "tools/camera_calibrate/collect.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <system_error>

#include <fmt/core.h>
#include <unistd.h>

#include "components/files/whole_file.h"
#include "os/clock.h"
#include "os/file.h"
#include "tools/camera_calibrate/board_finder.h"
#include "tools/camera_calibrate/calibrate.h"
#include "tools/camera_calibrate/grey_image.h"
#include "tools/camera_calibrate/living_camera.h"
#include "tools/cli/failure.h"

namespace rack::camera_calibrate {
namespace {

namespace fs = std::filesystem;
using timsctl::Exit;
using timsctl::Failure;

constexpr std::size_t kFileBytesMax = 256U << 20;
constexpr std::size_t kFilesMax = 2000;

bool is_picture(const fs::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<std::string_view, 4> kExtensions = {".png", ".pgm", ".jpg", ".jpeg"};
  return std::ranges::find(kExtensions, extension) != kExtensions.end();
}

std::vector<std::string> pictures_in(const std::string& folder) {
  std::vector<std::string> found;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (is_picture(entry->path())) found.push_back(entry->path().string());
  if (error)
    throw Failure(Exit::kNoSuch, "no_such_file", fmt::format("{}: {}", folder, error.message()));
  if (found.empty())
    throw Failure(Exit::kNoSuch, "no_such_file",
                  folder + ": no pictures (.png, .pgm, .jpg) in this folder");
  std::ranges::sort(found);
  return found;
}

std::vector<std::string> expanded(const std::vector<std::string>& arguments) {
  std::vector<std::string> files;
  for (const std::string& argument : arguments) {
    std::error_code ignored;
    if (!fs::is_directory(argument, ignored)) {
      files.push_back(argument);
      continue;
    }
    for (std::string& file : pictures_in(argument)) files.push_back(std::move(file));
  }
  if (files.size() > kFilesMax)
    throw timsctl::usage_error(fmt::format(
        "{} pictures; at most {} are possible, 15 to 30 are enough", files.size(), kFilesMax));
  return files;
}

GreyImage read_picture(const std::string& file) {
  const auto bytes = tims::os::read_file(file, kFileBytesMax);
  if (!bytes) throw Failure(Exit::kNoSuch, "no_such_file", bytes.error().detail());
  auto image = grey_of_file(*bytes);
  if (!image)
    throw Failure(Exit::kNo, "bad_file", fmt::format("{}: {}", file, image.error().detail()));
  return std::move(*image);
}

void check_size(CollectedViews& collected, const GreyImage& image, const std::string& name) {
  if (collected.width == 0) {
    collected.width = image.width;
    collected.height = image.height;
  }
  if (image.width != collected.width || image.height != collected.height)
    throw Failure(Exit::kNo, "bad_file",
                  fmt::format("{} has {}x{} pixels, pictures before it {}x{}", name, image.width,
                              image.height, collected.width, collected.height),
                  "a calibration needs pictures of one size of one camera");
}

// A view that was taken is kept as a picture, so that the calibration can be repeated.
void save(const std::string& folder, std::size_t number, const GreyImage& image) {
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  const std::string file = fmt::format("{}/view{:03}.png", folder, number);
  const auto png = timsctl::value_or_fail(png_of(image), file);
  if (const auto written = rack::write_file(file, png); !written)
    throw Failure(Exit::kDenied, "not_written", written.error().detail());
}

std::string text_of(const std::vector<std::string>& missing) {
  if (missing.empty()) return "nothing is missing";
  if (missing.size() == 1) return missing.front();
  return fmt::format("{} ({} more to do)", missing.front(), missing.size() - 1);
}

std::string text_of(std::optional<ViewCollector::Verdict> verdict) {
  if (!verdict) return "no board is seen";
  switch (*verdict) {
    case ViewCollector::Verdict::kTaken:
      return "taken";
    case ViewCollector::Verdict::kMoving:
      return "hold it still";
    default:
      return "there is a view like this one";
  }
}

}  // namespace

CollectProgress::CollectProgress(bool is_quiet)
    : is_quiet_(is_quiet), is_terminal_(!is_quiet && ::isatty(STDERR_FILENO) == 1) {}

CollectProgress::~CollectProgress() {
  if (is_terminal_) fmt::print(stderr, "\r\033[K");
}

void CollectProgress::show(const std::string& text, bool is_step) {
  if (is_quiet_ || text == last_) return;
  if (is_terminal_)
    fmt::print(stderr, "\r\033[Kcamera-calibrate: {}", text);
  else if (is_step)
    fmt::print(stderr, "camera-calibrate: {}\n", text);
  last_ = text;
}

CollectedViews views_of_files(const std::vector<std::string>& arguments, const Board& board,
                              const timsctl::Signals& signals, CollectProgress& progress) {
  CollectedViews collected;
  const std::vector<std::string> files = expanded(arguments);
  for (std::size_t i = 0; i < files.size(); ++i) {
    signals.sleep_until(tims::os::now());  // Ctrl-C
    const std::string& file = files[i];
    progress.show(fmt::format("{} of {}: {}", i + 1, files.size(), file), false);
    const GreyImage image = read_picture(file);
    check_size(collected, image, file);
    if (auto points = find_board(image, board))
      collected.views.push_back({.name = file, .points = std::move(*points)});
    else
      collected.without_board.push_back(file);
  }
  return collected;
}

CollectedViews views_of_camera(const LiveCollection& wanted, const Board& board,
                               const timsctl::Signals& signals, CollectProgress& progress) {
  LivingCamera camera(wanted.camera, wanted.host, wanted.timeout, signals);
  CollectedViews collected;
  std::optional<ViewCollector> collector;
  const tims::Time end = wanted.duration > tims::Duration(0)
                             ? tims::os::deadline_after(wanted.duration)
                             : tims::kNever;
  for (;;) {
    const GreyImage image = timsctl::value_or_fail(grey_of(camera.next()), camera.name());
    check_size(collected, image, "a picture");
    if (!collector) collector.emplace(board, image.width, image.height);
    std::optional<ViewCollector::Verdict> verdict;
    const std::size_t number = collector->views().size() + 1;
    if (const auto points = find_board(image, board))
      verdict = collector->offer(*points, fmt::format("view {}", number));
    else
      collector->offer_nothing();
    if (verdict == ViewCollector::Verdict::kTaken) save(wanted.folder, number, image);
    const auto missing = collector->missing();
    const std::size_t taken = collector->views().size();
    progress.show(fmt::format("{} of {} views; {}; {}", taken, wanted.views, text_of(verdict),
                              text_of(missing)),
                  verdict == ViewCollector::Verdict::kTaken);
    const bool is_complete = taken >= wanted.views && missing.empty();
    if (is_complete || taken >= 2 * wanted.views || tims::os::now() >= end) break;
  }
  collected.views = collector->views();
  if (collected.views.size() < kCalibrationViewsMin)
    throw Failure(Exit::kTimeout, "too_few_views",
                  fmt::format("{} views of the board in this time; at least {} are needed",
                              collected.views.size(), kCalibrationViewsMin),
                  text_of(collector->missing()) +
                      "; are --board and --size those of the board? Count the inner corners");
  return collected;
}

}  // namespace rack::camera_calibrate
