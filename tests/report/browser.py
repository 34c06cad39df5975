"""Headless Chromium for the report's checks: opens a file at a given width, tells what is on the page and what went wrong.

Selenium drives Debian's chromium and chromium-driver; both are found on the PATH and nothing is fetched.
"""

from __future__ import annotations

import base64
import contextlib
import re
import shutil
import tempfile
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

WIDTHS = {"desktop": (1280, 900), "phone": (390, 844)}
_LOADING = ("src", "href", "xlink:href", "srcset", "data", "action", "poster")
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--hide-scrollbars",
)  # fmt: skip


def missing() -> list[str]:
    """What a machine lacks for these checks."""
    found = [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]
    try:
        import selenium  # noqa: F401
    except ImportError:
        found.append("selenium")
    return found


@contextlib.contextmanager
def chromium() -> Iterator[Browser]:
    """A browser of its own profile, gone with all its files when the block ends."""
    from selenium.webdriver import Chrome, ChromeOptions
    from selenium.webdriver.chrome.service import Service

    with tempfile.TemporaryDirectory(prefix="peen-browser-") as profile:
        options = ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for flag in (*_FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = Chrome(options=options, service=Service(shutil.which("chromedriver")))
        try:
            yield Browser(driver)
        finally:
            driver.quit()


class Browser:
    """One page at a time."""

    def __init__(self, driver):
        self.driver = driver

    def open(self, path: Path, size: str, scripts: bool = True) -> None:
        """Load the file at a size of ``WIDTHS``, with or without running its scripts."""
        width, height = WIDTHS[size]
        self.driver.execute_cdp_cmd("Emulation.setScriptExecutionDisabled", {"value": not scripts})
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": size == "phone"},
        )
        self.driver.get("about:blank")
        self.driver.get_log("browser")  # what an earlier page said
        self.driver.get(Path(path).resolve().as_uri())

    def complaints(self) -> list[str]:
        """Console messages since the page was opened that are warnings or errors."""
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("WARNING", "SEVERE")]

    def run(self, script: str):
        """What ``script``, the body of a function, returns in the page."""
        return self.driver.execute_script(script)

    def overflow_px(self) -> int:
        """Pixels by which the page is wider than the screen: what a reader would have to scroll sideways."""
        return self.run("return document.documentElement.scrollWidth - window.innerWidth")

    def empty_figures(self) -> list[str]:
        """Figures without a natural size: pictures that did not load, drawings without extent."""
        return self.run(
            "return [...document.querySelectorAll('img, svg')].filter(f => f.tagName === 'IMG'"
            " ? !(f.complete && f.naturalWidth && f.naturalHeight) : !(f.getBBox().width && f.getBBox().height))"
            ".map(f => f.alt || f.getAttribute('aria-label') || f.outerHTML.slice(0, 80))"
        )

    def press(self, selector: str, *keys: str) -> None:
        """Keys sent to an element, as a user at a keyboard does."""
        from selenium.webdriver.common.by import By

        self.driver.find_element(By.CSS_SELECTOR, selector).send_keys(*keys)

    def click(self, selector: str) -> None:
        """A real click on the first such element, which a page may let copy."""
        from selenium.webdriver.common.by import By

        self.driver.find_element(By.CSS_SELECTOR, selector).click()

    def screenshot(self, path: Path, whole: bool = True) -> None:
        """The whole page, or what the screen shows, as PNG."""
        shot = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", "captureBeyondViewport": whole})
        path.write_bytes(base64.b64decode(shot["data"]))

    def pdf(self, path: Path) -> None:
        """The page as it is printed on A4."""
        size = {"paperWidth": 8.27, "paperHeight": 11.69, "printBackground": True, "preferCSSPageSize": True}
        path.write_bytes(base64.b64decode(self.driver.execute_cdp_cmd("Page.printToPDF", size)["data"]))


class _Addresses(HTMLParser):
    def __init__(self):
        super().__init__()
        self.found, self.in_style = [], False

    def handle_starttag(self, tag, attrs):
        self.in_style = tag == "style"
        for name, value in attrs:
            if name in _LOADING:
                self.found.append(value or "")
            elif name == "style":
                self.handle_style(value or "")

    def handle_data(self, data):
        if self.in_style:
            self.handle_style(data)

    def handle_style(self, text):
        self.found += re.findall(r"""url\(\s*["']?([^"')]+)""", text) + re.findall(r"@import\s+(\S+)", text)


def outside_references(html: str) -> list[str]:
    """Addresses that the page would fetch from elsewhere, by its attributes or its style."""
    addresses = _Addresses()
    addresses.feed(html)
    return [address for address in addresses.found if not address.startswith(("#", "data:"))]
