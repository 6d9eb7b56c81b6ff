#include "lib/hal/replay/playback.h"

#include <algorithm>
#include <atomic>
#include <string>
#include <thread>
#include <utility>

#include "lib/hal/replay/frame_codec.h"

namespace secondlook::hal {

using second_look::rec_error_t;

struct Reel {
  const Recording& recording;
  std::size_t segment{};
  std::atomic<Time> now{Time{}};
  std::int64_t stop_questions{};  ///< That the mission has asked.

  const Segment& Current() const { return recording.segments[segment]; }

  bool InLastSegment() const { return segment + 1 == recording.segments.size(); }

  void AdvanceTo(Time time) { now = std::max(now.load(), time); }

  [[noreturn]] void ThrowEnd(const std::string& what) const {
    Throw<EndOfRecording>("the recording ends here, after look {}: it has nothing more of {}",
                          segment, what);
  }
};

namespace {

[[noreturn]] void ThrowRecorded(const rec_error_t& error) {
  switch (error.kind) {
    case rec_error_t::CONFIG:
      throw ConfigError(error.what);
    case rec_error_t::ARGUMENT:
      throw InvalidArgument(error.what);
    case rec_error_t::PROTOCOL:
      throw ProtocolError(error.what);
    default:
      throw DeviceError(error.what);
  }
}

/// The values of one function of a device, of the segment that is being played.
template <class T>
class Tape {
 public:
  Tape(Reel* reel, std::vector<T> Segment::*values) : reel_(reel), values_(values) {}

  /// The next one; null when the segment has no more.
  const T* Next() {
    if (std::exchange(segment_, reel_->segment) != reel_->segment) next_ = 0;
    const std::vector<T>& values = reel_->Current().*values_;
    return next_ < values.size() ? &values[next_++] : nullptr;
  }

 private:
  Reel* reel_;
  std::vector<T> Segment::*values_;
  std::size_t segment_{};
  std::size_t next_{};
};

/// The answers of one function of a device that messages call `what`.
template <class T>
class Answers {
 public:
  Answers(Reel* reel, std::string what, std::vector<Answer<T>> Segment::*answers)
      : reel_(reel), what_(std::move(what)), tape_(reel, answers) {}

  /// The next one; null when there is no more and the recording goes on. Throws what was thrown.
  const T* Next() {
    const Answer<T>* answer = tape_.Next();
    if (answer == nullptr) {
      if (reel_->InLastSegment() && !reel_->recording.complete) reel_->ThrowEnd(what_);
      return nullptr;
    }
    if (const auto* error = std::get_if<rec_error_t>(answer)) {
      reel_->AdvanceTo(Time(Duration(error->now_ns)));
      ThrowRecorded(*error);
    }
    return &std::get<T>(*answer);
  }

  /// The next one, or the last once more.
  T NextOrLast() {
    if (const T* next = Next()) last_ = next;
    if (last_ == nullptr) reel_->ThrowEnd(what_);
    return *last_;
  }

 private:
  Reel* reel_;
  std::string what_;
  Tape<Answer<T>> tape_;
  const T* last_{};
};

class PlayedClock : public Clock {
 public:
  explicit PlayedClock(Reel* reel)
      : reel_(reel),
        now_(reel, &Segment::now),
        slept_(reel, &Segment::slept),
        thought_(reel, &Segment::thought) {}

  Time Now() const override {
    if (std::this_thread::get_id() == thread_) {
      if (const Time* now = now_.Next()) reel_->AdvanceTo(*now);
    }
    return reel_->now;
  }

  void SleepUntil(Time time) override {
    const Time* slept = slept_.Next();
    reel_->AdvanceTo(slept != nullptr ? *slept : time);
  }

  void ChargeThinking(Duration cost) override {
    const Time* thought = thought_.Next();
    reel_->AdvanceTo(thought != nullptr ? *thought : reel_->now.load() + cost);
  }

 private:
  Reel* reel_;
  mutable Tape<Time> now_;
  Tape<Time> slept_;
  Tape<Time> thought_;
  std::thread::id thread_{std::this_thread::get_id()};
};

class PlayedBase : public Base {
 public:
  explicit PlayedBase(Reel* reel)
      : info_(reel->recording.robot.base),
        states_(reel, "base '" + info_.name + "'", &Segment::base_states),
        starts_(reel, "base '" + info_.name + "'", &Segment::base_starts),
        statuses_(reel, "base '" + info_.name + "'", &Segment::base_statuses) {}

  const BaseInfo& info() const override { return info_; }
  BaseState State() override { return states_.NextOrLast(); }
  void Start(const BasePath& /*path*/) override { starts_.Next(); }
  MotionStatus Status() override { return statuses_.NextOrLast(); }
  void Stop() noexcept override {}

 private:
  BaseInfo info_;
  Answers<BaseState> states_;
  Answers<Started> starts_;
  Answers<MotionStatus> statuses_;
};

class PlayedPanTilt : public PanTilt {
 public:
  explicit PlayedPanTilt(Reel* reel)
      : info_(reel->recording.robot.head),
        states_(reel, "pan-tilt '" + info_.name + "'", &Segment::head_states),
        starts_(reel, "pan-tilt '" + info_.name + "'", &Segment::head_starts),
        statuses_(reel, "pan-tilt '" + info_.name + "'", &Segment::head_statuses) {}

  const PanTiltInfo& info() const override { return info_; }
  PanTiltState State() override { return states_.NextOrLast(); }
  void Start(const PanTiltAngles& /*target*/) override { starts_.Next(); }
  MotionStatus Status() override { return statuses_.NextOrLast(); }
  void Stop() noexcept override {}

 private:
  PanTiltInfo info_;
  Answers<PanTiltState> states_;
  Answers<Started> starts_;
  Answers<MotionStatus> statuses_;
};

class PlayedArm : public Arm {
 public:
  explicit PlayedArm(Reel* reel)
      : info_(reel->recording.robot.arm->arm),
        states_(reel, "arm '" + info_.name + "'", &Segment::arm_states),
        starts_(reel, "arm '" + info_.name + "'", &Segment::arm_starts),
        statuses_(reel, "arm '" + info_.name + "'", &Segment::arm_statuses) {}

  const ArmInfo& info() const override { return info_; }
  ArmState State() override { return states_.NextOrLast(); }
  void Start(const JointTrajectory& /*trajectory*/) override { starts_.Next(); }
  MotionStatus Status() override { return statuses_.NextOrLast(); }
  void Stop() noexcept override {}

 private:
  ArmInfo info_;
  Answers<ArmState> states_;
  Answers<Started> starts_;
  Answers<MotionStatus> statuses_;
};

class PlayedCamera : public Camera {
 public:
  PlayedCamera(Reel* reel, CameraInfo info, std::vector<Answer<Grabbed>> Segment::*frames)
      : reel_(reel), info_(std::move(info)), frames_(reel, "camera '" + info_.name + "'", frames) {}

  const CameraInfo& info() const override { return info_; }

  std::optional<RgbdFrame> Grab(Duration timeout) override {
    const Grabbed* grabbed = frames_.Next();
    if (grabbed == nullptr) {
      reel_->AdvanceTo(reel_->now.load() + timeout);
      return std::nullopt;
    }
    reel_->AdvanceTo(grabbed->now);
    if (!grabbed->came) return std::nullopt;
    RgbdFrame frame = grabbed->frame;
    DecodeImage(grabbed->color, &frame);
    DecodeImage(grabbed->depth, &frame);
    const cv::Size size(info_.model.width, info_.model.height);
    if (frame.color.size() != size || (info_.has_depth && frame.depth.size() != size)) {
      Throw<ProtocolError>("recorded frame {} has {} x {} pixels of colour and {} x {} of depth",
                           frame.sequence, frame.color.cols, frame.color.rows, frame.depth.cols,
                           frame.depth.rows);
    }
    return frame;
  }

 private:
  Reel* reel_;
  CameraInfo info_;
  Answers<Grabbed> frames_;
};

}  // namespace

Playback::Playback(const Recording& recording) : reel_(new Reel{recording}) {}

Playback::~Playback() = default;

Robot Playback::MakeRobot() {
  Robot robot;
  robot.clock = std::make_unique<PlayedClock>(reel_.get());
  robot.base = std::make_unique<PlayedBase>(reel_.get());
  robot.head = std::make_unique<PlayedPanTilt>(reel_.get());
  const RobotDescription& description = reel_->recording.robot;
  robot.head_camera =
      std::make_unique<PlayedCamera>(reel_.get(), description.head_camera, &Segment::frames);
  if (description.arm) {
    robot.arm = std::make_unique<PlayedArm>(reel_.get());
    robot.hand_camera =
        std::make_unique<PlayedCamera>(reel_.get(), description.arm->camera, &Segment::hand_frames);
  }
  return robot;
}

void Playback::NextLook() {
  if (!reel_->InLastSegment()) ++reel_->segment;
}

bool Playback::AskStop() {
  ++reel_->stop_questions;
  const auto& stop = reel_->Current().stop;
  return stop && (reel_->stop_questions >= stop->questions ||
                  reel_->now.load() > Time(Duration(stop->now_ns)));
}

int Playback::stop_signal() const {
  const auto& stop = reel_->recording.segments.back().stop;
  return stop ? stop->signal : 0;
}

const std::vector<second_look::task_t>& Playback::tasks() const { return reel_->Current().tasks; }

const std::vector<second_look::rec_model_t>& Playback::models() const {
  return reel_->Current().models;
}

}  // namespace secondlook::hal
