"""report.html of a good, a poor and a refused calibration, in a real browser: screen, telephone, dark, paper."""

import io
import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pdfplumber
import pytest

from devtools import Browser

ROOT = Path(__file__).parents[2]
BINARY = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "ringcal"
CHROMIUM = ROOT / ".test-env" / "browser" / "run"
BOARD = ROOT / "config" / "a4.yaml"
CAMERA = "--width 640 --height 480 --distortion=-0.21,0.07,0.0008,-0.0005,0 --seed 5"
PX = r"0\.\d\d\d px"

# the frames of a case, the word and the sentence of its verdict, and how many figures and pictures the page has
CASES = {
    "good": (
        "--views 14 --blur-sigma 2 --noise 0.01",
        "Good",
        r"Directions are known to 0\.0\d\d px \(one standard deviation\) everywhere in the frame; the rings "
        r"of 14 views cover 9\d % of it\.",
        8 + 12 + 1,
    ),
    "poor": (
        "--views 6 --blur-sigma 2 --noise 0.04 --max-tilt 15",
        "Usable",
        rf"Near pixel \(\d+, \d+\) directions are known to {PX} only \(good: at most 0\.1 px\); "
        r"6 views took part \(good: at least 10\)\.",
        8 + 6 + 1,
    ),
    "refused": (
        "--views 5 --blur-sigma 2 --noise 0.01 --max-tilt 0",
        "Not enough",
        r"No calibration was made\. The board stands at the same tilt in all views \(within \d\.\d degrees\): tilt it by "
        r"20 degrees or more about both axes\.",
        2 + 5 + 1,
    ),
}

# what is on the page: the verdict, every figure's size, whether it is wider than the screen, and text that is hard to read
LOOK = """
(() => {
  const box = (e) => { const r = e.getBoundingClientRect(); return [r.width, r.height]; };
  const channels = (colour) => (colour.match(/[\\d.]+/g) || []).map(Number);
  const light = (colour) => channels(colour).slice(0, 3)
    .map((v) => v / 255).map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const ratio = (a, b) => { const [x, y] = [light(a), light(b)]; return (Math.max(x, y) + 0.05) / (Math.min(x, y) + 0.05); };
  const ground = (e) => {
    for (; e; e = e.parentElement) {
      const colour = getComputedStyle(e).backgroundColor;
      if (channels(colour)[3] !== 0) return colour;
    }
    return 'rgb(255, 255, 255)';
  };
  const faint = [...document.querySelectorAll('p, li, td, th, dt, dd, h1, h2, h3, figcaption, .alarm')]
    .filter((e) => ratio(getComputedStyle(e).color, ground(e)) < 4.5);
  const drawn = [...document.querySelectorAll('svg .label, svg .muted')]
    .filter((e) => ratio(getComputedStyle(e).fill, ground(e)) < 4.5);
  const numbers = [...document.querySelectorAll('[class^="on"]')]
    .filter((e) => ratio(getComputedStyle(e).fill, getComputedStyle(e.previousElementSibling).fill) < 4.5);
  return {
    word: document.querySelector('#verdict .word').textContent,
    sentence: document.querySelector('#verdict .sentence').textContent,
    verdict: document.querySelector('#verdict').getBoundingClientRect().toJSON(),
    figures: [...document.querySelectorAll('figure svg')].map(box),
    pictures: [...document.querySelectorAll('figure image')].map(box),
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    ground: getComputedStyle(document.body).backgroundColor,
    faint: [...faint, ...drawn, ...numbers].map((e) => e.outerHTML.slice(0, 120)),
  };
})()
"""


@pytest.fixture(scope="session")
def pages(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The report of each case, with a file that is no picture among the frames."""
    folder = tmp_path_factory.mktemp("report")
    pages = {}
    for name, (options, *_) in CASES.items():
        frames, out = folder / name, folder / f"{name}_out"
        command = [BINARY, "simulate", "--board", BOARD, "--output", frames, *CAMERA.split(), *options.split()]
        subprocess.run(command, check=True, capture_output=True)
        # without a board: a picture, and none
        black = ["P5 640 480 255\n".encode(), bytes(640 * 480)]
        (frames / "view_900.pgm").write_bytes(b"".join(black))
        (frames / "view_901.png").write_text("no picture")
        done = subprocess.run([BINARY, "calibrate", frames, "--board", BOARD, "--output", out], capture_output=True, text=True)
        assert done.returncode == (1 if name == "refused" else 0), done.stderr
        (folder / f"{name}.txt").write_text(done.stdout)
        pages[name] = out / "report.html"
    return pages


@pytest.fixture(scope="session")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if not CHROMIUM.exists():
        # where it can always be had, its absence is a failure
        (pytest.fail if os.environ.get("CI") else pytest.skip)("no Chromium; see tests/report/browser.sh")
    browser = Browser(CHROMIUM, tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


def test_a_refused_calibration_has_a_report_and_nothing_else(pages: dict[str, Path]) -> None:
    files = {name: sorted(path.name for path in page.parent.iterdir()) for name, page in pages.items()}
    assert files["refused"] == ["report.html"]
    assert files["good"] == files["poor"] == ["calibration.json", "camera_info.yaml", "report.html"]
    assert all(page.stat().st_size < 1_000_000 for page in pages.values())


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1100, 360])
@pytest.mark.parametrize("case", CASES)
def test_it_opens_and_can_be_read(browser: Browser, pages: dict[str, Path], case: str, scheme: str, width: int) -> None:
    _, word, sentence, figures = CASES[case]
    events = browser.open(pages[case], scheme, width)
    said = [e for e in events if e["method"] in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")]
    assert not said, said
    asked = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
    assert asked and all(url == pages[case].as_uri() or url.startswith("data:") for url in asked), asked

    seen = browser.tell(LOOK)
    assert seen["word"] == word
    assert re.fullmatch(sentence, seen["sentence"]), seen["sentence"]
    # at the head of the page, without scrolling
    assert seen["verdict"]["top"] < 150 and seen["verdict"]["width"] > 0.8 * min(width, 1024)
    assert len(seen["figures"]) == figures
    assert all(side > 100 for box in seen["figures"] for side in box), seen["figures"]
    assert all(side > 100 for box in seen["pictures"] for side in box), seen["pictures"]
    assert seen["overflow"] == 0
    assert (seen["ground"] == "rgb(255, 255, 255)") == (scheme == "light")
    assert not seen["faint"], seen["faint"]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("case", CASES)
def test_it_prints_on_white_paper(browser: Browser, pages: dict[str, Path], case: str, scheme: str) -> None:
    _, word, _, _ = CASES[case]
    browser.open(pages[case], scheme, media="print")
    assert browser.tell(LOOK)["ground"] == "rgb(255, 255, 255)"
    with pdfplumber.open(io.BytesIO(browser.pdf())) as pdf:
        assert 1 <= len(pdf.pages) <= 8
        assert (round(pdf.pages[0].width), round(pdf.pages[0].height)) == (595, 842)
        first = pdf.pages[0].extract_text()
        rest = "".join(page.extract_text() for page in pdf.pages)
        assert word in first and "All views" in rest
        # nothing sticks out of the paper
        assert all(w["x1"] <= page.width and w["x0"] >= 0 for page in pdf.pages for w in page.extract_words())


def test_the_text_summary_has_the_same_verdict(pages: dict[str, Path]) -> None:
    for case, (_, word, sentence, _) in CASES.items():
        summary = pages[case].parent.with_name(f"{case}.txt").read_text()
        if case == "refused":
            assert not summary
            continue
        told = re.search(r"^verdict   ([a-z ]+): (.)(.*)$", summary, re.MULTILINE)
        assert told and told[1].capitalize() == word
        assert re.fullmatch(sentence, f"{told[2].upper()}{told[3]}.")
