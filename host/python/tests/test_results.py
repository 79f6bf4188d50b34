"""What a run gives, and what other packages make of it."""

import numpy as np
import pytest
from astropy.table import QTable

import skyfront


@pytest.fixture(scope="module")
def found(sky):
    return skyfront.segment(sky[0])


def test_planes_are_not_copied(found):
    assert found.labels.dtype == np.int32 and np.shares_memory(found.labels, found._labels)
    # Its memory is that of the engine.
    assert not found._labels.flags.owndata and found.labels.flags.c_contiguous
    assert found.labels.max() == len(found) == len(found.catalogue) > 10


def test_the_catalogue_is_described(found):
    catalogue = found.catalogue
    assert isinstance(catalogue, QTable) and catalogue is found.catalogue
    known = {name: description for name, _, description, _ in skyfront.columns()}
    for name in catalogue.colnames:
        assert catalogue[name].info.description and name in known
    assert str(catalogue["x"].unit) == "pix" and catalogue["label"].dtype.kind == "i"
    assert catalogue.meta["skyfront"]["n_sources"] == len(found)
    assert skyfront.Flag(int(catalogue["flags"][0])) is not None


def test_without_astropy_it_is_a_structured_array(found, monkeypatch):
    import sys

    from skyfront import _result

    columns = [("label", "", "", np.array([1, 2])), ("x", "pixel", "", np.array([1.5, 2.5]))]
    monkeypatch.setitem(sys.modules, "astropy.table", None)
    table = _result.table(columns, {})
    assert table.dtype.names == ("label", "x") and table["x"].tolist() == [1.5, 2.5]


def test_changed_labels_are_noticed(sky):
    found = skyfront.segment(sky[0])
    with pytest.raises(ValueError):
        found.front[0, 0] = 1
    found.labels[0, 0] = 99
    with pytest.raises(skyfront.OptionError, match="labels: they were changed"):
        found.catalogue


def test_outlines_lie_on_the_borders(found):
    labels = found.labels
    assert {outline.label for outline in found.outlines} == set(range(1, len(found) + 1))
    for outline in found.outlines:
        inside = np.rint(outline.points).astype(int).clip(0, [labels.shape[1] - 1, labels.shape[0] - 1])
        near = [labels[max(y - 1, 0) : y + 2, max(x - 1, 0) : x + 2] for x, y in inside]
        assert all((part == outline.label).any() for part in near)


def test_outlines_are_those_of_the_command_line(sky, found, command):
    import json

    out = command(sky[0], "--polygons")
    told = json.loads((out / "outlines.json").read_text())
    assert len(told) == len(found.outlines)
    for ring, outline in zip(told, found.outlines):
        assert (ring["label"], ring["hole"]) == (outline.label, outline.hole)
        assert np.allclose(ring["pixel"], outline.points + 1, rtol=0, atol=6e-4)


def test_the_picture_is_that_of_the_command_line(sky, found, command):
    assert found.picture() == (command(sky[0]) / "overlay.png").read_bytes()
    html = found._repr_html_()
    assert "data:image/png;base64," in html and f"{len(found)} sources" in html
    assert repr(found) == f"<Segmentation of 150 x 120 pixels: {len(found)} sources>"


def test_photutils(sky, found):
    from photutils.segmentation import SegmentationImage, SourceCatalog

    segments = SegmentationImage(found.labels)
    assert len(segments.labels) == len(found)
    catalogue = SourceCatalog(sky[0] - found.background, segments)
    assert np.allclose(catalogue.segment_flux, found.catalogue["flux"].value, rtol=1e-4)
    assert np.array_equal(catalogue.area.value, found.catalogue["area"])


def test_regions(sky):
    from astropy.wcs import WCS
    from regions import PolygonSkyRegion, Regions

    wcs = WCS(naxis=2)
    wcs.wcs.ctype, wcs.wcs.crval, wcs.wcs.cdelt = ["RA---TAN", "DEC--TAN"], [10, 20], [-1e-4, 1e-4]
    found = skyfront.segment(sky[0], wcs=wcs)
    polygons = found.regions()
    assert isinstance(polygons, Regions) and len(polygons) == len(found.outlines)
    mask = np.zeros(sky[0].shape, bool)
    for polygon in polygons:
        mask |= polygon.to_mask("center").to_image(mask.shape).astype(bool)
    assert np.mean(mask == (found.labels > 0)) > 0.99
    assert isinstance(found.regions(sky=True)[0], PolygonSkyRegion)


def test_ccdproc(sky):
    import ccdproc
    from astropy.nddata import CCDData

    raw = CCDData(sky[0] + 50, unit="adu")
    bias = CCDData(np.full(sky[0].shape, 50.0, np.float32), unit="adu")
    found = skyfront.segment(ccdproc.subtract_bias(raw, bias))
    assert len(found) > 10 and str(found.catalogue["flux"].unit) == "adu"


def test_paper_keeps_the_planes_of_its_steps(sky):
    found = skyfront.paper(sky[0])
    assert set(found.stages) == {"normalised", "rescaled", "filtered", "edge"}
    assert found.stages["normalised"].min() == 0 and found.stages["normalised"].max() == 1
    assert len(found.convergence) == found.summary["iterations"] and found.background is None
    assert np.array_equal(found.labels, skyfront.segment(sky[0], preset="paper-f160").labels)
    assert skyfront.segment(sky[0], preset="paper-f160").stages == {}
    assert skyfront.paper(sky[0], preset="chan-vese").summary["parameters"]["scheme"] == "chan-vese"


def test_measure_takes_any_label_map(sky, command, tmp_path):
    from astropy.io import fits

    labels = sky[1] * 3
    fits.PrimaryHDU(labels).writeto(tmp_path / "labels.fits")
    out = command(sky[0], "--segmentation", tmp_path / "labels.fits", "--apertures=3")
    table = fits.getdata(out / "catalog.fits")
    measured = skyfront.measure(sky[0], labels, apertures=3)
    assert list(measured["label"]) == sorted(set(labels[labels > 0]))
    for name in table.names:
        ours = np.asarray(getattr(measured[name], "value", measured[name]))
        assert ours.tobytes() == table[name].astype(table[name].dtype.newbyteorder("=")).tobytes(), name
    with pytest.raises(skyfront.OptionError, match="labels"):
        skyfront.measure(sky[0], -labels)


def test_scores_and_skies_are_those_of_the_command_line(program, tmp_path):
    import json
    import subprocess

    from astropy.io import fits

    run = lambda *line: subprocess.run([program, *map(str, line)], check=True, capture_output=True).stdout  # noqa: E731
    run("simulate", "--out", tmp_path, "--kind", "stars", "--seed", 5, "--side", 90)
    image, truth = skyfront.simulate("stars", seed=5, shape=(90, 90))
    assert image.tobytes() == fits.getdata(tmp_path / "sky.fits").astype("f4").tobytes()
    assert np.array_equal(truth, fits.getdata(tmp_path / "truth.fits"))
    labels = skyfront.segment(image).labels
    fits.PrimaryHDU(labels).writeto(tmp_path / "labels.fits")
    told = json.loads(
        run("score", tmp_path / "truth.fits", tmp_path / "labels.fits", "--image", tmp_path / "sky.fits")
    )
    assert skyfront.score(truth, labels, image) == told
    camera = ["--optics", "coma", "--lopsided", "--gradient", 3, "--full-well", 400, "--step", 0.5]
    run("simulate", "--out", tmp_path, "--overwrite", "--side", 70, *camera)
    image, truth = skyfront.simulate(
        shape=(70, 70), optics="coma", lopsided=True, gradient=3, full_well=400, step=0.5
    )
    assert image.tobytes() == fits.getdata(tmp_path / "sky.fits").astype("f4").tobytes()
    assert np.array_equal(truth, fits.getdata(tmp_path / "truth.fits"))
    with pytest.raises(skyfront.OptionError, match="kind"):
        skyfront.simulate("dark")
    for setting in [{"optics": "bad"}, {"full_well": 0.0}, {"step": -1.0}, {"gradient": float("nan")}]:
        with pytest.raises(skyfront.OptionError, match=next(iter(setting))):
            skyfront.simulate(**setting)
    with pytest.raises(skyfront.OptionError, match="shape"):
        skyfront.simulate(shape=(4, 20))
    with pytest.raises(skyfront.OptionError, match="labels"):
        skyfront.score(truth, labels[1:], image)
