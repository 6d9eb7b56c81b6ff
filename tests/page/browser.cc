#include "tests/page/browser.h"

#include <array>
#include <cstdio>
#include <memory>
#include <stdexcept>

#include <fmt/format.h>

#include "lib/common/files.h"
#include "tests/support/temporary_folder.h"

namespace secondlook::testing {
namespace {

/// Before the page's own script: collects every fault.
constexpr const char* kBefore = R"(<script>
const faults = [];
addEventListener('error', event => faults.push(event.message), true);
addEventListener('unhandledrejection', event => faults.push(String(event.reason)));
addEventListener('securitypolicyviolation', event => faults.push(`policy: ${event.blockedURI}`));
console.error = (...words) => faults.push(words.join(' '));
</script>)";

/// After it: uses the page as a reader would, then leaves what it found where --dump-dom shows it.
constexpr const char* kAfter = R"(<script>
function channels(color) { return color.match(/[\d.]+/g).map(Number); }
function luminance(color) {
  const [r, g, b] = channels(color).map(c => c / 255).map(c => c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}
function backgroundOf(element) {
  for (let e = element; e; e = e.parentElement) {
    const color = getComputedStyle(e).backgroundColor;
    if ((channels(color)[3] ?? 1) === 1) return color;
  }
  return 'rgb(255, 255, 255)';
}
function contrast(element) {
  const [a, b] = [getComputedStyle(element).color, backgroundOf(element)].map(luminance);
  return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
}
addEventListener('load', async () => {
  let pictures = 0, broken = 0;
  const look = async () => {
    for (const image of document.images) {
      ++pictures;
      if (!image.complete) await new Promise(done => { image.onload = image.onerror = done; });
      if (!(image.naturalWidth > 0)) ++broken;
    }
    document.querySelectorAll('details').forEach(details => { details.open = true; });
    document.querySelectorAll('.thing[role]').forEach(thing => thing.dispatchEvent(new MouseEvent('click')));
    document.querySelectorAll('.mark').forEach(mark => mark.dispatchEvent(new PointerEvent('pointerenter')));
    document.querySelectorAll('[role=application]').forEach(marks => marks.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowRight'})));
  };
  await look();
  const count = document.querySelectorAll('.strip button').length;
  for (let i = 0; i < count; ++i) {
    document.querySelectorAll('.strip button')[i].click();
    await look();
  }
  const texts = [...document.body.querySelectorAll('*')].filter(e => !e.closest('svg, script, noscript, style') &&
    [...e.childNodes].some(n => n.nodeType === Node.TEXT_NODE && n.data.trim()) && e.getClientRects().length);
  const found = {
    faults, pictures, broken,
    headline: document.querySelector('h1')?.textContent ?? '',
    text: document.body.innerText,
    background: getComputedStyle(document.body).backgroundColor,
    ink: getComputedStyle(document.body).color,
    lowest_contrast: Math.min(...texts.map(contrast)),
    overflows: document.documentElement.scrollWidth > innerWidth,
    elements: [...new Set([...document.body.querySelectorAll('*')].map(e => e.localName))].join(' '),
  };
  document.body.replaceChildren();
  document.body.append(['', encodeURIComponent(JSON.stringify(found)), ''].join('FOUND'));
});
</script>)";

std::string OutputOf(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  std::array<char, 65536> buffer{};
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe.get())) {
    output.append(buffer.data(), n);
  }
  return output;
}

/// The elements and texts of a page once it is drawn.
std::string Browse(const std::string& url, const std::string& options) {
  const TemporaryFolder profile;
  return OutputOf(fmt::format(
      "timeout 100 /usr/bin/chromium --headless --no-sandbox --disable-gpu --disable-quic "
      "--no-first-run --disable-background-networking --disable-component-update --disable-sync "
      "--disable-dev-shm-usage --user-data-dir={} {} --dump-dom '{}' 2>/dev/null",
      profile.path().string(), options, url));
}

std::string PercentDecoded(const std::string& text) {
  std::string decoded;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      decoded += text[i];
      continue;
    }
    decoded += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
    i += 2;
  }
  return decoded;
}

}  // namespace

bool HaveBrowser() { return std::filesystem::exists("/usr/bin/chromium"); }

std::string ElementsAt(const std::string& url) { return Browse(url, "--virtual-time-budget=3000"); }

Drawn Draw(const std::string& page, bool dark, int width) {
  const TemporaryFolder folder;
  std::string probed = page;
  probed.insert(probed.find("<title>"), kBefore);
  probed.insert(probed.find("</body>"), kAfter);
  WriteFile(folder / "page.html", probed);
  const std::string output = Browse("file://" + (folder / "page.html").string(),
                                    fmt::format("--virtual-time-budget=20000 --window-size={},900 "
                                                "--blink-settings=preferredColorScheme={}",
                                                width, dark ? 0 : 1));
  const std::size_t begin = output.find("FOUND");
  const std::size_t end = output.rfind("FOUND");
  if (begin == end) throw std::runtime_error("the page did not come to an end:\n" + output);
  const auto found =
      nlohmann::json::parse(PercentDecoded(output.substr(begin + 5, end - begin - 5)));
  Drawn drawn;
  drawn.faults = found["faults"].get<std::vector<std::string>>();
  drawn.pictures = found["pictures"];
  drawn.broken = found["broken"];
  drawn.headline = found["headline"];
  drawn.text = found["text"];
  drawn.background = found["background"];
  drawn.ink = found["ink"];
  drawn.lowest_contrast =
      found["lowest_contrast"].is_number() ? found["lowest_contrast"].get<double>() : 0.0;
  drawn.overflows = found["overflows"];
  drawn.elements = found["elements"];
  return drawn;
}

}  // namespace secondlook::testing
