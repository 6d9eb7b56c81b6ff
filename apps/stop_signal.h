#pragma once

namespace secondlook::apps {

/// Lets SIGINT, SIGTERM and SIGHUP ask for a safe stop instead of ending the process, and a file
/// that has reached the limit of its size end nothing but its own writing. Call once, from main.
void CatchStopSignals();

/// The signal that has asked for a stop (its number), or 0. From any thread.
int StopSignal();

}  // namespace secondlook::apps
