#!/usr/bin/env python3
"""Checks when OpenEXR takes the frame of an EXR file to be shown.

    python check_time.py FILE RATE HH:MM:SS:FF        (needs: OpenEXR)

RATE is a fraction, as 24000/1001. The first part has `framesPerSecond`, all have the same `timeCode`, which drops no
frame. Exit status 0 if it is so; otherwise 1, and a line that says what was found.
"""

import sys

import OpenEXR


def expect(holds, message):
    if not holds:
        raise SystemExit(f"{sys.argv[0]}: {message}")


path, rate, code = sys.argv[1:]
with OpenEXR.File(path, header_only=True) as file:
    headers = [dict(part.header) for part in file.parts]
found = headers[0].get("framesPerSecond")
expect(found is not None, f"{path}: no framesPerSecond")
expect(f"{found.numerator}/{found.denominator}" == rate, f"{path}: found {found.numerator}/{found.denominator}, expected {rate}")
for header in headers:
    time = header.get("timeCode")
    expect(time is not None, f"{path}: a part without timeCode")
    numbers = (time.hours, time.minutes, time.seconds, time.frame)
    text = ":".join(f"{number:02}" for number in numbers)
    expect(text == code, f"{path}: found {text}, expected {code}")
    expect(not time.dropFrame, f"{path}: found a code that drops frames")
