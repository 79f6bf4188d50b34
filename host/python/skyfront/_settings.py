"""The settings of a run as keywords, made from the table of parameters that the program has."""

import difflib
import inspect

import numpy as np

from . import _engine
from ._input import option_error

PARAMETERS = {parameter["name"]: parameter for parameter in _engine.parameters()}
CHOICES = _engine.choices()


def parameters():
    """Every setting of a run, by name: step, unit, range, default, words with their meanings, help."""
    return {name: dict(parameter) for name, parameter in PARAMETERS.items()}


def columns():
    """Every column that a catalogue can have: name, unit, description, and whether it is usual."""
    return _engine.columns()


def texts(function, settings):
    """The settings of a call as the command line would have them."""
    for name in settings:
        if name not in PARAMETERS:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}{_hint(name)}")
    return [(PARAMETERS[name]["option"], _text(name, value)) for name, value in settings.items() if value is not None]


def _hint(name):
    known = _engine.elsewhere(name)
    if known:
        return f"; here it is {known!r}"
    near = difflib.get_close_matches(name, PARAMETERS, 1)
    return f"; did you mean {near[0]!r}?" if near else ""


def _text(name, value):
    """A value as on the command line: a word, a number, two numbers, or a word with numbers."""
    if isinstance(value, str):
        return value
    if isinstance(value, (tuple, list)) and value:
        if isinstance(value[0], str):
            return ":".join([value[0], ",".join(_text(name, part) for part in value[1:])])
        return ",".join(_text(name, part) for part in value)
    if isinstance(value, (bool, np.bool_)):
        raise option_error(name, f"{value} is no number or word")
    if isinstance(value, (int, np.integer)):
        return str(int(value))
    if isinstance(value, (float, np.floating)):
        whole = PARAMETERS[name]["numbers"] == "int" and float(value).is_integer()
        # The shortest text that gives the number back, in the number's own precision.
        return str(int(value)) if whole else str(value) if isinstance(value, np.floating) else repr(value)
    raise option_error(name, f"{value!r} is no number or word")


OWN = [
    ("mask", None, "array", "True, or not 0, where a pixel must not be used."),
    ("weight", None, "array or number", "How well each pixel is known, in the sense of `weight_type`."),
    ("weight_type", None, f"str: {', '.join(CHOICES['weight_type'])}",
     "What `weight` holds: standard deviations, variances, or inverse variances up to a factor."),
    ("background", None, "array or number", "The sky of every pixel; not given, it is measured."),
    ("noise", None, "array or number",
     "The standard deviation of every pixel; not given, it is measured. The same as a `weight` of the type `rms`."),
    ("wcs", None, "astropy WCS or FITS header",
     "Coordinates for the catalogue. A header also gives GAIN and SATURATE, and its own digits."),
    ("bands", (), "sequence of images",
     "Further images of the same pixels, of any kind that the first may be: sources are found in all together, and "
     "measured in each (columns of the second begin with `m2_`). `background`, `noise` and `weight` do not go with it."),
    ("combine", None, f"str: {', '.join(CHOICES['combine'])}",
     "How: by their sum weighted by 1/noise^2 (the default), by the root of the sum of squares of signal-to-noise, or, "
     "with `scheme='chan-vese'` and `sky='none'`, by one front that goes by each of them."),
    ("preset", CHOICES["preset"][0], f"str: {', '.join(CHOICES['preset'])}", "Settings to start from."),
    ("arithmetic", CHOICES["arithmetic"][0], f"str: {', '.join(CHOICES['arithmetic'])}", "Numbers to compute in."),
    ("gain", None, "float", "Electrons in a unit of the image, for the errors; not given, GAIN of the header."),
    ("saturation", None, "float",
     "Pixel value from which pixels are saturated; not given, SATURATE of the header, or the end of an integer type."),
    ("zero_point", None, "float", "Magnitude of a flux of 1: adds magnitudes."),
    ("apertures", (), "sequence of float", "Radii of circular apertures, pixels."),
    ("neighbours", CHOICES["neighbours"][0], f"str: {', '.join(CHOICES['neighbours'])}",
     "What apertures count where they meet other sources."),
    ("columns", (), "sequence of str",
     "Columns of the catalogue: names (SExtractor's are understood too), 'default' or 'all'."),
    ("threads", None, "int", "Threads; the result does not depend on them. Not given, all processors."),
]  # fmt: skip
"""Keywords beside the settings: name, default, type and meaning."""


def signature(first, own, leave_out=(), **defaults):
    """The signature of a function with these positional arguments, keywords of its own, and every setting."""
    kind = inspect.Parameter
    listed = [kind(name, kind.POSITIONAL_OR_KEYWORD) for name in first]
    for name, default, _, _ in OWN:
        if name in own:
            listed.append(kind(name, kind.KEYWORD_ONLY, default=defaults.get(name, default)))
    listed += [kind(name, kind.KEYWORD_ONLY, default=None) for name in PARAMETERS if name not in leave_out]
    return inspect.Signature(listed)


def describe(name, leave_out=()):
    """The lines of a docstring on the settings, by step."""
    lines, step = [], None
    for parameter in PARAMETERS.values():
        if parameter["name"] in leave_out:
            continue
        if parameter["step"] != step:
            step = parameter["step"]
            lines += ["", f"    *{step}*", ""]
        notes = [f"default: {parameter['default']}"] if parameter["default"] else []
        notes += [note for note in (parameter["unit"], parameter["range"]) if note]
        notes += [f"with {need}" for need in parameter["needs"]]
        lines.append(f"    {parameter['name']} : {kind(parameter)}")
        lines.append(f"        {parameter['help']} [{'; '.join(notes)}]")
        lines += [f"        - {word}: {help}" for word, help in parameter["words"] if help]
    return "\n".join(lines)


def kind(parameter):
    """The Python types of a setting's values."""
    words = [word for word, _ in parameter["words"]]
    types = {"": [], "int": ["int"], "float": ["float"], "pair": ["(float, float)"]}[parameter["numbers"]]
    return " or ".join(types + (["str: " + ", ".join(words)] if words else []))


def describe_own(own):
    """The lines of a docstring on the other keywords."""
    lines = []
    for name, default, kind, meaning in OWN:
        if name in own:
            shown = "" if default in (None, ()) else f", default {default!r}"
            lines += [f"    {name} : {kind}{shown}", f"        {meaning}"]
    return "\n".join(lines)
