"""Compares what sources measure with Skyfront and its peers; see tests/peers/photometry."""

import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np
import sep
from astropy.io import fits
from astropy.table import Table
from photutils.segmentation import SegmentationImage, SourceCatalog

RADIUS, ZERO_POINT, MATCH = 4.0, 25.0, 1.0
# Our columns, and where the peers have the same quantity.
PHOTUTILS = {
    "x": "x_centroid", "y": "y_centroid", "area": "segment_area", "flux": "segment_flux", "flux_err": "segment_flux_err",
    "a": "semimajor_axis", "b": "semiminor_axis", "ellipticity": "ellipticity", "fwhm": "fwhm",
    "flux_kron": "kron_flux", "flux_kron_err": "kron_flux_err",
}
SEXTRACTOR = {
    "x": "X_IMAGE", "y": "Y_IMAGE", "xwin": "XWIN_IMAGE", "ywin": "YWIN_IMAGE", "errx2": "ERRX2_IMAGE",
    "errx2win": "ERRX2WIN_IMAGE", "a": "A_IMAGE", "b": "B_IMAGE", "ellipticity": "ELLIPTICITY", "flux": "FLUX_ISO",
    "flux_kron": "FLUX_AUTO", "flux_kron_err": "FLUXERR_AUTO", "half_light_radius": "FLUX_RADIUS",
    "flux_aper_1": "FLUX_APER", "flux_petrosian": "FLUX_PETRO", "mag_kron": "MAG_AUTO", "kron_factor": "KRON_RADIUS", "background": "BACKGROUND",
}


def pairs(path, side=512, width=3.0, noise=5.0, seed=1):
    """Stars of a signal-to-noise of 30 to 60, most of them with a neighbour at 2 to 3 widths; gives those that have one.

    Column and row from 1, flux: a row for each.
    """
    stars = []
    random = np.random.default_rng(seed)
    sigma = width / 2.3548
    y, x = np.mgrid[:side, :side].astype(float)
    pixels = random.normal(100, noise, (side, side))
    for row in range(30, side - 20, 40):
        for column in range(30, side - 20, 40):
            flux = random.uniform(30, 60) * noise * np.sqrt(4 * np.pi) * sigma
            places = [(column + random.uniform(-0.5, 0.5), row + random.uniform(-0.5, 0.5), flux)]
            if random.uniform() < 0.7:
                far, angle = random.uniform(2, 3) * width, random.uniform(0, 2 * np.pi)
                (cx, cy, _), share = places[0], random.uniform(0.5, 1)
                places.append((cx + far * np.cos(angle), cy + far * np.sin(angle), share * flux))
                stars.append((cx + 1, cy + 1, flux))
            near = np.s_[row - 25 : row + 26, column - 25 : column + 26]
            for cx, cy, light in places:
                square = (x[near] - cx) ** 2 + (y[near] - cy) ** 2
                pixels[near] += light / (2 * np.pi * sigma**2) * np.exp(-square / (2 * sigma**2))
    fits.writeto(path, pixels.astype(np.float32))
    return np.array(stars)


def ours(program, image, folder):
    words = [program, "segment", image, "--out", folder, "--overwrite", "--no-pictures", "--quiet", "--sky-maps"]
    words += ["--columns", "all", "--apertures", str(RADIUS), "--zero-point", str(ZERO_POINT)]
    subprocess.run(words, check=True)
    maps = {name: fits.getdata(folder / f"{name}.fits").astype(float) for name in ["background", "noise"]}
    return Table.read(folder / "catalog.fits"), fits.getdata(folder / "segmentation.fits"), maps


def photutils(pixels, labels, maps):
    """Its catalogue of the same labels, neighbours replaced by the light opposite to them, as ours."""
    settings = {"error": maps["noise"], "apermask_method": "correct", "kron_params": (2.5, 1.4, 0)}
    found = SourceCatalog(pixels - maps["background"], SegmentationImage(labels), **settings)
    bare = lambda values: np.asarray(getattr(values, "value", values), float)
    columns = {ours: bare(getattr(found, name)) for ours, name in PHOTUTILS.items() if name}
    columns["x"], columns["y"] = columns["x"] + 1, columns["y"] + 1
    columns["half_light_radius"] = bare(found.fluxfrac_radius(0.5))
    columns["flux_aper_1"] = bare(found.circular_photometry(RADIUS)[0])
    return columns


def with_sep(pixels, labels, maps, table):
    """Aperture sums and windowed centroids at the same places, other labels masked out of nothing."""
    data = np.ascontiguousarray(pixels - maps["background"])
    x, y = np.asarray(table["x"] - 1, float), np.asarray(table["y"] - 1, float)
    mapped = np.ascontiguousarray(labels.astype(np.int32))
    identity = np.asarray(table["label"], np.int32)
    flux, error, _ = sep.sum_circle(data, x, y, RADIUS, err=maps["noise"], segmap=mapped, seg_id=identity, subpix=0)
    width = np.where(np.isfinite(table["half_light_radius"]), table["half_light_radius"], 1)
    xwin, ywin, _ = sep.winpos(data, x, y, np.asarray(width * 2 / 2.35, float))
    return {"flux_aper_1": flux, "flux_aper_1_err": error, "xwin": xwin + 1, "ywin": ywin + 1}


def sextractor(image, folder):
    (folder / "peer.param").write_text("\n".join(["NUMBER", "FLAGS", *SEXTRACTOR.values()]) + "\n")
    (folder / "peer.conv").write_text("CONV NORM\n1 2 1\n2 4 2\n1 2 1\n")
    words = ["source-extractor", str(pathlib.Path(image).resolve()), "-c", "/dev/null", "-PARAMETERS_NAME", "peer.param"]
    words += ["-FILTER_NAME", "peer.conv", "-CATALOG_NAME", "peer.fits", "-CATALOG_TYPE", "FITS_1.0", "-GAIN", "0"]
    words += ["-PHOT_APERTURES", str(2 * RADIUS), "-MAG_ZEROPOINT", str(ZERO_POINT), "-VERBOSE_TYPE", "QUIET"]
    subprocess.run(words, cwd=folder, check=True)
    return Table.read(folder / "peer.fits")


def show(peer, column, mine, theirs):
    """One line: how many values, the ratio or for places the difference, its median and scatter."""
    sound = np.isfinite(mine) & np.isfinite(theirs)
    differs = column in ("x", "y", "xwin", "ywin", "mag_kron", "ellipticity", "background")
    sound &= differs | (theirs != 0)
    if not sound.any():
        return
    value = mine[sound] - theirs[sound] if differs else mine[sound] / theirs[sound]
    median = np.median(value)
    scatter = 1.4826 * np.median(np.abs(value - median))
    what = "difference" if differs else "ratio"
    ends = np.percentile(value, [5, 95])
    print(f"{peer:17} {column:18} {sound.sum():6} {what:10} {median:12.6g} {scatter:11.3g} {ends[0]:11.4g} {ends[1]:11.4g}")


def compare(program, image, folder):
    table, labels, maps = ours(program, image, folder)
    if not len(table):
        print(f"{image}: no source")
        return
    pixels = first_image(image).astype(float)
    print(f"\n{pathlib.Path(image).name}: {len(table)} sources")
    print(f"{'peer':17} {'column':18} {'number':>6} {'':10} {'median':>12} {'scatter':>11} {'5 %':>11} {'95 %':>11}")
    for peer, columns in [("photutils", photutils(pixels, labels, maps)), ("SEP", with_sep(pixels, labels, maps, table))]:
        for name, values in columns.items():
            if len(values) == len(table):
                show(peer, name, np.asarray(table[name], float), values)
    theirs = sextractor(image, folder)
    if not len(theirs):
        return
    far = np.hypot(*(np.asarray(table[n])[:, None] - np.asarray(theirs[m]) for n, m in [("x", "X_IMAGE"), ("y", "Y_IMAGE")]))
    nearest = far.argmin(axis=1)
    matched = far[np.arange(len(table)), nearest] < MATCH
    for name, peer in SEXTRACTOR.items():
        values = np.asarray(theirs[peer], float)
        values = values[nearest] if values.ndim == 1 else values[nearest, 0]
        show("source-extractor", name, np.asarray(table[name], float)[matched], values[matched])


def beside_truth(program, folder, seeds=range(1, 7)):
    """Kron fluxes and windowed centroids of stars with a close neighbour beside their true ones; whether the bars hold.

    Fluxes within 2 % in the median, with a scatter not above that of source-extractor's FLUX_AUTO, and centroids with
    an rms of at most 1.1 of its XWIN_IMAGE.
    """
    fluxes, offsets = {}, {}
    for seed in seeds:
        image, place = folder / f"truth{seed}.fits", folder / f"truth{seed}"
        place.mkdir()
        stars = pairs(image, side=1200, seed=seed)
        table, _, _ = ours(program, image, place)
        theirs = sextractor(image, place)
        for name, found, columns in [
            ("Skyfront", table, ("x", "y", "flux_kron", "xwin", "ywin")),
            ("source-extractor", theirs, ("X_IMAGE", "Y_IMAGE", "FLUX_AUTO", "XWIN_IMAGE", "YWIN_IMAGE")),
        ]:
            x, y, flux, xwin, ywin = (np.asarray(found[column], float) for column in columns)
            far = np.hypot(stars[:, :1] - x, stars[:, 1:2] - y)
            nearest = far.argmin(axis=1)
            seen = far.min(axis=1) < 2
            at = nearest[seen]
            fluxes.setdefault(name, []).extend(flux[at] / stars[seen, 2])
            offsets.setdefault(name, []).extend(np.hypot(xwin[at] - stars[seen, 0], ywin[at] - stars[seen, 1]))
    print(f"\n{'stars beside a neighbour':26} {'number':>6} {'Kron flux':>10} {'scatter':>8} {'windowed rms':>13}")
    figures = {}
    for name in fluxes:
        ratio, off = np.array(fluxes[name]), np.array(offsets[name])
        median = np.median(ratio)
        figures[name] = median, 1.4826 * np.median(np.abs(ratio - median)), np.sqrt(np.nanmean(off**2))
        print(f"{name:26} {len(ratio):6} {figures[name][0]:10.4f} {figures[name][1]:8.4f} {figures[name][2]:10.4f} px")
    (median, scatter, rms), (_, their_scatter, their_rms) = figures["Skyfront"], figures["source-extractor"]
    return abs(median - 1) <= 0.02 and scatter <= their_scatter and rms <= 1.1 * their_rms


def first_image(path):
    with fits.open(path) as hdus:
        return next(hdu.data for hdu in hdus if hdu.data is not None and hdu.data.ndim == 2)


def main():
    warnings.simplefilter("ignore")
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        images = sys.argv[2:]
        if not images:
            images = [folder / "pairs.fits"]
            pairs(images[0])
        for number, image in enumerate(images):
            place = folder / str(number)
            place.mkdir()
            compare(program, image, place)
        if not beside_truth(program, folder):
            sys.exit("a bar does not hold: 2 % in the median, source-extractor's scatter, 1.1 times its rms")


if __name__ == "__main__":
    main()
