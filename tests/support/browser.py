"""A headless Chromium, controlled through a pipe with the DevTools protocol: no port, no driver, only the standard library."""

from __future__ import annotations

import base64
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from types import TracebackType
from typing import Any, Self

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
    "--remote-debugging-pipe",
)  # fmt: skip


def find_browser() -> str | None:
    """Return the browser's path, or None if there is no browser."""
    return next((path for path in map(shutil.which, NAMES) if path), None)


class Browser:
    """A browser page, to be used as a context manager."""

    def __init__(self) -> None:
        self._number, self._events = 0, []

    def __enter__(self) -> Self:
        self._folder = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        ours_in, self._to = os.pipe()
        self._from, ours_out = os.pipe()
        # The browser reads from descriptor 3 and writes to descriptor 4.
        command = f'exec "$0" "$@" 3<&{ours_in} 4>&{ours_out}'
        # The browser uses its bundled graphics driver, which VK_DRIVER_FILES would hide.
        environment = {name: value for name, value in os.environ.items() if name != "VK_DRIVER_FILES"}
        self._process = subprocess.Popen(
            ["bash", "-c", command, str(find_browser()), *FLAGS, f"--user-data-dir={self._folder.name}"],
            env=environment, pass_fds=(ours_in, ours_out), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(ours_in)
        os.close(ours_out)
        self._buffer, self._session = b"", None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._process.kill()
        self._process.wait()
        os.close(self._to)
        os.close(self._from)
        self._folder.cleanup()

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and return its answer."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session is not None:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._read_message()
            if answer.get("id") == self._number:
                assert "error" not in answer, (method, answer["error"])
                return answer["result"]
            self._events.append(answer)

    def _read_message(self) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            piece = os.read(self._from, 1 << 16)
            assert piece, "the browser has ended"
            self._buffer += piece
        text, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(text)

    def open_page(self, page: Path, width: int = 1280, height: int = 900, dark: bool = False) -> None:
        """Load a file at a given screen width, in light or dark mode."""
        self._events.clear()
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600
        )  # fmt: skip
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", features=[scheme])
        self.call("Page.navigate", url=page.resolve().as_uri())
        while not any(event.get("method") == "Page.loadEventFired" for event in self._events):
            self._events.append(self._read_message())

    def evaluate_script(self, expression: str) -> Any:
        """Return the value of a JavaScript expression in the page, even if the page's own scripts are blocked."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def console_errors(self) -> list[Any]:
        """Return the errors and warnings in the browser's console and log since the page was opened."""
        self.evaluate_script("1")
        names = ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded", "Network.loadingFailed")
        return [event["params"] for event in self._events if event.get("method") in names]

    def requested_addresses(self) -> list[str]:
        """Return the addresses that the page requested."""
        self.evaluate_script("1")
        sent = (event["params"] for event in self._events if event.get("method") == "Network.requestWillBeSent")
        return [one["request"]["url"] for one in sent]

    def take_screenshot(self, path: Path, whole: bool = True) -> None:
        """Save a screenshot as PNG, of the whole page by default."""
        data = self.call("Page.captureScreenshot", captureBeyondViewport=whole)["data"]
        path.write_bytes(base64.b64decode(data))
