"""What each choice of a step brings: scores of settings on simulated skies with known truth, as a table.

    python3 tests/peers/choices.py [SEEDS [SKYFRONT]]
"""

import json
import pathlib
import subprocess
import sys
import tempfile

KINDS = ["bright", "noisy", "stars"]
SETTINGS = {
    "the default": "",
    "one sky for the frame": "--sky frame",
    "Gaussian alone": "--filter gauss",
    "outline at the threshold": "--outline-steps 0",
    "components": "--separate components",
    "by area alone": "--select area",
    "the paper's front": "--preset rsa",
    "the paper's setting": "--preset paper-f160",
}
MEASURES = ["combined", "f_score", "pq"]


def score(program, folder, words):
    segment = [program, "segment", folder / "sky.fits", "--out", folder / "out", "--overwrite", "--no-pictures"]
    subprocess.run([*segment, "--quiet", *words.split()], check=True)
    words = [program, "score", folder / "truth.fits", folder / "out/segmentation.fits", "--image", folder / "sky.fits"]
    return json.loads(subprocess.run(words, capture_output=True, check=True).stdout)


def main(seeds, program):
    means = {}
    for kind in KINDS:
        for seed in range(301, 301 + seeds):
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                subprocess.run([program, "simulate", "--kind", kind, "--seed", str(seed), "--out", folder], check=True)
                for setting, words in SETTINGS.items():
                    means.setdefault((setting, kind), []).append(score(program, folder, words))
    print(f"Means over seeds 301 to {300 + seeds}, 300 x 300 pixels: {', '.join(MEASURES)}\n")
    print("| choice | options | " + " | ".join(KINDS) + " |")
    print("|---" * (len(KINDS) + 2) + "|")
    for setting, words in SETTINGS.items():
        cells = []
        for kind in KINDS:
            scores = means[setting, kind]
            cells.append(", ".join(f"{sum(one[name] for one in scores) / seeds:.3f}" for name in MEASURES))
        print(f"| {setting} | `{words}` | " + " | ".join(cells) + " |")


main(int((sys.argv[1:] or [6])[0]), (sys.argv[2:] or ["target/release/skyfront"])[0])
