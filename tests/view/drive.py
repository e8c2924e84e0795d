"""Drives the page of `niji view` in Chromium: drive.py NIJI FOLDER.

Load, a slider, a drag in the picture, overlay on the bow, what is wrong beside its field, two tabs, a reload, a page
of another origin; a bow in a photograph, dragged by its picks. Ends what it started by its own number, and leaves
screenshots in FOLDER.
"""

import base64
import contextlib
import http.server
import math
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

PATIENCE_S = 180

# Large round drops of one size before a black sky: their bow ends at Descartes' ray.
SCENE = """# A scene for the page.
format = 1
name = "driven"
[sun]
elevation_deg = 20.0 # degrees
azimuth_deg = 180.0
[camera]
position_m = [0.0, 1.6, 0.0]
azimuth_deg = 0.0
elevation_deg = 12.0
horizontal_fov_deg = 90.0
width_px = 240
height_px = 135
[drops]
shape = "uniform"
box_min_m = [-2000.0, 0.0, -1200.0]
box_max_m = [2000.0, 1500.0, -300.0]
voxel_m = 100.0
number_density_m3 = 3.0
law = { monodisperse = { radius_um = 2000.0 } }
[effects]
drop_flattening = "off"
multiple_scattering = "off"
sun_disc = "off"
[picture]
exposure_ev = 1.0
"""


class Page:
    def __init__(self, driver):
        self.driver = driver

    def one(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def until(self, what, holds):
        end = time.time() + PATIENCE_S
        while time.time() < end:
            found = holds()
            if found:
                return found
            time.sleep(0.05)
        raise AssertionError(f"{what}: not within {PATIENCE_S} s; status {self.one('#status').text!r}")

    def finished(self):
        self.until("the picture", lambda: self.run("return document.getElementById('status')?.dataset.finished") == "true")

    def pixels(self):
        """Red, green and blue of the canvas by rows, and its width."""
        return self.run("""
            const canvas = document.getElementById('canvas');
            const all = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
            return [Array.from(all), canvas.width];""")

    def set_slider(self, path, part):
        """Moves the slider of a key as a hand does."""
        self.run("""
            const slider = document.getElementById(arguments[0]).closest('.field').querySelector('input[type=range]');
            slider.value = arguments[1];
            slider.dispatchEvent(new Event('input', { bubbles: true }));
            slider.dispatchEvent(new Event('change', { bubbles: true }));""", path, part)

    def type_into(self, path, text):
        box = self.driver.find_element(By.ID, path)
        self.run("arguments[0].closest('details').open = true", box)
        box.clear()
        box.send_keys(text, Keys.TAB)

    def value(self, path):
        return self.driver.find_element(By.ID, path).get_attribute("value")


def browser(size, scheme):
    options = webdriver.ChromeOptions()
    options.binary_location = "/usr/bin/chromium"
    for flag in ["--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage",
                 f"--window-size={size[0]},{size[1]}"]:
        options.add_argument(flag)
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService("/usr/bin/chromedriver"))
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia",
                           {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride",
                           {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": False})
    return driver


def as_run(niji, scene, folder, name):
    """The codes of a PNG that `niji run` leaves."""
    subprocess.run([niji, "run", scene, "-o", folder, "-q"], check=True, stdout=subprocess.DEVNULL)
    script = """
        const done = arguments[1];
        const image = new Image();
        image.onload = () => {
          const canvas = new OffscreenCanvas(image.width, image.height);
          const context = canvas.getContext('2d');
          context.drawImage(image, 0, 0);
          done(Array.from(context.getImageData(0, 0, image.width, image.height).data));
        };
        image.src = arguments[0];"""
    data = base64.b64encode((folder / name).read_bytes()).decode()
    return script, "data:image/png;base64," + data


def check_same(page, niji, scene, folder, name="image.png"):
    """Holds the canvas against the picture of a run."""
    script, source = as_run(niji, scene, folder, name)
    expected = page.driver.execute_async_script(script, source)
    found, _ = page.pixels()
    assert len(found) == len(expected), (len(found), len(expected))
    worst = max(abs(a - b) for a, b in zip(found, expected))
    assert worst <= 1, f"a code differs by {worst} from that of niji run"


def check_overlay(page):
    """From the middle of the bow outwards light ends where its red line runs, to one pixel."""
    lines = page.run("""
        return [...document.querySelectorAll('#marks .primary.red')].flatMap((line) =>
          line.getAttribute('points').split(' ').map((pair) => pair.split(',').map(Number)));""")
    rgb, width = page.pixels()
    height = len(rgb) // 4 // width

    def red(x, y):
        # Between pixels, linear.
        x, y = x - 0.5, y - 0.5
        column, row = int(math.floor(x)), int(math.floor(y))
        total = 0.0
        for j, wy in ((row, row + 1 - y), (row + 1, y - row)):
            for i, wx in ((column, column + 1 - x), (column + 1, x - column)):
                total += wx * wy * rgb[4 * (j * width + i)]
        return total

    top = min(lines, key=lambda it: it[1])
    offsets = []
    for a, b in zip(lines, lines[1:]):
        x, y = a
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        if length == 0 or abs(x - top[0]) > 40:
            continue
        # Across the line, outwards: up.
        across = [(b[1] - a[1]) / length, -(b[0] - a[0]) / length]
        if across[1] > 0:
            across = [-across[0], -across[1]]
        reach = [0.1 * step for step in range(-60, 61)]
        places = [(x + s * across[0], y + s * across[1]) for s in reach]
        if not all(1 < px < width - 1 and 1 < py < height - 1 for px, py in places):
            continue
        light = [red(*place) for place in places]
        falls = [light[i - 5] - light[i + 5] for i in range(5, len(light) - 5)]
        offsets.append(reach[5 + falls.index(max(falls))])
    assert len(offsets) > 20, len(offsets)
    mean = sum(offsets) / len(offsets)
    assert abs(mean) < 1.0, f"the red line lies {mean:.2f} pixels from where the light ends"
    return mean


def check_other_origin(page, address):
    """A page of somebody else in the same browser neither reads nor changes anything."""

    class Stranger(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<title>stranger</title>")

        def log_message(self, *_):
            pass

    server = http.server.HTTPServer(("127.0.0.1", 0), Stranger)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        page.driver.get(f"http://127.0.0.1:{server.server_address[1]}/")
        told = page.driver.execute_async_script("""
            const done = arguments[1];
            const ask = (mode) => fetch(arguments[0] + 'set', { method: 'POST', mode,
              body: '{"values": {"sun.elevation_deg": 44}}' }).then((it) => it.type, (it) => 'refused');
            Promise.all([ask('cors'), ask('no-cors')]).then(done);""", address)
        assert told[0] == "refused" and told[1] in ("opaque", "refused"), told
    finally:
        server.shutdown()
        server.server_close()


def check_drops(page):
    """The box of the drops is drawn when it is asked for, where the camera has it."""
    box = page.one("#show-drops")
    shown = "return getComputedStyle(document.querySelector('#marks .drops')).display"
    assert page.run(shown) == "none"
    box.click()
    assert page.run(shown) != "none"
    lines = page.run("""
        return [...document.querySelectorAll('#marks .drops polyline')].map((line) =>
          line.getAttribute('points').split(' ').map((pair) => pair.split(',').map(Number)));""")
    # Its far lower edge, 1.6 m below the eye and 1200 m away or a voxel farther, goes across the picture, which looks up
    # by 12 degrees and sees 90 across 240 pixels.
    def row(below, away):
        sin, cos = math.sin(math.radians(12.0)), math.cos(math.radians(12.0))
        return 67.5 + 120.0 * (below * cos + away * sin) / (away * cos - below * sin)

    rows = (row(1.6, 1200.0) - 0.5, row(101.6, 1300.0) + 0.5)
    across = [line for line in lines if abs(line[-1][0] - line[0][0]) > 200.0]
    assert any(all(rows[0] < y < rows[1] for _, y in line) for line in across), (rows, across)
    box.click()
    print(f"  drops: {len(lines)} lines of their box")


def check_date(page):
    """The sun by date and place and back; every scene on the way is one, and two steps take it back."""
    azimuth = page.value("sun.azimuth_deg")

    def choose(way):
        page.run("""
            const choice = document.getElementById('sun by');
            choice.value = arguments[0];
            choice.dispatchEvent(new Event('change', { bubbles: true }));""", way)

    def has(path):
        return page.run("return Boolean(document.getElementById(arguments[0]))", path)

    choose("date and place")
    page.until("a date", lambda: has("sun.date_time") and not has("sun.elevation_deg"))
    assert page.value("sun.latitude_deg") == "48.1"
    page.run("""
        const slider = document.getElementById('sun.date_time').closest('.field').querySelector('input[type=range]');
        slider.value = 60 * 19 + 5;
        slider.dispatchEvent(new Event('input', { bubbles: true }));
        slider.dispatchEvent(new Event('change', { bubbles: true }));""")
    page.until("another time", lambda: "2026-06-21T19:05:00+02:00" in page.run(
        "return document.querySelector('textarea').value"))
    page.type_into("sun.date_time", "yesterday")
    beside = "return document.getElementById('sun.date_time').closest('.field').querySelector('.wrong')?.textContent"
    page.until("what is wrong", lambda: page.run(beside))
    choose("elevation and azimuth")
    page.until("an elevation", lambda: has("sun.elevation_deg") and not has("sun.date_time"))
    # 21 June 2026, 17:05 UTC, 48.1 N, 11.6 E.
    elevation = float(page.value("sun.elevation_deg"))
    assert 18.0 < elevation < 21.0, elevation
    for _ in range(3):
        page.one("#undo").click()
    page.until("the sun of before", lambda: has("sun.azimuth_deg") and page.value("sun.azimuth_deg") == azimuth)
    page.finished()
    print(f"  date and place: sun at {elevation} degrees, and back")


def drive(page, niji, address, scene, folder):
    page.driver.get(address)
    page.finished()
    print("  load")
    check_same(page, niji, scene, folder / "loaded")
    print(f"  overlay {check_overlay(page):+.2f} pixels from the bow")

    before, _ = page.pixels()
    page.set_slider("sun.elevation_deg", 320)
    page.until("another picture", lambda: page.pixels()[0] != before)
    page.finished()
    slid = float(page.value("sun.elevation_deg"))
    assert abs(slid - 22.0) < 0.01, slid
    page.set_slider("sun.elevation_deg", 350)
    page.finished()
    changed, _ = page.pixels()
    assert changed != before and float(page.value("sun.elevation_deg")) == 25.0
    print(f"  slider: sun at {page.value('sun.elevation_deg')} degrees")

    canvas = page.one("#canvas")
    ActionChains(page.driver).move_to_element(canvas).click_and_hold().move_by_offset(40, 10).release().perform()
    page.until("the sun follows", lambda: abs(float(page.value("sun.azimuth_deg")) - 180.0) > 1.0)
    page.finished()
    print(f"  drag: sun at azimuth {page.value('sun.azimuth_deg')}")
    assert page.one("#reading").text.count("\n") >= 5, page.one("#reading").text

    assert "2000 µm" in page.one("#reading").text, page.one("#reading").text
    check_drops(page)
    check_date(page)

    page.type_into("sun.elevation_deg", "95")
    beside = "return document.getElementById('sun.elevation_deg').closest('.field').querySelector('.wrong')?.textContent"
    told = page.until("what is wrong", lambda: page.run(beside))
    assert "expected" in told and "90" in told, told
    print(f"  beside its field: {told}")
    page.type_into("sun.elevation_deg", "24")
    page.until("nothing is wrong", lambda: not page.run(beside))
    page.finished()

    page.run("document.getElementById('exposure').value = 2.5;"
             "document.getElementById('exposure').dispatchEvent(new Event('input'))")
    page.until("exposure", lambda: page.value("picture.exposure_ev") == "2.5")

    first = page.driver.current_window_handle
    page.driver.switch_to.new_window("tab")
    page.driver.get(address)
    page.finished()
    assert page.value("sun.elevation_deg") == "24"
    page.type_into("sun.elevation_deg", "26")
    page.finished()
    page.driver.close()
    page.driver.switch_to.window(first)
    page.until("the other tab", lambda: page.value("sun.elevation_deg") == "26")
    page.driver.refresh()
    page.finished()
    assert page.value("sun.elevation_deg") == "26"
    print("  two tabs, a reload")

    page.one("#keep").click()
    page.one("body").send_keys(Keys.CONTROL, "z")
    page.until("undo", lambda: page.value("sun.elevation_deg") == "24")
    page.finished()
    assert page.one("#wipe").is_displayed()
    page.one("#keep").click()
    page.one("#save").click()
    page.until("saved", lambda: not page.one("#save").is_enabled())
    text = scene.read_text()
    assert "elevation_deg = 24.0 # degrees" in text and text.startswith("# A scene for the page."), text
    check_same(page, niji, scene, folder / "saved")
    print("  saved, and a run makes the picture that is shown")

    scene.write_text(text.replace("driven", "theirs"))
    page.type_into("sun.elevation_deg", "25")
    page.until("edited", lambda: page.one("#save").is_enabled())
    page.one("#save").click()
    page.until("refused", lambda: "somebody else" in page.one("#message").text)
    page.one("#again").click()
    page.until("read again", lambda: page.one("#name").text == "theirs")
    print("  a scene that was edited elsewhere is not written over")

    # What was refused on purpose.
    refused = ("422", "409")
    complaints = [it for it in page.driver.get_log("browser")
                  if it["level"] == "SEVERE" and not any(code in it["message"] for code in refused)]
    assert not complaints, complaints
    check_other_origin(page, address)
    page.driver.get(address)
    page.finished()
    assert page.value("sun.elevation_deg") == "24"
    print("  another origin is refused")


def drive_photograph(page, niji, address, scene, folder):
    """A bow in a photograph: as a run sets it there; it goes where its picks are dragged to."""
    page.driver.get(address)
    page.finished()
    check_same(page, niji, scene, folder / "photograph", "composite.png")
    assert not page.one("#exposure").is_enabled()

    def picks():
        return page.run("""
            return [...document.querySelectorAll('#marks .pick')].map((it) => ['cx', 'cy'].map((key) => Number(it.getAttribute(key))));""")

    def red_line():
        return page.run("return document.querySelector('#marks .primary.red')?.getAttribute('points')")

    def drag(place, by):
        """From a place in pixels of the picture, by pixels of the screen; how many of these make one of those."""
        canvas = page.one("#canvas")
        size = page.run("const box = arguments[0].getBoundingClientRect(); return [box.width, box.height]", canvas)
        scale = size[0] / page.run("return document.getElementById('marks').viewBox.baseVal.width")
        offset = [round(at * scale - 0.5 * whole) for at, whole in zip(place, size)]
        (ActionChains(page.driver).move_to_element_with_offset(canvas, *offset)
            .click_and_hold().move_by_offset(*by).release().perform())
        return scale

    assert page.value("sun by") == "points of the bow"
    before, line = picks(), red_line()
    scale = drag(before[1], (0, -12))
    page.until("the bow follows", lambda: red_line() != line)
    page.finished()
    after = picks()
    moved = [b - a for a, b in zip(before[1], after[1])]
    assert abs(moved[0]) < 0.2 and abs(moved[1] + 12 / scale) < 0.2, moved
    places = [[float(it) for it in pair.split(",")] for pair in red_line().split()]
    off = max(min(math.dist(place, pick) for place in places) for pick in after)
    # Its line has a point every few pixels.
    assert off < 4.0, off
    print(f"  photograph: as a run makes it; its bow goes where a pick is dragged, {off:.1f} pixels off at most")

    # The sun of a bow so high has set.
    drag((320, 400), (0, -380 * scale))
    page.until("what is wrong", lambda: page.one("#message").text)
    print(f"  a bow that no sun makes: {page.one('#message').text}")
    # As far as it went.
    if picks() != after:
        page.one("#undo").click()
        page.until("undone", lambda: picks() == after)
    page.finished()
    page.one("#save").click()
    page.until("saved", lambda: not page.one("#save").is_enabled())
    check_same(page, niji, scene, folder / "dragged", "composite.png")
    ActionChains(page.driver).move_to_element(page.one("#canvas")).perform()
    page.driver.save_screenshot(str(folder / "view-photograph.png"))

    assert not page.one("#warnings").text
    scene.write_text(re.sub(r"(?m)^picks_px = .*", "picks_px = [[200, 110], [440, 89], [620, 77]]", scene.read_text()))
    page.one("#again").click()
    page.until("the nearest bow", lambda: "the nearest misses them" in page.one("#warnings").text)
    page.finished()
    print(f"  picks that are off: {page.one('#warnings').text}")


def photograph(folder):
    """The shipped scene of one, beside the files that it names."""
    data = Path(__file__).resolve().parents[2] / "data"
    text = (data / "scenes/photo-pavilion-rain.toml").read_text().replace("../photos/", f"{data}/photos/")
    scene = folder / "photograph.toml"
    scene.write_text(text)
    return scene


@contextlib.contextmanager
def served(niji, scene):
    """The address of a scene's page."""
    view = subprocess.Popen([niji, "view", scene, "-q"], stdout=subprocess.PIPE, text=True)
    try:
        yield view.stdout.readline().strip()
    finally:
        view.send_signal(signal.SIGINT)
        assert view.wait(20) == 130, view.returncode


def main():
    niji, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    scene = folder / "driven.toml"
    scene.write_text(SCENE)
    for old in ("loaded", "saved", "photograph", "dragged"):
        subprocess.run(["rm", "-rf", folder / old], check=True)
    driver = browser((1280, 800), "light")
    driver.set_script_timeout(PATIENCE_S)
    try:
        with served(niji, scene) as address:
            drive(Page(driver), niji, address, scene, folder)
            for size in ((1280, 800), (1920, 1080)):
                for scheme in ("light", "dark"):
                    driver.quit()
                    driver = browser(size, scheme)
                    page = Page(driver)
                    driver.get(address)
                    page.finished()
                    room = page.run("return [document.documentElement.scrollWidth, innerWidth]")
                    assert room[0] <= room[1], f"{size}: {room}"
                    ActionChains(driver).move_to_element(page.one("#canvas")).perform()
                    page.until("a spectrum", lambda: page.run("return document.querySelector('#spectrum polyline')"))
                    driver.save_screenshot(str(folder / f"view-{size[0]}-{scheme}.png"))
            print("  readable at 1280 and 1920, light and dark")
        driver.set_script_timeout(PATIENCE_S)
        scene = photograph(folder)
        with served(niji, scene) as address:
            drive_photograph(Page(driver), niji, address, scene, folder)
    finally:
        driver.quit()


if __name__ == "__main__":
    main()
