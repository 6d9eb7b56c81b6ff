#include "lib/common/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>

namespace secondlook {

void StartLog(spdlog::level::level_enum level) {
  auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  auto logger = std::make_shared<spdlog::logger>("secondlook", sink);  // spdlog's own interface
  logger->set_level(level);
  logger->set_pattern("%H:%M:%S.%e %^%-7l%$ %v");
  spdlog::set_default_logger(logger);
}

}  // namespace secondlook
