"""Feeds centroids to a plate solver: Skyfront's beside those of the peers; see tests/peers/tracker."""

import ctypes
import pathlib
import subprocess
import sys
import tempfile
import time
from math import erf

import numpy as np
import sep
import tetra3
import tetra3rs
from astropy.io import fits
from astropy.table import Table

# Brightest stars given to the solver, as a tracker uses them: with more, it takes wrong stars for its own, whoever found
# them; a window's side, pixels.
STARS, SIDE = 30, 15
# A tracker may be off by this much in the middle of its frames, arcseconds.
BAR = 4.5
LOST = 16


class Camera(ctypes.Structure):
    _fields_ = [(name, ctypes.c_float) for name in ("black", "gain", "read_noise", "saturation", "psf_sigma")]


class Window(ctypes.Structure):
    _fields_ = [("x", ctypes.c_float), ("y", ctypes.c_float), ("width", ctypes.c_uint16), ("height", ctypes.c_uint16)]


STAR = np.dtype([(name, "f4") for name in ("x", "y", "flux", "snr", "errx2", "erry2", "errxy")] + [("flags", "u4")])


def made(solver, seed, side=1024, field=12.0, sigma=1.0):
    """A frame of the sky by the solver's catalogue, where its stars are, and the camera that made it."""
    random = np.random.default_rng(seed)
    table = solver.star_table
    ra, dec, roll = random.uniform(0, 2 * np.pi), np.arcsin(random.uniform(-1, 1)), random.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(dec) * np.cos(ra), np.cos(dec) * np.sin(ra), np.sin(dec)])
    east = np.array([-np.sin(ra), np.cos(ra), 0])
    north = np.cross(axis, east)
    vectors = table[:, 2:5]
    depth = vectors @ axis
    near = depth > np.cos(np.radians(field))
    scale = side / 2 / np.tan(np.radians(field / 2))
    # Columns grow to the west where north is up: the sky seen from inside.
    right, up = -(vectors[near] @ east) / depth[near] * scale, (vectors[near] @ north) / depth[near] * scale
    x = np.cos(roll) * right - np.sin(roll) * up + side / 2 - 0.5
    y = side / 2 - 0.5 - (np.sin(roll) * right + np.cos(roll) * up)
    flux = 4e5 * 10 ** (-0.4 * (table[near, 5] - 2))
    # One centroid cannot be two stars: those with a neighbour within six pixels are left out of the sky.
    alone = np.hypot(x[:, None] - x, y[:, None] - y) + 99 * np.eye(len(x))
    inside = (x > 8) & (y > 8) & (x < side - 9) & (y < side - 9) & (alone.min(axis=0) > 6)
    light = np.full((side, side), 30.0)
    edges = np.arange(side + 1) - 0.5
    share = np.vectorize(lambda distance: 0.5 * erf(distance / (sigma * 2**0.5)))
    for cx, cy, electrons in zip(x[inside], y[inside], flux[inside]):
        columns, rows = (slice(int(c) - 7, int(c) + 9) for c in (cx, cy))
        along = [np.diff(share(edges[span.start : span.stop + 1] - c)) for span, c in ((columns, cx), (rows, cy))]
        light[rows, columns] += electrons * np.outer(along[1], along[0])
    counts = (random.poisson(light) + random.normal(0, 8, light.shape)) / 2 + 100
    camera = Camera(black=100, gain=2, read_noise=8, saturation=65535, psf_sigma=sigma)
    return np.clip(np.round(counts), 0, 65535).astype(np.uint16), (x[inside], y[inside]), camera


def unknown(frame, x, y):
    """A camera by its frame alone: all noise is the read-out's, and the width that of the middle of the stars."""
    values = frame.astype(float)
    sky = np.median(values)
    noise = 1.4826 * np.median(np.abs(values - sky))
    widths = []
    for cx, cy in zip(x, y):
        column, row = int(round(cx)), int(round(cy))
        near = values[row - 4 : row + 5, column - 4 : column + 5] - sky
        if near.shape == (9, 9) and near.max() < 60000 - sky:
            # The light under a Gaussian of one pixel's width and of two: their ratio tells the star's own.
            yy, xx = np.mgrid[-4:5, -4:5]
            square = (xx + column - cx) ** 2 + (yy + row - cy) ** 2
            narrow, wide = (np.sum(near * np.exp(-square / (2 * s * s))) for s in (1, 2))
            ratio = wide / narrow
            # A star of width t holds s^2 / (s^2 + t^2) of its light under a window of width s.
            widths.append(np.sqrt(max(0.3, (4 * ratio - 4) / (4 - ratio))) if ratio < 3.8 else 3)
    return Camera(black=0, gain=100, read_noise=noise * 100, saturation=65535, psf_sigma=np.clip(np.median(widths), 0.5, 3))


def detected(program, frame, folder):
    """Places by the catalogue of the preset, brightest first: its centroids and those under its own window."""
    fits.writeto(folder / "frame.fits", frame, overwrite=True)
    words = [program, "segment", folder / "frame.fits", "--out", folder, "--overwrite", "--no-pictures", "--quiet"]
    subprocess.run([*words, "--preset", "star-tracker", "--columns", "x,y,xwin,ywin,flux"], check=True)
    table = Table.read(folder / "catalog.fits")
    table.sort("flux", reverse=True)
    table = table[np.isfinite(table["xwin"])][: 2 * STARS]
    plain, windowed = ((np.array(table[a]) - 1, np.array(table[b]) - 1) for a, b in (("x", "y"), ("xwin", "ywin")))
    return plain, windowed


def tracked(library, frame, x, y, camera):
    """Centres by the C interface in windows at given places, brightest first, and the seconds it took."""
    windows = (Window * len(x))(*[Window(cx, cy, SIDE, SIDE) for cx, cy in zip(x, y)])
    stars = np.zeros(len(x), STAR)
    height, width = frame.shape
    sizes = [ctypes.c_size_t(size) for size in (width, height, width)]
    frame_at, stars_at = (ctypes.c_void_p(array.ctypes.data) for array in (frame, stars))
    count = ctypes.c_size_t(len(x))
    began = time.perf_counter()
    error = library.skyfront_track_u16(
        frame_at, *sizes, ctypes.byref(camera), windows, count, None, ctypes.c_size_t(0), stars_at
    )
    seconds = time.perf_counter() - began
    assert error == 0, f"error {error}"
    good = stars[stars["flags"] & LOST == 0]
    good = good[np.argsort(-good["flux"])]
    # Two windows that found one star: the second of a pair is left out.
    apart = np.hypot(np.diff(good["x"], prepend=-9.0), np.diff(good["y"], prepend=-9.0)) > 0.5
    return good[apart], seconds


def solution(solver, places, shape):
    """Whether the solver finds the field, its residual (arcseconds), and its matches."""
    x, y = (np.asarray(axis)[:STARS] for axis in places)
    found = solver.solve_from_centroids(np.column_stack([y, x]) + 0.5, shape, fov_estimate=None)
    if found["RA"] is None:
        return None
    return found["RMSE"], found["Matches"]


def methods(program, library, solver, frame, camera, folder):
    """Name, places and seconds of every way to find stars."""
    began = time.perf_counter()
    plain, windowed = detected(program, frame, folder)
    seconds = time.perf_counter() - began
    yield "skyfront, catalogue", plain, seconds
    yield "skyfront, xwin", windowed, seconds
    stars, seconds = tracked(library, frame, *plain, camera or unknown(frame, *plain))
    yield "skyfront, track", (stars["x"], stars["y"]), seconds
    began = time.perf_counter()
    places = tetra3.get_centroids_from_image(frame)
    yield "cedar-solve's own", (places[:, 1] - 0.5, places[:, 0] - 0.5), time.perf_counter() - began
    began = time.perf_counter()
    values = frame.astype(float)
    back = sep.Background(values)
    objects = sep.extract(values - back.back(), 5, err=back.globalrms)
    objects = objects[np.argsort(-objects["flux"])][: 2 * STARS]
    radius, _ = sep.flux_radius(values - back.back(), objects["x"], objects["y"], 6 * objects["a"], 0.5)
    xwin, ywin, _ = sep.winpos(values - back.back(), objects["x"], objects["y"], radius / 1.1774)
    yield "sep, winpos", (xwin, ywin), time.perf_counter() - began
    began = time.perf_counter()
    found = tetra3rs.extract_centroids(values.astype(np.float32)).centroids
    found = sorted(found, key=lambda star: -star.brightness)
    height, width = frame.shape
    # Its origin is the middle of the image.
    places = [(star.x + width / 2 - 0.5, star.y + height / 2 - 0.5) for star in found]
    yield "tetra3rs", tuple(np.array(places).T), time.perf_counter() - began


def main(program, library, images):
    library = ctypes.CDLL(str(pathlib.Path(library).resolve()))
    solver = tetra3.Tetra3("default_database")
    frames = [(f"made {seed}", *made(solver, seed)) for seed in range(1, 6)]
    for image in images:
        pixels = np.ascontiguousarray(fits.getdata(image)[::-1].astype(np.uint16))
        frames.append((pathlib.Path(image).stem, pixels, None, None))
    print(f"{'frame':<32} {'centroids':<20} {'residual':>9} {'matches':>7} {'off':>7} {'time':>8}")
    print(f"{'':<32} {'':<20} {'arcsec':>9} {'':>7} {'px':>7} {'ms':>8}")
    residuals = {}
    for name, frame, truth, camera in frames:
        with tempfile.TemporaryDirectory() as folder:
            for method, places, seconds in methods(program, library, solver, frame, camera, pathlib.Path(folder)):
                solved = solution(solver, places, frame.shape)
                residual, matches = solved if solved else (np.inf, 0)
                residuals.setdefault(method, []).append(residual)
                off = "-"
                if truth:
                    distance = [np.min(np.hypot(truth[0] - x, truth[1] - y)) for x, y in zip(*places)][:STARS]
                    distance = [d for d in distance if d < 1]
                    off = f"{np.sqrt(np.mean(np.square(distance))):.4f}"
                print(f"{name:<32} {method:<20} {residual:9.2f} {matches:7} {off:>7} {1e3 * seconds:8.1f}")
    print()
    for method, values in residuals.items():
        print(f"{method:<20} solved {np.isfinite(values).sum()} of {len(values)}, median residual {np.median(values):.2f} arcsec")
    for method in ("skyfront, catalogue", "skyfront, track"):
        if not np.isfinite(residuals[method]).all():
            sys.exit(f"{method}: a frame is not solved")
    if np.median(residuals["skyfront, catalogue"]) > BAR:
        sys.exit(f"the median residual of the catalogue's centroids is above {BAR} arcsec")


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3:])
