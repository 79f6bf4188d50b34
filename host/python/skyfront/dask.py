"""Mosaics in chunks, and many files: what outgrows a machine.

`segment` gives for a Dask array the labels and the catalogue that `skyfront.segment` gives for the
same array in one piece. `catalogue` segments many files, each on whatever worker is free.

Both use the scheduler that Dask uses: threads of this process, or the workers of a
`distributed.Client`.
"""

import hashlib
import json
import os
import pathlib
import time
import traceback
import warnings

import dask
import dask.array as da
import numpy as np

from . import _api, _engine
from ._input import option_error
from ._result import in_python, table, told

# Cells of the sky's mesh: their side, and the most along an axis (see skyfront_core::sky::CELL).
CELL, MOST_CELLS = 64, 64
# The least halo: filters, and the light around the typical source.
LEAST_DEPTH = 64


class Mosaic:
    """A segmented Dask array.

    Attributes
    ----------
    labels : dask array of int32
        The source of every pixel, from 1; 0 = background.
    background, noise : dask arrays of float32
        Sky and its standard deviation at every pixel.
    catalogue : QTable or structured array
        One row per source, as `Segmentation.catalogue`, and the column `beyond_halo`: 1 where the source, or an
        aperture around it, ends beyond the halo of its chunk. All other rows are those of one piece; these
        may differ, and a larger `depth` mends it.
    summary : dict
        Parameters, sources, chunks and halo.
    """

    def __init__(self, labels, background, noise, catalogue, summary):
        self.labels, self.background, self.noise = labels, background, noise
        self.catalogue, self.summary = catalogue, summary

    def __len__(self):
        return self.summary["n_sources"]

    def __repr__(self):
        height, width = self.labels.shape
        return f"<Mosaic of {width} x {height} pixels in {self.summary['chunks']} chunks: {len(self)} sources>"


def segment(image, *, depth=None, wcs=None, **keywords):
    """Segments a Dask array chunk by chunk, with the result of one piece.

    Parameters
    ----------
    image : dask array of two axes
        A mosaic, for example from zarr or a memory-mapped FITS file. Each chunk must fit into a worker's
        memory about twenty times (in float32), its halo included.
    depth : int
        Pixels of the halo around each chunk: sources up to this size come out as in one piece. Not given, 128,
        or as much as a cell of the sky's mesh needs.
    wcs : astropy WCS or FITS header
        Coordinates of the whole array.
    **keywords
        Those of `skyfront.segment`; maps may be Dask arrays. `threads` is 1 unless it is given. Mosaics
        are made by the default's steps in f32.

    Returns
    -------
    Mosaic

    All chunks are gone through about a dozen times: what depends on the whole image (sky, noise, how bright
    a source must be) is found by a map over the chunks and a reduce, and each answer lets the chunks go further.
    Nothing but these answers is kept between, so that a worker that is lost costs the time of its chunks only.
    """
    if not isinstance(image, da.Array) or image.ndim != 2:
        raise TypeError("image: a Dask array of two axes is wanted")
    if any(np.isnan(length) for lengths in image.chunks for length in lengths):
        raise ValueError("image: the sizes of its chunks are not known; compute_chunk_sizes() finds them")
    if keywords.get("weight_type") == "weight":
        raise option_error("weight_type", "in chunks it must be rms or variance: such weights are scaled to an image")
    keywords.setdefault("threads", 1)
    parts = _parts(image, _depth(image.shape, depth))
    maps = {name: keywords.pop(name) for name in ("mask", "background", "noise", "weight") if name in keywords}
    answers = {}

    def tasks(function):
        for part in parts:
            window = part["window"]
            here = {name: _window(name, value, image.shape, window) for name, value in maps.items()}
            yield dask.delayed(function)(image[window], here, part["place"], wcs, known, keywords)

    while True:
        known = dask.delayed(list(answers.items()), pure=True)
        asked = dask.compute(*tasks(_asked))
        names = sorted({name for own in asked for name, _ in own})
        if not names:
            break
        contributions = {name: [dict(own)[name] for own in asked if name in dict(own)] for name in names}
        answers.update((name, _engine.answer(name, contributions[name])) for name in names)
    return _joined(image, parts, dask.persist(*tasks(_final)))


def _depth(shape, depth):
    """The halo: as much as the sky's mesh needs beyond a chunk's own pixels, at least."""
    sides = [-(-length // max(1, min(MOST_CELLS, (length + CELL // 2) // CELL))) for length in shape]
    needed = max(LEAST_DEPTH, max(sides) // 2 + 2)
    if depth is None:
        return max(128, needed)
    if depth < needed:
        raise option_error("depth", f"{depth} must be at least {needed} for {shape[0]} x {shape[1]} pixels")
    return int(depth)


def _parts(image, depth):
    """Where each chunk lies, with its halo."""
    ends = [np.cumsum((0, *lengths)) for lengths in image.chunks]
    parts = []
    for bottom, top in zip(ends[0], ends[0][1:]):
        for left, right in zip(ends[1], ends[1][1:]):
            own = ((int(bottom), int(top)), (int(left), int(right)))
            outer = [(max(0, a - depth), min(length, b + depth)) for (a, b), length in zip(own, image.shape)]
            (y0, y1), (x0, x1) = outer
            place = {
                "image": (image.shape[1], image.shape[0]),
                "origin": (x0, y0),
                "columns": (own[1][0] - x0, own[1][1] - x0),
                "rows": (own[0][0] - y0, own[0][1] - y0),
            }
            parts.append({"own": own, "window": (slice(y0, y1), slice(x0, x1)), "place": place})
    return parts


def _window(name, value, shape, window):
    """What a chunk needs of a map; numbers hold everywhere."""
    if value is None or np.ndim(value) == 0:
        return value
    if value.shape != shape:
        raise option_error(name, f"its shape is {value.shape}, that of the image {shape}")
    return value[window]


def _run(pixels, maps, place, wcs, answers, keywords):
    """A chunk as far as the answers go."""
    options = dict(keywords, wcs=wcs, **maps)
    return _api._run("segment", np.asarray(pixels), options, _api._ALL, part=place, answers=answers)[1]


def _asked(*chunk):
    """What a chunk contributes to the next questions; nothing where all are answered."""
    return _run(*chunk).get("asked", [])


def _final(*chunk):
    """A chunk's own pixels, and the rows of its sources."""
    place, found = chunk[2], _run(*chunk)
    sky = [(found[name], False) for name in ("background", "noise")]
    columns, settings, notes = found["sources"].measure(found["labels"], *sky)
    labels, firsts, clipped = found["labels"], found["firsts"], found["clipped"]
    (left, right), (bottom, top) = place["columns"], place["rows"]
    own = (slice(bottom, top), slice(left, right))
    # A source belongs to the chunk that has its first pixel; one that is cut off, to all that see it.
    y, x = np.divmod(firsts[1:], place["image"][0])
    x, y = x - place["origin"][0], y - place["origin"][1]
    owned = (left <= x) & (x < right) & (bottom <= y) & (y < top)
    seen = np.zeros(len(firsts), bool)
    seen[np.unique(labels[own])] = True
    rows = owned | (clipped & seen)[1:]
    ids = np.where(firsts < 0, 0, firsts + 1)
    height, width = labels.shape
    lines = {
        "left": (own[0], left), "right": (own[0], right - 1), "bottom": (bottom, own[1]), "top": (top - 1, own[1]),
        "beyond_left": (own[0], left - 1) if left else None,
        "beyond_right": (own[0], right) if right < width else None,
        "beyond_bottom": (bottom - 1, own[1]) if bottom else None,
        "beyond_top": (top, own[1]) if top < height else None,
    }  # fmt: skip
    summary = json.loads(found["summary"])
    summary["measuring"] = json.loads(settings)
    facts = {
        "ids": ids,
        "rows": np.flatnonzero(rows) + 1,
        "owned": owned[rows],
        "clipped": clipped[1:][rows],
        "columns": [(name, unit, text, values[rows]) for name, unit, text, values in columns],
        "lines": {name: None if line is None else ids[labels[line]] for name, line in lines.items()},
        "notes": [*found["warnings"], *notes],
        "summary": summary,
    }
    planes = {"labels": labels[own].copy(), **{name: found[name][own].copy() for name in ("background", "noise")}}
    return {"facts": facts, "planes": planes}


def _facts(final):
    return final["facts"]


def _plane(final, name):
    return final["planes"][name]


def _numbered(final, numbers):
    return numbers[final["planes"]["labels"]].astype(np.int32)


def _joined(image, parts, finals):
    """The chunks as one: labels numbered by the first pixels of the sources, and one table."""
    facts = dask.compute(*[dask.delayed(_facts)(final) for final in finals])
    columns = len(image.chunks[1])
    roots = {}

    def root(number):
        while roots.get(number, number) != number:
            number = roots[number]
        return number

    disputed = set()

    def agree(ours, theirs):
        """Two chunks on the same pixels: where they name different sources, these are one that is cut off."""
        if ours is None or theirs is None:
            return
        for one, other in {(int(a), int(b)) for a, b in zip(ours, theirs) if a and b and a != b}:
            one, other = sorted((root(one), root(other)))
            roots[other] = one
            disputed.add(one)

    for at, own in enumerate(facts):
        if (at + 1) % columns:
            right = facts[at + 1]["lines"]
            agree(own["lines"]["beyond_right"], right["left"])
            agree(own["lines"]["right"], right["beyond_left"])
        if at + columns < len(facts):
            above = facts[at + columns]["lines"]
            agree(own["lines"]["beyond_top"], above["bottom"])
            agree(own["lines"]["top"], above["beyond_bottom"])

    table_rows, chosen = _rows(facts, root, {root(one) for one in disputed})
    numbers = {number: index for index, number in enumerate(sorted(chosen), 1)}
    maps = [
        np.array([numbers.get(root(int(number)), 0) if number else 0 for number in own["ids"]], np.int64) for own in facts
    ]
    order = sorted(chosen, key=numbers.get)
    catalogue = _table(table_rows, [chosen[number] for number in order])
    notes = list(dict.fromkeys(in_python(note) for own in facts for note in own["notes"]))
    told(notes)
    summary = {name: value for name, value in facts[0]["summary"].items() if name in
               ("program", "version", "arithmetic", "parameters", "measuring")}  # fmt: skip
    summary.update(width=image.shape[1], height=image.shape[0], n_sources=len(order), chunks=len(parts),
                   result_warnings=notes)  # fmt: skip

    def plane(delayed, dtype):
        blocks = [
            da.from_delayed(block, [b - a for a, b in part["own"]], dtype) for block, part in zip(delayed, parts)
        ]
        return da.block([blocks[at : at + columns] for at in range(0, len(blocks), columns)])

    labels = plane([dask.delayed(_numbered)(final, map) for final, map in zip(finals, maps)], np.int32)
    sky = [plane([dask.delayed(_plane)(final, name) for final in finals], np.float32) for name in ("background", "noise")]
    return Mosaic(labels, *sky, table(catalogue, summary), summary)


def _rows(facts, root, disputed):
    """All rows, and for every source the row that stands for it: its owner's, or of one cut off that of its largest
    piece."""
    names = [(name, unit, text) for name, unit, text, _ in facts[0]["columns"]]
    values = [np.concatenate([own["columns"][at][3] for own in facts]) for at in range(len(names))]
    ids = [root(int(number)) for own in facts for number in own["ids"][own["rows"]]]
    owned = np.concatenate([own["owned"] for own in facts])
    clipped = np.concatenate([own["clipped"] for own in facts])
    by_name = {name: at for at, (name, _, _) in enumerate(names)}
    beyond = values[by_name["beyond_halo"]]
    area = values[by_name["area"]] if "area" in by_name else np.zeros(len(ids))
    beyond |= clipped
    beyond |= np.array([number in disputed for number in ids], bool)
    chosen = {}
    for row, number in enumerate(ids):
        rank = (owned[row] and not beyond[row], area[row], owned[row], -row)
        if number not in chosen or rank > chosen[number][0]:
            chosen[number] = (rank, row)
    columns = [(*name, value) for name, value in zip(names, values)]
    return columns, {number: row for number, (_, row) in chosen.items()}


def _table(columns, rows):
    """The chosen rows, numbered anew."""
    made = []
    for name, unit, text, values in columns:
        made.append((name, unit, text, np.arange(1, len(rows) + 1) if name == "label" else values[rows]))
    return made


def catalogue(files, folder, *, hdu=None, retry=False, **keywords):
    """Segments many files, each into a catalogue and a label map of its own in a folder.

    Parameters
    ----------
    files : iterable of paths
        FITS images.
    folder : path
        For the results, which all workers can write to: `NAME.ecsv` and `NAME.labels.fits`, by the name of the file,
        and `NAME.json`, which says how it went. What is there from the same file and the same keywords is not
        made again.
    hdu : int or str
        The image in each file; not given, the first of two axes.
    retry : bool
        Whether to try again what failed before.
    **keywords
        Those of `skyfront.segment`. `threads` is 1 unless it is given.

    Returns
    -------
    list of dict
        One for each file, in order: `file`, `status` (`done` or `failed`), `error`, `n_sources`, `seconds`,
        `catalogue`, `labels` (paths) and `kept`, whether it was there already. A file that fails stops no other.
    """
    keywords.setdefault("threads", 1)
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = [pathlib.Path(file) for file in files]
    names = _names(paths)
    frame = dask.delayed(_frame, pure=False)
    return list(dask.compute(*[frame(path, folder / name, hdu, retry, keywords) for path, name in zip(paths, names)]))


def _names(paths):
    """A name for the results of each file; files of one name are told apart by their folders."""
    stems = [path.name.removesuffix(".gz").removesuffix(".fz").rsplit(".", 1)[0] for path in paths]
    unique = [
        stem if stems.count(stem) == 1 else f"{stem}-{hashlib.sha256(os.fsencode(path.absolute())).hexdigest()[:8]}"
        for stem, path in zip(stems, paths)
    ]
    twice = {str(path) for path, name in zip(paths, unique) if unique.count(name) > 1}
    if twice:
        raise ValueError(f"files: {', '.join(sorted(twice))} stand there more than once")
    return unique


def _key(path, hdu, keywords):
    """By what a result is known again: the file, the keywords and the version."""
    about = path.stat()
    arrays = {
        name: hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest() if hasattr(value, "shape") else value
        for name, value in sorted(keywords.items())
    }
    return [str(path.absolute()), about.st_size, about.st_mtime_ns, repr(hdu), repr(arrays), _engine.__version__]


def _frame(path, target, hdu, retry, keywords):
    """One file: its row, as it is written beside its results."""
    record, began = target.with_name(target.name + ".json"), time.time()
    row = {"file": str(path), "status": "failed", "error": "", "n_sources": 0, "seconds": 0.0, "catalogue": "", "labels": ""}
    try:
        row["key"] = _key(path, hdu, keywords)
        known = _known(record, row["key"], retry)
        if known is not None:
            return dict(known, kept=True)
        row.update(_segmented(path, target, hdu, keywords), status="done")
    except Exception as error:
        reason = "".join(traceback.format_exception_only(error)).strip()
        row["error"] = f"{path}: {reason}"
    row["seconds"] = time.time() - began
    _write(record, lambda path: path.write_text(json.dumps(row)))
    return dict(row, kept=False)


def _known(record, key, retry):
    """What an earlier run of the same file left."""
    try:
        known = json.loads(record.read_text())
    except (OSError, ValueError):
        return None
    if known.get("key") != key or (retry and known["status"] == "failed"):
        return None
    there = all(os.path.exists(known[name]) for name in ("catalogue", "labels") if known[name])
    return known if there else None


def _segmented(path, target, hdu, keywords):
    """Segments a file and writes what it gives."""
    from astropy.io import fits

    with fits.open(path, memmap=False) as hdus:
        image = hdus[hdu] if hdu is not None else _first_image(hdus)
        with warnings.catch_warnings(record=True) as notes:
            warnings.simplefilter("always")
            found = _api.segment(image, **keywords)
            sources = found.catalogue
    sources.meta["skyfront"] = dict(found.summary, file=str(path), warnings=[str(note.message) for note in notes])
    labels = fits.PrimaryHDU(found.labels)
    names = {"catalogue": target.with_name(target.name + ".ecsv"), "labels": target.with_name(target.name + ".labels.fits")}
    _write(names["catalogue"], lambda path: sources.write(path, format="ascii.ecsv"))
    _write(names["labels"], lambda path: labels.writeto(path))
    return {"n_sources": len(found), **{name: str(path) for name, path in names.items()}}


def _first_image(hdus):
    for hdu in hdus:
        if hdu.is_image and hdu.data is not None and hdu.data.squeeze().ndim == 2:
            return hdu
    raise ValueError("there is no image of two axes in the file")


def _write(path, write):
    """Writes a file under another name first: a worker that is lost leaves no half of one."""
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    part.unlink(missing_ok=True)
    try:
        write(part)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
