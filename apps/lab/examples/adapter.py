#!/usr/bin/env python3
"""A device of the live bench on standard input and output: put the calls of your hardware in the place of `Hardware`."""

import json
import random
import sys
import time

RATE, BLOCK = 10240.0, 512
CHANNELS = ["reference", "x", "y", "z"]


class Hardware:
    """Stands in for a shaker: every channel follows the drive, and noise is added."""

    def __init__(self):
        self.counter = 0
        self.due = time.monotonic()

    def start(self):
        """Begins anew; samples from before are let go."""
        self.counter = 0
        self.due = time.monotonic()

    def exchange(self, drive):
        """Puts out one block of drive, waits for its samples."""
        first, self.counter = self.counter, self.counter + len(drive)
        self.due += len(drive) / RATE
        time.sleep(max(0.0, self.due - time.monotonic()))
        gains = [0.3, 0.05, 0.05, 0.3]
        return first, [[g * v + random.gauss(0, 1e-5) for g in gains] for v in drive]

    def silence(self):
        """Puts the output to zero."""


def main():
    hardware = Hardware()
    identity = {
        "maker": "example", "model": "adapter in Python", "serial": "1", "channels": CHANNELS,
        "rate_Hz": RATE, "block": BLOCK, "full_scale_V": 10.0, "drive_V": 5.0,
    }
    for line in sys.stdin:
        word, _, rest = line.strip().partition(" ")
        if word == "hello":
            answer = "identity " + json.dumps(identity)
        elif word == "start":
            hardware.start()
            answer = "ok"
        elif word == "drive":
            first, rows = hardware.exchange([float(v) for v in rest.split()])
            answer = f"block {first} - " + " ".join(f"{v:.7g}" for row in rows for v in row)
        elif word == "silence":
            hardware.silence()
            answer = "ok"
        elif word == "arrange":
            answer = "ok"
        else:
            answer = f"error unknown word {word}"
        print(answer, flush=True)


main()
