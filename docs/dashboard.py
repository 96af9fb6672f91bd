"""Makes docs/dashboard.png: the dashboard in a headless browser, at the end of a run.

    circumspect scan toilet-7 --start 30 --seed 4 --frame-interval 2 --viewer   # Ctrl-C at its end
    python docs/dashboard.py runs/scan-DATE-TIME

Needs the extra viewer, playwright, and Chromium.
"""

from __future__ import annotations

import argparse
import io
import shutil
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

from circumspect.classification import Classifier
from circumspect.storage import atomic_open
from circumspect.viewer import Dashboard, PlayedRun, Player, SavedRun

OUT = Path(__file__).with_suffix(".png")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--use-gl=angle", "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)  # fmt: skip
SIZE, PATIENCE = (1280, 800), 120_000


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("run", help="folder of a run")
    run: str = parser.parse_args().run
    played = PlayedRun(SavedRun.load(run))
    with Dashboard(Classifier.load(), port=0) as dashboard, sync_playwright() as driver:
        player = Player(played, dashboard)
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=list(FLAGS))
        page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
        page.goto(dashboard.url)
        bar = page.get_by_role("slider").first
        bar.wait_for(timeout=PATIENCE)
        bar.focus()
        page.keyboard.press("End")
        page.get_by_text(f"frame {len(played)},").wait_for(timeout=PATIENCE)
        for close in page.locator(".mantine-Notification-closeButton").all():
            close.click()
        turn = page.get_by_role("slider").nth(1)
        turn.focus()
        for _ in range(37):
            page.keyboard.press("ArrowRight")
        page.get_by_text("turned by 37°").wait_for(timeout=PATIENCE)
        page.wait_for_timeout(3000)
        shot = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        browser.close()
        player.close()
    with atomic_open(OUT, "wb") as stream:
        shot.save(stream, "PNG", optimize=True)


if __name__ == "__main__":
    main()
