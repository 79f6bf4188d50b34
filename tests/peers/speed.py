"""Times Skyfront and its peers in turn; see tests/peers/speed."""

import os
import statistics
import subprocess
import sys
import time

import numpy as np
import SimpleITK as sitk
from skimage.segmentation import morphological_geodesic_active_contour

SKYFRONT = "target/release/skyfront"
FRONT = "target/release/examples/front_speed"


# Starts a command from a small process: a child's peak memory counts that of the process it was forked from.
LAUNCH = """
import os, subprocess, sys, time
start = time.perf_counter()
child = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, usage = os.wait4(child.pid, 0)
print(status, time.perf_counter() - start, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)
"""


def command(words, folder):
    """Wall seconds, processor seconds and peak MiB of a command."""
    launch = [sys.executable, "-S", "-c", LAUNCH, *words]
    status, *figures = subprocess.run(launch, cwd=folder, check=True, capture_output=True, text=True).stdout.split()
    if status != "0":
        sys.exit(f"failed: {' '.join(words)}")
    return [float(figure) for figure in figures]


def cpu(function):
    start = time.process_time()
    function()
    return time.process_time() - start


def itk(g):
    """The front from the frame, shrinking at speed g, for 625 iterations."""
    h, w = g.shape
    y, x = np.mgrid[:h, :w]
    u0 = np.minimum(np.minimum(x, w - 1 - x), np.minimum(y, h - 1 - y)).astype(np.float32) - 1.5
    filter = sitk.GeodesicActiveContourLevelSetImageFilter()
    filter.SetPropagationScaling(-1.0)
    filter.SetCurvatureScaling(0.0)
    filter.SetAdvectionScaling(0.0)
    filter.SetMaximumRMSError(0.0)
    filter.SetNumberOfIterations(625)
    filter.SetNumberOfThreads(1)
    initial, feature = sitk.GetImageFromArray(-u0), sitk.GetImageFromArray(g)
    return cpu(lambda: filter.Execute(initial, feature))


def skimage(g):
    """The same front by morphology, for 150 iterations of one pixel each, smoothed as by default."""
    start = np.zeros(g.shape, np.int8)
    start[2:-2, 2:-2] = 1
    return cpu(lambda: morphological_geodesic_active_contour(
        g, 150, init_level_set=start, threshold=0.01, balloon=-1))


def table(title, unit, columns, reference):
    print(f"\n{title}")
    base = statistics.median(columns[reference])
    for name, values in columns.items():
        median = statistics.median(values)
        print(f"  {name:44} {median:9.4f} {unit}   {base / median:7.2f} x {reference}")


def fronts(small, runs, folder):
    edge = os.path.join(folder, "edge.f32")
    # The paper's step, a quarter of a pixel where g = 1, as SimpleITK's; and the longest one that is monotone.
    fronts = {"skyfront fd": ["0.025"], "skyfront fd, band 8": ["0.025", "8"], "skyfront fd, band 4": ["0.025", "4"],
              "skyfront fd, dt 0.05": ["0.05"], "skyfront fd, dt 0.05, band 8": ["0.05", "8"]}
    columns = {name: [] for name in ("SimpleITK", "scikit-image", *fronts)}
    for _ in range(runs):
        for name, how in fronts.items():
            words = subprocess.run([FRONT, "front", small, edge, *how], check=True, capture_output=True, text=True)
            seconds, _, width, height = words.stdout.split()
            columns[name].append(float(seconds))
        g = np.fromfile(edge, "<f4").reshape(int(height), int(width))
        columns["SimpleITK"].append(itk(g))
        columns["scikit-image"].append(skimage(g))
    title = f"front from the frame to rest on {small}, one thread, processor seconds"
    table(title, "s", columns, "SimpleITK")
    table(title, "s", columns, "scikit-image")


ISOPHOTAL = ["NUMBER", "X_IMAGE", "Y_IMAGE", "FLUX_ISO", "A_IMAGE", "B_IMAGE", "THETA_IMAGE", "ISOAREA_IMAGE", "FLAGS"]
# What our catalogue holds beside it.
ALL = [*ISOPHOTAL, "FLUX_AUTO", "FLUXERR_AUTO", "FLUX_RADIUS", "KRON_RADIUS"]
# Our columns that need the pixels of the sources only.
OURS = "label,x,y,area,flux,a,b,theta,flags"


def source_extractor(large, folder, columns):
    """The command that writes a map and these columns."""
    name = f"peer{len(columns)}.param"
    with open(os.path.join(folder, name), "w") as file:
        file.write("\n".join(columns) + "\n")
    with open(os.path.join(folder, "peer.conv"), "w") as file:
        file.write("CONV NORM\n1 2 1\n2 4 2\n1 2 1\n")
    return ["source-extractor", os.path.abspath(large), "-c", "/dev/null", "-PARAMETERS_NAME", name,
            "-FILTER_NAME", "peer.conv", "-CHECKIMAGE_TYPE", "SEGMENTATION", "-CHECKIMAGE_NAME", "peer_map.fits",
            "-CATALOG_TYPE", "ASCII", "-CATALOG_NAME", "peer.cat", "-NTHREADS", "1", "-VERBOSE_TYPE", "QUIET"]


def in_turn(title, commands, runs, folder):
    """Runs the commands in turn and prints what each took beside the first."""
    results = {name: [] for name in commands}
    for _ in range(runs):
        for name, words in commands.items():
            results[name].append(command(words, folder))
    for index, (what, unit) in enumerate((("wall seconds", "s"), ("processor seconds", "s"), ("peak memory", "MiB"))):
        columns = {name: [row[index] for row in rows] for name, rows in results.items()}
        table(f"{title}, {what}", unit, columns, next(iter(commands)))


def ours(large, folder):
    return [os.path.abspath(SKYFRONT), "segment", os.path.abspath(large), "--no-pictures", "--overwrite", "--quiet",
            "--out", os.path.abspath(os.path.join(folder, "out"))]


def the_default(large, runs, folder):
    """The default beside a peer that measures the same."""
    words = [*ours(large, folder), "--map-only"]
    short = [*words, "--columns", OURS]
    in_turn(f"{large}, the default, with FLUX_AUTO, FLUX_RADIUS and KRON_RADIUS", {
        "source-extractor": source_extractor(large, folder, ALL),
        "skyfront": [*words, "--threads", "1"],
        "skyfront, 2 threads": [*words, "--threads", "2"],
    }, runs, folder)
    in_turn(f"{large}, the default, with what the sources' own pixels tell", {
        "source-extractor": source_extractor(large, folder, ISOPHOTAL),
        "skyfront": [*short, "--threads", "1"],
        "skyfront, 2 threads": [*short, "--threads", "2"],
    }, runs, folder)


def whole(large, runs, folder):
    words = [*ours(large, folder), "--t-max", "200", "--preset", "paper-f160"]
    marching = [*words, "--threads", "1", "--scheme", "fast-marching"]
    in_turn(f"{large}, file to map and catalogue", {
        "source-extractor": source_extractor(large, folder, ISOPHOTAL),
        "skyfront fast-marching": marching,
        "skyfront fast-marching, --map-only": [*marching, "--map-only"],
        "skyfront fd, start threshold": [*words, "--threads", "1", "--band", "8", "--start", "threshold"],
        "skyfront fd from the frame, band 8": [*words, "--threads", "1", "--band", "8"],
        "skyfront fd from the frame, band 8, 2 threads": [*words, "--threads", "2", "--band", "8"],
    }, runs, folder)


if __name__ == "__main__":
    small, large, runs, folder = sys.argv[1:]
    the_default(large, int(runs), folder)
    fronts(small, int(runs), folder)
    whole(large, int(runs), folder)
