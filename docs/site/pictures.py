"""A picture of every page of the site, made by a headless Chromium, to be looked at.

python docs/site/pictures.py build/site build/pictures [part of a page's name]
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WIDTH, HEIGHT = 1400, 3000


def main() -> int:
    """One PNG a page."""
    site, pictures, *part = sys.argv[1:]
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        print(f"none of {', '.join(BROWSERS)} is installed")
        return 1
    for page in sorted(Path(site).rglob("*.html")):
        name = page.relative_to(site).with_suffix("").as_posix().replace("/", "-")
        if "_static" in page.parts or (part and part[0] not in name):
            continue
        target = Path(pictures, f"{name}.png").resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        subprocess.run(
            [
                browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                f"--window-size={WIDTH},{HEIGHT}", f"--screenshot={target}",
                page.resolve().as_uri(),
            ],
            check=True, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main())
