"""The Python lines of the documents run, and the names in their tables are names that there are."""

import pathlib
import re

import pytest

import skyfront
from skyfront import _engine, _settings

FOLDER = pathlib.Path(__file__).parents[1]
DOCUMENTS = [FOLDER / "README.md", *sorted((FOLDER / "doc").glob("*.md"))]


def blocks(document):
    return re.findall(r"```python\n(.*?)```", document.read_text(), re.DOTALL)


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_python_lines_run(document, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": document.stem}
    for block in blocks(document):
        exec(compile(block, document.name, "exec"), names)


@pytest.mark.parametrize("name", ["from-sep.md", "from-sextractor.md"])
def test_tables_of_names_have_names(name):
    known = {column for column, *_ in skyfront.columns()} | set(skyfront.parameters())
    known |= {own for own, *_ in _settings.OWN} | {"labels", "seg", "outlines", "noise", "background", "flag"}
    text = (FOLDER / "doc" / name).read_text()
    for row in re.findall(r"^\|[^|]*\|([^|]*)\|", text, re.MULTILINE):
        for code in re.findall(r"`([^`]*)`", row):
            word = re.match(r"(?:seg\.|skyfront\.)?([A-Za-z_0-9]+)", code)[1]
            ours = word in known or hasattr(skyfront, word) or word in sum(_settings.CHOICES.values(), [])
            assert ours or word.startswith("flux_aper_") or word in ("np", "mag_kron"), (code, word)


def test_sextractor_names_lead_where_the_table_says():
    text = (FOLDER / "doc" / "from-sextractor.md").read_text()
    rows = re.findall(r"^\| `([A-Z0-9_]+)`[^|]*\| `([a-z_]+)`", text, re.MULTILINE)
    assert len(rows) > 15
    image, _ = skyfront.simulate("bright", seed=2, shape=(60, 60))
    for theirs, ours in rows:
        told = _engine.elsewhere(theirs)
        if told is not None and ours in skyfront.parameters():
            assert told == ours, (theirs, ours)
        if ours in {column for column, *_ in skyfront.columns()} and ours not in ("ra", "dec", "threshold"):
            found = skyfront.segment(image, columns=["label", theirs], apertures=[3], zero_point=25)
            assert ours in found.catalogue.colnames, (theirs, ours, found.catalogue.colnames)
