#include "apps/version.h"

namespace secondlook::apps {

const char* Version() { return "0.1.0"; }

}  // namespace secondlook::apps
