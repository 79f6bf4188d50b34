"""Mosaics in chunks and many files, on the threads of one process and on a cluster of two workers."""

import os
import pathlib
import signal
import threading
import warnings

import dask
import dask.array as da
import numpy as np
import pytest
from astropy.io import fits
from astropy.table import QTable
from distributed import Client, LocalCluster, get_worker

import skyfront
import skyfront.dask


@pytest.fixture(scope="module")
def cluster():
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster:
        yield cluster


@pytest.fixture(scope="module")
def mosaic():
    """A crowded sky on a slope, with a hole and an edge of filling."""
    image, _ = skyfront.simulate("noisy", seed=11, shape=(520, 610))
    image += np.linspace(0, 0.03, image.shape[1], dtype=np.float32)
    image[200:230, 250:310] = np.nan
    image[:, -7:] = 0
    return image


def same(mosaic, one):
    """Whether a mosaic is the result of one piece: labels, sky, and every number of the catalogue."""
    assert np.array_equal(mosaic.labels.compute(), one.labels)
    for name in ["background", "noise"]:
        assert np.array_equal(getattr(mosaic, name).compute(), getattr(one, name), equal_nan=True)
    assert len(mosaic) == len(one) == len(mosaic.catalogue) and not mosaic.catalogue["beyond_halo"].any()
    for name in one.catalogue.colnames:
        ours, theirs = (np.asarray(getattr(table[name], "value", table[name])) for table in (mosaic.catalogue, one.catalogue))
        # Both are rounded to nine digits, from numbers that may differ in their sixteenth.
        assert np.allclose(ours, theirs, rtol=1e-8, atol=1e-12, equal_nan=True), name


def test_chunks_give_the_result_of_one_piece(mosaic):
    one = skyfront.segment(mosaic, apertures=[3], columns="all", zero_point=25)
    assert len(one) > 100
    for chunks in [(300, 300), ((100, 420), (610,)), (-1, -1)]:
        found = skyfront.dask.segment(da.from_array(mosaic, chunks), apertures=[3], columns="all", zero_point=25)
        same(found, one)
        assert found.summary["parameters"] == one.summary["parameters"]
        assert found.labels.dtype == np.int32 and found.labels.shape == mosaic.shape


def test_sixteen_chunks():
    """As large as SKYFRONT_MOSAIC says."""
    side = int(os.environ.get("SKYFRONT_MOSAIC", 512))
    piece = min(side, 512)
    seeds = iter(range(10**6))
    row = lambda: [skyfront.simulate("noisy", seed=next(seeds), shape=(piece, piece))[0] for _ in range(side // piece)]  # noqa: E731
    image = np.block([row() for _ in range(side // piece)])
    same(skyfront.dask.segment(da.from_array(image, side // 4)), skyfront.segment(image))


def test_on_a_cluster_of_two_workers(mosaic, cluster, tmp_path):
    zarr = pytest.importorskip("zarr")
    zarr.save(str(tmp_path / "mosaic.zarr"), mosaic)
    with Client(cluster):
        found = skyfront.dask.segment(da.from_zarr(str(tmp_path / "mosaic.zarr"), chunks=(300, 310)))
        same(found, skyfront.segment(mosaic))


def test_settings_and_maps(mosaic):
    noise = np.linspace(0.01, 0.02, mosaic.shape[0], dtype=np.float32)[:, None] * np.ones_like(mosaic)
    mask = np.zeros(mosaic.shape, bool)
    mask[90:120, 280:330] = True
    chunked = da.from_array(mosaic, (300, 300))
    for options in [
        {"mask": mask, "threshold": 1.5, "min_area": 10},
        {"weight": noise**2, "weight_type": "variance"},
        {"background": 0.015, "noise": noise, "neighbours": "mask", "gain": 2.0},
    ]:
        wrapped = {k: da.from_array(v, (99, 120)) if isinstance(v, np.ndarray) else v for k, v in options.items()}
        # Above a sky that is given too low the slope makes a source of 165 rows: a wider halo than by itself holds it.
        same(skyfront.dask.segment(chunked, depth=150, **wrapped), skyfront.segment(mosaic, **options))


def test_coordinates_are_those_of_the_whole(mosaic):
    from astropy.wcs import WCS

    wcs = WCS(naxis=2)
    wcs.wcs.ctype, wcs.wcs.crval, wcs.wcs.cdelt = ["RA---TAN", "DEC--TAN"], [10, 20], [-1e-4, 1e-4]
    wcs.wcs.crpix = [300, 250]
    one = skyfront.segment(mosaic, wcs=wcs).catalogue
    found = skyfront.dask.segment(da.from_array(mosaic, (300, 300)), wcs=wcs).catalogue
    for name in ["ra", "dec"]:
        assert np.allclose(found[name].value, one[name].value, rtol=0, atol=1e-10)


def test_what_is_larger_than_the_halo_is_joined_and_flagged(mosaic):
    image = mosaic.copy()
    y, x = np.mgrid[: image.shape[0], : image.shape[1]]
    # A galaxy of half the mosaic's width across the borders of four chunks.
    image += np.exp(-(((x - 300) / 110.0) ** 2 + ((y - 265) / 60.0) ** 2))
    one = skyfront.segment(image)
    found = skyfront.dask.segment(da.from_array(image, (260, 305)), depth=64)
    labels, large = found.labels.compute(), found.catalogue["beyond_halo"] == 1
    assert large.any() and (labels[265, 295] == labels[265, 310]) and labels[265, 300] > 0
    assert large[labels[265, 300] - 1]
    assert len(found.catalogue) == len(found) == labels.max()
    assert set(np.unique(labels)) == set(range(len(found) + 1))
    # A source that is flagged nowhere is one of those of the whole, but where the large one has spoilt the sky.
    small = [number for number in np.unique(labels)[1:] if not large[number - 1]]
    agreeing = sum(len(np.unique(one.labels[labels == number])) == 1 for number in small)
    assert agreeing > 0.9 * len(small)


def test_what_cannot_be_a_mosaic_is_refused(mosaic):
    chunked = da.from_array(mosaic, (300, 300))
    for options, name in [({"depth": 10}, "depth"), ({"preset": "paper-f160"}, "preset"), ({"arithmetic": "q24"}, "arithmetic"),
                          ({"mask": np.zeros((3, 3))}, "mask"), ({"weight": 1.0, "weight_type": "weight"}, "weight_type"), ({"threshold": 0}, "threshold")]:  # fmt: skip
        with pytest.raises(skyfront.OptionError) as error:
            skyfront.dask.segment(chunked, **options)
        assert error.value.option == name
    with pytest.raises(TypeError, match="Dask array"):
        skyfront.dask.segment(mosaic)
    with pytest.raises(ValueError, match="not known"):
        skyfront.dask.segment(chunked[chunked[:, 0] > 0])


def _killing(block, flag=None):
    """A chunk whose worker dies when it is first read there."""
    path = pathlib.Path(flag)
    try:
        get_worker()
    except ValueError:
        return block
    if block.shape[0] > 1 and not path.exists():
        path.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return block


def test_a_killed_worker_costs_its_chunks_time_only(mosaic, tmp_path):
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster, Client(cluster):
        image = da.from_array(mosaic, (300, 310)).map_blocks(_killing, flag=str(tmp_path / "killed"), dtype=np.float32)
        found = skyfront.dask.segment(image)
        assert (tmp_path / "killed").exists()
        same(found, skyfront.segment(mosaic))


def _images(folder, count):
    paths = []
    for seed in range(count):
        image, _ = skyfront.simulate("noisy", seed=seed, shape=(80, 90))
        hdus = [fits.PrimaryHDU(), fits.ImageHDU(image, name="SCI")]
        hdus[1].header["BUNIT"] = "adu"
        paths.append(folder / f"frame{seed}.fits")
        fits.HDUList(hdus).writeto(paths[-1])
    return paths


def test_many_files_are_resumed_and_failures_are_rows(tmp_path, cluster):
    files = _images(tmp_path, 4)
    broken = tmp_path / "broken.fits"
    broken.write_bytes(b"SIMPLE  = no")
    files.insert(2, broken)
    files.append(tmp_path / "absent.fits")
    with Client(cluster):
        rows = skyfront.dask.catalogue(files, tmp_path / "out", threshold=1.2)
    assert [row["status"] for row in rows] == ["done", "done", "failed", "done", "done", "failed"]
    assert "broken.fits" in rows[2]["error"] and "absent.fits" in rows[5]["error"]
    with fits.open(files[0]) as hdus:
        one = skyfront.segment(hdus["SCI"], threshold=1.2)
    table = QTable.read(rows[0]["catalogue"])
    assert np.array_equal(fits.getdata(rows[0]["labels"]), one.labels) and rows[0]["n_sources"] == len(one)
    assert table.colnames == one.catalogue.colnames and (table["flux"] == one.catalogue["flux"]).all()
    assert not list((tmp_path / "out").glob(".*"))

    again = skyfront.dask.catalogue(files, tmp_path / "out", threshold=1.2)
    assert [row["kept"] for row in again] == [True, True, True, True, True, False]
    for row in rows + again:
        row.pop("kept"), row.pop("seconds")
    assert again == rows
    # Other keywords, another file of the name, a lost result, a wish to try again: these are new runs.
    assert not skyfront.dask.catalogue(files[:1], tmp_path / "out", threshold=1.3)[0]["kept"]
    pathlib.Path(rows[1]["labels"]).unlink()
    assert not skyfront.dask.catalogue(files[1:2], tmp_path / "out", threshold=1.2)[0]["kept"]
    assert not skyfront.dask.catalogue([broken], tmp_path / "out", threshold=1.2, retry=True)[0]["kept"]
    fits.PrimaryHDU(np.ones((30, 30))).writeto(broken, overwrite=True)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert skyfront.dask.catalogue([broken], tmp_path / "out", threshold=1.2)[0]["status"] == "done"


def test_files_of_one_name_keep_apart(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    files = _images(tmp_path / "a", 1) + _images(tmp_path / "b", 1)
    rows = skyfront.dask.catalogue(files, tmp_path / "out", hdu="SCI")
    assert [row["status"] for row in rows] == ["done", "done"] and rows[0]["labels"] != rows[1]["labels"]
    with pytest.raises(ValueError, match="more than once"):
        skyfront.dask.catalogue(files[:1] * 2, tmp_path / "out")


def test_a_killed_worker_loses_no_finished_file(tmp_path):
    files = _images(tmp_path, 8)
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0") as cluster, Client(cluster):
        victim = next(iter(cluster.workers.values()))
        killer = threading.Timer(0.5, lambda: os.kill(victim.pid, signal.SIGKILL))
        killer.start()
        rows = skyfront.dask.catalogue(files, tmp_path / "out")
        killer.join()
    assert [row["status"] for row in rows] == ["done"] * 8
    with dask.config.set(scheduler="synchronous"):
        assert all(row["kept"] for row in skyfront.dask.catalogue(files, tmp_path / "out"))
