"""Settings as keywords: all that the table has, as the command line takes them, and refused by name."""

import inspect
import json
import pathlib
import warnings

import numpy as np
import pytest

import skyfront
from conftest import same
from skyfront import _settings, _stubs

PARAMETERS = skyfront.parameters()


def with_needs(name):
    """The choices that a setting needs in order to be used."""
    chosen = {}
    for need in PARAMETERS[name]["needs"]:
        choice, words = need.split(" ", 1)
        chosen[choice] = words.replace(" or ", ", ").split(", ")[0]
    return chosen


@pytest.mark.parametrize("name", PARAMETERS)
def test_every_setting_is_a_keyword(name, sky):
    needs = with_needs(name)
    small = sky[0][:40, :48]
    if needs.get("start") == "map":
        needs["start"] = np.zeros(small.shape)
        needs["start"][10:20, 10:20] = 1
    with_it = skyfront.segment(small, **{**needs, name: PARAMETERS[name]["default"]})
    without = skyfront.segment(small, **needs)
    assert np.array_equal(with_it.labels, without.labels)
    assert PARAMETERS[name]["option"].replace("-", "_") in with_it.summary["parameters"]


def test_settings_change_results_as_on_the_command_line(sky, command):
    for settings in [
        {"threshold": 1.7},
        {"min_area": 12, "connectivity": 4},
        {"deblend_contrast": np.float32(0.1), "false_sources": 2.5},
        {"preset": "paper-f160", "normalize": ("noise", 2.0, 25.0), "tau": "noise:2.5", "threads": 2},
        {"preset": "paper-real", "scheme": "sl", "range": None},
        {"preset": "paper-f160", "normalize": "percentile", "range": (1, 99.5), "t_max": 3.0},
        {"preset": "chan-vese", "arithmetic": "q24"},
        {"arithmetic": "q11", "preset": "paper-f160"},
        {"apertures": [2.0, 5.5], "zero_point": 25, "neighbours": "mask", "columns": "all", "gain": 3, "saturation": 200},
    ]:
        line = []
        for name, value in settings.items():
            if isinstance(value, tuple) and isinstance(value[0], str):
                value = f"{value[0]}:{value[1]},{value[2]}"
            text = ",".join(map(str, value)) if isinstance(value, (tuple, list)) else str(value)
            line += [] if value is None else [f"--{name.replace('_', '-')}={text}"]
        out = command(sky[0], *line)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", skyfront.SkyfrontWarning)
            found = skyfront.segment(sky[0], **settings)
        same(found, out)
        told = json.loads((out / "summary.json").read_text())
        for key in ["parameters", "n_sources", "labels_crc32", "measuring", "stop", "arithmetic"]:
            assert found.summary[key] == told[key], (settings, key)


def test_a_front_starts_from_a_map(sky, command, tmp_path):
    from astropy.io import fits

    fits.PrimaryHDU(sky[1]).writeto(tmp_path / "start.fits")
    for options in [{}, {"margin": 7}]:
        line = [f"--{name}={value}" for name, value in options.items()]
        out = command(sky[0], "--preset=paper-f160", f"--start={tmp_path / 'start.fits'}", *line)
        same(skyfront.segment(sky[0], preset="paper-f160", start=sky[1], **options), out)
    with pytest.raises(skyfront.OptionError, match="start: the map marks no pixel"):
        skyfront.segment(sky[0], preset="paper-f160", start=0 * sky[1])


def test_what_cannot_be_had_is_refused_by_name(sky):
    wrong = {
        "threshold": [0, float("nan"), "x", True, ("a",), object()],
        "min_area": [0, 1.5, -3],
        "beta": [8],
        "preset": ["paper"],
        "arithmetic": ["f64"],
        "weight_type": ["rms"],
        "weight": [np.ones((3, 3))],
        "mask": [np.ones((3, 3)), True],
        "background": [np.ones((3, 3)), np.nan],
        "noise": [0.0, -1.0],
        "gain": [0, "much", -2, np.inf],
        "apertures": [[3, 0], [2e4]],
        "columns": [["nothing"], ["mag"], ["flux_aper_1"]],
        "neighbours": ["none"],
        "threads": [0],
    }
    for name, values in wrong.items():
        for value in values:
            keywords = {name: value, **({"weight_type": "rms"} if name == "weight" else {})}
            with pytest.raises(skyfront.OptionError) as error:
                skyfront.segment(sky[0], **keywords)
            assert error.value.option == name and name in str(error.value), (name, value, error.value)
    with pytest.raises(skyfront.OptionError, match="noise: it says the same as weight"):
        skyfront.segment(sky[0], weight=1, weight_type="rms", noise=1)
    with pytest.raises(TypeError, match="'tresh'; did you mean 'threshold'"):
        skyfront.segment(sky[0], tresh=2)
    with pytest.raises(TypeError, match="'thresh'; here it is 'threshold'"):
        skyfront.segment(sky[0], thresh=2)
    with pytest.raises(TypeError, match="measure.*'threshold'"):
        skyfront.measure(sky[0], sky[1], threshold=2)


def test_signature_docstring_and_stubs_come_from_the_table():
    keywords = inspect.signature(skyfront.segment).parameters
    for name, parameter in PARAMETERS.items():
        assert name in keywords
        assert parameter["help"] in skyfront.segment.__doc__
    for name, *_ in _settings.OWN:
        assert name in keywords and f"    {name} : " in skyfront.segment.__doc__
    stubs = pathlib.Path(_stubs.__file__).with_name("__init__.pyi")
    assert stubs.read_text() == _stubs.stubs(), "python -m skyfront._stubs > skyfront/__init__.pyi"


def test_stubs_tell_of_all_that_is_public():
    stubs = _stubs.stubs()
    for name in skyfront.__all__:
        assert f"def {name}(" in stubs or f"class {name}" in stubs or f"{name}:" in stubs
