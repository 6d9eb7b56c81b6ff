#pragma once

#include <memory>
#include <vector>

#include "lib/common/error.h"
#include "lib/hal/replay/recording.h"
#include "lib/hal/robot.h"

namespace secondlook::hal {

/// The recording does not reach as far as the mission that is played from it.
class EndOfRecording : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

struct Reel;  // What the devices share.

/// Where a recording is being played: in one of its segments, at an instant.
class Playback {
 public:
  /// `recording` must outlive this.
  explicit Playback(const Recording& recording);
  ~Playback();

  /// A robot whose devices answer as the recorded ones did. Each function gives its own answers of
  /// the segment, in their order. Where it is asked more often than it was, a state or a status
  /// stays as it is, a sleep lasts as long as it should and no frame comes, unless the recording is
  /// one that ends in this segment: then EndOfRecording is thrown, by all but the clock. A frame
  /// whose images are damaged is a ProtocolError naming it. Nothing can be reached by Stop().
  /// To be called by the mission's thread, once; the playback must outlive the robot.
  Robot MakeRobot();

  /// The mission sets out for a look: what it is answered comes from the next segment from now on.
  void NextLook();

  /// The mission asks whether to stop. It is answered as the recorded one was: from the same
  /// question on, or once the time is past at which the recorded one stopped.
  bool AskStop();
  /// The signal that asked the recorded mission to stop; 0: none.
  int stop_signal() const;

  /// The tasks that the recorded mission was set in this segment, before its next step.
  const std::vector<second_look::task_t>& tasks() const;
  /// The models that the recorded mission got in this segment, before its next step.
  const std::vector<second_look::rec_model_t>& models() const;

 private:
  std::unique_ptr<Reel> reel_;
};

}  // namespace secondlook::hal
