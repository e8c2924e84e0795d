"""Time and memory of a photo scene at 24 megapixels: JPEG, JPEG turned by EXIF, PNG of 16 bit.

    python photo_24_megapixels.py path/to/niji

Needs NumPy and Pillow. The shipped photograph is enlarged to 6000 x 4003 pixels; its labels stay small
and its bow is rendered at 640 x 427. Prints wall time, the program's peak memory and the time of each
stage; fails above 30 s or 3 GiB, or if the three pictures differ by more than their coding.
"""

import json
import os
import struct
import sys
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
SIZE = (6000, 4003)
MOST_SECONDS = 30.0
MOST_BYTES = 3 << 30
# Orientation of EXIF: row 0 of the file is the right side of the scene.
ORIENTATION_TAG, TURNED = 0x0112, 6


def png16(path, codes):
    """Writes 16-bit RGB, which Pillow does not."""
    height, width, _ = codes.shape
    rows = np.zeros((height, 1 + 6 * width), np.uint8)
    rows[:, 1:] = codes.astype(">u2").reshape(height, -1).view(np.uint8)

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 16, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
        file.write(chunk(b"IDAT", zlib.compress(rows.tobytes(), 1)) + chunk(b"IEND", b""))


def pictures(folder):
    small = Image.open(ROOT / "data/photos/pavilion.jpg").convert("RGB")
    large = small.resize(SIZE, Image.BICUBIC)
    large.save(folder / "plain.jpg", quality=95, subsampling=0)
    exif = Image.Exif()
    exif[ORIENTATION_TAG] = TURNED
    large.transpose(Image.ROTATE_90).save(folder / "turned.jpg", quality=95, subsampling=0, exif=exif)
    png16(folder / "deep.png", np.asarray(large).astype(np.uint16) * 257)
    return ["plain.jpg", "turned.jpg", "deep.png"]


def scene(folder, picture):
    text = (ROOT / "data/scenes/photo-pavilion-rain.toml").read_text()
    text = text.replace("../photos/pavilion.jpg", str(folder / picture))
    text = text.replace("../photos/", str(ROOT / "data/photos") + "/")
    # Picks are pixels of the photograph.
    scale = SIZE[0] / 640
    picks = np.array([[200.0, 109.6], [440.0, 48.7], [620.0, 76.7]]) * scale
    lines = [
        f"picks_px = {picks.tolist()}" if line.startswith("picks_px") else line
        for line in text.splitlines()
    ]
    path = folder / f"{picture}.toml"
    path.write_text("\n".join(lines) + "\n")
    return path


def measure(niji, folder, picture):
    out = folder / f"out-{picture}"
    command = [niji, "run", str(scene(folder, picture)), "-o", str(out), "-q", "--threads", "2"]
    start = time.perf_counter()
    pid = os.spawnv(os.P_NOWAIT, niji, command)
    _, status, usage = os.wait4(pid, 0)
    seconds = time.perf_counter() - start
    assert status == 0, f"niji ended with {os.waitstatus_to_exitcode(status)}"
    stages = json.loads((out / "report.json").read_text())["stages"]
    table = ", ".join(f"{stage['stage']} {stage['seconds']:.2f}" for stage in stages)
    cpu = usage.ru_utime + usage.ru_stime
    peak = 1024 * usage.ru_maxrss
    print(f"{picture}: {seconds:.1f} s, {cpu:.1f} s of CPU, {peak / 2**30:.2f} GiB ({table})")
    return np.asarray(Image.open(out / "composite.png")).astype(int), seconds, peak


def main():
    niji = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        results = [measure(niji, folder, picture) for picture in pictures(folder)]
    plain = results[0][0]
    for picture, _, _ in results[1:]:
        difference = np.abs(picture - plain)
        print(f"mean difference {difference.mean():.2f} of 255, 99.9 % within "
              f"{np.percentile(difference, 99.9):.0f}")
        assert difference.mean() < 2.0
    assert all(seconds < MOST_SECONDS for _, seconds, _ in results)
    assert all(peak < MOST_BYTES for _, _, peak in results)


if __name__ == "__main__":
    main()
