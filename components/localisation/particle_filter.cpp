#include "components/localisation/particle_filter.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace rack::localisation {

namespace {

constexpr float kBinSize = 500;                            // mm
constexpr float kBinAngle = static_cast<float>(kPi / 12);  // rad
constexpr std::int32_t kBinAngles = 24;
constexpr float kTurn = static_cast<float>(2 * kPi);
constexpr double kClusterRadius = 1000;  // mm
constexpr double kClusterAngle = kPi / 6;
constexpr std::uint32_t kTriesAtStart = 20;
// Draws for all particles that one step of the recovery replaces: when they are few, each is the
// best of many draws.
constexpr std::size_t kDrawsInRecovery = 25000;
constexpr std::size_t kTriesInRecoveryMost = 500;
constexpr std::uint32_t kTriesNearby = 30;
constexpr std::size_t kJumpShare = 5;  // a fifth of the cloud
constexpr double kInjectedShareMax = 0.5;
constexpr std::size_t kInjectedMax = 500;  // a step, to limit its time

std::int32_t angle_bin(float rho) {
  const float turns = rho / kTurn;
  const auto bin = static_cast<std::int32_t>((turns - std::floor(turns)) * kBinAngles);
  return std::min(bin, kBinAngles - 1);
}

// Whether a particle belongs to the cluster around a pose.
struct ClusterOf {
  explicit ClusterOf(const Pose& middle)
      : x(static_cast<float>(middle.x)),
        y(static_cast<float>(middle.y)),
        sine(static_cast<float>(std::sin(middle.rho))),
        cosine(static_cast<float>(std::cos(middle.rho))) {}
  // `dx`, `dy`: distance from the centre; sine and cosine of the particle's heading.
  bool operator()(float dx, float dy, float its_sine, float its_cosine) const {
    constexpr auto kSquare = static_cast<float>(kClusterRadius * kClusterRadius);
    return dx * dx + dy * dy <= kSquare && cosine * its_cosine + sine * its_sine >= least_cosine;
  }
  float x;
  float y;
  float sine;
  float cosine;
  float least_cosine = static_cast<float>(std::cos(kClusterAngle));
};

}  // namespace

StepNoise noise_of(const FilterSettings& settings, double distance, double turn) {
  return {.along = settings.distance_least + settings.along_by_distance * distance,
          .across = settings.distance_least + settings.side_by_distance * distance,
          .turn = settings.turn_least + settings.turn_by_turn * turn +
                  settings.turn_by_distance * distance / 1000};
}

PoseBins::PoseBins(std::size_t poses_max) : bins_(std::bit_ceil(4 * poses_max)) {
  used_.reserve(poses_max);
}

void PoseBins::clear() {
  used_.clear();
  count_ = 0;
  if (++stamp_ == 0) {  // wrapped around
    std::ranges::fill(bins_, Bin{});
    stamp_ = 1;
  }
}

std::size_t PoseBins::place(std::int32_t x, std::int32_t y, std::int32_t rho) const {
  std::uint64_t key = static_cast<std::uint32_t>(x) * 0x9E3779B97F4A7C15U;
  key = (key ^ static_cast<std::uint32_t>(y)) * 0xBF58476D1CE4E5B9U;
  key = (key ^ static_cast<std::uint32_t>(rho)) * 0x94D049BB133111EBU;
  std::size_t at = (key ^ key >> 31U) & (bins_.size() - 1);
  while (bins_[at].stamp == stamp_ &&
         (bins_[at].x != x || bins_[at].y != y || bins_[at].rho != rho))
    at = (at + 1) & (bins_.size() - 1);
  return at;
}

void PoseBins::add(float x, float y, float rho, float weight) {
  const auto bx = static_cast<std::int32_t>(std::floor(x / kBinSize));
  const auto by = static_cast<std::int32_t>(std::floor(y / kBinSize));
  const std::int32_t br = angle_bin(rho);
  const std::size_t at = place(bx, by, br);
  if (bins_[at].stamp != stamp_) {
    bins_[at] = {stamp_, 0, bx, by, br};
    used_.push_back(static_cast<std::uint32_t>(at));
    ++count_;
  }
  bins_[at].weight += weight;
}

float PoseBins::weight(std::int32_t x, std::int32_t y, std::int32_t rho) const {
  const Bin& bin = bins_[place(x, y, (rho + kBinAngles) % kBinAngles)];
  return bin.stamp == stamp_ ? bin.weight : 0;
}

PoseBins::Heaviest PoseBins::heaviest() const {
  const Bin* best = nullptr;
  float most = -1;
  for (const std::uint32_t at : used_) {
    const Bin& bin = bins_[at];
    if (9 * bin.weight < most) continue;
    float around = 0;
    for (std::int32_t x = -1; x <= 1; ++x)
      for (std::int32_t y = -1; y <= 1; ++y)
        for (std::int32_t r = -1; r <= 1; ++r) around += weight(bin.x + x, bin.y + y, bin.rho + r);
    around += bin.weight;  // prefers the bin in the middle of its neighbours
    if (around <= most) continue;
    most = around;
    best = &bin;
  }
  if (best == nullptr) return {};
  return {{.x = (static_cast<double>(best->x) + 0.5) * kBinSize,
           .y = (static_cast<double>(best->y) + 0.5) * kBinSize,
           .rho = (best->rho + 0.5) * kBinAngle},
          most};
}

ParticleFilter::ParticleFilter(const FilterSettings& settings, std::uint64_t seed)
    : settings_(settings),
      random_(seed),
      bins_(std::max(settings.particles, settings.particles_max)) {
  settings_.particles = std::max<std::uint32_t>(1, settings.particles);
  settings_.particles_max = std::max(settings_.particles, settings.particles_max);
  for (auto* field : {&x_, &y_, &rho_, &sine_, &cosine_, &weight_, &next_.x, &next_.y, &next_.rho,
                      &next_.sine, &next_.cosine})
    field->reserve(settings_.particles_max);
  start_at({}, 0, 0);
}

void ParticleFilter::clear() {
  x_.clear();
  y_.clear();
  rho_.clear();
  sine_.clear();
  cosine_.clear();
}

void ParticleFilter::even_weights() {
  weight_.assign(x_.size(), 1.0F / static_cast<float>(x_.size()));
  effective_ = static_cast<double>(x_.size());
}

void ParticleFilter::set(std::size_t i, float x, float y, float rho) {
  x_[i] = x;
  y_[i] = y;
  rho_[i] = rho > kTurn ? rho - kTurn : rho < 0 ? rho + kTurn : rho;  // floats near 0 are fine
  sine_[i] = std::sin(rho);
  cosine_[i] = std::cos(rho);
}

void ParticleFilter::add(float x, float y, float rho) {
  for (auto* field : {&x_, &y_, &rho_, &sine_, &cosine_}) field->push_back(0);
  set(x_.size() - 1, x, y, rho);
}

// The number of particles that KLD sampling requires for the occupied bins.
void ParticleFilter::start_at(const Pose& pose, double deviation, double deviation_rho) {
  clear();
  bins_.clear();
  while (x_.size() < wanted_size()) {
    const auto around = [&](double middle, double by) {
      return static_cast<float>(middle + by * static_cast<double>(random_.normal()));
    };
    const float x = around(pose.x, deviation);
    const float y = around(pose.y, deviation);
    const float rho = around(pose.rho, deviation_rho);
    add(x, y, rho);
    bins_.add(x, y, rho, 0);
  }
  even_weights();
  slow_ = fast_ = 0;
}

void ParticleFilter::start_anywhere(const LikelihoodField& field, const Beams& beams) {
  clear();
  for (std::uint32_t i = 0; i < settings_.particles_max; ++i)
    add_fitting(field, beams, kTriesAtStart, [&] { return anywhere(field); });
  even_weights();
  slow_ = fast_ = 0;
}

ParticleFilter::Draw ParticleFilter::anywhere(const LikelihoodField& field) {
  const MapPoint place = field.draw_free(random_);
  return {static_cast<float>(place.x), static_cast<float>(place.y), random_.uniform(0, kTurn)};
}

ParticleFilter::Draw ParticleFilter::near(std::size_t particle) {
  const auto within = [&](double most) {
    return random_.uniform(static_cast<float>(-most), static_cast<float>(most));
  };
  return {x_[particle] + within(settings_.jump_distance),
          y_[particle] + within(settings_.jump_distance),
          rho_[particle] + within(settings_.jump_turn)};
}

template <typename Source>
void ParticleFilter::add_fitting(const LikelihoodField& field, const Beams& beams,
                                 std::uint32_t tries, const Source& source) {
  std::uint32_t most = 0;
  Draw best{};
  for (std::uint32_t i = 0; i < tries; ++i) {
    const Draw draw = source();
    const std::uint32_t sum =
        field.sum(draw.x, draw.y, std::sin(draw.rho), std::cos(draw.rho), beams);
    if (i > 0 && sum <= most) continue;
    most = sum;
    best = draw;
  }
  add(best.x, best.y, best.rho);
}

void ParticleFilter::move(const Pose& step) {
  const StepNoise noise =
      noise_of(settings_, std::hypot(step.x, step.y), std::abs(signed_angle(step.rho)));
  const auto deviation_turn = static_cast<float>(noise.turn);
  const auto deviation_along = static_cast<float>(noise.along);
  const auto deviation_side = static_cast<float>(noise.across);
  const auto dx = static_cast<float>(step.x);
  const auto dy = static_cast<float>(step.y);
  const auto dr = static_cast<float>(signed_angle(step.rho));
  const auto slipping =
      static_cast<std::size_t>(settings_.slip_share * static_cast<double>(x_.size()));
  // The particles that slip are a range that begins at a random index: copies of a particle are
  // neighbours, so that a fixed stride would favour some of them.
  const std::size_t every =
      slipping == 0 ? x_.size() + 1 : std::max<std::size_t>(1, x_.size() / slipping);
  const std::size_t first = random_.below(static_cast<std::uint32_t>(every));
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const float times = i % every == first ? static_cast<float>(settings_.slip_times) : 1.0F;
    const float turned = times * deviation_turn * random_.normal();
    const float along = dx + times * deviation_along * random_.normal();
    // Half of the excess rotation happens before the translation.
    const float across = dy + times * deviation_side * random_.normal() + 0.5F * turned * dx;
    set(i, x_[i] + cosine_[i] * along - sine_[i] * across,
        y_[i] + sine_[i] * along + cosine_[i] * across, rho_[i] + dr + turned);
  }
}

void ParticleFilter::weigh(const LikelihoodField& field, const Beams& beams) {
  injected_ = 0;
  if (beams.empty()) return;
  const float scale = 1 / (255.0F * static_cast<float>(beams.size()));
  const auto sharpness = static_cast<float>(settings_.sharpness);
  double fit = 0;
  double all = 0;
  double squares = 0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const float fits =
        scale * static_cast<float>(field.sum(x_[i], y_[i], sine_[i], cosine_[i], beams));
    weight_[i] *= std::exp(sharpness * (fits - 1));
    fit += static_cast<double>(weight_[i] * fits);
    all += static_cast<double>(weight_[i]);
    squares += static_cast<double>(weight_[i]) * static_cast<double>(weight_[i]);
  }
  if (!(all > 0)) return even_weights();
  fit_ = fit / all;
  slow_ = slow_ == 0 ? fit_ : slow_ + settings_.average_slow * (fit_ - slow_);
  fast_ = fast_ == 0 ? fit_ : fast_ + settings_.average_fast * (fit_ - fast_);
  const auto norm = static_cast<float>(1 / all);
  for (float& weight : weight_) weight *= norm;
  effective_ = all * all / squares;
}

Estimate ParticleFilter::estimate() {
  bins_.clear();
  const float idle = 0.1F / static_cast<float>(x_.size());
  for (std::size_t i = 0; i < x_.size(); ++i)
    if (weight_[i] > idle) bins_.add(x_[i], y_[i], rho_[i], weight_[i]);
  return estimate_near(bins_.heaviest().middle);
}

Estimate ParticleFilter::estimate_near(const Pose& expected) const {
  const Estimate near = around(expected);
  return near.share > 0 ? around(near.pose) : Estimate{};
}

Estimate ParticleFilter::around(const Pose& middle) const {
  const ClusterOf is_near(middle);
  double w = 0, x = 0, y = 0, r = 0;
  Covariance sum;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const float dx = x_[i] - is_near.x;
    const float dy = y_[i] - is_near.y;
    if (!is_near(dx, dy, sine_[i], cosine_[i])) continue;
    // For small angles the sine is the angle.
    const float dr_sine = is_near.cosine * sine_[i] - is_near.sine * cosine_[i];
    const float dr = dr_sine * (1 + dr_sine * dr_sine / 6);
    const auto weight = static_cast<double>(weight_[i]);
    const auto ex = static_cast<double>(dx);
    const auto ey = static_cast<double>(dy);
    const auto er = static_cast<double>(dr);
    w += weight;
    x += weight * ex;
    y += weight * ey;
    r += weight * er;
    sum.xx += weight * ex * ex;
    sum.xy += weight * ex * ey;
    sum.yy += weight * ey * ey;
    sum.x_rho += weight * ex * er;
    sum.y_rho += weight * ey * er;
    sum.rho_rho += weight * er * er;
  }
  if (!(w > 0)) return {.pose = middle};
  x /= w;
  y /= w;
  r /= w;
  return {.pose = {.x = middle.x + x, .y = middle.y + y, .rho = heading(middle.rho + r)},
          .covariance = {.xx = sum.xx / w - x * x,
                         .xy = sum.xy / w - x * y,
                         .yy = sum.yy / w - y * y,
                         .x_rho = sum.x_rho / w - x * r,
                         .y_rho = sum.y_rho / w - y * r,
                         .rho_rho = sum.rho_rho / w - r * r},
          .share = w};
}

void ParticleFilter::favour(const Pose& pose, double share) {
  const ClusterOf is_near(pose);
  double near = 0;
  for (std::size_t i = 0; i < x_.size(); ++i)
    if (is_near(x_[i] - is_near.x, y_[i] - is_near.y, sine_[i], cosine_[i]))
      near += static_cast<double>(weight_[i]);
  if (!(near > 0) || near >= share) return;
  const auto more = static_cast<float>(share / near);
  const auto less = static_cast<float>((1 - share) / (1 - near));
  double squares = 0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    const bool here = is_near(x_[i] - is_near.x, y_[i] - is_near.y, sine_[i], cosine_[i]);
    weight_[i] *= here ? more : less;
    squares += static_cast<double>(weight_[i]) * static_cast<double>(weight_[i]);
  }
  effective_ = 1 / squares;
}

std::size_t ParticleFilter::wanted_size() const {
  const double k = static_cast<double>(bins_.count()) - 1;
  if (k < 1) return settings_.particles;
  const double a = 2 / (9 * k);
  const double b = 1 - a + std::sqrt(a) * settings_.kld_quantile;
  const double n = k / (2 * settings_.kld_error) * b * b * b;
  return static_cast<std::size_t>(std::clamp(n, static_cast<double>(settings_.particles),
                                             static_cast<double>(settings_.particles_max)));
}

double ParticleFilter::searching_share() const {
  if (!(slow_ > 0)) return 0;
  return std::clamp(1 - settings_.recovery_margin * fast_ / slow_, 0.0, kInjectedShareMax);
}

void ParticleFilter::resample(const LikelihoodField& field, const Beams& beams,
                              const Search& search) {
  const double share =
      search.anywhere && !beams.empty() ? std::max(search.least, searching_share()) : 0;
  const std::size_t size = wanted_size();
  const auto replaced =
      std::min(kInjectedMax, static_cast<std::size_t>(share * static_cast<double>(size)));
  const auto jumped = search.nearby && !beams.empty() && misfits(fit_) ? size / kJumpShare : 0;
  const bool idle = effective_ < 0.5 * static_cast<double>(x_.size());
  if (!idle && replaced + jumped == 0 && 10 * size <= 11 * x_.size() && 10 * x_.size() <= 15 * size)
    return;
  const std::size_t kept = size - replaced - jumped;
  draw_systematically(kept);
  for (std::size_t i = 0; i < jumped; ++i) {
    const std::size_t around = random_.below(static_cast<std::uint32_t>(kept));
    add_fitting(field, beams, kTriesNearby, [&] { return near(around); });
  }
  const auto tries = static_cast<std::uint32_t>(
      std::min(kTriesInRecoveryMost, kDrawsInRecovery / std::max<std::size_t>(1, replaced)));
  for (std::size_t i = 0; i < replaced; ++i)
    add_fitting(field, beams, tries, [&] { return anywhere(field); });
  injected_ = replaced;
  even_weights();
}

// Systematic resampling: `count` equal steps through the cumulative weights, from a random offset
// within the first step.
void ParticleFilter::draw_systematically(std::size_t count) {
  for (auto* to : {&next_.x, &next_.y, &next_.rho, &next_.sine, &next_.cosine}) to->resize(count);
  const double step = 1 / static_cast<double>(count);
  const double first = static_cast<double>(random_.uniform()) * step;
  double sum = static_cast<double>(weight_[0]);
  std::size_t from = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = first + static_cast<double>(i) * step;
    while (sum < at && from + 1 < x_.size()) sum += static_cast<double>(weight_[++from]);
    next_.x[i] = x_[from];
    next_.y[i] = y_[from];
    next_.rho[i] = rho_[from];
    next_.sine[i] = sine_[from];
    next_.cosine[i] = cosine_[from];
  }
  x_.swap(next_.x);
  y_.swap(next_.y);
  rho_.swap(next_.rho);
  sine_.swap(next_.sine);
  cosine_.swap(next_.cosine);
}

}  // namespace rack::localisation
