#include "apps/page.h"

#include <string_view>

#include <fmt/format.h>

#include "apps/page_text.h"

namespace secondlook::apps {
namespace {

/// The page with `json` in it. Nothing in it can end the element it stands in.
std::string PageWith(std::string_view json) {
  constexpr std::string_view kPlace = "{{story}}";
  const std::string_view text = PageText();
  const std::size_t place = text.find(kPlace);
  std::string page(text.substr(0, place));
  for (const char c : json) {
    if (c == '<') {
      page += "\\u003c";
    } else {
      page += c;
    }
  }
  page += text.substr(place + kPlace.size());
  return page;
}

}  // namespace

std::string Page(const StoryPart& story) {
  return PageWith(
      fmt::format(R"({{"left_out":{},"messages":{}}})", story.left_out, story.messages));
}

std::string LivePage() { return PageWith(R"({"live":true})"); }

}  // namespace secondlook::apps
