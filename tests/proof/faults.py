#!/usr/bin/env python3
"""Plants faults in a copy of the program, one at a time, and tells which of them no check notices.

    tests/proof/faults.py [--only WORD] [--list]

Every fault is an expression that another takes the place of. All are built at once, each behind a switch, and one
environment variable throws a switch when the checks run: what would take an hour of compiling takes minutes. The
checks are the narrowest that should notice, "core", "host" or "all" (the tests that span both) and the part of the
tests' names; without any fault all of them must pass. Needs only this repository. Exit code 1 where a fault lives or
its place is not found exactly once.
"""

import argparse
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SWITCH = "SKYFRONT_FAULT"

# What is wrong, the file, the expression between << and >> in its surroundings, what takes its place, the checks.
FAULTS = [
    # Values, sky and noise.
    ("levels are those of the other end", "core/src/image/normalize.rs", "(pixel - self.low) / <<span>>", "(span + self.low)", "all:crosscheck::"),
    ("the sky's mode is its median", "core/src/sky/clipped.rs", "<<2.5 * middle - 1.5 * mean>>", "middle", "core:sky:: all:rules_default::"),
    ("clipping keeps its bias", "core/src/sky/clipped.rs", "(deviation * <<CLIPPED_AWAY>>)", "1.0", "core:sky:: all:rules_default::"),
    ("coarse noise has a median", "core/src/sky/clipped.rs", "centre = if <<coarse(noise)>> {", "false", "core:sky:: all:rules_default::"),
    ("a cell is read at the next column", "core/src/sky/mesh.rs", "sides(size, grid, <<place + column>>)", "place + (column + 1) % cells.len()", "core:sky:: all:rules_default::"),
    ("the sky's slope ends at the outer cells", "core/src/sky/mesh.rs", "near + <<slope>> * (near - far)", "0.0", "core:sky:: all:rules_default::"),
    ("the sky is not smoothed", "core/src/sky/mesh.rs", "sort::few(&mut values, |a, b| a.key() < b.key());\n    let [.., middle, _, _, _, _] = <<values>>;", "{ let [_, _, _, _, least, ..] = values; let mut copy = values; copy[4] = least * 1.01; copy }", "core:sky:: all:rules_default::"),
    ("spikes keep their light", "core/src/sky/spike.rs", "(own - median > height && alone).then_some(<<median>>)", "own", "core:sky:: all:rules_default::"),
    ("the mirror at the border misses a pixel", "core/src/plane/smooth.rs", "else { <<distance - at - 1>> };", "distance - at", "core:plane:: all:rules_default::"),
    ("everything is smoothed by the spline", "core/src/sky/signal.rs", "magnitude() >= <<least>> { fine }", "least + least", "all:rules_default::"),
    ("the mask is too narrow", "core/src/sky/signal.rs", "mark_rows(rows, (work.fine, <<L::of(NEAR)>>), work.rows", "L::of(0.25)", "all:rules_default::"),
    ("photons count half", "core/src/sky/photon.rs", "<<PHOTON_MARGIN * photon>>)", "0.75 * photon", "core:sky::"),
    ("the photon noise is the greatest level's", "core/src/sky/photon.rs", "curve.least = if <<curve.least < slope>> {", "curve.least.is_finite() && curve.least > slope", "core:sky:: all:rules_default::"),
    ("symmetric noise has a tail", "core/src/sky/tail.rs", "let skewness = (cubes / count / (variance * libm::sqrt(variance))) as f32;\n    if skewness < LEAST { <<0.0>> }", "0.3", "core:sky:: all:rules_default::"),
    # The paper's image steps.
    ("r2 is r1", "core/src/image/rescale.rs", "A::pow(<<A::log2_1p(x)>>, alpha)", "x", "all:rules::every_rule_of"),
    ("r3 is damped by the root", "core/src/image/rescale.rs", "tau * A::pow(x.ratio(tau), <<damp>>)", "EIGHTH_ROOT", "all:crosscheck::"),
    ("Otsu takes the last of equals", "core/src/sky/otsu.rs", "if <<between > best>> {", "between >= best", "core:sky:: all:thresholds::"),
    ("heat flows a little faster", "core/src/image/filter.rs", "i + <<filter.lambda>> * ((l + r) + (b + a)));\n        }\n    }\n}\n\n/// One step of Perona", "(filter.lambda + filter.lambda)", "all:crosscheck::"),
    ("F1 is F2", "core/src/image/filter.rs", "Diffusivity::F1 => <<d.ratio(A::Real::ONE + s * s)>>,", "A::exp_neg(s * s) * d", "all:rules::every_filter"),
    ("the median is the next", "core/src/image/filter/median.rs", "let [_, median, _] = <<sorted([least, middle, greatest])>>;", "[least, greatest, middle]", "core:image::filter::median::"),
    # Edge detector and front.
    ("g1 is steeper", "core/src/front/edge.rs", "one.ratio(one + A::pow(<<z>>, p));", "z + z", "all:rules::every_filter"),
    ("g2 forgets the least gradient", "core/src/front/edge.rs", "(s - <<least>>).ratio(span)", "A::Real::ZERO", "all:crosscheck::"),
    ("fd moves too far", "core/src/front/scheme/fd.rs", "A::retreat(v, around, <<courant>>, g)", "courant + courant", "all:crosscheck::"),
    ("the curvature loses its mixed term", "core/src/front/scheme/fd_curvature.rs", "- <<(mixed + mixed)>>)", "mixed", "all:crosscheck::"),
    ("the filtered scheme is not filtered", "core/src/front/scheme/fd_filtered.rs", "size.least(<<(room + room - size).positive()>>)", "size", "all:fd_filtered:: all:rules::every_front"),
    ("lambda1 is lambda2", "core/src/front/bands.rs", "inside: A::Real::of(dt * <<weights.lambda1>>)", "weights.lambda2", "all:chan_vese:: all:rules::every_front"),
    ("the second front forgets the first", "core/src/front/scheme/multiphase.rs", "scheme.step(&near, <<v>>, [[first, both]", "A::Real::ZERO", "all:multiphase:: all:rules::every_front"),
    ("a phase weighs without the product", "core/src/front/region.rs", "signed(in_first == in_second, <<product>>)", "0", "core:front::region all:rules::every_front"),
    ("fast marching goes around corners", "core/src/front/march.rs", "<<0.5 * ((first + second) + A::root(2.0 * delay * delay - lag * lag))>> } else", "first + delay", "all:rules::every_front"),
    ("the front rests too early", "core/src/front/stop.rs", "rest: <<(eps / scale) as u64>>", "(4.0 * eps / scale) as u64", "all:crosscheck::"),
    ("a banded front does not grow", "core/src/front/settle.rs", "(v + <<growth>>).least", "A::Real::ZERO", "core:front::settle all:rules::every_front"),
    ("distances end where the front starts", "core/src/front/start.rs", "<<margin + 2.0 * FLOOR>>", "margin", "core:front::start all:rules::every_front"),
    ("the outline moves with the wrong side", "core/src/front/outline.rs", "(if <<outwards>> { rise }", "!outwards", "core:front::outline all:rules_default::"),
    ("the outline bends less", "core/src/front/outline.rs", "- <<twist * (x * y)>> +", "L::ZERO", "core:front::outline all:rules_default::"),
    # Sources.
    ("saddles cost nothing", "core/src/sources/tree.rs", "let light = faint.sum - <<saddle.times(faint.area)>>;", "saddle.times(0)", "all:rules_default::"),
    ("contrast is the branch's", "core/src/sources/tree.rs", "L::share(bright.sum, <<setting.contrast>>)", "setting.contrast + 0.5", "all:rules_default:: all:settings::"),
    ("four of nine are most", "core/src/sources/tree.rs", ".count() >= <<MOST>>", "4", "core:sources::tree"),
    ("a third source's light counts", "core/src/sources/tree.rs", "let light = if <<third>> {", "false", "all:rules_default::"),
    ("centres lie on pixels", "core/src/plane/field.rs", "L::whole(x) + <<offset(dx.to_f32())>>", "L::ZERO", "all:rules_default::"),
    ("light is read at the wrong corner", "core/src/plane/field.rs", "(row(first) * (L::ONE - <<part_y>>)", "part_x", "core:plane:: all:rules_default::"),
    ("wide sources are centred on their peaks", "core/src/sources/centre.rs", "    <<region.area > WIDE>>\n", "region.area > 100 * WIDE", "core:sources::centre"),
    ("a galaxy's knots are sources", "core/src/sources/deblend.rs", "is_wide(host) && known < <<KNOT>>", "0", "core:sources::deblend all:rules_default::knots"),
    ("clouds are galaxies", "core/src/sources/knots.rs", "extent < <<CONCENTRATED>> * area", "1.0", "core:sources::knots"),
    ("knots are as bright as their galaxies", "core/src/sources/knots.rs", "region.sum < <<most>> &&", "galaxy.sum", "core:sources::knots all:rules_default::a_galaxy"),
    ("a needle has an ellipse", "core/src/plane/field.rs", "(left > <<THINNEST>>)", "0.001", "core:plane::field"),
    ("a faint sharp star is a hot pixel", "core/src/sky/spike.rs", "share(SHARPEST) - L::of(<<TAKEN>>)", "0.5", "core:sky::spike all:rules_default::every_choice"),
    ("plateaus are twice as large", "core/src/sources/centre.rs", "count < <<SHARE>> * region.area", "0.5", "core:sources::centre"),
    ("the typical source is the lower octile's", "core/src/sources/typical.rs", "least.get(<<count / 4>>)", "count / 8", "core:sources::typical"),
    ("reopened groups need no area", "core/src/sources/deblend.rs", "opening.unexplained >= <<least_area>> && has_peak", "1", "all:rules_default:: all:settings::"),
    ("the flank of a lopsided star is a source", "core/src/sources/deblend.rs", "&& (<<opening.has_maximum>> ||", "true", "core:sources::deblend"),
    ("the excess is not asked", "core/src/sources/deblend.rs", "L::of(<<self.excess>> * self.noise.least", "0.5 * self.excess", "all:rules_default:: all:settings::"),
    ("what was open is forgotten", "core/src/sources/deblend.rs", "*label = *label & !AGAIN | <<OPEN>>;", "0", "core:sources::deblend"),
    ("new sources are not asked", "core/src/sources/deblend.rs", "(is_first || <<region.area == 0>>)", "false", "core:sources::deblend"),
    ("borders lie elsewhere", "core/src/sources/deblend.rs", "let is_low = |light: L| field.at(at) > light.scaled(L::Weight::of(<<OTHER>>));", "1.5", "all:rules_default::"),
    ("isophotes lean half as far", "core/src/sources/centre.rs", "part(<<2.0 * region.offsets.1>>)", "region.offsets.1", "core:sources::centre all:rules_default::a_crowd"),
    ("borders are swept forwards alone", "core/src/sources/deblend.rs", "(&mut *contest, <<sweep_number % 2 == 0>>)", "true", "all:rules_default::a_crowd"),
    ("another's light is a host's", "core/src/sources/deblend.rs", "|| <<!is_more_alone(field, centres(), across, bound)>>", "true", "all:rules_default::a_crowd"),
    ("another's pixels are on the ellipse", "core/src/sources/deblend.rs", "let counts = |at: usize| <<[0, label].contains(&label_at(labels, at))>>;", "at < labels.len()", "all:rules_default::a_crowd"),
    ("combs stay", "core/src/sources/deblend.rs", "(others >= <<6>> && same < 3)", "8", "all:rules_default::"),
    ("noise has other peaks", "core/src/sources/significance.rs", "libm::expf(<<-0.5>> * height", "-0.45", "all:rules_default::"),
    ("the cut is asked once", "core/src/sources/selection.rs", "*allowed = if <<share > *allowed>> {", "false", "all:rules_default::"),
    ("leniency for all", "core/src/sources/selection.rs", "else if <<!divided>> && enough", "true", "all:rules_default:: all:rules::"),
    ("light is not asked", "core/src/sources/selection.rs", "<<part * light>>)\n    };", "0.0 * part * light", "all:rules_default:: all:settings::"),
    ("centroids are a pixel off", "core/src/sources/catalog.rs", "self.x0 as f32 + <<dx>>", "dx + 1.0", "core:sources:: all:crosscheck::"),
    # Between polls.
    ("a snapshot of any version", "core/src/run/snapshot.rs", "if <<word != expected>> {", "word != expected && what != \"format version\"", "all:snapshots::"),
    # The program.
    ("CROTA turns the other way", "host/src/sky/linear.rs", "let sign = if <<axes[0] == 1>>", "axes[0] != 3", "all:sky::"),
    ("regions are half a pixel off", "host/src/outline/files.rs", "{:.3},{:.3}\", <<x + 1.0>>,", "x + 0.5", "all:catalogue::outlines"),
    ("a variance is a deviation", "host/src/input/weight.rs", "WeightType::Variance => <<value.sqrt()>>,", "value", "host:input::weight all:maps::"),
]


def expression(text):
    """What stands before the place of a fault, the expression, and what stands behind it."""
    before, rest = text.split("<<")
    inside, after = rest.split(">>")
    return before, inside, after


def plant(files, number, path, pattern, other):
    """Puts a fault behind its switch; what is wrong with its place, if anything is."""
    before, own, after = expression(pattern)
    found = files[path].count(before + own + after)
    if found != 1:
        return f"has its place {found} times in {path}: {before + own + after!r}"
    crate = "crate" if path.startswith("core/") else "skyfront_core"
    switched = f"(if {crate}::fault({number}) {{ {other} }} else {{ {own} }})"
    files[path] = files[path].replace(before + own + after, before + switched + after)
    return None


SWITCHES = f"""
/// Which fault is planted.
pub fn fault(number: u32) -> bool {{
    extern crate std;
    static PLANTED: std::sync::OnceLock<u32> = std::sync::OnceLock::new();
    *PLANTED.get_or_init(|| std::env::var("{SWITCH}").ok().and_then(|text| text.parse().ok()).unwrap_or(0)) == number
}}
"""


def planted():
    """The files with all faults, by their paths; ends the program where a fault has no place, or several."""
    places = {path: ROOT / path for _, path, *_ in FAULTS}
    files = {path: place.read_text() if place.is_file() else "" for path, place in places.items()}
    wrong = [(fault[0], plant(files, n, *fault[1:4])) for n, fault in enumerate(FAULTS, 1)]
    if any(what for _, what in wrong):
        sys.exit("\n".join(f"{name}: {what}" for name, what in wrong if what))
    return files


def copied(copy):
    """Copies the program with all its faults into a folder, and touches only what is not there yet."""
    names = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True).stdout.decode()
    files, lib = planted(), "core/src/lib.rs"
    files[lib] = files.get(lib, (ROOT / lib).read_text()) + SWITCHES
    for name in names.split("\0")[:-1]:
        bytes = files[name].encode() if name in files else (ROOT / name).read_bytes()
        file = copy / name
        if not file.is_file() or file.read_bytes() != bytes:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(bytes)
            file.chmod((ROOT / name).stat().st_mode)


def build(copy, environment):
    """Builds all tests; which program has those of each crate. The tests build the program they run."""
    command = ["cargo", "test", "--no-run", "--quiet", "--message-format=json"]
    packages = {"core": "skyfront-core", "host": "skyfront", "all": "skyfront-tests"}
    for package in packages.values():
        command += ["--package", package]
    command += ["--lib", "--test", "all"]
    run = subprocess.run(command, cwd=copy, env=environment, capture_output=True, text=True)
    if run.returncode != 0:
        sys.exit(f"the faults do not compile\n{run.stderr}")
    programs = {}
    for line in run.stdout.splitlines():
        message = json.loads(line)
        name = message.get("target", {}).get("name")
        if message.get("executable") and name in ("skyfront_core", "skyfront", "all"):
            programs[{"skyfront_core": "core", "skyfront": "host", "all": "all"}[name]] = message["executable"]
    return programs


def passes(copy, programs, check, environment):
    """Whether the tests of a check pass; they must be some."""
    program, part = check.split(":", 1)
    folder = {"core": "core", "host": "host", "all": "tests"}[program]
    command = [programs[program], part, "--test-threads=2"]
    try:
        run = subprocess.run(command, cwd=copy / folder, env=environment, capture_output=True, text=True, timeout=900)
    except subprocess.TimeoutExpired:
        return False
    if "running 0 tests" in run.stdout:
        sys.exit(f"{check}: there is no such test")
    return run.returncode == 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", help="faults whose name, file or checks hold this word")
    parser.add_argument("--list", action="store_true", help="name the faults, see that each has its place, and build nothing")
    options = parser.parse_args()
    chosen = [(n, fault) for n, fault in enumerate(FAULTS, 1) if options.only in " ".join(fault)]
    if options.list:
        planted()
        print("\n".join(f"{n} {fault[0]} ({fault[1]})" for n, fault in chosen))
        return
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "faults"
    copy = target / "copy"
    copied(copy)
    environment = {name: value for name, value in os.environ.items() if name != SWITCH}
    environment["CARGO_TARGET_DIR"] = str(target)
    programs = build(copy, environment)
    for check in sorted({check for _, fault in chosen for check in fault[4].split()}):
        if not passes(copy, programs, check, environment):
            sys.exit(f"{check} fails without any fault")
    lived = 0
    for n, (name, path, _, _, checks) in chosen:
        switched = dict(environment, **{SWITCH: str(n)})
        by = next((check for check in checks.split() if not passes(copy, programs, check, switched)), None)
        lived += by is None
        print(f"{f'caught by {by}' if by else 'LIVED':36} {path}: {name}", flush=True)
    print(f"{len(chosen)} faults, {lived} lived")
    sys.exit(lived > 0)


if __name__ == "__main__":
    main()
