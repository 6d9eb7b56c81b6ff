#pragma once

namespace secondlook::apps {

/// Lets SIGINT, SIGTERM and SIGHUP ask for a safe stop instead of ending the process. Call once,
/// from main.
void CatchStopSignals();

/// The signal that has asked for a stop (its number), or 0. From any thread.
int StopSignal();

}  // namespace secondlook::apps
