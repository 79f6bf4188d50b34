"""What each filter brings with each front: scores and times on images with known truth, as a table.

    python3 tests/peers/filters.py FOLDER [SKYFRONT [NAME ...]]

FOLDER holds NAME.fits and NAME_truth.fits.gz for each name; not given, all of them are taken.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

STEPPED = ["heat", "pm", "median", "median5", "bilateral:0.1", "tv:0.1", "starlet:3"]
FILTERS = ["none", *STEPPED, "gauss", "adaptive"]
FRONTS = {
    "the paper's setting": "--preset paper-f160",
    "two planes": "--preset paper-f160 --normalize noise:3,30 --tau noise:3 --min-area 6 --order filter-first",
    "fd, rescaled first": "--preset rsa",
    "fd": "--preset rsa --order filter-first",
    "sl": "--preset rsa --scheme sl --order filter-first",
    "chan-vese": "--preset rsa --scheme chan-vese --order filter-first",
    "the default": "",
}


def options(front, name):
    """The options for a front with a filter; None where they do not go together."""
    words = FRONTS[front]
    if name in STEPPED:
        return f"{words} --filter {name}"
    # Without a sky there are no smoothed planes; what is no step has no order.
    if front in ["the paper's setting", "two planes"] and name != "none" or front == "fd, rescaled first":
        return None
    return f"{words.removesuffix(' --order filter-first')} --filter {name}"


def run(program, image, truth, words):
    with tempfile.TemporaryDirectory() as out:
        segment = [program, "segment", image, "--out", out, "--overwrite", "--no-pictures", "--map-only", "--quiet"]
        start = time.monotonic()
        subprocess.run([*segment, *words.split()], check=True)
        seconds = time.monotonic() - start
        labels = pathlib.Path(out) / "segmentation.fits"
        words = [program, "score", truth, labels, "--image", image]
        return json.loads(subprocess.run(words, capture_output=True, check=True).stdout)["combined"], seconds


def main(folder, program="target/release/skyfront", *names):
    folder = pathlib.Path(folder)
    names = names or sorted(path.name.removesuffix("_truth.fits.gz") for path in folder.glob("*_truth.fits.gz"))
    print(f"Combined score and seconds, means over {', '.join(names)}\n")
    print("| filter | " + " | ".join(FRONTS) + " |")
    print("|---" * (len(FRONTS) + 1) + "|")
    for name in FILTERS:
        cells = []
        for front in FRONTS:
            words = options(front, name)
            if words is None:
                cells.append("")
                continue
            files = [(folder / f"{one}.fits", folder / f"{one}_truth.fits.gz") for one in names]
            results = [run(program, image, truth, words) for image, truth in files]
            score, seconds = (sum(part) / len(results) for part in zip(*results))
            cells.append(f"{score:.3f}, {seconds:.2f}")
        print(f"| `{name}` | " + " | ".join(cells) + " |", flush=True)


main(*sys.argv[1:])
